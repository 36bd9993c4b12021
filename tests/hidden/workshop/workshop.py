"""Draws the records: clean ones in 28 of 100, else a kind at random, each as likely; a third of those of one joint in an arm."""
import math
import zlib

import numpy as np

from . import bench, kinds_clean, kinds_data, kinds_encoder, kinds_machine

FAULTY = kinds_encoder.KINDS + kinds_machine.KINDS + kinds_data.KINDS
NAMES = {k.__name__: k for k in kinds_clean.KINDS + FAULTY}
CLEAN = 0.28


def chosen(seed, index):
    """Kinds evenly distributed over the indices, so that any run of records holds nearly all of them."""
    clean = (index * 0.6180339887 + 0.1) % 1.0 < CLEAN
    kinds = kinds_clean.KINDS if clean else FAULTY
    return kinds[int((index * math.sqrt(2) + seed * math.pi) % 1.0 * len(kinds))]


def make(seed, index, name=None):
    """Record `index` of this seed; a draw that cannot show its fault is repeated."""
    kind = NAMES[name] if name else chosen(seed, index)
    for attempt in range(3000):
        rng = np.random.default_rng([zlib.crc32(kind.__name__.encode()), seed, index, attempt])
        try:
            record = kind(rng)
        except bench.Unfair:
            continue
        if record.single and "prismatic" not in record.spec and not record.truth.get("alone") and rng.random() < 0.33:
            record = bench.in_an_arm(rng, record)
        record.truth = {"kind": "w", "sub": kind.__name__, "id": f"w{index:04d}", **record.truth}
        return record
    raise RuntimeError(f"seed {seed}, record {index}: no fair draw of {kind.__name__}")


def write_one(job):
    seed, index, name, out = job
    record = make(seed, index, name)
    folder = out / f"w{index:04d}_{record.truth['sub']}"
    bench.write(record, folder)
    return str(folder)
