"""Faults of the log, of the reference and of the model of the arm."""
import math

import numpy as np

from . import arms, bench, counting, paths
from .bench import Record, fair, size
from .kinds_clean import tip_bench, tip_record
from .kinds_encoder import slot


def coarse_reference(rng):
    b = bench.draw(rng, noise=(0.001, 0.003))
    grid = rng.uniform(2.5, 12) * b.count
    return b.record(rng, b.counter.count(b.q), {"clean": True, "says": ["coarser"], "may_decline": True},
                    reference=np.round(b.q / grid) * grid)


def reference_of_a_stepper(rng):
    """The reference is a stepper's count of steps: its own error has 50 or 200 periods a turn of the joint. On a motor encoder
    nothing tells it from a gear that errs so."""
    b = bench.draw(rng, slide=False, rows=(6000, 60000))
    order = int(rng.choice([50, 100, 200]))
    if np.abs(np.diff(b.q)).max() * order > 1 or np.ptp(b.q) * order < 60:
        raise bench.Unfair
    x = size(rng, b, 1.5)
    if x * order > 0.1:  # a stepper errs by a few per cent of its step
        raise bench.Unfair
    bad = b.q + x * np.sin(order * b.q + 1)
    return b.record(rng, b.counter.count(b.q), {"causes": [slot("reference_error", "transmission_error", "eccentricity", amplitude=x)],
                                                "tolerated": ["offset"]}, reference=b.reference(rng, bad))


def wrong_unit(rng):
    """The header says rad or m, the column is another unit; or turns."""
    b = bench.draw(rng, slide=bool(rng.random() < 0.4))
    factor = 1000.0 if b.counter.lead else float(rng.choice([180 / math.pi, 1 / (2 * math.pi), 1000.0]))
    return b.record(rng, b.counter.count(b.q), {"causes": [], "says": [r"times what the header", "looks like", "unit"], "tolerated": [],
                                                "factor": factor}, reference=b.reference(rng) * factor)


def two_joints(rng):
    arm = arms.draw(rng, int(rng.integers(2, 5)))
    n, rate = int(rng.integers(1500, 20000)), float(rng.choice([100, 500, 1000]))
    t = np.arange(n) / rate
    q = [paths.MOTIONS[str(rng.choice(["sines", "random_moves"]))](rng, rng.uniform(0.2, 1), t[-1])(t) for _ in arm.names]
    return arm, t, q, [counting.draw(rng, form="counts") for _ in arm.names]


def exchanged(rng):
    """The references of two joints, or their counts, stand under each other's name."""
    arm, t, q, counters = two_joints(rng)
    i, k = (int(x) for x in rng.choice(len(q), 2, replace=False))
    order = list(range(len(q)))
    order[i], order[k] = k, i
    columns = [("time [s]", t, "%.6f")]
    noise, of_counts = 1e-6 * rng.standard_normal((len(q), len(t))), rng.random() < 0.5
    for j, name in enumerate(arm.names):
        read, ref = (order[j], j) if of_counts else (j, order[j])
        columns.append((f"{name}.counts", counters[read].count(q[read]), "%d"))
        columns.append((f"{name}.reference [rad]", q[ref] + noise[ref], "%.9f"))
    spec = "qerr: 1\nrobot: {urdf: robot.urdf}\nencoders:\n" + "".join(f"  {j}: {c.spec()}\n" for j, c in zip(arm.names, counters))
    return Record(spec, columns, {"joint": [arm.names[i], arm.names[k]], "any_joint": True, "rows": len(t), "causes": [],
                                  "says": ["exchanged"]}, arm.urdf())


def held_counts(rng):
    """The bus updates the counts every few rows only."""
    b = bench.draw(rng, motions=paths.LIVELY, rows=(4000, 60000))
    every = int(rng.integers(3, 11))
    if np.abs(np.diff(b.q)).max() * every < 3 * b.count:
        raise bench.Unfair
    counts = b.counter.count(b.q)[np.arange(len(b.t)) // every * every]
    return b.record(rng, counts, {"causes": [], "says": ["held"], "tolerated": ["latency", "offset"]})


def outliers(rng):
    """Single readings are far off: a disturbed line."""
    b = bench.draw(rng)
    counts = b.counter.count(b.q)
    where = rng.choice(len(counts) - 20, int(rng.integers(1, max(2, len(counts) // 800))), replace=False) + 10
    counts[where] += rng.integers(200, 20000, len(where)) * rng.choice([-1, 1], len(where))
    return b.record(rng, counts, {"causes": [], "says": ["single", "outlier", "far from", "far off"], "tolerated": []})


def few_decimals(rng):
    """Not counts but positions are logged, with three or four decimals."""
    b = bench.draw(rng, slide=False, rows=(3000, 60000))
    places = 3 if b.count < 3e-4 else 2
    grid = 10.0 ** -places
    if not 2 * b.count < grid < 400 * b.count:
        raise bench.Unfair
    value = np.round(b.counter.count(b.q) * b.counter.step / grid) * grid
    return b.record(rng, None, {"causes": [slot("log_rounding", step=grid)], "tolerated": ["offset"], "says": ["decimals"]},
                    measured=(f"{b.name}.measured [rad]", value, f"%.{places}f"))


def blind_spot(rng):
    """Nothing moves and the counter is out by a few counts: an offset is all that can be seen, and is there."""
    b = bench.draw(rng, slide=False, noise=(0.01, 0.1))
    at, off = rng.uniform(-500, 500) * b.count, int(rng.integers(3, 200))
    b.path, b.t = (lambda t: np.full(len(t), at)), b.t[:int(rng.integers(100, 2000))]
    return b.record(rng, b.counter.count(b.q) + off, {"causes": [slot("offset", offset=off * b.count)], "says": ["does not move"],
                                                      "says_is_enough": False})


def tool_length(rng):
    """The tool is longer or shorter than the URDF's, and only it is tracked: tool, flange or target cannot be told apart."""
    arm, t, q, counters, columns = tip_bench(rng)
    rods = arm.rods.copy()
    rods[-1] *= 1 + rng.choice([-1, 1]) * rng.uniform(0.5e-3, 2e-3) / np.linalg.norm(rods[-1])
    return tip_record(rng, arm, t, counters, columns, arm.tip(q, rods), {
        "causes": [slot("tool", "geometry")], "says": ["tool", "target"], "tolerated": []})


def link_length(rng):
    """A rod before the last one is longer."""
    arm, t, q, counters, columns = tip_bench(rng, int(rng.integers(3, 6)))
    rods, k = arm.rods.copy(), len(arm.names) - 2
    rods[k] *= 1 + rng.choice([-1, 1]) * rng.uniform(0.5e-3, 2e-3) / np.linalg.norm(rods[k])
    return tip_record(rng, arm, t, counters, columns, arm.tip(q, rods), {"causes": [slot("geometry")], "says": [], "tolerated": []})


def base_frame(rng):
    """The tracker's frame is displaced and turned against the base: it is the cause."""
    arm, t, q, counters, columns = tip_bench(rng, int(rng.integers(3, 6)))
    w, shift = rng.uniform(-2e-3, 2e-3, 3), rng.uniform(-2e-3, 2e-3, 3)
    tip = arm.tip(q)
    return tip_record(rng, arm, t, counters, columns, tip + np.cross(w, tip) + shift, {
        "causes": [slot("frame", "geometry")], "says": ["tracker", "base"], "tolerated": []})


def zero_of_a_joint(rng):
    """One joint other than the first was homed wrong; only the tool is tracked. A wrong last rod may look the same."""
    arm, t, q, counters, columns = tip_bench(rng, int(rng.integers(3, 6)))
    j = int(rng.integers(1, len(q) - 1))
    shifted = q.copy()
    shifted[j] -= rng.choice([-1, 1]) * rng.uniform(5, 40) * abs(counters[j].step)
    r = tip_record(rng, arm, t, counters, columns, arm.tip(shifted), {"causes": [slot("offset", "geometry")], "says": [], "tolerated": []})
    r.truth["hidden_at"] = arm.names[j]
    return r


KINDS = [coarse_reference, reference_of_a_stepper, wrong_unit, exchanged, held_counts, outliers, few_decimals, blind_spot,
         tool_length, link_length, base_frame, zero_of_a_joint]
