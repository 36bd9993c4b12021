"""Records of machines and logs in order: what is unusual in them is no fault."""
import numpy as np

from . import arms, bench, counting, paths
from .bench import Unfair

QUIET = {"clean": True}


def plain(rng):
    b = bench.draw(rng)
    return b.record(rng, b.counter.count(b.q), dict(QUIET))


def noisy_reference(rng):
    b = bench.draw(rng, noise=(0.1, 0.3))
    return b.record(rng, b.counter.count(b.q), dict(QUIET))


def poor_reference(rng):
    """Noise of the reference of 0.3 to 1 count: to decline is right too."""
    b = bench.draw(rng, noise=(0.3, 1.0))
    return b.record(rng, b.counter.count(b.q), {**QUIET, "may_decline": True})


def gridded_reference(rng):
    b = bench.draw(rng, noise=(0.001, 0.003))
    grid = rng.uniform(0.05, 0.5) * b.count
    return b.record(rng, b.counter.count(b.q), dict(QUIET), reference=np.round(b.q / grid) * grid)


def second_encoder(rng):
    """The reference is an encoder too, with a count of 0.6 to 1.5 of the tested one's: it judges only what is larger."""
    b = bench.draw(rng, noise=(0.001, 0.003))
    grid = rng.uniform(0.6, 1.5) * b.count
    return b.record(rng, b.counter.count(b.q), {**QUIET, "may_decline": True}, reference=np.round(b.q / grid) * grid)


def slower_reference(rng):
    """The reference is read every few rows and the last value held in between: its rows are old, the machine is right."""
    b = bench.draw(rng, motions=paths.LIVELY, rows=(4000, 60000))
    every = int(rng.integers(3, 9))
    old = b.reference(rng)[np.arange(len(b.t)) // every * every]
    if np.abs(np.diff(b.q)).max() * every < 3 * b.count:
        raise Unfair
    return b.record(rng, b.counter.count(b.q), {**QUIET, "says": ["constant for", "held", "jumps"], "may_decline": True},
                    reference=old)


def negative_gear(rng):
    b = bench.draw(rng, slide=False, form="counts")
    b.counter.gear = -abs(b.counter.gear)
    return b.record(rng, b.counter.count(b.q), dict(QUIET))


def laser(rng):
    """A slide under an interferometer: a grid of 10 nm, no noise to speak of."""
    b = bench.draw(rng, slide=True, noise=(0.001, 0.01))
    return b.record(rng, b.counter.count(b.q), dict(QUIET), reference=np.round(b.reference(rng) / 1e-8) * 1e-8)


def slide_without_limits(rng):
    """A record of a slide is judged whether or not its travel is stated: the log shows where it was."""
    b = bench.draw(rng, slide=True)
    return b.record(rng, b.counter.count(b.q), dict(QUIET), limits=False)


def static_poses(rng):
    b = bench.draw(rng, motions=["poses"])
    return b.record(rng, b.counter.count(b.q), dict(QUIET))


def one_way(rng):
    b = bench.draw(rng, motions=["one_way"])
    return b.record(rng, b.counter.count(b.q), dict(QUIET))


def free_zero(rng):
    """An incremental encoder without index: its constant is no fault."""
    b = bench.draw(rng, form="counts")
    b.counter.free_zero = True
    return b.record(rng, b.counter.count(b.q) + int(rng.integers(-5000, 5000)), dict(QUIET))


def more_columns(rng):
    """Temperature, motor current with friction, and a command that the joint follows with a lag: none of it an error."""
    b = bench.draw(rng, motions=paths.REVERSING)
    v = np.gradient(b.q, b.t)
    b.column("effort", "A", 0.4 * np.sign(v) + 2 * np.cos(b.q) + 0.02 * rng.standard_normal(len(v)))
    b.column("temperature", "degC", np.round((22 + 6 * (1 - np.exp(-b.t / (b.t[-1] / 2)))) * 10) / 10)
    b.column("command", b.unit, b.path(b.t + 0.02), "%.8f")
    return b.record(rng, b.counter.count(b.q), dict(QUIET))


def crawl(rng):
    """Well below a count per row: the error is a sawtooth of the angle, as it should be."""
    b = bench.draw(rng, motions=["sines", "ramps", "one_way"], rows=(8000, 60000))
    slow = rng.uniform(0.02, 0.3) / (np.abs(np.diff(b.q)).max() / b.count)
    whole, start = b.path, b.q[0]
    b.path = lambda t: start + slow * (whole(t) - start)
    if np.abs(np.diff(b.q)).sum() < 60 * b.count:
        raise Unfair
    return b.record(rng, b.counter.count(b.q), dict(QUIET))


def standstill(rng):
    b = bench.draw(rng, slide=False, noise=(0.01, 0.1))
    at = (round(float(rng.uniform(-500, 500))) + rng.uniform(-0.3, 0.3)) * b.count
    b.path, n = (lambda t: np.full(len(t), at)), int(rng.integers(60, 2000))
    b.t = b.t[:n]
    return b.record(rng, b.counter.count(b.q), {**QUIET, "may_decline": True})


def uneven_stamps(rng):
    """Rows come when they come, and are stamped right."""
    b = bench.draw(rng, rows=(1500, 20000))
    b.t = np.round(np.sort(b.t + rng.uniform(-0.4, 0.4, len(b.t)) * (b.t[1] - b.t[0])), 6)
    b.t[0] = 0.0 if b.t[0] < 0 else b.t[0]
    return b.record(rng, b.counter.count(b.q), {**QUIET, "says": ["stamps are uneven"]})


def rounds_down(rng):
    b = bench.draw(rng, form="counts")
    b.counter.down = True
    return b.record(rng, b.counter.count(b.q), dict(QUIET))


def tracked_tool(rng):
    """An arm of which only the tool is measured, by a tracker."""
    arm, t, q, counters, columns = tip_bench(rng)
    return tip_record(rng, arm, t, counters, columns, arm.tip(q), {**QUIET, "may_decline": True})


def tip_bench(rng, joints=None):
    """(arm, t, q, counters, columns of counts) of an arm that moves all over its range."""
    arm = arms.draw(rng, joints or int(rng.integers(2, 5)))
    n, rate = int(rng.integers(3000, 12000)), float(rng.choice([100, 200, 500]))
    t = np.arange(n) / rate
    # The joints' periods differ, so that the poses fill the workspace.
    q = np.array([rng.uniform(-0.5, 0.5) + paths.Sines([(rng.uniform(0.4, 0.9), rng.uniform(2, 6) / t[-1], rng.uniform(0, 6)),
                                                        (0.15, rng.uniform(8, 14) / t[-1], 1.0)])(t) for _ in arm.names])
    counters = [counting.draw(rng, form="counts", finest=3e-5, coarsest=4e-4) for _ in arm.names]
    return arm, t, q, counters, [(f"{j}.counts", c.count(x), "%d") for j, c, x in zip(arm.names, counters, q)]


def tip_record(rng, arm, t, counters, columns, tip, truth):
    noise = rng.uniform(0.02, 0.15) * 0.4 * max(abs(c.step) for c in counters)
    tip = tip + noise * rng.standard_normal(tip.shape)
    spec = "qerr: 1\nrobot: {urdf: robot.urdf}\nencoders:\n" + "".join(
        f"  {j}: {c.spec()}\n" for j, c in zip(arm.names, counters)) + "coordinates: [x, y, z]\n"
    truth.update(joint="tip", any_joint=True, rows=len(t), tip_noise=noise, arm_of=len(arm.names))
    return bench.Record(spec, [("time [s]", t, "%.6f"), *columns] + [
        (f"tip.{k} [m]", tip[:, i], "%.9f") for i, k in enumerate("xyz")], truth, arm.urdf())


KINDS = [plain, noisy_reference, poor_reference, gridded_reference, second_encoder, slower_reference, negative_gear, laser,
         slide_without_limits,
         static_poses, one_way, free_zero, more_columns, crawl, standstill, uneven_stamps, rounds_down, tracked_tool]
