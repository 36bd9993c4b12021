"""A case: a machine, its record and the truth about it."""
import math
from dataclasses import dataclass, field

import numpy as np

import motions
from encoders import random_encoder
from machine import Machine
from robots import random_robot


@dataclass
class Case:
    kind: str
    sub: str
    robot: object
    encoders: list
    rate: float
    rows: int
    paths: object = None
    drawn: list = field(default_factory=list)
    verdict: str = "explained"
    coupling: list = None
    reference: str = "joints"
    reference_noise: np.ndarray = None
    tip_noise: float = 0.0
    payload: float = 0.0
    columns: set = field(default_factory=set)
    logged_as_measured: dict = field(default_factory=dict)  # joint -> decimals
    warm_joint: int = 0
    warming: tuple = (3.0, 5.0)                             # K, s
    filter_order: int = 2
    cutoff: float = 50.0
    velocity_factor: dict = field(default_factory=dict)     # joint -> true corner over the spec's
    uneven: bool = False
    comment: bool = False
    pairs: list = field(default_factory=list)
    why: str = ""
    spec_motion: object = None
    record: object = None
    record2: object = None
    truth: dict = None

    def __post_init__(self):
        n = len(self.robot.joints)
        self.time = np.arange(self.rows) / self.rate
        self.spec_motion = motions.Paths([motions.Sines(round(float(c), 4), [(0.05 if slide else 0.6, 0.21 + 0.03 * j, 0.3 * j),
                                                                            (0.01 if slide else 0.1, 0.93 + 0.05 * j, 0.0)])
                                          for j, (c, slide) in enumerate(zip(self.robot.centre_angle, self.robot.prismatic))])
        if self.reference_noise is None:
            self.reference_noise = np.zeros(n)

    def temperature(self, t):
        return 21 - self.warming[0] * np.expm1(-t / self.warming[1])

    def machine(self, noisy=True):
        quiet = np.zeros(len(self.encoders))
        return Machine(self.robot, self.encoders, [d.effect for d in self.drawn], self.coupling,
                       self.reference_noise if noisy else quiet, self.payload, self.tip_noise if noisy else 0.0)


def base(rng, kind, sub, shape=None, seconds=None, encoders=None, **more):
    """A random machine without effects, with the length of its record and the noise of its reference."""
    robot = random_robot(rng, shape)
    encoders = encoders or [random_encoder(rng, p) for p in robot.prismatic]
    while True:
        rate, rows = float(rng.choice([250, 500, 1000, 1000, 2000, 4000])), int(math.exp(rng.uniform(*np.log([1500, 10000]))))
        if (seconds or (1.8, 16))[0] <= rows / rate <= (seconds or (1.8, 16))[1]:
            break
    case = Case(kind, sub, robot, encoders, rate, rows, **more)
    step = np.array([e.resolution for e in encoders])
    case.reference_noise = np.exp(rng.uniform(*np.log([0.01, 0.1]), len(step))) * step
    case.comment, case.warm_joint = bool(rng.random() < 0.3), int(rng.integers(len(step)))
    case.cutoff = float(min(50, rate / 10))
    if rng.random() < 0.15:
        case.columns.add("temperature")  # irrelevant unless the effect is a drift
    if rng.random() < 0.1:
        case.columns.add("command")
    return case


def estimated_velocity(case, measured, joint):
    """The controller's velocity: back difference, then `filter_order` one-pole sections a = exp(-2 pi f T), started in the steady
    state of the first motion."""
    pole = math.exp(-2 * math.pi * case.cutoff * case.velocity_factor.get(joint, 1.0) / case.rate)
    v = np.diff(measured, prepend=2 * measured[0] - measured[1]) * case.rate
    for _ in range(case.filter_order):
        last, out = v[:20].mean(), np.empty_like(v)
        for k, x in enumerate(v):
            last = pole * last + (1 - pole) * x
            out[k] = last
        v = out
    return v


def recorded(case, rng, paths, rows):
    """The machine's record along the paths, with the columns that depend on the complete record."""
    t = np.arange(rows) / case.rate
    if case.uneven:  # uneven instants with correct time stamps are no error
        t = t + np.concatenate([[0], rng.uniform(-0.3, 0.3, rows - 1)]) / case.rate
    record = case.machine().record(paths, t, rng)
    for d in case.drawn:
        e = d.effect
        if e.name == "controller_droop":  # its "load" is the gain times the servo error, which explains that error
            servo = record.model[e.joint] - record.link[e.joint]
            record.effort[e.joint] = e.p["gain"] * servo
    if "velocity" in case.columns:
        record.velocity = np.array([estimated_velocity(case, m, i) for i, m in enumerate(record.measured)])
    return record


# Effects that also appear along the spec's own motion, independent of the record.
REPEATABLE = {"offset", "scale", "eccentricity", "transmission_error", "subdivision_error", "state_width", "backlash",
              "compliance", "latency", "noise", "timing_jitter", "clock_drift"}


def simulated_rms(case):
    """rms of measured - joint along the spec's own motion: the expected result of `qerr simulate` with the extended model.
    None if the effect belongs to the record (an event, a temperature) or if the URDF lacks the load."""
    names = {d.effect.name for d in case.drawn}
    if not names <= REPEATABLE or ("compliance" in names and case.payload):
        return None
    t = np.arange(int(5 * case.rate)) / case.rate
    r = case.machine(noisy=False).record(case.spec_motion, t, np.random.default_rng(1))
    return dict(zip(case.robot.joints, np.sqrt(np.mean((r.measured - r.link) ** 2, axis=1)).tolist()))


def truth_of(case, machine, expected_verdict):
    joints, step = case.robot.joints, machine.resolution
    effects, tolerated = [], []
    for d in case.drawn:
        e = d.effect
        alone = Machine(case.robot, case.encoders, [e], case.coupling, None, case.payload)
        shift = alone.record(case.paths, case.time, np.random.default_rng(0))
        size = d.random_sigma or np.abs(shift.model - shift.link)[e.joint].max()
        if e.name == "reference_error":
            size = e.p["amplitude"]
        if e.name == "geometry":
            size = abs(e.p["length"]) / d.tip_per_count * step[e.joint]
        effects.append({"effect": e.name, "joint": joints[e.joint], "amplitude_counts": float(size / step[e.joint]),
                        "parameters": d.parameters, "also_accept": d.also_accept,
                        "physical": {k: v for k, v in e.p.items() if not callable(v)}})
        tolerated += [{"effect": n, "joint": joints[e.joint]} for n in ["offset"] + d.tolerated]
    out = {"id": None, "kind": case.kind, "sub": case.sub, "verdict": expected_verdict, "effects": effects,
           "tolerated": tolerated, "gain": machine.gain(case.record), "reference": case.reference,
           "resolution": dict(zip(joints, step.tolist())),
           "reference_noise": dict(zip(joints, case.reference_noise.tolist())),
           "tip_noise": case.tip_noise or None}
    if case.record2 is not None:
        out["log2"] = machine.gain(case.record2)
    if case.kind in "bc" and (simulated := simulated_rms(case)):
        out["simulate_rms"] = simulated
        out["coupling"] = {j: dict(zip(joints, row)) for j, row in zip(joints, machine.coupling.tolist())}  # of the encoders
    if case.pairs:
        out["pair"], out["why"] = case.pairs, case.why
    return out


def finish(case, rng, second=True):
    """Records the case along two different motions, and returns the truth."""
    case.record = recorded(case, rng, case.paths, case.rows)
    if second:
        rows = max(1200, int(case.rows * rng.uniform(0.5, 0.8)))
        case.record2 = recorded(case, rng, motions.rich(rng, case.robot, rows / case.rate), rows)
    case.truth = truth_of(case, case.machine(), case.verdict)
    return case
