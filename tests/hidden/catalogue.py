"""Draws one effect of the catalogue, of a given size in counts, for a joint of a given machine in a given motion.

Each maker takes a `Scene` and a size [rad or m at the joint] and returns a `Drawn`: the effect (or the flaw set on the encoder),
the parameters that an analysis should find, and what else it may rightly say.
"""
import math
from dataclasses import dataclass, field

import numpy as np

from machine import Effect, play


@dataclass
class Scene:
    rng: np.random.Generator
    robot: object
    encoders: list
    paths: object
    time: np.ndarray
    joint: int
    payload: float = 0.0
    temperature: bool = False
    fixed: dict = field(default_factory=dict)  # parameters with the same value in a second record

    def __post_init__(self):
        self.q, self.v, self.a = self.paths.at(self.time)

    @property
    def encoder(self):
        return self.encoders[self.joint]

    @property
    def duration(self):
        return self.time[-1] - self.time[0]

    def effort(self):
        return self.robot.effort(self.q, self.v, self.a, self.payload)[self.joint]

    def peak(self, x):
        return np.abs(x).max()


@dataclass
class Drawn:
    effect: Effect
    parameters: list = field(default_factory=list)
    also_accept: list = field(default_factory=list)
    tolerated: list = field(default_factory=list)
    flaws: dict = field(default_factory=dict)      # set on the joint's encoder
    random_sigma: float = 0.0                      # standard deviation [rad] if it is random and has no expected shape


def parameter(name, values, unit, *aliases):
    return {"name": name, "values": [float(v) for v in np.atleast_1d(values)], "unit": unit, "aliases": list(aliases)}


def phase_of(s):
    return float(s.rng.uniform(0, 2 * math.pi))


def offset(s, size):
    size *= s.rng.choice([-1, 1])
    return Drawn(Effect("offset", s.joint, {"offset": size}), [parameter("offset", size, "rad")])


def scale(s, size):
    x = size / s.peak(s.q[s.joint]) * s.rng.choice([-1, 1])
    return Drawn(Effect("scale", s.joint, {"scale": x}), [parameter("scale", x, "", "ratio")])


def eccentricity(s, size):
    e, phase = size * abs(s.encoder.to_shaft), phase_of(s)
    if e > 0.3:
        return None
    return Drawn(Effect("eccentricity", s.joint, {"eccentricity": e, "phase": phase}),
                 [parameter("amplitude", [size, e], "rad"), parameter("order", [1.0, s.encoder.to_shaft], "")],
                 tolerated=["transmission_error"], flaws={"eccentricity": (e, phase)})


def transmission_error(s, size):
    """Order 2 to 6 of the encoder's shaft (flexspline, poles), or the teeth of a wheel on the joint."""
    to_shaft, phase = s.encoder.to_shaft, phase_of(s)
    if s.rng.random() < 0.7 or to_shaft == 1:
        shaft, order = "encoder", int(s.rng.choice([2, 2, 3, 4, 6]))
        orders = [order, order * to_shaft]
    else:
        shaft, order = "joint", int(s.rng.integers(7, 60))
        orders = [order, order / to_shaft]
        if abs(orders[1] - round(orders[1])) < 0.05:
            return None
    p = {"amplitude": size, "phase": phase, "order": order, "shaft": shaft}
    return Drawn(Effect("transmission_error", s.joint, p),
                 [parameter("amplitude", [size, size * to_shaft], "rad"), parameter("order", orders, "")],
                 tolerated=["eccentricity"] if order == 1 else [])


def subdivision_error(s, size):
    """Two of the errors of sine and cosine, scaled together to the given peak error."""
    e, rng = s.encoder, s.rng
    names = list(rng.choice(["offset_sin", "offset_cos", "gain", "phase", "clipping"], 2, replace=False))
    weight = {n: rng.uniform(0.4, 1.0) * (1 if n == "clipping" else rng.choice([-1, 1])) for n in names}
    turn = np.linspace(0, 2 * np.pi, 721) / (e.to_shaft * e.periods)

    def flaws(k):
        return {n: 1 - k * w if n == "clipping" else k * w for n, w in weight.items()}

    def peak(k):
        e.flaws["heydemann"] = flaws(k)
        return np.abs(e.interpolated(turn) - turn).max()
    low, high = 0.0, 0.6
    try:
        if peak(high) < size:
            return None
        for _ in range(50):
            middle = (low + high) / 2
            low, high = (middle, high) if peak(middle) < size else (low, middle)
    finally:
        e.flaws.pop("heydemann")
    found = flaws(high)
    return Drawn(Effect("subdivision_error", s.joint, found),
                 [parameter(n, x, "rad" if n == "phase" else "") for n, x in found.items()], flaws={"heydemann": found})


def state_width(s, size):
    shift = size / s.encoder.resolution
    if shift > 0.95:
        return None
    phase = 2 * math.pi * shift / 4 * s.rng.choice([-1, 1])
    return Drawn(Effect("state_width", s.joint, {"phase": phase}), [parameter("phase", phase, "rad")],
                 flaws={"quadrature": phase})


def missed_counts(s, size):
    each = max(1, round(size / s.encoder.resolution))
    number = int(s.rng.choice([1, 1, 2, 3]))
    lost = [int(each * s.rng.choice([-1, 1])) for _ in range(number)]
    if abs(np.cumsum(lost)).max() < each:
        return None
    times = s.time[0] + s.duration * (np.arange(number) + s.rng.uniform(0.35, 0.65, number)) / number
    return Drawn(Effect("missed_counts", s.joint, {"times": times.tolist(), "counts": lost}))


def decoding(s, size):
    every = int(s.rng.choice([2, 4]))
    return Drawn(Effect("decoding", s.joint, {"factor": 1 / every}), [parameter("factor", [1 / every, every], "")],
                 flaws={"counts_every": every})


def backlash(s, size):
    return Drawn(Effect("backlash", s.joint, {"gap": 2 * size}), [parameter("gap", 2 * size, "rad", "backlash", "width")])


def compliance(s, size):
    c = size / s.peak(s.effort())
    return Drawn(Effect("compliance", s.joint, {"compliance": c}),
                 [parameter("compliance", [c, -c], "rad/(N m)", "c"), parameter("stiffness", 1 / c, "N m/rad", "k")])


def latency(s, size):
    delay = size / s.peak(s.v[s.joint])
    return Drawn(Effect("latency", s.joint, {"delay": delay}), [parameter("delay", delay, "s", "latency", "time", "tau")])


def timing_jitter(s, size):
    sigma = size / s.peak(s.v[s.joint])
    return Drawn(Effect("timing_jitter", s.joint, {"sigma": sigma}), [parameter("sigma", sigma, "s")], random_sigma=size)


def clock_drift(s, size):
    rate = size / s.peak(s.time * s.v[s.joint]) * s.rng.choice([-1, 1])
    return Drawn(Effect("clock_drift", s.joint, {"rate": rate}), [parameter("rate", [rate, -rate], "")])


def noise(s, size):
    size = min(size, 3 * s.encoder.resolution)
    return Drawn(Effect("noise", s.joint, {"sigma": size}), [parameter("sigma", size, "rad")], random_sigma=size)


def drift(s, size):
    constant = s.duration * s.rng.uniform(0.15, 0.5)
    size *= s.rng.choice([-1, 1]) / -math.expm1(-s.duration / constant)
    found = [parameter("amplitude", size, "rad"), parameter("time_constant", constant, "s")]
    p = {"amplitude": size, "time_constant": constant}
    if s.temperature:
        p["kelvin"] = float(s.rng.uniform(4, 15))
        found.append(parameter("coefficient", size / p["kelvin"], "rad/K"))
    return Drawn(Effect("drift", s.joint, p), found)


def rollover(s, size):
    """A counter with too few bits for the motion: the largest power of two that wraps."""
    counts = np.abs(s.q[s.joint]).max() / s.encoder.resolution
    modulus = 2 ** math.floor(math.log2(2 * counts))
    wrapped = np.abs(s.q[s.joint]) / s.encoder.resolution > modulus / 2
    if modulus < 256 or not 0.03 < wrapped.mean() < 0.9:
        return None
    return Drawn(Effect("rollover", s.joint, {"modulus": modulus}), [parameter("modulus", modulus, "counts")])


def geometry(s, size):
    """A link longer than its drawing, measured by a tracker; size is the displacement of the tip [m]."""
    j, r = s.joint, s.robot
    axis = "xyz"[int(np.argmax(np.abs(r.xyz[j])))]
    along = np.eye(3)["xyz".index(axis)]
    if j == 0 or abs(along @ r.axis[j - 1]) > 0.1 or abs(along @ r.axis[j]) > 0.1 or any(r.prismatic):
        return None
    length = size * s.rng.choice([-1, 1])
    return Drawn(Effect("geometry", j, {"axis": axis, "length": length}), [parameter("length", length, "m")])


def reference_error(s, size):
    """A stepper motor as reference: orders 50 and multiples, which indicate the reference and not the joint."""
    order, phase = int(s.rng.choice([50, 100, 200])), phase_of(s)
    ratio = order / s.encoder.to_shaft
    if abs(ratio - round(ratio)) < 0.02:
        return None
    return Drawn(Effect("reference_error", s.joint, {"amplitude": size, "phase": phase, "order": order}),
                 [parameter("amplitude", size, "rad"), parameter("order", order, "")],
                 also_accept=[{"effect": "transmission_error", "orders": [order, ratio], "tolerance": 0.004}])


def log_rounding(s, size):
    step = 10.0 ** round(math.log10(2 * size))
    return Drawn(Effect("log_rounding", s.joint, {"step": step}), [parameter("step", step, "rad")], random_sigma=step / 2)


def controller_droop(s, size):
    """The set point as `reference`, and a `load` that is the controller's gain times the servo error."""
    j, path = s.joint, s.paths.joints[s.joint]
    top = s.peak(s.v[j] + 0.05 * s.a[j])
    droop = lambda t: -size / top * (path.at(t)[1] + 0.05 * path.at(t)[2])
    return Drawn(Effect("controller_droop", j, {"droop": droop, "gain": -float(s.rng.uniform(20, 300)) / size}),
                 tolerated=["latency"])


def filter_mismatch(s, size):
    """The cut-off of the controller's velocity filter differs from the spec's."""
    factor = float(s.rng.choice([0.2, 0.35, 2.5, 4.0]))
    return Drawn(Effect("filter_mismatch", s.joint, {"factor": factor}), random_sigma=size)


MAKERS = {f.__name__: f for f in (offset, scale, eccentricity, transmission_error, subdivision_error, state_width,
                                  missed_counts, decoding, backlash, compliance, latency, timing_jitter, clock_drift, noise,
                                  drift, rollover, geometry, reference_error, log_rounding, controller_droop,
                                  filter_mismatch)}
# Relative frequency, required encoder, and the columns besides counts and reference that are needed to identify the effect.
WEIGHT = {"offset": 1, "scale": 2, "eccentricity": 3, "transmission_error": 3, "subdivision_error": 2, "state_width": 1,
          "missed_counts": 2, "decoding": 1, "backlash": 3, "compliance": 2, "latency": 3, "timing_jitter": 1,
          "clock_drift": 1, "noise": 2, "drift": 2, "rollover": 1, "geometry": 1, "reference_error": 1, "log_rounding": 1,
          "controller_droop": 1, "filter_mismatch": 1}
ENCODER = {"subdivision_error": "sincos", "state_width": "lines", "decoding": "lines", "log_rounding": "resolution"}
COLUMNS = {"compliance": {"effort"}, "controller_droop": {"effort"}, "filter_mismatch": {"velocity"}}
# Effects with zero mean, or with a mean that no other effect resembles.
SHAPELESS = {"offset", "state_width", "missed_counts", "decoding", "timing_jitter", "noise", "rollover", "geometry",
             "log_rounding", "filter_mismatch", "controller_droop"}
PAIRABLE = ["scale", "eccentricity", "transmission_error", "backlash", "compliance", "latency", "noise", "drift", "offset",
            "missed_counts", "subdivision_error"]


def shapes(s, gap=None):
    """Contributions of the other effects in this record, to check that the true one is distinguishable."""
    j, out = s.joint, {}
    out["latency"] = s.v[j]
    out["scale"] = s.q[j]
    out["clock_drift"] = s.time * s.v[j]
    out["drift"] = -np.expm1(-s.time / (0.3 * s.duration))
    out["compliance"] = s.effort()
    out["backlash"] = s.q[j] - play(s.q[j], gap or 2 * s.encoder.resolution)
    return out


def correlation(x, y):
    """|correlation| of two shapes; 1 where one of them is constant."""
    x, y = x - x.mean(), y - y.mean()
    norm = np.linalg.norm(x) * np.linalg.norm(y)
    return 1.0 if norm == 0 else abs(x @ y) / norm
