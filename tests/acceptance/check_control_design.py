#!/usr/bin/env python3
"""`qerr design` with requirements on torques, closed loops, walls and count rates, against an enumeration.

    check_control_design.py --qerr PATH [--problems 10] [--seed 1]

The random arms of check_control.py with options of bits and prices for both encoders, families and orders for the velocity
filter, and in some of them gains of the controllers. Every combination is computed by check_control's own loops and walls. Limits are drawn between the
values that combinations reach. The price of the design must be the least of all combinations that meet the limits, its own
combination one of them; without any, the exit code is 1.
"""
import argparse
import itertools
import json
import math
import pathlib
import random
import tempfile

import numpy as np

import filters
from check_control import URDF, Case, Loop, h2, l1
from tool import Tally, run


class Problem:
    def __init__(self, rng):
        self.case = case = Case(rng)
        case.joints[0]["inertia"] = rng.uniform(0.1, 2)
        case.coupling = np.array([[1, 0], [rng.choice([0, 0, 0.5]), 1]])
        for j in case.joints:
            j["damping"] = j["damping"] or rng.uniform(0.01, 1)
        omega = case.rate * 10 ** rng.uniform(-2.5, -1.7)
        for j, joint in enumerate(case.joints):
            inertia = case.inertia(j, case.points[0])
            joint["kp"], joint["kd"] = inertia * omega**2, 1.4 * inertia * omega
        self.cutoff = case.rate * rng.uniform(0.08, 0.3)
        self.families = [(f, n) for f in ("first_order", "butterworth") for n in (1, 2)] if rng.random() < 0.6 else []
        self.options = [sorted(rng.sample(range(10, 20), rng.randint(2, 4))) for _ in range(2)]
        self.prices = [sorted(rng.sample(range(5, 60), len(o))) for o in self.options]
        self.gains = [1.0]
        if rng.random() < 0.4:
            self.gains = sorted(rng.uniform(0.5, 1.3) for _ in range(3))
        self.kd = case.joints[0]["kd"]

    def combinations(self):
        choices = [self.families or [None], self.gains, range(len(self.options[0])), range(len(self.options[1]))]
        return list(itertools.product(*choices))

    def figures(self):
        """Of every combination: {quantity: value}; the loops once for each filter and gain."""
        case, all_of, loops = self.case, {}, {}
        for family, gain, a, b in self.combinations():
            if (family, gain) not in loops:
                if family:
                    case.filter = {"derivative": 1, "sample_rate": case.rate,
                                   "lowpass": {"family": family[0], "order": family[1], "cutoff": self.cutoff}}
                case.joints[0]["kd"] = gain * self.kd
                velocity = filters.impulse(case.filter).astype(float)
                parts = []
                for j in range(2):
                    h = case.joints[j]["kd"] * velocity
                    h[0] += case.joints[j]["kp"]
                    loop = Loop(case, j, case.inertia(j, case.points[0]))
                    response = loop.response()
                    parts.append((h, response, loop.margins()["gain_margin"] if response else 0.0))
                loops[family, gain] = parts
            parts = loops[family, gain]
            case.bits = [self.options[0][a], self.options[1][b]]
            delta, values = case.delta(), {}
            for j, joint in enumerate(("a1", "a2")):
                h, response, margin = parts[j]
                widths = np.abs(case.coupling[j]) @ delta / 2
                values[f"torque.{joint}.worst_case"] = l1(h) * widths
                values[f"closed_torque.{joint}.worst_case"] = l1(response[1]) * widths if response else math.inf
                values[f"closed_position.{joint}.sigma"] = h2(response[0]) * math.sqrt(
                    case.coupling[j] ** 2 @ delta**2 / 12) if response else math.inf
                values[f"loop.{joint}.limit_cycle"] = l1(response[0]) * widths if response else math.inf
                values[f"loop.{joint}.gain_margin"] = margin
                values[f"encoder.{joint}.count_rate"] = 2 ** case.bits[j] * 9 / (2 * math.pi) * (
                    1 if j == 0 else np.abs(np.linalg.inv(case.coupling)[1]).sum())
            values["wall.w.stiffness"] = self.stiffness(delta)
            all_of[family, gain, a, b] = values
        return all_of

    def stiffness(self, delta):
        case, least = self.case, math.inf
        normal = np.array(case.normal[:2]) / np.linalg.norm(case.normal)
        for q in case.points:
            g = case.jacobian(q).T @ normal
            counts = np.abs(g @ case.coupling) @ delta
            least = min(least, 2 * case.rate / ((1 + 2 * case.delay * case.rate) * sum(
                g[j] ** 2 / case.joints[j]["damping"] for j in range(2))))
            least = min(least, min(2 * case.joints[j]["friction"] / (abs(g[j]) * counts) for j in range(2)))
        return least

    def requirements(self, values, rng):
        chosen = []
        for quantity in rng.sample(sorted(next(iter(values.values()))), rng.randint(1, 4)):
            reached = sorted({v[quantity] for v in values.values() if math.isfinite(v[quantity]) and v[quantity] > 0})
            if not reached:
                continue
            least = "stiffness" in quantity or "margin" in quantity
            at = rng.choice(reached)
            chosen.append((quantity, least, at * (rng.uniform(0.985, 0.999) if least else rng.uniform(1.001, 1.015))))
        return chosen

    def spec(self, requirements):
        self.case.bits = [self.options[0][0], self.options[1][0]]
        self.case.joints[0]["kd"] = self.kd
        text = self.case.spec()
        lines = []
        for quantity, least, limit in requirements:
            single = quantity.split(".")[0] in ("loop", "wall", "encoder")
            lines.append(f"  - {{quantity: {quantity}, {'' if single else 'statistic: max, '}{'at_least' if least else 'at_most'}: {limit!r}}}")
        encoders = "".join(f"    {name}: {{catalogue: {name}.csv}}\n" for name in ("a1", "a2"))
        more = ""
        if self.families:
            more += f"  filters:\n    v: {{families: [first_order, butterworth], orders: [1, 2], cutoff: {self.cutoff!r}}}\n"
        if len(self.gains) > 1:
            more += f"  gains:\n    a1: {{kd: {[g * self.kd for g in self.gains]}}}\n"
        return text + "requirements:\n" + "\n".join(lines) + "\ndesign:\n  encoders:\n" + encoders + more


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--qerr", required=True)
    parser.add_argument("--problems", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--verbose", action="store_true")
    arguments = parser.parse_args()
    qerr, tally, solved = pathlib.Path(arguments.qerr).resolve(), Tally(arguments.verbose), 0
    for index in range(arguments.problems):
        rng = random.Random(f"{arguments.seed} design {index}")
        problem = Problem(rng)
        values = problem.figures()
        requirements = problem.requirements(values, rng)
        if not requirements:
            continue

        def met(v):
            return all(v[q] >= limit if least else v[q] <= limit for q, least, limit in requirements)
        prices = {c: problem.prices[0][c[2]] + problem.prices[1][c[3]] for c, v in values.items() if met(v)}
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder)
            (path / "arm.urdf").write_text(URDF.format(**problem.case.arm))
            (path / "spec.yaml").write_text(problem.spec(requirements))
            for j, name in enumerate(("a1", "a2")):
                rows = "".join(f"{b}bit,{p},{b}\n" for b, p in zip(problem.options[j], problem.prices[j]))
                (path / f"{name}.csv").write_text("name,price,bits\n" + rows)
            ran = run(qerr, "design", "spec.yaml", "--json", "-q", cwd=path, limit=300)
        name = f"problem {index}: {requirements}"
        if not prices:
            tally.check(f"{name}: none", ran.code == 1, f"{ran.code} {ran.err.decode()[:400]}")
            continue
        if not tally.check(f"{name} is solved", ran.code == 0, ran.out.decode()[:600] + ran.err.decode()[:600]):
            continue
        solved += 1
        found = json.loads(ran.out)["optimal"]
        tally.check(f"{name}: least price", abs(found["price"] - min(prices.values())) < 1e-6, f"{found['price']} of {min(prices.values())}")
        tally.check(f"{name}: proven", json.loads(ran.out)["proven"])
        choice = tuple(problem.options[j].index(int(found["encoders"][n].removesuffix("bit"))) for j, n in enumerate(("a1", "a2")))
        family = (found["filters"]["v"]["family"], found["filters"]["v"]["order"]) if problem.families else None
        gain = 1.0
        if len(problem.gains) > 1:
            gain = min(problem.gains, key=lambda g: abs(g * problem.kd - found["gains"]["a1"]["kd"]))
        tally.check(f"{name}: its combination is one that meets them", (family, gain, *choice) in prices, f"{family} {gain} {choice}")
        mine = values[family, gain, *choice]
        for told, (quantity, _, _) in zip(found["requirements"], requirements):
            tally.check(f"{name}: value of {quantity}", math.isclose(told["value"], mine[quantity], rel_tol=1e-4), f"{told['value']} {mine[quantity]}")
    tally.check("most problems have a solution", solved * 3 >= arguments.problems, f"{solved}")
    print(f"{solved} of {arguments.problems} problems solved")
    return tally.close()


if __name__ == "__main__":
    raise SystemExit(main())
