#!/usr/bin/env python3
"""`qerr design` against an enumeration of all combinations in numpy, with Jacobians of its own (robot.py).

    check_design.py --qerr build/qerr [--verbose] [--problems 30] [--seed 1]

Random problems: 2 to 6 joints with 2 to 8 options each, of catalogues (with prices that tie, options that are dearer and
no finer, accuracy, counters that round down), of bits and gears; max, p99, p95, median, mean and min of worst case and
sigma, of positions and behind filters; couplings. Optimum and runner-up must be those of the enumeration, whose order
is price, then the options by price and place in the catalogue, the first joint's first. The written spec must pass
`qerr check`. Then problems without an answer, whose message is compared.
"""
import argparse
import csv
import itertools
import json
import math
import pathlib
import random
import sys
import tempfile

import numpy as np

import filters
from cases import CORPUS, flow
from robot import Chain
from tool import Tally, run

ROBOTS = [("arm.urdf", None, None), ("prr.urdf", None, None), ("two_joints.urdf", None, None)]
KUKA = pathlib.Path(__file__).resolve().parents[2] / "configs" / "kuka_lwr" / "kuka_lwr.urdf"
STATISTICS = ["max", "max", "p99", "p99", "p95", "median", "mean", "min"]


class Problem:
    """A random problem: the text of its spec, and what the enumeration needs."""

    def __init__(self, seed, folder):
        self.rng = random.Random(seed)
        self.name = f"problem {seed}"
        self.folder = folder / f"p{seed}"
        self.folder.mkdir()
        rng = self.rng
        urdf = KUKA if rng.random() < 0.5 else CORPUS / rng.choice(ROBOTS)[0]
        self.chain = Chain(urdf, None, None)
        self.names = self.chain.names
        self.options = {}
        encoders, design = {}, {}
        most = {2: 8, 3: 8, 4: 6}.get(len(self.names), 4)
        designed = [n for n in self.names if rng.random() < 0.85][:6] or self.names[:1]
        for name in self.names:
            unit = self.chain.units[self.names.index(name)]
            encoders[name] = {"resolution": 2e-5 if unit == "m" else 3e-4}
            if name not in designed:
                self.options[name] = [self.option("", 0, 2e-5 if unit == "m" else 3e-4)]
                continue
            design[name] = self.bits(name) if unit == "rad" and rng.random() < 0.3 else self.catalogue(name, unit, most)
        n = len(self.names)
        self.coupling = None
        if rng.random() < 0.35:
            self.coupling = [[float(i == k) for k in range(n)] for i in range(n)]
            self.coupling[-1][0] = rng.choice([-1.0, 0.5])
            if n > 2:
                self.coupling[1][2] = 0.25
        points = np.random.default_rng(seed).random((rng.choice([37, 150, 400]), n))
        low, high = [], []
        for name in self.names:
            joint = self.chain.by_name[name]
            low.append(-1.5 if joint.lower is None else joint.lower)
            high.append(1.5 if joint.upper is None else joint.upper)
        self.points = np.array(low) + (np.array(high) - np.array(low)) * (0.01 + 0.98 * points)
        self.filter = {"derivative": 1, "sample_rate": 1000,
                       "lowpass": {"family": "first_order", "order": rng.choice([1, 2]), "cutoff": 40}}
        self.coordinates = ["x", "y", "z"] if rng.random() < 0.6 else ["x", "z", "ry"]
        self.prepare()
        self.requirements = [self.requirement() for _ in range(rng.randint(1, 4))]
        self.write(urdf, encoders, design)

    @staticmethod
    def option(name, price, delta, down=False, accuracy=0.0):
        return {"name": name, "price": price, "half": 0.5 * delta, "mean": -0.5 * delta if down else 0.0,
                "variance": delta**2 / 12, "accuracy": accuracy}

    def catalogue(self, name, unit, most):
        rng, rows, options = self.rng, [], []
        with_accuracy = rng.random() < 0.3
        for i in range(rng.randint(2, most)):
            bits = rng.randint(8, 16)
            price = rng.choice([round(3 * bits * rng.uniform(0.5, 1.5)), 2 * bits, round(bits * 1.37, 2)])
            down = rng.random() < 0.2
            accuracy = rng.choice([0.0, 1e-4, 3e-4]) if with_accuracy and unit == "rad" else 0.0
            delta = 2 * math.pi / 2**bits if unit == "rad" else 0.01 / 2**bits
            row = {"name": f"{name}-{i}", "price": price, "rounding": "down" if down else "nearest",
                   "accuracy": repr(accuracy) if accuracy else "", "comment": "any, text"}
            row |= {"bits": bits, "resolution": ""} if unit == "rad" else {"bits": "", "resolution": repr(delta)}
            rows.append(row)
            options.append(self.option(row["name"], price, delta, down, accuracy))
        with open(self.folder / f"{name}.csv", "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)
        self.options[name] = sorted(options, key=lambda o: o["price"])
        return {"catalogue": f"{name}.csv"}

    def bits(self, name):
        rng = self.rng
        low = rng.randint(8, 13)
        ratios = rng.choice([[1], [1, 50]])
        per_bit, fixed, gear = rng.choice([1, 2.5]), rng.choice([0, 7]), [0, 11.5]
        options = []
        for b in range(low, low + 3):
            for i, ratio in enumerate(ratios):
                text = f"bits {b}" + (f", gear_ratio {ratio}" if len(ratios) > 1 else "")
                options.append(self.option(text, per_bit * b + fixed + (gear[i] if len(ratios) > 1 else 0),
                                           2 * math.pi / 2**b / ratio))
        self.options[name] = sorted(options, key=lambda o: o["price"])
        entry = {"bits": f"{low}..{low + 2}", "price": {"per_bit": per_bit, "fixed": fixed}}
        return entry | ({"gear_ratio": ratios, "gear_price": gear} if len(ratios) > 1 else {})

    def prepare(self):
        motion = self.chain.jacobian(self.points, self.coordinates)
        self.joint_columns = motion if self.coupling is None else motion @ np.array(self.coupling)
        self.choices = list(itertools.product(*(range(len(self.options[n])) for n in self.names)))
        self.prices = np.array([sum(self.options[n][o]["price"] for n, o in zip(self.names, c)) for c in self.choices])
        # millionths: sums of decimal prices must tie as they do on paper
        self.prices = np.round(self.prices * 1e6).astype(np.int64)
        self.norms = filters.norms(self.filter)

    def values(self, coordinate, behind, bound, statistic):
        """The figure of every choice."""
        a = self.joint_columns[:, self.coordinates.index(coordinate), :]
        h2, l1 = self.norms if behind else (1.0, 1.0)
        dc = 0.0 if behind else 1.0
        found = np.empty(len(self.choices))
        index = np.array(self.choices)
        table = {key: [np.array([o[key] for o in self.options[n]]) for n in self.names]
                 for key in ("half", "mean", "variance", "accuracy")}
        for begin in range(0, len(index), 4096):
            part = index[begin:begin + 4096]
            of = {key: np.stack([table[key][j][part[:, j]] for j in range(len(self.names))], axis=1) for key in table}
            if bound == "worst_case":
                v = l1 * (of["half"] + of["accuracy"]) @ np.abs(a).T + dc * np.abs(of["mean"] @ a.T)
            else:
                v = h2 * np.sqrt((of["variance"] + of["accuracy"]**2 / 2) @ (a**2).T)
            found[begin:begin + 4096] = {
                "max": lambda: v.max(axis=1), "min": lambda: v.min(axis=1), "mean": lambda: v.mean(axis=1),
                "median": lambda: np.percentile(v, 50, axis=1), "p95": lambda: np.percentile(v, 95, axis=1),
                "p99": lambda: np.percentile(v, 99, axis=1)}[statistic]()
        return found

    def requirement(self):
        rng = self.rng
        accurate = any(o["accuracy"] for n in self.names for o in self.options[n])
        while True:
            coordinate, statistic = rng.choice(self.coordinates), rng.choice(STATISTICS)
            bound, behind = rng.choice(["worst_case", "sigma"]), rng.random() < 0.4
            if behind and bound == "sigma" and accurate:
                continue  # not known behind a filter
            values = self.values(coordinate, behind, bound, statistic)
            # between two values: the rounding of neither decides
            ranked = np.unique(values)
            at = int(len(ranked) * rng.uniform(0.1, 0.7))
            limit = 0.5 * (ranked[at] + ranked[min(at + 1, len(ranked) - 1)]) * (1 + 1e-6)
            if limit > 0:
                return {"quantity": f"{'velocity' if behind else 'position'}.{coordinate}.{bound}",
                        "statistic": statistic, "at_most": float(limit)}, values

    def write(self, urdf, encoders, design):
        lines = ["qerr: 1", "robot:", f"  urdf: {urdf}", "encoders:"]
        lines += [f"  {n}: {flow(e)}" for n, e in encoders.items()]
        lines += [f"coupling: {flow(self.coupling)}"] if self.coupling else []
        lines += [f"coordinates: {flow(self.coordinates)}", f"filters: {flow({'velocity': self.filter})}"]
        limits = {n: [-2.0, 2.0] for n in self.names if self.chain.by_name[n].kind == "continuous"}
        lines += ["configurations:", "  method: list"] + ([f"  limits: {flow(limits)}"] if limits else [])
        lines += ["  points:"] + [f"    - {flow([float(v) for v in p])}" for p in self.points]
        lines += ["requirements:"] + [f"  - {flow(r)}" for r, _ in self.requirements]
        lines += ["design:", "  encoders:"] + [f"    {n}: {flow(d)}" for n, d in design.items()]
        self.spec = self.folder / "spec.yaml"
        self.spec.write_text("\n".join(lines) + "\n")

    def expected(self):
        met = np.all([values <= r["at_most"] for r, values in self.requirements], axis=0)
        places = sorted(np.flatnonzero(met), key=lambda i: (self.prices[i], self.choices[i]))
        return [self.choices[i] for i in places[:2]]

    def named(self, choice):
        return {n: self.options[n][o]["name"] for n, o in zip(self.names, choice) if self.options[n][o]["name"]}


def check_problem(qerr, problem, t):
    done = run(qerr, "design", problem.spec, "--format", "json", "-q", "--write-spec", problem.folder / "chosen.yaml")
    expected = problem.expected()
    if not t.check(f"{problem.name}: exit code", done.code == (0 if expected else 1), f"{done.code} {done.err[:300]}"):
        return
    report = json.loads(done.out)
    t.check(f"{problem.name}: proven", report["proven"])
    for key, choice in itertools.zip_longest(("optimal", "runner_up"), expected):
        found = report[key] and report[key]["encoders"]
        wanted = problem.named(choice) if choice is not None else None
        t.check(f"{problem.name}: {key} of {len(problem.choices)}", found == wanted, f"{found}, expected {wanted}")
    if not expected:
        t.check(f"{problem.name}: says why", report["obstacles"] and report["finest"])
        return
    at = problem.choices.index(expected[0])
    for found, (wanted, values) in zip(report["optimal"]["requirements"], problem.requirements):
        t.check(f"{problem.name}: {wanted['quantity']} {wanted['statistic']}",
                abs(found["value"] - values[at]) <= 1e-9 * values[at], f"{found['value']}, expected {values[at]}")
    check = run(qerr, "check", problem.folder / "chosen.yaml", "--format", "json", "-q")
    t.check(f"{problem.name}: the written spec passes", check.code == 0, check.err[:300])
    if check.code == 0:
        t.check(f"{problem.name}: with the same figures",
                [r["value"] for r in json.loads(check.out)["requirements"]]
                == [r["value"] for r in report["optimal"]["requirements"]])


ARM = """qerr: 1
robot: {urdf: %s}
encoders: {'*': {bits: 16}}
filters:
  velocity: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: first_order, order: 2, cutoff: 50 Hz}}
configurations: {count: 200}
requirements:
  - {quantity: position.x.worst_case, statistic: max, at_most: 0.5 mm}
design: %s
"""


def check_without_answer(qerr, folder, t):
    def answer(design, code, *words, requirements=None, catalogue=None):
        if catalogue is not None:
            (folder / "c.csv").write_text(catalogue)
        text = ARM % (KUKA, design)
        if requirements is not None:
            text = text.replace("  - {quantity: position.x.worst_case, statistic: max, at_most: 0.5 mm}\n", requirements)
        (folder / "spec.yaml").write_text(text)
        done = run(qerr, "design", folder / "spec.yaml", "-q", limit=120)
        shown = (done.err + done.out).decode()
        flat = " ".join(shown.split())
        t.check(f"{design} {requirements or ''}", done.code == code and all(w in flat for w in words),
                f"exit code {done.code}: {shown[:500]}")

    table = "name,price,bits\n"
    answer("{encoders: {'*': {catalogue: c.csv}}}", 3, "duplicate name", "c.csv:3", catalogue=table + "a,1,12\na,2,13\n")
    answer("{encoders: {'*': {catalogue: c.csv}}}", 3, "price of 'b' is missing", "c.csv:3", catalogue=table + "a,1,12\nb,,13\n")
    answer("{minimize: resolution, encoders: {'*': {catalogue: c.csv}}}", 0, "coarsest", catalogue="name,bits\na,12\nb,16\n")
    answer("{encoders: {'*': {catalogue: c.csv}}}", 3, "no rows", catalogue=table)
    answer("{encoders: {'*': {catalogue: none.csv}}}", 4, "none.csv")
    answer("{encoders: {}}", 3, "names no joint")
    answer("{}", 3, "nothing to choose")
    answer("{encoders: {elbow: {bits: 12..23}}}", 3, "unknown joint", "elbow")
    answer("{encoders: {'*': {bits: 23..12}}}", 3, "the range is empty")
    answer("{encoders: {'*': {bits: []}}}", 3, "the list is empty")
    answer("{encoders: {'*': {bits: [12, 12]}}}", 3, "duplicate value")
    answer("{encoders: {'*': {bits: 12..23, counts_per_rev: 4096}}}", 3, "stated in one way")
    answer("{encoders: {'*': {bits: 12..23, price: 3}}}", 3, "ambiguous", "per_bit")
    answer("{encoders: {'*': {bitts: 12..23}}}", 3, "bitts")
    answer("{encoders: {'*': {bits: 12..23}, 'a*': {bits: 12..23}}}", 3, "two patterns")
    answer("{encoders: {'*': {catalogue: c.csv, price: 3}}}", 3, "the catalogue has the prices", catalogue=table + "a,1,12\n")
    answer("{encoders: {'*': {bits: 1..100000}}}", 3, "more than 10000")
    answer("{minimize: weight, encoders: {'*': {bits: 12..23}}}", 3, "price, resolution")
    answer("{minimize: position.x.sigma, budget: 20, encoders: {'*': {bits: 12..23}}}", 1, "budget is 20")
    answer("{budget: 20, encoders: {'*': {bits: 12..23}}}", 3, "budget")
    answer("{encoders: {'*': {bits: 12..23}}}", 3, "none", requirements="  []\n")
    answer("{encoders: {'*': {bits: 8..12}}}", 1, "position.x.worst_case max is", "with the finest of everything",
           requirements="  - {quantity: position.x.worst_case, statistic: max, at_most: 1 um}\n")
    answer("{encoders: {'*': {bits: 8..12}}}", 3, "at_least",
           requirements="  - {quantity: position.x.worst_case, statistic: max, at_least: 1 mm}\n")
    answer("{encoders: {a1: {bits: 12..14}}}", 0, "no option changes position.z.worst_case",
           requirements="  - {quantity: position.z.worst_case, statistic: max, at_most: 1 mm}\n")
    answer("{filters: {velocity: {delay: 1 us}}}", 1, "no low-pass of filter 'velocity'", "least delay")
    answer("{filters: {speed: {delay: 1 ms}}}", 3, "no filter of this name")
    answer("{filters: {velocity: {families: [bessell]}}}", 3, "bessel")
    answer("{filters: {velocity: {cutoff: [50 Hz, 5 Hz]}}}", 3, "the range is empty")
    answer("{filters: {velocity: {tracking: {band: 600 Hz, at_most: 1 %}}}}", 3, "half the sample rate")
    contradictory = ("  - {quantity: velocity.delay, at_most: 2 ms}\n  - {quantity: velocity.h2_norm, at_most: 1}\n")
    answer("{filters: {velocity: {}}}", 1, "no low-pass", requirements=contradictory)


def check_command_line(qerr, folder, t):
    """A wrong figure is the command line's fault; a choice that cannot be written does not lose the report."""
    spec = folder / "spec.yaml"
    spec.write_text(ARM % (KUKA, "{encoders: {'*': {bits: 12..23}}}"))
    done = run(qerr, "design", spec, "-q", "--pareto", "nosuch")
    t.check("--pareto nosuch: 2", done.code == 2 and not done.out and b"--pareto" in done.err, f"{done.code}: {done.err[:300]}")
    done = run(qerr, "design", spec, "-q", "--write-spec", "/dev/full", limit=120)
    t.check("--write-spec /dev/full: 4 and the report", done.code == 4 and done.out and b"/dev/full" in done.err, f"{done.code}: {done.out[:300]}")
    done = run(qerr, "filter", spec, "--at", "1e9")
    t.check("filter --at 1e9: 2, the filter's key and a remedy", done.code == 2 and b"sample_rate" in done.err and b"up to" in done.err,
            f"{done.code}: {done.err[:300]}")


def check_filters(qerr, folder, t):
    """The quietest filter for a delay: no filter of a finer scan through `qerr filter` is quieter."""
    (folder / "spec.yaml").write_text(ARM % (KUKA, "{minimize: velocity.h2_norm, filters: {velocity: {families: "
                                             "[first_order, butterworth, bessel], orders: 1..3, delay: 5 ms}}}"))
    done = run(qerr, "design", folder / "spec.yaml", "--format", "json", "-q")
    if not t.check("filters: an answer", done.code == 0, done.err[:300]):
        return
    chosen = json.loads(done.out)["optimal"]["filters"]["velocity"]
    t.check("filters: the delay is kept and used", 0.999e-2 / 2 <= chosen["delay"] <= 5e-3, chosen["delay"])
    quietest = math.inf
    for order in (1, 2, 3):
        for cutoff in np.geomspace(20, 200, 40):
            for family in ("first_order", "butterworth"):  # filters.py has no bessel
                f = {"derivative": 1, "sample_rate": 1000, "lowpass": {"family": family, "order": order, "cutoff": float(cutoff)}}
                if delay_of(f) <= 5e-3:
                    quietest = min(quietest, filters.norms(f)[0])
    t.check("filters: none of an independent scan is quieter", chosen["h2_norm"] <= quietest * (1 + 1e-9),
            f"{chosen['h2_norm']} and {quietest}")


def delay_of(f):
    """-d arg H/d omega at a low frequency, from the impulse response."""
    h = filters.impulse(f)
    h = h[0] if isinstance(h, tuple) else h
    h = np.asarray(h, dtype=float)
    # H/(1 - z^-1) has the step response as its impulse response; a difference delays by half a sample.
    s = np.cumsum(h)
    return (np.sum(np.arange(len(s)) * s) / np.sum(s) + 0.5) / f["sample_rate"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--qerr", required=True)
    parser.add_argument("--verbose", action="store_true")
    parser.add_argument("--problems", type=int, default=30)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    qerr, t = pathlib.Path(arguments.qerr).resolve(), Tally(arguments.verbose)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for seed in range(arguments.seed, arguments.seed + arguments.problems):
            check_problem(qerr, Problem(seed, folder), t)
        check_without_answer(qerr, folder, t)
        check_command_line(qerr, folder, t)
        check_filters(qerr, folder, t)
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
