"""Machines without effects, in difficult records: slow, at rest, one-way, with a very good or a poor reference."""
import numpy as np

import catalogue
import motions
from case import base, finish
from encoders import Encoder, random_encoder
from machine import Effect


def resolution(case):
    return np.array([e.resolution for e in case.encoders])


def each(case, make):
    return motions.Paths([make(j, c) for j, c in enumerate(case.robot.centre_angle)])


def multisine(rng, case):
    case.paths = motions.rich(rng, case.robot, case.rows / case.rate, "sines")


def stops(rng, case):
    case.paths = motions.rich(rng, case.robot, case.rows / case.rate, "stops")


def slow(rng, case):
    """0.02 to 0.4 counts a sample: the error is neither white nor uniform, although there is no effect."""
    step = resolution(case) * case.rate
    case.paths = each(case, lambda j, c: motions.Sines(c, [(step[j] * rng.uniform(0.02, 0.4) / (2 * np.pi * f), f, 0.0)
                                                           for f in [rng.uniform(0.8, 2.5) * case.rate / case.rows]]))


def standstill(rng, case):
    case.paths = each(case, lambda j, c: motions.standstill(c + rng.uniform(-0.3, 0.3)))


def constant_speed(rng, case):
    case.paths = each(case, lambda j, c: motions.constant_speed(
        c, rng.choice([-1, 1]) * rng.uniform(0.01, 0.05 if case.robot.prismatic[j] else 0.3)))


def tiny_reference_noise(rng, case):
    multisine(rng, case)
    case.reference_noise = 1e-3 * resolution(case)


def poor_reference(rng, case):
    multisine(rng, case)
    case.reference_noise = rng.uniform(0.2, 0.25) * resolution(case)


def free_zero(rng, case):
    """Incremental without an index: its offset is arbitrary."""
    stops(rng, case)
    for j, e in enumerate(case.encoders):
        if e.kind != "bits":
            e.zero = "free"
            case.drawn.append(catalogue.Drawn(Effect("offset", j, {"offset": float(rng.uniform(-0.2, 0.2))})))


def uneven_stamps(rng, case):
    multisine(rng, case)
    case.uneven = True


def all_columns(rng, case):
    """Load, temperature, velocity and command are logged, and none of them explains the residual."""
    multisine(rng, case)
    case.columns |= {"effort", "temperature", "velocity", "command"}


def tracker(rng, case):
    multisine(rng, case)
    case.reference = str(rng.choice(["tip", "both"]))
    case.tip_noise = 0.02 * 0.3 * resolution(case).min()


def coupled(rng, case):
    multisine(rng, case)
    n = len(case.encoders)
    if n > 1 and not any(case.robot.prismatic):
        case.coupling = np.eye(n).tolist()
        case.coupling[1][0] = float(rng.choice([1.0, -1.0, 0.5]))


def rounding_down(rng, case):
    stops(rng, case)
    case.encoders = [Encoder(**{**vars(e), "rounding": "down"}) for e in case.encoders]


def fine_encoders(rng, case):
    """Sine/cosine and absolute encoders; some joints do not move."""
    for j, prismatic in enumerate(case.robot.prismatic):
        if not prismatic:
            case.encoders[j] = random_encoder(rng, kind=str(rng.choice(["sincos", "bits"])))
    case.reference_noise = rng.uniform(0.02, 0.1) * resolution(case)
    multisine(rng, case)
    for j in range(1, len(case.encoders)):
        if rng.random() < 0.4:
            case.paths.joints[j] = motions.standstill(case.robot.centre_angle[j])


CLEAN = {f.__name__: f for f in (multisine, stops, slow, standstill, constant_speed, tiny_reference_noise, poor_reference,
                                 free_zero, uneven_stamps, all_columns, tracker, coupled, rounding_down, fine_encoders)}


def clean(rng, name):
    case = base(rng, "a", name, verdict="nothing_wrong")
    CLEAN[name](rng, case)
    case = finish(case, rng, second=False)
    case.truth["effects"] = []
    return case
