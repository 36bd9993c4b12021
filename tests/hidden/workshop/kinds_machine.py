"""Faults of the mechanics and of the surroundings."""
import math

import numpy as np

from . import bench, mechanics, paths
from .bench import Unfair, fair, size
from .kinds_encoder import slot

LOST = "hysteresis|reversal"


def pure_play(rng):
    """The encoder leads on the motor, the joint follows through the clearance."""
    b = bench.draw(rng, motions=paths.REVERSING)
    gap = size(rng, b, 1)
    link = mechanics.play_along(b.path, b.t, gap, rng.choice([-1, 0, 1]))
    fair(b, b.q - link, ["direction"])
    return b.record(rng, b.counter.count(b.q), {"causes": [slot("backlash", gap=gap)], "tolerated": ["offset"]}, q=link)


def play_behind(rng):
    """The encoder itself is coupled with play: it lags the joint."""
    b = bench.draw(rng, motions=paths.REVERSING)
    gap = size(rng, b, 1)
    lag = mechanics.play_along(b.path, b.t, gap)
    fair(b, lag - b.q, ["direction"])
    return b.record(rng, b.counter.count(lag), {"causes": [slot("backlash", gap=gap)], "tolerated": ["offset"]})


def wind_up(rng):
    """Friction F at the joint behind a spring k: the joint sticks until k (motor - joint) exceeds F. As to the position that is
    a clearance of 2 F/k; the logged torque of the spring makes it a compliance as well. Either name is right."""
    b = bench.draw(rng, motions=paths.REVERSING, slide=False)
    gap = size(rng, b, 2)
    link = mechanics.play_along(b.path, b.t, gap)
    fair(b, b.q - link, ["direction"])
    b.column("effort", "N m", 2e4 * (b.q - link) + 0.01 * gap * 1e4 * rng.standard_normal(len(link)))
    return b.record(rng, b.counter.count(b.q), {"causes": [slot("backlash", "compliance", "controller_droop")], "says": [LOST],
                                                "tolerated": ["offset", "noise"]}, q=link)


def presliding(rng):
    """Dahl's hysteresis. A play beside it, or in its place, is no wrong name: play is its limit of no travel."""
    b = bench.draw(rng, motions=paths.REVERSING, rows=(6000, 60000))
    width = size(rng, b, 2)
    travel = np.ptp(b.q) * rng.uniform(0.02, 0.08)
    lag = mechanics.presliding(b.q, width, travel)
    fair(b, lag, ["direction"])
    return b.record(rng, b.counter.count(b.q - lag), {"causes": [], "says": [LOST], "tolerated": ["offset", "backlash"]})


def slip(rng):
    """A coupling slips once, by any amount. A whole number of counts can as well be counts that were missed."""
    b = bench.draw(rng)
    by, when = size(rng, b, 3) * rng.choice([-1, 1]), rng.uniform(0.2, 0.8) * b.t[-1]
    whole = rng.random() < 0.4
    by = round(by / b.count) * b.count if whole else (math.floor(by / b.count) + rng.uniform(0.35, 0.65)) * b.count
    near = [slot("missed_counts", time=when)] if whole else []
    return b.record(rng, b.counter.count(b.q + by * (b.t >= when)), {"causes": near, "says": ["step", "slip"], "tolerated": ["offset"]})


def slow_slip(rng):
    b = bench.draw(rng, rows=(5000, 60000))
    by, when, lasts = size(rng, b, 5), rng.uniform(0.2, 0.7) * b.t[-1], rng.uniform(0.01, 0.05) * b.t[-1]
    return b.record(rng, b.counter.count(b.q + by * np.clip((b.t - when) / lasts, 0, 1)), {
        "causes": [], "says": ["step", "slip"], "tolerated": ["offset"]})


def swinging_arm(rng):
    """(bench, link, torque of the spring) of a bar that swings in gravity behind an elastic gear."""
    b = bench.draw(rng, motions=["sines", "random_moves", "jogging", "stop_and_go"], slide=False, rows=(3000, 20000), seconds=(4, 40))
    if np.ptp(b.q) < 0.6:
        raise Unfair
    mass, length = rng.uniform(1, 8), rng.uniform(0.2, 0.6)
    weight = mass * 9.80665 * length
    k = weight / size(rng, b, 2)
    inertia = 1.33 * mass * length**2
    if k / inertia > (2 * math.pi * 60) ** 2 or k / inertia < (2 * math.pi * 5) ** 2 or len(b.t) * b.t[-1] > 4e5:
        raise Unfair
    damping = 0.3 * math.sqrt(k * inertia)
    link, torque = mechanics.spring_mass(b.path, b.t, inertia, k, damping, lambda q: -weight * math.cos(q))
    fair(b, b.q - link)
    return b, link, torque, k


def sensed(rng, torque):
    """Noise of a load sensor, 0.1 to 1 % of what it measures. Times the compliance it is white like noise of the encoder: an
    answer that names `noise` beside the compliance is tolerated."""
    return rng.uniform(0.001, 0.01) * np.std(torque) * rng.standard_normal(len(torque))


def elastic(rng):
    b, link, torque, k = swinging_arm(rng)
    b.column("effort", "N m", torque + sensed(rng, torque), "%.7g")
    return b.record(rng, b.counter.count(b.q), {"causes": [slot("compliance", compliance=1 / k)], "tolerated": ["offset", "noise"],
                                                "alone": True}, q=link)


def elastic_with_friction(rng):
    """The load is the motor's current, with Coulomb friction, viscous friction and an offset in it. Subtracted again, the frictions
    look like play and like a latency: both are tolerated beside the compliance."""
    b, link, torque, k = swinging_arm(rng)
    v = np.gradient(b.q, b.t)
    part = rng.uniform(0.05, 0.25) * np.ptp(torque)
    current = 0.5 * (torque + part * np.tanh(v / (0.02 * np.abs(v).max())) + part * v / np.abs(v).max()) + rng.normal()
    b.column("effort", "A", current + sensed(rng, current), "%.7g")
    return b.record(rng, b.counter.count(b.q), {"causes": [slot("compliance")], "alone": True,
                                                "tolerated": ["offset", "noise", "backlash", "latency"]}, q=link)


def droop(rng):
    """Reference is the setpoint, load is the controller's output P (setpoint - reading): the joint gives way under a force."""
    b = bench.draw(rng, motions=["sines", "random_moves", "ramps"])
    force = paths.random_moves(rng, 1.0, b.t[-1])(b.t) + 0.4 * np.sin(2 * math.pi * rng.uniform(3, 9) * b.t / b.t[-1])
    gives = size(rng, b, 4) * force
    fair(b, gives)
    counts = b.counter.count(b.q + gives)
    setpoint = b.q
    b.noise = 0.0
    b.column("effort", "A", 3.0 / b.count * (setpoint - counts * b.counter.step), "%.6g")
    return b.record(rng, counts, {"causes": [slot("controller_droop")], "tolerated": ["offset"]}, reference=setpoint)


def growth(rng):
    """A screw grows with its temperature: error = position x expansion x rise."""
    b = bench.draw(rng, motions=paths.REVERSING, slide=True, rows=(5000, 60000), seconds=(10, 300))
    rise = mechanics.warmth(b.t, rng.uniform(0.15, 0.6) * b.t[-1], 1.0)
    x = size(rng, b, 3) / np.abs(b.q).max()
    error = x * rise * b.q
    fair(b, error, [], 0.97)
    if rng.random() < 0.5:
        b.column("temperature", "degC", np.round((21 + 8 * rise) * 20) / 20, "%.2f")
    return b.record(rng, b.counter.count(b.q - error), {"causes": [], "says": ["in proportion to the position"],
                                                        "tolerated": ["offset", "scale"]})


def warming(rng):
    """The zero wanders while the machine warms up."""
    b = bench.draw(rng, motions=paths.REVERSING, rows=(5000, 60000), seconds=(5, 300))
    tau = rng.uniform(0.1, 0.4) * b.t[-1]
    rise = mechanics.warmth(b.t, tau, 1.0)
    x = size(rng, b, 2)
    if rng.random() < 0.4:
        b.column("temperature", "degC", np.round((21 + 5 * rise) * 20) / 20, "%.2f")
    fair(b, x * rise, ["time"])
    return b.record(rng, b.counter.count(b.q + x * rise), {"causes": [slot("drift")], "tolerated": ["offset"]})


def creep(rng):
    b = bench.draw(rng, motions=["stop_and_go", "both_sides", "poses"], rows=(4000, 60000), seconds=(4, 120))
    speed = np.abs(np.gradient(b.q, b.t))
    rest = np.median(np.diff(np.flatnonzero(np.diff((speed > 1e-9).astype(int))))) * (b.t[1] - b.t[0])
    x = size(rng, b, 4)
    error = mechanics.settling(b.q, b.t, rest * rng.uniform(0.15, 0.35), x, 1e-9)
    fair(b, error, [], 0.85)
    return b.record(rng, b.counter.count(b.q + error), {"causes": [], "says": ["after each stop", "exponential"], "tolerated": ["offset"]})


def hum(rng):
    """A vibration of a fixed frequency: the mains, twice the mains, or a fan."""
    b = bench.draw(rng, rows=(4000, 60000), noise=(0.005, 0.05))
    f = float(rng.choice([50, 60, 100, 120, round(rng.uniform(11, 180), 1)]))
    if f > 0.4 / (b.t[1] - b.t[0]) or f * b.t[-1] < 100:
        raise Unfair
    x = math.exp(rng.uniform(*np.log([0.8, 20]))) * b.count
    truth = {"causes": [], "says": ["vibrates", "line"], "tolerated": ["offset"], "frequency": f}
    return b.record(rng, b.counter.count(b.q + x * np.sin(2 * math.pi * f * b.t + 1)), truth)


KINDS = [pure_play, play_behind, wind_up, presliding, slip, slow_slip, elastic, elastic_with_friction, droop, growth, warming, creep, hum]
