"""Draws cases that hide one or two effects of the catalogue, or one from outside it.

Kinds: a clean, b one effect, c two effects, d outside the catalogue, e inseparable. Clean cases are in clean.py, inseparable
pairs in pairs.py. A drawn case is kept only when its effect is `distinguishable` in this motion.
"""
import math

import numpy as np

import catalogue
import motions
from case import base, finish
from encoders import Encoder, random_encoder
from foreign import FOREIGN, Context
from machine import Effect, Machine

INDISTINGUISHABLE = 0.95  # |correlation| of two effects above which a record cannot distinguish them


def distinguishable(scene, drawn, machine):
    """Whether the effect is distinguishable in this motion: neither constant nor like another effect."""
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
        return max(catalogue.correlation(shift, x) for x in others.values()) < 0.8
    return all(catalogue.correlation(shift, x) < INDISTINGUISHABLE for x in others.values())


def chosen_encoder(rng, name, size):
    if name == "log_rounding":  # finer than the file: the grid of the log is observed
        step = 10.0 ** float(rng.choice([-4, -3.0]))
        return Encoder("resolution", 1.0, round(2 * math.pi / (step / (2 * size))))
    return random_encoder(rng, kind=catalogue.ENCODER.get(name))


def with_effects(rng, kind, names, sizes, tries=400):
    """A case that hides the named effects, each of its size in counts; None if no draw was distinguishable."""
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
    """In some cases a tracker on the tool is the reference, alone or in addition to the joints' references."""
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
        if not distinguishable(scene, drawn, Machine(case.robot, case.encoders, [drawn.effect], case.coupling, None, case.payload)):
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
        return catalogue.correlation(*shifts) < 0.7
    return True


def size_in_counts(rng, name=None):
    """0.5 to 10 counts, uniform in the logarithm."""
    return float(rng.uniform(0.5, 0.93)) if name == "state_width" else math.exp(rng.uniform(*np.log([0.5, 10])))


def one_effect(rng, name):
    return with_effects(rng, "b", [name], [size_in_counts(rng, name)])


def two_effects(rng):
    names = [str(n) for n in rng.choice(catalogue.PAIRABLE, 2, replace=False)]
    return with_effects(rng, "c", names, [math.exp(rng.uniform(*np.log([1, 10]))) for _ in names])


def outside(rng, name, tries=300):
    """One effect outside the catalogue, distinguishable from those in it."""
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
        if name != "bump" and name != "creep" and not distinguishable(scene, drawn, Machine(
                case.robot, case.encoders, [drawn.effect])):
            continue
        case.drawn = [drawn]
        return finish(case, rng, second=False)
    return None
