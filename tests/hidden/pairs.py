"""Records in which two effects fit equally well: the right answer names both, and the record that distinguishes them.

Each maker fills a case and returns (effect, names that fit, why). The truth is one of the names, by the toss of a coin where
either can be built.
"""
import math

import numpy as np

import catalogue
import motions
from case import base, finish
from cases import size_in_counts
from encoders import Encoder, random_encoder
from machine import Effect

ONE_SPEED = "one speed, no rest: a delay and a gap shift by the same amount, with the sign of the motion"


def step(case):
    return case.encoders[0].resolution


def rich(rng, case):
    case.paths = motions.rich(rng, case.robot, case.rows / case.rate)


def offset_truncation(rng, case):
    rich(rng, case)
    why = "truncation shifts by exactly half a count"
    if rng.random() < 0.5:
        case.encoders[0].flaws["truncation"] = True
        return Effect("truncation", 0), [["truncation", "offset"]], why
    return Effect("offset", 0, {"offset": -0.5 * step(case)}), [["offset", "truncation"]], why


def latency_backlash(rng, case):
    """The gap is crossed, or the delay over, within half a sample. Measured leads behind a gap and lags by a delay, so that
    a gap looks like a reference that is late and a delay like a gap behind the reference."""
    duration = case.rows / case.rate
    case.paths = motions.Paths([motions.triangle(rng, c, duration, rng.uniform(0.3, 0.6), int(rng.integers(3, 7)),
                                                 ramp=0.5 / case.rate) for c in case.robot.centre_angle])
    speed = np.abs(case.paths.at(case.time)[1][0]).max()
    size = max(0.5 * step(case), min(size_in_counts(rng) * step(case), 0.45 * speed / case.rate))
    if rng.random() < 0.5:
        return Effect("latency", 0, {"delay": size / speed}), [["latency", "backlash"]], ONE_SPEED
    return Effect("backlash", 0, {"gap": 2 * size}), [["backlash", "latency"]], ONE_SPEED


def backlash_one_way(rng, case):
    """The gap is crossed before the record starts."""
    size, name = size_in_counts(rng) * step(case), str(rng.choice(["backlash", "offset", "latency"]))
    speed = rng.uniform(0.1, 0.4) * rng.choice([-1, 1])
    case.paths = motions.Paths([motions.constant_speed(c, speed) for c in case.robot.centre_angle])
    pairs = [["backlash", "offset"], ["latency", "offset"], ["backlash", "latency"], ["truncation", "offset"]]
    p = {"backlash": {"gap": 2 * size, "side": int(np.sign(speed))}, "offset": {"offset": size},
         "latency": {"delay": size / abs(speed)}}[name]
    return Effect(name, 0, p), pairs, "one way at one speed: a gap, a delay and a zero are one number"


def resolver_eccentricity(rng, case):
    """One electrical period per revolution: an offset of the sine is an eccentric disc."""
    bits = int(rng.integers(10, 14))
    gear = float(rng.choice([10, 20, 30]))
    case.encoders[0] = Encoder("sincos", gear, 2.0 ** bits, 1, bits)
    rich(rng, case)
    size = math.exp(rng.uniform(*np.log([1, 8]))) / 2 ** bits * 2 * np.pi
    why = "one signal period a revolution: order k of the signal is order k of the shaft"
    if rng.random() < 0.5:
        case.encoders[0].flaws["heydemann"] = {"offset_sin": size}
        return Effect("subdivision_error", 0, {"offset_sin": size}), [["subdivision_error", "eccentricity"]], why
    case.encoders[0].flaws["eccentricity"] = (size, 0.4)
    return Effect("eccentricity", 0, {"eccentricity": size, "phase": 0.4}), [["eccentricity", "subdivision_error"]], why


def compliance_or_order_1(rng, case):
    """A slow horizontal axis under gravity, no load logged: the sag is a cosine of the joint's angle."""
    case.paths = motions.Paths([motions.Sines(c, [(rng.uniform(1.0, 1.5), rng.uniform(1.3, 2.5) * case.rate / case.rows, 0.5)])
                                for c in case.robot.centre_angle])
    q, v, a = case.paths.at(case.time)
    size = size_in_counts(rng) * step(case)
    why = "gravity goes with the cosine of the angle: order 1 of the joint"
    if rng.random() < 0.5:
        c = size / np.abs(case.robot.effort(q, 0 * v, 0 * a)[0]).max()
        return Effect("compliance", 0, {"compliance": c}), [["compliance", "transmission_error"],
                                                            ["compliance", "eccentricity"]], why
    p = {"amplitude": size, "phase": float(np.pi / 2), "order": 1, "shaft": "joint"}
    return Effect("transmission_error", 0, p), [["transmission_error", "compliance"], ["eccentricity", "compliance"]], why


def scale_or_clock(rng, case):
    """One direction at one speed, from zero: angle and time are proportional."""
    case.paths = motions.Paths([motions.constant_speed(0.0, rng.uniform(0.2, 0.5) * rng.choice([-1, 1]))
                                for _ in case.robot.joints])
    size, q = size_in_counts(rng) * step(case), case.paths.at(case.time)[0][0]
    x = size / np.abs(q).max()
    name = str(rng.choice(["scale", "clock_drift"]))
    pairs = [["scale", "clock_drift"], ["scale", "drift"], ["clock_drift", "drift"]]
    return Effect(name, 0, {"scale": x} if name == "scale" else {"rate": x}), pairs, "angle and time are proportional"


def noise_or_jitter(rng, case):
    """One speed: jitter of the instant is noise of the angle."""
    case.paths = motions.Paths([motions.constant_speed(c, rng.uniform(0.2, 0.5)) for c in case.robot.centre_angle])
    size, v = rng.uniform(0.7, 3) * step(case), case.paths.at(case.time)[1][0, 0]
    if rng.random() < 0.5:
        return Effect("noise", 0, {"sigma": size}), [["noise", "timing_jitter"]], "one speed"
    return Effect("timing_jitter", 0, {"sigma": size / v}), [["timing_jitter", "noise"]], "one speed"


def encoder_or_reference(rng, case):
    """An order of both machines: 50 of a stepper motor, and the second order of a gear with 25 teeth."""
    case.encoders[0] = Encoder("lines", 25.0, 4.0 * rng.choice([500, 1000, 1024]))
    rich(rng, case)
    size, order = size_in_counts(rng) * step(case), 50
    phase, pairs = float(rng.uniform(0, 2 * np.pi)), [["reference_error", "transmission_error"]]
    why = "order 50 of the joint: the second of the motor, or the electrical period of a stepper"
    if rng.random() < 0.5:
        return Effect("reference_error", 0, {"amplitude": size, "phase": phase, "order": order}), pairs, why
    return Effect("transmission_error", 0, {"amplitude": size, "phase": phase, "order": 2, "shaft": "encoder"}), pairs, why


PAIRS = {f.__name__: f for f in (offset_truncation, latency_backlash, backlash_one_way, resolver_eccentricity,
                                 compliance_or_order_1, scale_or_clock, noise_or_jitter, encoder_or_reference)}


def inseparable(rng, name):
    shape = {"compliance_or_order_1": "swing_arm"}.get(name) or str(rng.choice(["turntable", "swing_arm", "two_links"]))
    if name == "compliance_or_order_1":
        seconds = (6.0, 16.0)
    else:
        seconds = (2.0, 6.0)
    probe = [random_encoder(rng, kind=str(rng.choice(["counts", "lines"]))) for _ in range(2 if shape == "two_links" else 1)]
    case = base(rng, "e", name, shape, seconds, probe, verdict="ambiguous")
    case.columns -= {"temperature"}
    effect, case.pairs, case.why = PAIRS[name](rng, case)
    random_sigma = {"noise": lambda p: p["sigma"], "timing_jitter": lambda p: p["sigma"] * np.abs(case.paths.at(case.time)[1][0]).max()}
    case.drawn = [catalogue.Drawn(effect, random_sigma=float(random_sigma.get(effect.name, lambda p: 0.0)(effect.p)))]
    case.reference_noise = rng.uniform(0.02, 0.1) * np.array([e.resolution for e in case.encoders])
    return finish(case, rng, second=False)
