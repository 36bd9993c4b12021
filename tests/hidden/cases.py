"""Cases with a known truth: a machine, one or two hidden effects of the catalogue or one from outside it, a record and its truth.

Kinds: a clean, b one effect, c two effects, d outside the catalogue, e inseparable. Clean cases are in clean.py, inseparable
pairs in pairs.py. A drawn case is kept only when its effect has a shape of its own in this motion (`told_apart`).
"""
import math
from dataclasses import dataclass, field

import numpy as np

import catalogue
import motions
from encoders import Encoder, random_encoder
from foreign import FOREIGN, Context
from machine import Effect, Machine
from robots import random_robot

ALIKE = 0.95  # shapes that correlate by more than this are not told apart in a record


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

    def machine(self, chance=True):
        quiet = np.zeros(len(self.encoders))
        return Machine(self.robot, self.encoders, [d.effect for d in self.drawn], self.coupling,
                       self.reference_noise if chance else quiet, self.payload, self.tip_noise if chance else 0.0)


def base(rng, kind, sub, shape=None, seconds=None, encoders=None, **more):
    """A random machine without flaws, with its record's length and the noise of its reference."""
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
        case.columns.add("temperature")  # a decoy unless the effect is a drift
    if rng.random() < 0.1:
        case.columns.add("command")
    return case


def estimated_velocity(case, measured, joint):
    """The controller's own: back difference, then `filter_order` one-pole sections a = exp(-2 pi f T), started in the steady
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
    """The machine's record along the paths, with the columns that depend on the whole of it."""
    t = np.arange(rows) / case.rate
    if case.uneven:  # the instants are uneven and the stamps are right: data, not an error
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


# What the spec's motion shows again, whatever the record was.
REPEATABLE = {"offset", "scale", "eccentricity", "transmission_error", "subdivision_error", "state_width", "backlash",
              "compliance", "latency", "noise", "timing_jitter", "clock_drift"}


def simulated_rms(case):
    """rms of measured - joint along the spec's own motion: what `qerr simulate` with the extended model should find.
    None where the flaw belongs to the record (an event, a temperature) or the URDF does not know the load."""
    names = {d.effect.name for d in case.drawn}
    if not names <= REPEATABLE or ("compliance" in names and case.payload):
        return None
    t = np.arange(int(5 * case.rate)) / case.rate
    r = case.machine(chance=False).record(case.spec_motion, t, np.random.default_rng(1))
    return dict(zip(case.robot.joints, np.sqrt(np.mean((r.measured - r.link) ** 2, axis=1)).tolist()))


def truth_of(case, machine, expected_verdict):
    joints, step = case.robot.joints, machine.resolution
    effects, tolerated = [], []
    for d in case.drawn:
        e = d.effect
        alone = Machine(case.robot, case.encoders, [e], case.coupling, None, case.payload)
        shift = alone.record(case.paths, case.time, np.random.default_rng(0))
        size = d.chance or np.abs(shift.model - shift.link)[e.joint].max()
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
    if case.pairs:
        out["pair"], out["why"] = case.pairs, case.why
    return out


def finish(case, rng, second=True):
    """Records the case once, and once more in another motion, and writes down the truth."""
    case.record = recorded(case, rng, case.paths, case.rows)
    if second:
        rows = max(1200, int(case.rows * rng.uniform(0.5, 0.8)))
        case.record2 = recorded(case, rng, motions.rich(rng, case.robot, rows / case.rate), rows)
    case.truth = truth_of(case, case.machine(), case.verdict)
    return case


def told_apart(scene, drawn, machine):
    """Whether the effect has a shape in this motion: not a constant, and none of the other shapes."""
    name = drawn.effect.name
    if name in catalogue.SHAPELESS:
        return True
    shift = machine.record(scene.paths, scene.time, np.random.default_rng(0))
    shift = (shift.model - shift.link)[scene.joint] if name != "reference_error" else np.sin(
        drawn.effect.p["order"] * scene.q[scene.joint])
    if np.std(shift) < 0.25 * np.abs(shift).max():
        return False
    others = catalogue.shapes(scene, drawn.effect.p.get("gap"))
    others.pop(name, None)
    if name.startswith("outside:"):
        return max(catalogue.alike(shift, x) for x in others.values()) < 0.8
    return all(catalogue.alike(shift, x) < ALIKE for x in others.values())


def chosen_encoder(rng, name, size):
    if name == "log_rounding":  # finer than the file: the grid of the log is what one sees
        step = 10.0 ** float(rng.choice([-4, -3.0]))
        return Encoder("resolution", 1.0, round(2 * math.pi / (step / (2 * size))))
    return random_encoder(rng, kind=catalogue.ENCODER.get(name))


def with_effects(rng, kind, names, sizes, tries=400):
    """A case that hides the named effects, each of its size in counts; None when no draw had a shape of its own."""
    for _ in range(tries):
        case = base(rng, kind, "+".join(names))
        revolute = [j for j, p in enumerate(case.robot.prismatic) if not p]
        first = int(rng.choice(revolute))
        joints = [first] + [int(rng.choice(revolute)) for _ in names[1:]]
        if len(revolute) > 1 and kind == "b" and rng.random() < 0.08 and not any(case.robot.prismatic):
            n = len(case.robot.joints)
            case.coupling = np.eye(n).tolist()
            case.coupling[n - 1][n - 2] = 1.0
            joints = [n - 1]
        for name, j, size in zip(names, joints, sizes):
            if name in catalogue.ENCODER:
                case.encoders[j] = chosen_encoder(rng, name, size)
            case.columns |= catalogue.COLUMNS.get(name, set())
            if name == "drift" and rng.random() < 0.5:
                case.columns.add("temperature")
                case.warm_joint = j
        case.reference_noise = np.exp(rng.uniform(*np.log([0.01, 0.1]), len(case.encoders))) * [
            e.resolution for e in case.encoders]
        case.payload = float(rng.choice([0, 0, 1.0, 2.5]))
        seen_by_tip(rng, case, names, kind)
        case.paths = motions.rich(rng, case.robot, case.rows / case.rate)
        if drawn_into(rng, case, names, joints, sizes):
            second = not set(names) & {"missed_counts", "controller_droop"}
            return finish(case, rng, second)
    return None


def seen_by_tip(rng, case, names, kind):
    """Now and then a tracker on the tool is the truth, alone or beside the joints' own."""
    n, dice = len(case.robot.joints), rng.random()
    small = n <= 3 and not case.coupling
    if names == ["geometry"]:
        case.reference = "tip"
    elif small and kind == "b" and dice < 0.08 and set(names) <= {"eccentricity", "backlash", "scale", "latency", "offset"}:
        case.encoders, case.reference = [case.encoders[0]] + [Encoder(**{**vars(case.encoders[0]), "flaws": {}})
                                                              for _ in range(n - 1)], "tip"
    elif dice > 0.93:
        case.reference = "both"
    if case.reference != "joints":
        case.tip_noise = 0.01 * float(rng.uniform(1, 5)) * 0.3 * min(e.resolution for e in case.encoders)


def drawn_into(rng, case, names, joints, sizes):
    shifts = []
    for name, j, size in zip(names, joints, sizes):
        scene = catalogue.Scene(rng, case.robot, case.encoders, case.paths, case.time, j, case.payload,
                                "temperature" in case.columns and case.warm_joint == j)
        per_count = case.encoders[j].resolution
        if name == "geometry":
            per_count = max(e.resolution for e in case.encoders) * 0.5
        drawn = catalogue.MAKERS[name](scene, size * per_count)
        if drawn is None:
            return False
        drawn.tip_per_count = per_count
        case.encoders[j].flaws.update(drawn.flaws)
        if not told_apart(scene, drawn, Machine(case.robot, case.encoders, [drawn.effect], case.coupling, None, case.payload)):
            return False
        case.drawn.append(drawn)
        if name == "drift":
            case.warming = (drawn.effect.p.get("kelvin", 3.0), drawn.effect.p["time_constant"])
        if name == "filter_mismatch":
            case.velocity_factor[j] = drawn.effect.p["factor"]
        if name == "log_rounding":
            case.logged_as_measured[j] = round(-math.log10(drawn.effect.p["step"]))
        alone = Machine(case.robot, case.encoders, [drawn.effect], case.coupling, None, case.payload)
        r = alone.record(case.paths, case.time, np.random.default_rng(0))
        shifts.append((r.model - r.link)[j])
    if len(shifts) == 2 and joints[0] == joints[1] and names[0] != names[1]:
        return catalogue.alike(*shifts) < 0.7
    return True


def size_in_counts(rng, name=None):
    """Half a count to ten, as many small as large."""
    return float(rng.uniform(0.5, 0.93)) if name == "state_width" else math.exp(rng.uniform(*np.log([0.5, 10])))


def one_effect(rng, name=None):
    weights = np.array(list(catalogue.WEIGHT.values()), float)
    name = name or str(rng.choice(list(catalogue.WEIGHT), p=weights / weights.sum()))
    return with_effects(rng, "b", [name], [size_in_counts(rng, name)])


def two_effects(rng):
    names = [str(n) for n in rng.choice(catalogue.PAIRABLE, 2, replace=False)]
    return with_effects(rng, "c", names, [math.exp(rng.uniform(*np.log([1, 10]))) for _ in names])


def outside(rng, name=None, tries=300):
    """One effect that the catalogue does not have, and that is unlike those that it has."""
    name = name or str(rng.choice(list(FOREIGN)))
    for _ in range(tries):
        case = base(rng, "d", name, seconds=(2.5, 16), verdict="unexplained")
        j = int(rng.choice([k for k, p in enumerate(case.robot.prismatic) if not p]))
        case.paths = motions.rich(rng, case.robot, case.rows / case.rate)
        scene = catalogue.Scene(rng, case.robot, case.encoders, case.paths, case.time, j)
        q, size = scene.q[j], math.exp(rng.uniform(*np.log([1, 10])))
        context = Context(scene.duration, q.min(), q.max(), case.encoders[j].to_shaft, np.abs(scene.effort()).max(),
                          np.abs(scene.v[j]).max(), case.paths.joints[j])
        if context.effort < 1e-3:
            continue
        shape, facts, accept = FOREIGN[name](rng, size * case.encoders[j].resolution, context)
        drawn = catalogue.Drawn(Effect("outside:" + name, j, {"shape": shape, **facts}), also_accept=accept)
        if name != "bump" and name != "creep" and not told_apart(scene, drawn, Machine(
                case.robot, case.encoders, [drawn.effect])):
            continue
        case.drawn = [drawn]
        return finish(case, rng, second=False)
    return None
