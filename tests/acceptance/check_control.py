#!/usr/bin/env python3
"""Checks controllers, loops and walls of `qerr analyze` against an own computation and simulations.

    check_control.py --qerr PATH [--count 12] [--inertias 0] [--loops 8] [--effects 4] [--unstable 6] [--walls 6] [--seed 1]

Random planar arms of two joints with masses, couplings, velocity filters, gains, delays (fractions of a sample, too) and
stated or varying inertias. Torques: norms of the impulse response kp + kd h. Closed loops: responses by a matrix
exponential of the plant, at every configuration; margins on a grid, refined by bisection; unstable loops by the growth of
their response. Stable loops are then simulated with the quantizer in the loop at random offsets: never above the bounds.
Walls: the formulas.

--loops: single joints, whose bounds are those that the program states, with the quantizer in the loop from many starts and
offsets at once; --effects: with an effect that changes them, read and driven at parts of a sample; --slow: accuracies and eccentricities at constant speeds, by the responses' values at their frequencies; --unstable: loops above their critical gain by a millionth or more, and loops without damping; --walls:
energy of random hand motions at 0.99 of the program's limit, and of the two critical motions of one axis at 1.3 of it.
"""
import argparse
import json
import math
import pathlib
import random
import tempfile

import numpy as np

import filters
from tool import Tally, Worst, run

URDF = """<robot name="arm"><link name="base"/>
<link name="upper"><inertial><origin xyz="{c1} 0 0"/><mass value="{m1}"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01"
 iyz="0" izz="{i1}"/></inertial></link>
<link name="lower"><inertial><origin xyz="{c2} 0 0"/><mass value="{m2}"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01"
 iyz="0" izz="{i2}"/></inertial></link><link name="tip"/>
<joint name="a1" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="10" velocity="9"/></joint>
<joint name="a2" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="{l1} 0 0"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="10" velocity="9"/></joint>
<joint name="end" type="fixed"><parent link="lower"/><child link="tip"/><origin xyz="{l2} 0 0"/></joint></robot>
"""


class Case:
    def __init__(self, rng):
        u = rng.uniform
        self.arm = {"l1": u(0.2, 0.6), "l2": u(0.2, 0.6), "c1": u(0.1, 0.2), "c2": u(0.1, 0.2), "m1": u(1, 5),
                    "m2": u(0.5, 4), "i1": u(0.01, 0.1), "i2": u(0.01, 0.1)}
        self.points = [[u(-2.9, 2.9), u(-2.9, 2.9)] for _ in range(4)]
        self.coupling = np.array([[1, 0], [rng.choice([0, 0, 1, -0.5]), 1]])
        self.bits = [rng.randint(12, 18) for _ in range(2)]
        self.rate = rng.choice([500, 1000, 4000])
        self.filter = {"derivative": 1, "sample_rate": self.rate}
        if rng.random() < 0.8:
            self.filter["lowpass"] = {"family": rng.choice(["first_order", "butterworth"]), "order": rng.randint(1, 2),
                                      "cutoff": self.rate * u(0.02, 0.2)}
        self.delay = rng.choice([0, 1, 2, u(0, 2)]) / self.rate
        self.joints, damped = [], rng.random() < 0.6
        for j in range(2):
            inertia = u(0.05, 2) if rng.random() < 0.5 else None
            typical = inertia or (0.5, 0.1)[j]
            omega = self.rate * 10 ** u(-2.5, -1.1)
            self.joints.append({"kp": typical * omega**2, "kd": 2 * u(0.3, 1.2) * typical * omega, "inertia": inertia,
                                "damping": u(0.01, 1) if damped or rng.random() < 0.3 else 0, "friction": u(0.05, 1)})
        self.normal = [u(-1, 1), u(-1, 1), 0]

    def spec(self):
        low = self.filter.get("lowpass")
        lowpass = "" if not low else ", lowpass: {family: %s, order: %d, cutoff: %r}" % (
            low["family"], low["order"], low["cutoff"])
        joints = ""
        for name, j in zip(("a1", "a2"), self.joints):
            inertia = "" if j["inertia"] is None else f"inertia: {j['inertia']!r}, "
            joints += (f"    {name}: {{kp: {j['kp']!r}, kd: {j['kd']!r}, velocity: v, {inertia}"
                       f"damping: {j['damping']!r}, friction: {j['friction']!r}}}\n")
        walls = f"walls: {{w: {{normal: {self.normal}}}}}\n" if all(j["damping"] for j in self.joints) else ""
        encoders = f"{{a1: {{bits: {self.bits[0]}}}, a2: {{bits: {self.bits[1]}}}}}"
        return (f"qerr: 1\nrobot: {{urdf: arm.urdf}}\nencoders: {encoders}\n"
                f"coupling: {self.coupling.tolist()}\ncoordinates: [x, y]\n"
                f"filters: {{v: {{derivative: 1, sample_rate: {self.rate}{lowpass}}}}}\n"
                f"control:\n  delay: {self.delay!r}\n  joints:\n{joints}{walls}"
                f"configurations: {{method: list, points: {self.points}}}\n")

    def delta(self):
        return np.array([2 * math.pi / 2**b for b in self.bits])

    def inertia(self, j, q):
        a = self.arm
        if self.joints[j]["inertia"] is not None:
            return self.joints[j]["inertia"]
        if j == 1:
            return a["i2"] + a["m2"] * a["c2"] ** 2
        return (a["i1"] + a["i2"] + a["m1"] * a["c1"] ** 2
                + a["m2"] * (a["l1"] ** 2 + a["c2"] ** 2 + 2 * a["l1"] * a["c2"] * math.cos(q[1])))

    def jacobian(self, q):
        a, s, c = self.arm, math.sin, math.cos
        return np.array([[-a["l1"] * s(q[0]) - a["l2"] * s(q[0] + q[1]), -a["l2"] * s(q[0] + q[1])],
                         [a["l1"] * c(q[0]) + a["l2"] * c(q[0] + q[1]), a["l2"] * c(q[0] + q[1])]])


def exponential(matrix):
    halvings = max(0, int(math.ceil(math.log2(np.abs(matrix).sum() + 1e-300))) + 4)
    m, total, term = matrix / 2**halvings, np.eye(len(matrix)), np.eye(len(matrix))
    for k in range(1, 20):
        term = term @ m / k
        total = total + term
    for _ in range(halvings):
        total = total @ total
    return total


def held(inertia, damping, t):
    """State matrix and input column of M q'' + b q' = u over t."""
    e = exponential(np.array([[0, 1, 0], [0, -damping / inertia, 1 / inertia], [0, 0, 0]]) * t)
    return e[:2, :2], e[:2, 2]


class Loop:
    """One joint's loop as a state space: position, velocity, past torques, sections of the velocity filter."""

    def __init__(self, case, j, inertia):
        self.case, self.joint = case, case.joints[j]
        samples = case.delay * case.rate
        whole = round(samples) if abs(samples - round(samples)) < 1e-9 else math.floor(samples)
        late = max(0.0, samples - whole)
        self.early = held(inertia, self.joint["damping"], late / case.rate)
        self.after = held(inertia, self.joint["damping"], (1 - late) / case.rate)
        self.whole, self.late = whole, late
        self.sections = [(np.array(b, dtype=float), np.array(a, dtype=float)) for b, a in filters.sections_of(case.filter)]

    def filtered(self, value, states):
        """One sample of the velocity filter; the states are past inputs and outputs of each section."""
        for (b, a), (ins, outs) in zip(self.sections, states):
            ins.insert(0, value)
            ins.pop()
            value = sum(c * v for c, v in zip(b, ins)) - sum(c * v for c, v in zip(a[1:], outs))
            if outs:
                outs.insert(0, value)
                outs.pop()
        return value

    def at_rest(self):
        """Past torques, and states of the filter."""
        return [0.0] * (self.whole + 2), [([0.0] * len(b), [0.0] * (len(a) - 1)) for b, a in self.sections]

    def sample(self, x, past, states, reading, first=0.0):
        """The motion after one sample, and its torque; `first`: the reading at which the filter has rested."""
        u = -self.joint["kp"] * reading - self.joint["kd"] * self.filtered(reading - first, states)
        past.insert(0, u)
        past.pop()
        if self.late > 0:
            x = self.early[0] @ x + self.early[1] * past[self.whole + 1]
        return self.after[0] @ x + self.after[1] * past[self.whole], u

    def quantized(self, count, quantum, offset, start):
        """Motion and torque; the reading is q rounded to multiples of a quantum about an offset."""
        x, (past, states), first = np.array(start), self.at_rest(), None
        motions, torques = [], []
        for _ in range(count):
            reading = quantum * math.floor((x[0] - offset) / quantum + 0.5) + offset
            first = reading if first is None else first
            motions.append(x[0])
            x, u = self.sample(x, past, states, reading, first)
            torques.append(u)
        return np.array(motions), np.array(torques)

    def sampled(self, state, error=0.0):
        """`sample` of a state as one vector, of the reading q + error."""
        past, states = self.at_rest()
        numbers = iter(state[2:])
        for values in (past, *(values for section in states for values in section)):
            values[:] = [next(numbers) for _ in values]
        x, u = self.sample(state[:2], past, states, state[0] + error)
        return np.concatenate([x, past, *(values for section in states for values in section)]), u

    def after_error(self, count):
        """Motion and torque after an error of 1 in the first reading; None where they grow without end."""
        past, states = self.at_rest()
        size = 2 + len(past) + sum(len(values) for section in states for values in section)
        state, first = self.sampled(np.zeros(size), 1.0)
        columns = [self.sampled(unit) for unit in np.eye(size)]  # a sample is linear
        power = np.array([column for column, _ in columns]).T
        rows = np.array([[np.eye(size)[0], [u for _, u in columns]]])
        for _ in range(6):  # the 64 samples that follow a state
            rows, power = np.concatenate([rows, rows @ power]), power @ power
        parts = [np.array([[0.0, first]])]
        for _ in range(0, count, len(rows)):
            parts.append(rows @ state)
            state = power @ state
            if not np.abs(parts[-1][:, 0]).max() < 1e12:
                return None
        return tuple(np.concatenate(parts)[:count].T)

    def response(self):
        for count in (1000, 4000, 16000, 64000, 256000):
            r = self.after_error(count)
            if r is None:
                return None
            if max(np.abs(x[-count // 8:]).sum() / np.abs(x).sum() for x in r) < 1e-12:
                return r
        return r if max(np.abs(x[-count // 8:]).sum() / np.abs(x).sum() for x in r) < 1e-3 else None

    def open(self, omega):
        """L at e^(j omega)."""
        q, case = np.exp(-1j * omega), self.case
        h = 1
        for b, a in self.sections:
            h = h * sum(c * q**k for k, c in enumerate(b)) / sum(c * q**k for k, c in enumerate(a))
        # x+ = A x + B0 u(k - d) + B1 u(k - d - 1)
        a = self.after[0] @ self.early[0]
        sooner, later = self.after[1], self.after[0] @ self.early[1] * (self.late > 0)
        b = [sooner[i] * q**self.whole + later[i] * q ** (self.whole + 1) for i in range(2)]
        z = 1 / q
        determinant = (z - a[0, 0]) * (z - a[1, 1]) - a[0, 1] * a[1, 0]
        g = ((z - a[1, 1]) * b[0] + a[0, 1] * b[1]) / determinant
        return g * (self.joint["kp"] + self.joint["kd"] * h)

    def margins(self):
        grid = np.concatenate([np.geomspace(1e-5, 0.1, 3000), np.linspace(0.1, math.pi, 6000)[1:]])
        values = self.open(grid)

        def crossings(of):
            f = of(values)
            for i in np.nonzero(f[:-1] * f[1:] < 0)[0]:
                lower, upper = grid[i], grid[i + 1]
                for _ in range(80):
                    middle = 0.5 * (lower + upper)
                    if of(self.open(middle)) * f[i] > 0:
                        lower = middle
                    else:
                        upper = middle
                yield middle

        gains = [1 / -v.real for v in map(self.open, crossings(lambda v: v.imag)) if v.real < 0]
        last = self.open(math.pi)
        if last.real < 0:
            gains.append(-1 / last.real)
        phases = [abs(np.angle(-self.open(w))) for w in crossings(lambda v: np.abs(v) - 1)]
        band = [w for w in crossings(lambda v: np.abs(v / (1 + v)) - math.sqrt(0.5))]
        return {"gain_margin": min([g for g in gains if g > 1], default=math.inf),
                "phase_margin": min(phases, default=math.inf),
                "bandwidth": min(band, default=math.nan) * self.case.rate / (2 * math.pi)}


def l1(h):
    return float(np.abs(h).sum())


def h2(h):
    return float(np.sqrt((h * h).sum()))


def summed(parts):
    total = np.zeros(max(map(len, parts)))
    for p in parts:
        total[:len(p)] += p
    return total


def check_case(case, report, worst, reached, tally, rng, name, searched=False):
    delta, coupling = case.delta(), case.coupling
    velocity = filters.impulse(case.filter).astype(float)
    by_signal = {}
    for row in report["position"]:
        by_signal[row.get("signal", "position"), row["coordinate"]] = row
    for row in report["derivatives"]:
        for c in row["coordinates"]:
            by_signal[row.get("signal", row["filter"]), c["coordinate"]] = c
    for j, joint in enumerate(("a1", "a2")):
        h = case.joints[j]["kd"] * velocity
        h[0] += case.joints[j]["kp"]
        row = by_signal["torque", joint]
        worst["torque"].add(f"{name} {joint} worst", row["worst_case"]["max"], l1(h) * np.abs(coupling[j]) @ delta / 2)
        worst["torque"].add(f"{name} {joint} sigma", row["sigma"]["max"], h2(h) * math.sqrt(coupling[j] ** 2 @ delta**2 / 12))
    loops = [[Loop(case, j, case.inertia(j, q)) for j in range(2)] for q in case.points]
    responses = [[loop.response() for loop in of_point] for of_point in loops]
    stable = [all(r[j] is not None for r in responses) for j in range(2)]
    for j, joint in enumerate(("a1", "a2")):
        told = report["control"]["loops"][j]
        # At an inertia between those of the configurations a loop may be unstable that is not at them.
        between = stable[j] and told["gain_margin"] is not None and told["gain_margin"] < 1
        tally.check(f"{name} {joint} stability", told["stable"] == stable[j] or between, f"{told} {stable}")
        if not stable[j]:
            continue
        for kind, part in (("closed_position", 0), ("closed_torque", 1)):
            row = by_signal[kind, joint]
            worst["closed"].add(f"{name} {kind} {joint}", row["worst_case"]["max"],
                                max(l1(r[j][part]) for r in responses) * np.abs(coupling[j]) @ delta / 2)
            worst["closed"].add(f"{name} {kind} {joint} sigma", row["sigma"]["max"],
                                max(h2(r[j][part]) for r in responses) * math.sqrt(coupling[j] ** 2 @ delta**2 / 12))
        if case.joints[j]["inertia"] is not None or j == 1:
            for key, value in loops[0][j].margins().items():
                if math.isfinite(value):
                    worst["margin"].add(f"{name} {joint} {key}", told[key], value)
        elif searched and told["stable"]:
            check_inertias(case, told, worst["margin"], f"{name} {joint}")
        count = np.abs(coupling[j]) @ delta
        if np.count_nonzero(coupling[j]) == 1:
            reached.append(check_quantized(loops[0][j], responses[0][j], count, tally, rng, f"{name} {joint}"))
    if all(stable):
        for i, c in enumerate(("x", "y")):
            worst_case, sigma = [], []
            for q, r in zip(case.points, responses):
                row = case.jacobian(q)[i]
                parts = [summed([row[j] * coupling[j, e] * r[j][0] for j in range(2)]) for e in range(2)]
                worst_case.append(sum(l1(p) * d / 2 for p, d in zip(parts, delta)))
                sigma.append(math.sqrt(sum(h2(p) ** 2 * d**2 / 12 for p, d in zip(parts, delta))))
            row = by_signal["closed_position", c]
            worst["closed"].add(f"{name} tip {c}", row["worst_case"]["max"], max(worst_case))
            worst["closed"].add(f"{name} tip {c} sigma", row["sigma"]["mean"], float(np.mean(sigma)))
    if report["control"]["walls"]:
        check_wall_figures(case, report["control"]["walls"][0], worst["wall"], name)


def check_inertias(case, told, worst, name):
    """The least margins between the inertias of the configurations: on a grid, then by golden sections about the least."""
    inertias = [case.inertia(0, q) for q in case.points]
    low, ratio = min(inertias), math.log(max(inertias) / min(inertias))
    known = {}

    def at(place):
        if place not in known:
            known[place] = Loop(case, 0, low * math.exp(ratio * place)).margins()
        return known[place]

    grid = np.linspace(0, 1, 25)
    for key in ("gain_margin", "phase_margin", "bandwidth"):
        values = [at(g)[key] for g in grid]
        if not all(map(math.isfinite, values)):
            continue
        i = int(np.argmin(values))
        a, b = grid[max(i - 1, 0)], grid[min(i + 1, len(grid) - 1)]
        least = min(values)
        for _ in range(14):
            left, right = a + 0.382 * (b - a), a + 0.618 * (b - a)
            x, y = at(left)[key], at(right)[key]
            least, (a, b) = min(least, x, y), (a, right) if x < y else (left, b)
        worst.add(f"{name} {key} between inertias", told[key], least)


def check_quantized(loop, response, count, tally, rng, name):
    """At rest near the set point, at random offsets of the counts: never above the bounds. Returns what part is reached."""
    motion, torque = (l1(r) * count / 2 for r in response)
    reached, size = 0.0, min(4000, 4 * len(response[0]))
    for _ in range(4):
        offset = rng.choice([0.5, rng.uniform(-0.5, 0.5)]) * count
        run_ = loop.quantized(size, count, offset, (rng.uniform(-2, 2) * count, 0.0))
        tail = [np.abs(x[size // 2:]).max() for x in run_]
        # What is left of the start decays; the bounds hold for what quantization keeps alive.
        left = np.abs(response[0][size // 2:]).sum() if len(response[0]) > size // 2 else 0
        if not tally.check(f"{name} quantized", tail[0] <= motion * (1 + 1e-6) + 10 * left * count
                           and tail[1] <= torque * (1 + 1e-6) + 1e3 * left * count, f"{tail} {motion} {torque}"):
            break
        reached = max(reached, tail[1] / torque)
    return reached


def check_wall_figures(case, told, worst, name):
    delta, least = case.delta(), (math.inf, math.inf, math.inf)
    normal = np.array(case.normal[:2]) / np.linalg.norm(case.normal)
    samples = case.delay * case.rate
    for q in case.points:
        g = case.jacobian(q).T @ normal
        counts = np.abs(g @ case.coupling) @ delta
        sampling = 2 * case.rate / ((1 + 2 * samples) * sum(g[j] ** 2 / case.joints[j]["damping"] for j in range(2)))
        counting = min(2 * case.joints[j]["friction"] / (abs(g[j]) * counts) for j in range(2))
        least = min(least[0], min(sampling, counting)), min(least[1], sampling), min(least[2], counting)
    for key, value in zip(("stiffness", "limit_of_rate", "limit_of_counts"), least):
        worst.add(f"{name} wall {key}", told[key], value)


class Single:
    """A loop of one joint with a stated inertia; what Loop needs of a Case."""

    def __init__(self, rng):
        u = rng.uniform
        self.rate, self.delta = 10 ** u(2, 4.5), 10 ** u(-6, -2)
        self.filter = {"derivative": 1, "sample_rate": self.rate}
        if rng.random() < 0.8:
            self.filter["lowpass"] = {"family": rng.choice(["first_order", "butterworth"]), "order": rng.randint(1, 3),
                                      "cutoff": self.rate * u(0.02, 0.2)}
        self.delay = rng.choice([0, 1, 2, u(0, 2), u(0, 2)]) / self.rate
        inertia, omega = 10 ** u(-4, 1), self.rate * 10 ** u(-1.9, -0.8)
        self.joints = [{"kp": inertia * omega**2, "kd": 2 * u(0.2, 1.2) * inertia * omega, "inertia": inertia,
                        "damping": inertia * self.rate * 10 ** u(-4, 0) if rng.random() < 0.5 else 0.0, "friction": 0.0}]

    def loop(self):
        return Loop(self, 0, self.joints[0]["inertia"])

    def report(self, qerr, folder, walls=""):
        """Of `qerr analyze`; `walls` are sections to add."""
        j, low = self.joints[0], self.filter.get("lowpass")
        lowpass = "" if not low else f", lowpass: {{family: {low['family']}, order: {low['order']}, cutoff: {low['cutoff']!r}}}"
        gains = f"kp: {j['kp']!r}, " + (f"kd: {j['kd']!r}, velocity: v, " if j["kd"] else "")
        (folder / "single.yaml").write_text(
            f"qerr: 1\nrobot: {{joint: {{name: j, type: prismatic, limits: [-1, 1]}}}}\nencoders: {{j: {{resolution: {self.delta!r}}}}}\n"
            f"filters: {{v: {{derivative: 1, sample_rate: {self.rate!r}{lowpass}}}}}\n"
            f"control: {{sample_rate: {self.rate!r}, delay: {self.delay!r}, joints: {{j: {{{gains}"
            f"inertia: {j['inertia']!r}, damping: {j['damping']!r}, friction: {j['friction']!r}}}}}}}\n{walls}"
            "configurations: {method: list, points: [[0]]}\n")
        return run(qerr, "analyze", "single.yaml", "-q", "--json", cwd=folder)


def quantized(loop, quantum, starts, offsets, speeds, count):
    """Largest motion and torque in the second half of many runs with the quantizer in the loop, side by side."""
    x = np.array([starts, speeds])
    past = [np.zeros(len(starts)) for _ in range(loop.whole + 2)]
    states = [([np.zeros(len(starts)) for _ in b], [np.zeros(len(starts)) for _ in a[1:]]) for b, a in loop.sections]
    first, motion, torque = None, 0.0, 0.0
    for k in range(count):
        reading = quantum * np.floor((x[0] - offsets) / quantum + 0.5) + offsets
        first = reading if first is None else first  # the filter has rested there
        value = loop.filtered(reading - first, states)
        past.insert(0, -loop.joint["kp"] * reading - loop.joint["kd"] * value)
        past.pop()
        if k > count // 2:
            motion, torque = max(motion, np.abs(x[0]).max()), max(torque, np.abs(past[0]).max())
        if loop.late > 0:
            x = loop.early[0] @ x + np.outer(loop.early[1], past[loop.whole + 1])
        x = loop.after[0] @ x + np.outer(loop.after[1], past[loop.whole])
    return motion, torque


def check_loops(t, qerr, folder, count, seed):
    """Stable loops at rest near the set point: what quantization keeps alive is within the bounds, and comes near them."""
    done = beyond_half = nearest = 0
    for i in range(100 * count):
        rng = random.Random(f"loop {seed} {i}")
        case = Single(rng)
        loop = case.loop()
        response = loop.response()
        if response is None or len(response[0]) > 4000:  # of slow ones the start would not decay in time
            continue
        ran = case.report(qerr, folder)
        if not t.check(f"loop {i} runs", ran.code == 0, ran.err.decode()[:300]):
            continue
        report = json.loads(ran.out)
        bounds = {row["signal"]: row["worst_case"]["max"] for row in report["position"] if "signal" in row}
        runs, d = 48, case.delta
        starts = [rng.uniform(-3, 3) * d for _ in range(runs)]
        offsets = np.array([rng.choice([0, 0.5, rng.uniform(-0.5, 0.5)]) * d for _ in range(runs)])
        speeds = [rng.uniform(-1, 1) * d * case.rate * 0.1 for _ in range(runs)]
        length = len(response[0])
        motion, torque = quantized(loop, d, starts, offsets, speeds, 2 * min(length, 3000))
        slack = 1 + 1e-6
        t.check(f"loop {i} is within its bounds", motion <= bounds["closed_position"] * slack
                and torque <= bounds["closed_torque"] * slack, f"{motion} {torque} {bounds}")
        done, part = done + 1, torque / bounds["closed_torque"]
        beyond_half, nearest = beyond_half + (part > 0.5), max(nearest, part)
        if done == count:
            break
    t.check(f"{beyond_half} of {done} quantized loops go beyond half of the torque's bound, the nearest to {nearest:.2f} of it",
            done == count and beyond_half >= 0.3 * count)


def check_slow(t, qerr, folder, count, seed):
    """Sigma in loops of stated inertia, at constant speeds: of an accuracy and of an eccentricity |H| at the shaft's frequency."""
    worst, done, accuracy = {"accuracy": Worst(1e-4), "eccentricity": Worst(0.02)}, 0, 3e-4
    for i in range(100 * count):
        rng = random.Random(f"slow {seed} {i}")
        case = Case(rng)
        for joint in case.joints:
            joint["inertia"] = joint["inertia"] or rng.uniform(0.05, 2)
        responses = [Loop(case, j, case.joints[j]["inertia"]).response() for j in range(2)]
        if any(r is None or len(r[0]) > case.rate for r in responses):
            continue
        speeds = np.array([rng.uniform(3, 30), rng.uniform(-30, -3)])
        shafts = np.linalg.inv(case.coupling) @ speeds / case.rate
        turns = 40 * 2 * math.pi / abs(speeds[1])  # whole ones of the second joint
        (folder / "arm.urdf").write_text(URDF.format(**case.arm).replace('type="revolute"', 'type="continuous"'))
        plain = case.spec() + (f"motion: {{sample_rate: {case.rate}, duration: {10 + turns!r}, settling: 10, joints: "
                               f"{{a1: {{velocity: {speeds[0]!r}}}, a2: {{velocity: {speeds[1]!r}}}}}}}\n")
        slow = {"accuracy": plain.replace("}, a2: {bits", f", accuracy: {accuracy}}}, a2: {{bits").replace("}}\ncoupling", f", accuracy: {accuracy}}}}}\ncoupling"),
                "eccentricity": plain + f"effects: [{{type: eccentricity, joint: a2, amplitude: {accuracy}}}]\n"}
        for kind, spec in slow.items():
            (folder / "spec.yaml").write_text(spec)
            ran = run(qerr, "analyze", folder / "spec.yaml", "--format", "json")
            if not t.check(f"slow errors {i} run", ran.code == 0, ran.err.decode()[:300]):
                continue
            for row in json.loads(ran.out)["position"]:
                if row.get("signal") not in ("closed_position", "closed_torque"):
                    continue
                if kind == "accuracy":
                    t.check(f"slow errors {i}: {row['signal']} {row['coordinate']}: sigma is at most the worst case",
                            row["sigma"]["max"] <= row["worst_case"]["max"] * (1 + 1e-9))
                if row["coordinate"] not in ("a1", "a2"):
                    continue
                j, part = int(row["coordinate"][1]) - 1, row["signal"] == "closed_torque"
                h = responses[j][part]
                passed = [abs(h @ np.exp(-1j * w * np.arange(len(h)))) for w in shafts]
                if kind == "eccentricity":
                    passed = [0, passed[1] * (j == 1 or case.coupling[0, 1] != 0)]
                of_counts = h2(h) ** 2 * (case.coupling[j] ** 2 @ case.delta() ** 2) / 12
                of_slow = sum((case.coupling[j, e] * accuracy * passed[e]) ** 2 / 2 for e in range(2))
                worst[kind].add(f"slow {i} {row['signal']} a{j + 1}", row["sigma"]["max"], math.sqrt(of_counts + of_slow))
        done += 1
        if done == count:
            break
    for kind, w in worst.items():
        t.check(f"sigma of {kind} in {done} pairs of loops", done == count and w.holds(), w.detail())


class Reading:
    """What an effect makes of the motion, by its definition; of many runs side by side."""

    def __init__(self, rng, case):
        self.kind = rng.choice(["latency", "scale", "decoding", "drive", "load"])
        self.late, self.factor, self.play, d = 0.0, 1.0, 0.0, case.delta
        if self.kind == "latency":
            self.late = rng.choice([1, 2, rng.randint(1, 16) / PARTS]) / case.rate
            self.row = f"{{type: latency, joint: j, delay: {self.late!r}}}"
        elif self.kind in ("scale", "decoding"):
            self.factor = rng.uniform(0.4, 2.5) if self.kind == "scale" else rng.choice([2, 3, 0.5, 0.25])
            size = self.factor - 1 if self.kind == "scale" else self.factor
            self.row = f"{{type: {self.kind}, joint: j, {'scale' if self.kind == 'scale' else 'factor'}: {size!r}}}"
        else:
            self.play = d * rng.choice([0.5, 3, 1000])
            self.row = f"{{type: backlash, joint: j, gap: {self.play!r}, side: {self.kind}}}"
        self.at = None  # the driven side

    def counts(self, x, v, d, offsets):
        if self.kind == "drive":
            x = x + 0.5 * self.play * np.sign(v)
        if self.kind == "load":
            self.at = x if self.at is None else np.clip(self.at, x - 0.5 * self.play, x + 0.5 * self.play)
            x = self.at
        n = np.floor(((self.factor if self.kind == "scale" else 1) * x - offsets) / d + 0.5)
        return (np.floor(self.factor * n + 0.5) if self.kind == "decoding" else n) * d + offsets


PARTS = 8  # of a sample, at which motions are known


def read_loop(case, reading, starts, offsets, speeds, count):
    """Largest motion and torque in the last third of many runs, the joint read late and the torque late, and the largest
    amplitude: within its play a joint may rest anywhere."""
    joint, loop = case.joints[0], case.loop()
    a, b = held(joint["inertia"], joint["damping"], 1 / case.rate / PARTS)
    x, late, due = np.array([starts, speeds]), round(reading.late * case.rate * PARTS), round(case.delay * case.rate * PARTS)
    states = [([np.zeros(len(starts)) for _ in num], [np.zeros(len(starts)) for _ in den[1:]]) for num, den in loop.sections]
    past, torques, first, motion, torque = [x] * (late + 1), {}, None, 0.0, 0.0
    held_torque, least, most = np.zeros(len(starts)), np.inf, -np.inf
    for n in range(count * PARTS):
        past = [x] + past[:late]
        if n % PARTS == 0:
            read = reading.counts(past[-1][0], past[-1][1], case.delta, offsets)
            first = read if first is None else first
            value = loop.filtered(read - first, states)
            torques[n + due] = -joint["kp"] * read - joint["kd"] * value
            if n > count * PARTS * 2 // 3:
                motion, torque = max(motion, np.abs(past[-1][0]).max()), max(torque, np.abs(torques[n + due]).max())
                least, most = np.minimum(least, past[-1][0]), np.maximum(most, past[-1][0])
        held_torque = torques.pop(n, held_torque)
        x = a @ x + np.outer(b, held_torque)
        if not np.abs(x[0]).max() < 1e6 * case.delta + 100 * reading.play:
            return None
    return motion, torque, 0.5 * (most - least).max()


def check_effects(t, qerr, folder, count, seed):
    """Effects that change a loop: the loop as the program states it is that of a simulation by the effect's definition."""
    done, kinds, reached, play = 0, set(), 0.0, Worst(0.4)
    for i in range(100 * count):
        rng = random.Random(f"effects {seed} {i}")
        case = Single(rng)
        case.delay = rng.randint(0, 2 * PARTS) / PARTS / case.rate
        reading = Reading(rng, case)
        ran = case.report(qerr, folder, f"effects: [{reading.row}]\n")
        if not t.check(f"effect {i} runs", ran.code == 0, ran.err.decode()[:300]):
            continue
        told = json.loads(ran.out)["control"]["loops"][0]
        gains = case.joints[0]["kp"], case.joints[0]["kd"], case.delay
        case.joints[0]["kp"] *= reading.factor
        case.joints[0]["kd"] *= reading.factor
        case.delay += reading.late
        loop = case.loop()
        response = loop.response()
        t.check(f"effect {i}, {reading.row}: stable or not", told["stable"] == (response is not None), told)
        if told["stable"] and response is not None:
            for key, value in loop.margins().items():
                t.check(f"effect {i}, {reading.row}: {key}", not math.isfinite(value)
                        or math.isclose(told[key], value, rel_tol=1e-4), f"{told[key]} {value}")
        case.joints[0]["kp"], case.joints[0]["kd"], case.delay = gains
        if response is None or len(response[0]) > 1000:
            continue
        runs, d, size = 24, case.delta, case.delta + reading.play
        starts, speeds = [np.array([rng.uniform(-1, 1) * size * scale for _ in range(runs)]) for scale in (2, case.rate * 0.1)]
        offsets = np.array([rng.choice([0, 0.5, rng.uniform(-0.5, 0.5)]) * d for _ in range(runs)])
        ran = read_loop(case, reading, starts, offsets, speeds, 3000)
        cycle = told["limit_cycle"]
        if not t.check(f"effect {i}, {reading.row}: it ends", ran is not None):
            continue
        # Offsets of the counts displace the middle of a motion, by half a count at most.
        middle = 0.5 * d / reading.factor if reading.factor != 1 else 0
        t.check(f"effect {i}, {reading.row}: within its bounds", ran[0] <= cycle["bound"] * (1 + 1e-6) + middle
                and ran[1] <= cycle["torque_bound"] * (1 + 1e-6) + middle * gains[0], f"{ran} {cycle}")
        reached = max(reached, ran[1] / cycle["torque_bound"])
        if reading.play > 100 * d:  # else counts disturb it; without a motion kept alive it may drift from flank to flank, ever slower
            play.add(f"effect {i}, {reading.row}: motion", cycle.get("play_amplitude", 0), ran[2],
                     2 * d + (0 if "play_amplitude" in cycle else 0.5 * reading.play))
        kinds.add(reading.kind)
        done += 1
        if done == count:
            break
    t.check(f"loops with {', '.join(sorted(kinds))}: at most {reached:.2f} of the torque's bound", done == count and reached <= 1 + 1e-6)
    if play.count:  # a describing function is an approximation
        t.check(f"{play.count} motions kept alive by play, as predicted", play.holds(), play.detail())


def check_unstable(t, qerr, folder, count, seed):
    done = 0
    for i in range(100 * count):
        rng = random.Random(f"unstable {seed} {i}")
        case = Single(rng)
        kind = ("beyond", "marginal", "undamped")[done % 3]
        joint = case.joints[0]
        if kind == "undamped":  # a delayed spring without damping gains energy
            joint["kd"] = joint["damping"] = 0.0
            factor = 1.0
        else:
            loop = case.loop()
            if loop.response() is None:
                continue
            critical = loop.margins()["gain_margin"]
            if not math.isfinite(critical):
                continue
            factor = critical * (1 + 1e-6 if kind == "marginal" else rng.uniform(1.05, 2))
        joint["kp"] *= factor
        joint["kd"] *= factor
        if kind == "beyond" and case.loop().response() is not None:  # stable again at a higher gain
            continue
        told = json.loads(case.report(qerr, folder).out)
        bounds = [row["worst_case"]["max"] for row in told["position"] if "signal" in row]
        t.check(f"{kind} loop {i} is told to be unstable", not told["control"]["loops"][0]["stable"] and len(bounds) >= 2
                and all(b is None for b in bounds), f"{bounds} {told['control']['loops']}")
        if kind == "marginal":
            for key in ("kp", "kd"):
                joint[key] *= (1 - 2e-6)
            told = json.loads(case.report(qerr, folder).out)
            t.check(f"marginal loop {i} is stable just below", told["control"]["loops"][0]["stable"])
        done += 1
        if done == count:
            return
    t.check(f"{count} unstable loops", False, f"only {done} found")


def hand_energy(case, stiffness, x, fine):
    """Energy that the hand puts in along a motion, straight between points `fine` of which are a sample: against the wall's
    held force, viscous damping and Coulomb friction. Inertia gives back what it takes."""
    k = np.arange(len(x) - 1) - int(round(case.delay * case.rate * fine))
    sample = np.where(k < 0, 0, k // fine * fine)
    force, step = stiffness * case.delta * np.floor(x[sample] / case.delta + 0.5), np.diff(x)
    joint = case.joints[0]
    return float(force @ step + joint["damping"] * (step @ step) * case.rate * fine + joint["friction"] * np.abs(step).sum())


def check_walls(t, qerr, folder, count, seed, motions=200):
    """Both conditions of one axis, each at delays of whole and half samples."""
    deciding = set()
    for i in range(count):
        rng = random.Random(f"wall {seed} {i}")
        case, fine = Single(rng), 8
        case.delay = rng.choice([0, 0.5, 1, 2]) / case.rate
        joint, counting = case.joints[0], i % 2 == 0
        joint["damping"] = rng.uniform(0.1, 5)
        # Friction by which the counts, or the rate, decide clearly.
        joint["friction"] = joint["damping"] * case.rate * case.delta * (rng.uniform(0.01, 0.1) if counting else rng.uniform(5, 50))
        ran = case.report(qerr, folder, "walls: {w: {normal: [1, 0, 0]}}\n")
        if not t.check(f"wall {i} runs", ran.code == 0, ran.err.decode()[:300]):
            continue
        limit = json.loads(ran.out)["control"]["walls"][0]["stiffness"]
        numbers = np.random.default_rng(i)
        s = np.linspace(0, 1, 200 * fine + 1)
        least = math.inf
        for _ in range(motions):
            size = case.delta * 10 ** numbers.uniform(-1, 2.5)
            a, b = size * numbers.uniform(-1, 1, 2)
            f, g = np.floor(numbers.uniform([2, 3], [42, 83]))
            x = 2 * size + a * np.sin(np.pi * f * s) + b / 4 * np.sin(np.pi * g * s)
            lost = joint["friction"] * np.abs(np.diff(x)).sum()
            least = min(least, hand_energy(case, 0.99 * limit, x, fine) / lost)
        t.check(f"wall {i} gives no energy below its limit", least >= -1e-9, f"{least} of what friction takes")
        for factor in (0.99, 1.3):
            if counting:  # across an edge within a sample, wait for the force, back
                wait, d = int(case.delay * case.rate + 3) * fine, 1e-6 * case.delta  # viscous losses are of second order in d
                x = np.tile(np.repeat([0.5 * case.delta - d, 0.5 * case.delta + d], wait), 4)
                energy = hand_energy(case, factor * limit, np.append(x, x[0]), fine)
            else:  # back and forth, turning at samples, so fast that counts and friction vanish beside it
                ramp, speed = 40, 1e6 * case.delta
                up = np.arange(ramp * fine) * speed / fine
                x = np.append(np.tile(np.concatenate([up, 2 * up[-1] - up + speed / fine - up[-1]]), 4), 0)
                energy = hand_energy(case, factor * limit, x, fine)
            t.check(f"wall {i}, decided by {'counts' if counting else 'the rate'}, at {factor} of its limit", (energy < 0) == (factor > 1), f"{energy}")
        deciding.add(counting)
    t.check("walls of both conditions", len(deciding) == min(count, 2))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--qerr", required=True)
    parser.add_argument("--count", type=int, default=12)
    parser.add_argument("--loops", type=int, default=8)
    parser.add_argument("--inertias", type=int, default=0, help="of so many cases search the least margins between inertias, too")
    parser.add_argument("--effects", type=int, default=4)
    parser.add_argument("--slow", type=int, default=3)
    parser.add_argument("--unstable", type=int, default=6)
    parser.add_argument("--walls", type=int, default=6)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    tally = Tally(False)
    worst = {"torque": Worst(1e-9), "closed": Worst(1e-6), "margin": Worst(1e-4), "wall": Worst(1e-9)}
    reached = []  # parts of the bound of the torque
    with tempfile.TemporaryDirectory() as folder:
        for i in range(arguments.count):
            rng = random.Random(f"{arguments.seed} {i}")
            case = Case(rng)
            path = pathlib.Path(folder)
            (path / "arm.urdf").write_text(URDF.format(**case.arm))
            (path / "spec.yaml").write_text(case.spec())
            done = run(pathlib.Path(arguments.qerr).resolve(), "analyze", path / "spec.yaml", "--format", "json")
            if tally.check(f"case {i} runs", done.code == 0, done.err.decode()[:500]):
                check_case(case, json.loads(done.out), worst, reached, tally, rng, f"case {i}", i < arguments.inertias)
        qerr = pathlib.Path(arguments.qerr).resolve()
        for check, count in ((check_loops, arguments.loops), (check_effects, arguments.effects), (check_slow, arguments.slow), (check_unstable, arguments.unstable), (check_walls, arguments.walls)):
            if count:
                check(tally, qerr, pathlib.Path(folder), count, arguments.seed)
    for name, w in worst.items() if arguments.count else ():
        tally.check(f"{name}: {w.count} figures", w.holds(), w.detail())
    return tally.close()


if __name__ == "__main__":
    raise SystemExit(main())
