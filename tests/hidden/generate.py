#!/usr/bin/python3
"""Writes logs with a known hidden effect: one folder a case with spec.yaml, robot.urdf, log.csv, log2.csv and truth.json.

usage: generate.py --out DIR --cases N --seed S [--kind a|b|c|d|e|w ...] [--name NAME] [--jobs N]

Kinds: a clean, b one effect, c two effects, d outside the catalogue, e inseparable; w, alone, records as from a workshop, by a
generator of their own (workshop/). --name asks for one effect, one clean
record, one foreign effect or one pair (`--list` shows them). Case i of seed S is always the same.
"""
import argparse
import json
import math
import multiprocessing
import pathlib
import sys

import numpy as np

import catalogue
import cases
import clean
import foreign
import pairs
import write
from workshop import workshop

SHARES = {"a": 0.22, "b": 0.42, "c": 0.12, "d": 0.12, "e": 0.12}
NAMES = {"a": clean.CLEAN, "b": catalogue.MAKERS, "d": foreign.FOREIGN, "e": pairs.PAIRS}


def kind_of(index, kinds):
    """Kinds according to their shares, evenly distributed, so that the first N cases contain all of them."""
    weight = np.array([SHARES[k] for k in kinds])
    return kinds[int(np.searchsorted(np.cumsum(weight) / weight.sum(), (index * 0.6180339887 + 0.5) % 1.0, side="right"))]


def name_of(seed, index, kind):
    """An effect, record or pair of this kind according to its share, evenly distributed; pairs of effects are random."""
    if kind not in NAMES:
        return None
    weight = np.array([catalogue.WEIGHT[n] if kind == "b" else 1 for n in NAMES[kind]], float)
    place = np.searchsorted(np.cumsum(weight) / weight.sum(), (index * math.sqrt(2) + seed * math.pi) % 1.0, side="right")
    return list(NAMES[kind])[min(int(place), len(weight) - 1)]


def make(seed, index, kinds, name=None):
    """Case number `index` of this seed; a draw without a distinguishing motion is repeated."""
    for attempt in range(20):
        rng = np.random.default_rng([seed, index, attempt])
        kind = kind_of(index, kinds)
        if name:
            kind = next((k for k in kinds if name in NAMES.get(k, {})), kind)
        which = name or name_of(seed, index, kind)
        case = {"a": lambda: clean.clean(rng, which), "b": lambda: cases.one_effect(rng, which),
                "c": lambda: cases.two_effects(rng), "d": lambda: cases.outside(rng, which),
                "e": lambda: pairs.inseparable(rng, which)}[kind]()
        if case is not None:
            case.truth["id"] = f"c{index:04d}"
            return case
    raise RuntimeError(f"seed {seed}, case {index}: this effect is not distinguishable in any drawn motion")


def write_one(job):
    seed, index, kinds, name, out = job
    case = make(seed, index, kinds, name)
    folder = out / f"c{index:04d}_{case.kind}_{case.sub.replace('+', '_and_')}"
    write.case_files(case, folder)
    return str(folder)


def generate(out, number, seed, kinds="abcde", name=None, jobs=1):
    """Writes the cases and returns their folders."""
    if kinds == "w":
        one, work = workshop.write_one, [(seed, i, name, pathlib.Path(out)) for i in range(number)]
    else:
        one, work = write_one, [(seed, i, kinds, name, pathlib.Path(out)) for i in range(number)]
    if jobs == 1:
        return [one(w) for w in work]
    with multiprocessing.Pool(jobs) as pool:
        return pool.map(one, work, chunksize=1)


def main():
    a = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    a.add_argument("--out", type=pathlib.Path)
    a.add_argument("--cases", type=int, default=60)
    a.add_argument("--seed", type=int, default=1)
    a.add_argument("--kind", action="append", choices=[*sorted(SHARES), "w"],
                   help="only this kind; may be repeated (w stands alone)")
    a.add_argument("--name", help="only this effect, record or pair")
    a.add_argument("--jobs", type=int, default=1)
    a.add_argument("--list", action="store_true", help="the names that --name knows")
    o = a.parse_args()
    if o.list:
        for kind, names in {**NAMES, "w": workshop.NAMES}.items():
            print(kind, *names)
        return 0
    if not o.out:
        a.error("--out is missing")
    kinds = "".join(sorted(set(o.kind))) if o.kind else "abcde"
    if "w" in kinds and kinds != "w":
        a.error("--kind w cannot stand beside other kinds")
    if o.name and not any(o.name in n for n in ([workshop.NAMES] if kinds == "w" else NAMES.values())):
        a.error(f"nothing is called {o.name!r}; --list shows the names")
    if o.name and not o.kind:
        kinds = "".join(k for k, n in NAMES.items() if o.name in n)
    folders = generate(o.out, o.cases, o.seed, kinds, o.name, o.jobs)
    counts = {}
    for f in folders:
        k = json.loads((pathlib.Path(f) / "truth.json").read_text(encoding="utf-8"))["kind"]
        counts[k] = counts.get(k, 0) + 1
    print(f"{len(folders)} cases under {o.out}: " + ", ".join(f"{n} of kind {k}" for k, n in sorted(counts.items())))
    return 0


if __name__ == "__main__":
    sys.exit(main())
