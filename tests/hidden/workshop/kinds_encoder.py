"""Faults of the encoder, of its counter and of its clock."""
import math

import numpy as np

from . import bench, counting, mechanics, paths
from .bench import Unfair, fair, size


def slot(*effects, **values):
    return {"effects": list(effects), "values": values}


def offset(rng):
    b = bench.draw(rng)
    x = size(rng, b, 1.5) * rng.choice([-1, 1])
    return b.record(rng, b.counter.count(b.q + x), {"causes": [slot("offset", offset=x)]})


def wrong_ratio(rng):
    b = bench.draw(rng, motions=paths.REVERSING)
    x = size(rng, b, 1, 5000) / np.abs(b.q).max() * rng.choice([-1, 1])
    fair(b, x * b.q, ["position"])
    return b.record(rng, b.counter.count(b.q * (1 + x)), {"causes": [slot("scale", scale=x)], "tolerated": ["offset"]})


def disc_bench(rng, **more):
    """A motion over at least two revolutions of the disc, sampled at least six times in each."""
    b = bench.draw(rng, **more)
    angle = b.counter.shaft(b.q)
    if np.ptp(angle) < 12 or np.abs(np.diff(angle)).max() > 1:
        raise Unfair
    return b


def eccentric(rng):
    """Exact geometry: order 2 of half the amplitude times the radius is there as well."""
    b = disc_bench(rng)
    amplitude = size(rng, b)
    radius = amplitude / b.count / b.counter.per_rev * 2 * math.pi
    if radius > 0.05:
        raise Unfair
    disc = counting.off_centre(radius, rng.uniform(0, 6.28))
    angle = b.counter.shaft(b.q)
    fair(b, (disc(angle) - angle) * b.counter.turn / (2 * math.pi * b.counter.gear))
    return b.record(rng, b.counter.count(b.q, disc), {"causes": [slot("eccentricity", amplitude=amplitude)],
                                                      "tolerated": ["offset", "transmission_error"]})


def waves(b, orders, sizes, phases):
    return lambda a: a + sum(s / b.count / b.counter.per_rev * 2 * math.pi * np.sin(o * a + p) for o, s, p in zip(orders, sizes, phases))


def second_order(rng):
    b = disc_bench(rng)
    x = size(rng, b)
    disc = waves(b, [2], [x], [rng.uniform(0, 6.28)])
    fair(b, x * np.sin(2 * b.counter.shaft(b.q)))
    return b.record(rng, b.counter.count(b.q, disc), {"causes": [slot("transmission_error", amplitude=x, order=2.0)],
                                                      "tolerated": ["offset"]})


def four_orders(rng):
    """Orders 1, 2, 4 and 50 together, as of a magnet over a two-phase stepper."""
    b = disc_bench(rng, motions=["sines", "ramps", "one_way", "random_moves"], rows=(8000, 60000))
    if np.abs(np.diff(b.counter.shaft(b.q))).max() * 50 > 2.5:
        raise Unfair
    sizes = rng.uniform(1.5, 6, 4) * b.count
    disc = waves(b, [1, 2, 4, 50], sizes, rng.uniform(0, 6.28, 4))
    names = slot("transmission_error")
    return b.record(rng, b.counter.count(b.q, disc), {"causes": [slot("eccentricity", amplitude=sizes[0]), names],
                                                      "tolerated": ["offset", "reference_error"]})


def ratio_and_eccentric(rng):
    b = disc_bench(rng, motions=paths.REVERSING + ["one_way"])
    if np.ptp(b.counter.shaft(b.q)) < 40:
        raise Unfair
    amplitude, x = size(rng, b, 1, 20), rng.choice([-1, 1]) * math.exp(rng.uniform(*np.log([1e-3, 2e-2])))
    radius = amplitude / b.count / b.counter.per_rev * 2 * math.pi
    if radius > 0.05:
        raise Unfair
    disc = counting.off_centre(radius, rng.uniform(0, 6.28))
    return b.record(rng, b.counter.count(b.q * (1 + x), disc), {
        "causes": [slot("scale", scale=x), slot("eccentricity", amplitude=amplitude)],
        "tolerated": ["offset", "transmission_error"]})


def states(rng):
    """Unequal states of an A/B disc: phase of B against A, and duty of both."""
    b = bench.draw(rng, form="lines", noise=(0.005, 0.05), rows=(10000, 60000), fewest=4000)
    phase, duty = rng.uniform(0.25, 0.6) * rng.choice([-1, 1]), rng.uniform(-0.15, 0.15, 2)
    edges = np.array([duty[0], phase + duty[1], -duty[0], phase - duty[1]])
    return b.record(rng, b.counter.count(b.q, edges=edges), {"causes": [slot("state_width")], "tolerated": ["offset", "subdivision_error"],
                                                             "says": ["every four counts"]})


def interpolation(rng):
    """Offset, gain and phase of sine and cosine."""
    b = bench.draw(rng, form="sincos", motions=paths.REVERSING, rows=(6000, 60000))
    period = b.counter.per_rev / b.counter.periods
    o, g, p = rng.uniform(0.6, 6, 3) / period * 2 * math.pi * rng.choice([-1, 1], 3)
    if np.hypot(o, g) > 0.2 or np.ptp(b.q) / b.count < 5 * period or np.median(np.abs(np.diff(b.q))) / b.count > period / 7:
        raise Unfair
    signals = lambda s, c: ((1 + g) * (s * math.cos(p) + c * math.sin(p)) + o, c)
    like = slot("subdivision_error") if b.counter.periods > 1 else slot("subdivision_error", "eccentricity", "transmission_error")
    also = ["offset"] if b.counter.periods > 1 else ["offset", "eccentricity", "transmission_error"]
    return b.record(rng, b.counter.count(b.q, signals=signals), {"causes": [like], "tolerated": also})


def missed(rng):
    b = bench.draw(rng)
    lost = 4 * int(rng.integers(1, 12)) * rng.choice([-1, 1])
    when = rng.uniform(0.25, 0.75) * b.t[-1]
    counts = b.counter.count(b.q) + lost * (b.t >= when)
    return b.record(rng, counts, {"causes": [slot("missed_counts", counts=lost, time=when)], "tolerated": ["offset"]})


def wrong_decoding(rng):
    b = bench.draw(rng, form="counts")
    f = float(rng.choice([0.25, 0.5, 2, 4]))
    if f < 1:  # every second or fourth edge counts
        every = round(1 / f)
        counts = (b.counter.count(b.q) + every // 2) // every
    else:  # the disc has more lines than the spec says
        per, b.counter.per_rev = b.counter.per_rev, b.counter.per_rev * f
        counts = b.counter.count(b.q)
        b.counter.per_rev = per
    return b.record(rng, counts, {"causes": [slot("decoding", factor=f)], "tolerated": ["offset"]})


def channels_exchanged(rng):
    b = bench.draw(rng, form="counts", motions=paths.REVERSING)
    return b.record(rng, b.counter.count(-b.q), {"causes": [slot("decoding")], "says": ["wrong direction"], "tolerated": ["offset"]})


def rollover(rng):
    """A counter of 12 or 16 bits over a reference that wanders (odometry)."""
    b = bench.draw(rng, noise=(0.01, 0.05))
    m = int(rng.choice([4096, 65536]))
    counts = b.counter.count(b.q)
    if np.ptp(counts // m) < 1 or np.abs(np.diff(counts)).max() > m / 4:
        raise Unfair
    walk = np.cumsum(rng.standard_normal(len(b.t)))
    walk *= rng.uniform(0, 2) * b.count / max(1, np.ptp(walk))
    return b.record(rng, counts % m, {"causes": [slot("rollover", modulus=m)], "says": ["overflows"],
                                      "tolerated": ["offset", "drift", "scale"]}, reference=b.reference(rng) + walk)


def latency(rng):
    b = bench.draw(rng, motions=paths.LIVELY)
    d = size(rng, b) / np.abs(np.gradient(b.q, b.t)).max()
    fair(b, b.path(b.t - d) - b.q, ["speed"])
    return b.record(rng, b.counter.count(b.path(b.t - d)), {"causes": [slot("latency", delay=d)], "tolerated": ["offset"]})


def latency_and_play(rng):
    b = bench.draw(rng, motions=paths.LIVELY)
    d, gap = size(rng, b, 1.5, 60) / np.abs(np.gradient(b.q, b.t)).max(), size(rng, b, 2, 60)
    late = mechanics.play_along(b.path, b.t - d, gap)
    fair(b, late - b.q, ["speed", "direction"], 0.93)
    return b.record(rng, b.counter.count(late), {"causes": [slot("latency", delay=d), slot("backlash", gap=gap)], "tolerated": ["offset"]})


def clock(rng):
    """The logger's clock runs fast or slow against that of the encoder."""
    b = bench.draw(rng, motions=["sines", "random_moves"], seconds=(20, 300))
    rate = size(rng, b, 2) / np.abs(np.gradient(b.q, b.t)).max() / b.t[-1] * rng.choice([-1, 1])
    if abs(rate) > 3e-4:  # beyond any quartz
        raise Unfair
    fair(b, b.path(b.t * (1 + rate)) - b.q)
    return b.record(rng, b.counter.count(b.path(b.t * (1 + rate))), {"causes": [slot("clock_drift", rate=rate)],
                                                                     "tolerated": ["offset"]})


def noise(rng):
    b = bench.draw(rng, noise=(0.005, 0.05))
    s = math.exp(rng.uniform(*np.log([0.6, 8])))
    return b.record(rng, b.counter.count(b.q, noise=s * rng.standard_normal(len(b.t))), {"causes": [slot("noise", sigma=s * b.count)]})


def shaken(b, rng, counts):
    """Readings at instants that scatter so that they are off by `counts` (rms over the record)."""
    s = counts * b.count / np.sqrt(np.mean(np.gradient(b.q, b.t)**2))
    return s, b.path(b.t + s * rng.standard_normal(len(b.t)))


def jitter(rng):
    b = bench.draw(rng, motions=paths.LIVELY, noise=(0.005, 0.05))
    s, x = shaken(b, rng, math.exp(rng.uniform(*np.log([0.6, 8]))))
    return b.record(rng, b.counter.count(x), {"causes": [slot("timing_jitter", sigma=s)]})


def noise_and_jitter(rng):
    b = bench.draw(rng, motions=paths.LIVELY, noise=(0.005, 0.05), rows=(8000, 60000))
    n = rng.uniform(0.6, 2)
    s, x = shaken(b, rng, n * rng.uniform(0.8, 2))
    return b.record(rng, b.counter.count(x, noise=n * rng.standard_normal(len(b.t))), {
        "causes": [slot("noise", sigma=n * b.count), slot("timing_jitter", sigma=s)]})


KINDS = [offset, wrong_ratio, eccentric, second_order, four_orders, ratio_and_eccentric, states, interpolation, missed,
         wrong_decoding, channels_exchanged, rollover, latency, latency_and_play, clock, noise, jitter, noise_and_jitter]
