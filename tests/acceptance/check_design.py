#!/usr/bin/env python3
"""`qerr design` against an enumeration of all combinations in numpy, with Jacobians of its own (robot.py).

    check_design.py --qerr build/qerr [--verbose] [--problems 24] [--seed 1]

Random problems: 2 to 7 joints with up to 8 options each, of catalogues (with prices that tie or are missing, options that
are dearer and no finer, accuracy, backlash, counters that round down or are too slow, semicolons and decimal commas), of
bits and gears; filters to choose; max, p99, p95, median, mean and min of worst case and sigma, of positions and behind
filters; couplings; least price, bits or figure, with a budget. Optimum and runner-up must be those of the enumeration, in
the order of `qerr help choice`. The written spec must pass `qerr check`. Without an answer, the sentences about what hinders
must be those of the least values of the enumeration. Then problems without an answer, whose message is compared.
"""
import argparse
import csv
import itertools
import json
import math
import pathlib
import random
import re
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

import numpy as np

import filters
from cases import CORPUS, flow
from robot import Chain
from tool import Tally, run

ROBOTS = [("arm.urdf", None, None), ("prr.urdf", None, None), ("two_joints.urdf", None, None)]
KUKA = pathlib.Path(__file__).resolve().parents[2] / "configs" / "kuka_lwr" / "kuka_lwr.urdf"
STATISTICS = ["max", "max", "p99", "p99", "p95", "median", "mean", "min"]


def response(f, frequencies):
    """|H|^2 of a filter of filters.py at frequencies [Hz]."""
    z = np.exp(-2j * np.pi * np.asarray(frequencies) / f["sample_rate"])
    value = np.ones(len(z), dtype=complex)
    for numerator, denominator in filters.sections_of(f):
        value *= sum(float(c) * z**k for k, c in enumerate(numerator)) / sum(float(c) * z**k for k, c in enumerate(denominator))
    return np.abs(value)**2


class Problem:
    """A random problem: the text of its spec, and what the enumeration needs."""

    def __init__(self, seed, folder):
        self.rng = random.Random(seed)
        self.name = f"problem {seed}"
        self.folder = folder / f"p{seed}"
        self.folder.mkdir()
        rng = self.rng
        urdf = KUKA if rng.random() < 0.4 else CORPUS / rng.choice(ROBOTS)[0]
        self.chain = Chain(urdf, None, None)
        self.names = self.chain.names
        self.minimize = rng.choice(["price", "price", "price", "resolution", "figure", "budget"])
        self.options, self.slow = {}, {}
        encoders, design = {}, {}
        most = {2: 8, 3: 7, 4: 5}.get(len(self.names), 4)
        designed = [n for n in self.names if rng.random() < 0.85][:5] or self.names[:1]
        n = len(self.names)
        self.coupling = None
        if rng.random() < 0.35:
            self.coupling = [[float(i == k) for k in range(n)] for i in range(n)]
            self.coupling[-1][0] = rng.choice([-1.0, 0.5])
            if n > 2:
                self.coupling[1][2] = 0.25
        limits = {j.get("name"): float(j.find("limit").get("velocity"))
                  for j in ElementTree.parse(urdf).getroot().findall("joint") if j.find("limit") is not None}
        self.joint_speeds = np.array([limits[name] for name in self.names])
        inverse = np.eye(n) if self.coupling is None else np.linalg.inv(np.array(self.coupling))
        self.speeds = np.abs(inverse) @ self.joint_speeds  # of the encoders' coordinates
        self.with_play, self.with_rates = rng.random() < 0.35, rng.random() < 0.35
        for name in self.names:
            unit = self.chain.units[self.names.index(name)]
            encoders[name] = {"resolution": 2e-5 if unit == "m" else 3e-4}
            if name not in designed:
                self.options[name] = [self.option("", 0, 2e-5 if unit == "m" else 3e-4)]
                continue
            design[name] = self.bits(name) if unit == "rad" and rng.random() < 0.3 else self.catalogue(name, unit, most)
        self.by_bits = self.minimize == "resolution" or any(o["price"] is None for l in self.options.values() for o in l)
        for options in self.options.values():
            for o in options:
                o["cost"] = 0 if not o["name"] else round(1e6 * (o["bits"] if self.by_bits else o["price"]))
            options.sort(key=lambda o: o["cost"])
        points = np.random.default_rng(seed).random((rng.choice([37, 150, 400]), n))
        low, high = [], []
        for name in self.names:
            joint = self.chain.by_name[name]
            low.append(-1.5 if joint.lower is None else joint.lower)
            high.append(1.5 if joint.upper is None else joint.upper)
        self.points = np.array(low) + (np.array(high) - np.array(low)) * (0.01 + 0.98 * points)
        self.filter = {"derivative": 1, "sample_rate": 1000,
                       "lowpass": {"family": "first_order", "order": rng.choice([1, 2]), "cutoff": 40}}
        self.filters = [self.filter]
        if rng.random() < 0.25:
            low_passes = [(f, o) for f in ("first_order", "butterworth") for o in (1, 2, 3)]
            self.filters = [self.filter | {"lowpass": {"family": f, "order": o, "cutoff": 40}} for f, o in low_passes]
        self.coordinates = ["x", "y", "z"] if rng.random() < 0.6 else ["x", "z", "ry"]
        self.prepare()
        self.requirements = [self.requirement() for _ in range(rng.randint(1, 4))]
        if self.minimize in ("figure", "budget"):
            self.goal = self.requirement(goal=True)
            self.budget = int(np.median(self.prices)) if self.choices and self.minimize == "budget" else None
        self.write(urdf, encoders, design)

    @staticmethod
    def option(name, price, delta, down=False, accuracy=0.0, gap=0.0, whole=2 * math.pi, ratio=1.0, slow=False):
        return {"name": name, "price": price, "half": 0.5 * delta, "mean": -0.5 * delta if down else 0.0,
                "variance": delta**2 / 12, "accuracy": accuracy, "gap": gap, "bits": math.log2(whole / delta),
                "ratio": ratio, "slow": slow}

    def catalogue(self, name, unit, most):
        rng, rows, options = self.rng, [], []
        with_accuracy = rng.random() < 0.3
        comma = rng.random() < 0.3
        speed = self.speeds[self.names.index(name)]
        for i in range(rng.randint(2, most)):
            bits = rng.randint(8, 16)
            price = rng.choice([round(3 * bits * rng.uniform(0.5, 1.5)), 2 * bits, 20, round(bits * 1.37, 2)])
            if self.minimize in ("resolution", "figure") and rng.random() < 0.2:
                price = None
            down = rng.random() < 0.2
            accuracy = rng.choice([0.0, 1e-4, 3e-4]) if with_accuracy and unit == "rad" else 0.0
            gap = rng.choice([0.0, 0.5, 2.0]) if self.with_play and unit == "rad" else 0.0
            delta = 2 * math.pi / 2**bits if unit == "rad" else 0.01 / 2**bits
            rate = rng.choice([None, 0.9, 1.1, 5.0]) if self.with_rates else None
            written = "" if price is None else str(price)
            row = {"name": f"{name}-{i}", "price": written.replace(".", ",") if comma else written,
                   "rounding": "down" if down else "nearest", "accuracy": repr(accuracy) if accuracy else "",
                   "backlash [arcmin]": (str(gap).replace(".", ",") if comma else str(gap)) if gap else "",
                   "max_count_rate": "" if rate is None else f"{rate * speed / delta:.6e} Hz",
                   "comment": "any; text" if comma else "any, text"}
            row |= {"bits": bits, "resolution": ""} if unit == "rad" else {"bits": "", "resolution": repr(delta)}
            rows.append(row)
            options.append(self.option(row["name"], price, delta, down, accuracy, gap * math.pi / 180 / 60,
                                       2 * math.pi if unit == "rad" else 1, slow=rate is not None and rate < 1))
        with open(self.folder / f"{name}.csv", "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys(), delimiter=";" if comma else ",")
            writer.writeheader()
            writer.writerows(rows)
        self.slow[name] = [o["name"] for o in options if o["slow"]]
        self.options[name] = [o for o in options if not o["slow"]]
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
                                           2 * math.pi / 2**b / ratio, ratio=ratio))
        self.options[name] = options
        entry = {"bits": f"{low}..{low + 2}", "price": {"per_bit": per_bit, "fixed": fixed}}
        return entry | ({"gear_ratio": ratios, "gear_price": gear} if len(ratios) > 1 else {})

    def prepare(self):
        self.rows = self.chain.jacobian(self.points, self.coordinates)  # of the joints
        self.encoder_rows = self.rows if self.coupling is None else self.rows @ np.array(self.coupling)
        self.choices = list(itertools.product(*(range(len(self.options[n])) for n in self.names)))
        self.prices = np.array([sum(self.options[n][o]["cost"] for n, o in zip(self.names, c)) for c in self.choices])
        if self.minimize == "budget":
            self.prices = np.array([sum(round(1e6 * self.options[n][o]["price"]) for n, o in zip(self.names, c))
                                    for c in self.choices])
        self.measures = []
        for f in self.filters:
            h2, l1 = filters.norms(f)
            h = filters.impulse(f).astype(float)
            energy = float(np.sum(np.cumsum(h)**2)) / f["sample_rate"]
            of_disc = np.array([np.mean(response(f, (np.arange(4096) + 0.5) / 4096 * v / (2 * math.pi))) for v in self.speeds])
            spans = self.points.max(axis=0) - self.points.min(axis=0)
            of_play = 4 * energy * 0.5 * self.joint_speeds / spans  # of the variance (gap/2)^2
            self.measures.append({"h2": h2, "l1": l1, "disc": of_disc, "play": of_play})
        # Sets of filters in the order of their noise; one whose requirements on sigma and worst case another equals
        # never precedes it.
        order = np.argsort([m["h2"] for m in self.measures], kind="stable")
        self.filters, self.measures = [self.filters[i] for i in order], [self.measures[i] for i in order]

    def values(self, coordinate, behind, bound, statistic):
        """The figure of every choice: [filter, choice]."""
        c = self.coordinates.index(coordinate)
        a, joints = self.encoder_rows[:, c, :], self.rows[:, c, :]
        index = np.array(self.choices)
        table = {key: [np.array([o[key] for o in self.options[n]]) for n in self.names]
                 for key in ("half", "mean", "variance", "accuracy", "gap")}
        found = np.empty((len(self.filters), len(index)))
        for s, m in enumerate(self.measures):
            if s > 0 and not behind:
                found[s] = found[0]
                continue
            h2, l1, dc = (m["h2"], m["l1"], 0.0) if behind else (1.0, 1.0, 1.0)
            of_disc, of_play = (m["disc"], m["play"]) if behind else (1.0, 1.0)
            for begin in range(0, len(index), 4096):
                part = index[begin:begin + 4096]
                of = {key: np.stack([table[key][j][part[:, j]] for j in range(len(self.names))], axis=1) for key in table}
                if bound == "worst_case":
                    v = l1 * ((of["half"] + of["accuracy"]) @ np.abs(a).T + 0.5 * of["gap"] @ np.abs(joints).T) \
                        + dc * np.abs(of["mean"] @ a.T)
                elif bound == "sigma_quantization":
                    v = h2 * np.sqrt(of["variance"] @ (a**2).T)
                else:
                    v = np.sqrt((h2**2 * of["variance"] + of_disc * of["accuracy"]**2 / 2) @ (a**2).T
                                + (of_play * of["gap"]**2 / 4) @ (joints**2).T)
                found[s, begin:begin + 4096] = {
                    "max": lambda: v.max(axis=1), "min": lambda: v.min(axis=1), "mean": lambda: v.mean(axis=1),
                    "median": lambda: np.percentile(v, 50, axis=1), "p95": lambda: np.percentile(v, 95, axis=1),
                    "p99": lambda: np.percentile(v, 99, axis=1)}[statistic]()
        return found

    def requirement(self, goal=False):
        rng = self.rng
        while True:
            coordinate, statistic = rng.choice(self.coordinates), rng.choice(STATISTICS)
            behind = rng.random() < 0.4
            bound = rng.choice(["worst_case", "sigma", "sigma_quantization"] if behind else ["worst_case", "sigma"])
            values = self.values(coordinate, behind, bound, statistic)
            if not values.size:
                values = np.array([[1.0]])
            # between two values: the rounding of neither decides
            ranked = np.unique(values)
            at = int(len(ranked) * rng.uniform(0.1, 0.7))
            limit = 0.5 * (ranked[at] + ranked[min(at + 1, len(ranked) - 1)]) * (1 + 1e-6)
            if rng.random() < 0.04:
                limit = 0.7 * ranked[0]
            if limit > 1e-12:
                quantity = f"{'velocity' if behind else 'position'}.{coordinate}.{bound}"
                return {"quantity": quantity, "statistic": statistic, "at_most": float(limit)}, values

    def write(self, urdf, encoders, design):
        section = {"minimize": self.minimize if self.minimize in ("price", "resolution") else self.goal[0]["quantity"]}
        if self.minimize in ("figure", "budget"):
            section["statistic"] = self.goal[0]["statistic"]
        if self.minimize == "budget" and self.choices:
            section["budget"] = self.budget / 1e6
        lines = ["qerr: 1", "robot:", f"  urdf: {urdf}", "encoders:"]
        lines += [f"  {n}: {flow(e)}" for n, e in encoders.items()]
        lines += [f"coupling: {flow(self.coupling)}"] if self.coupling else []
        lines += [f"coordinates: {flow(self.coordinates)}", f"filters: {flow({'velocity': self.filter})}"]
        limits = {n: [-2.0, 2.0] for n in self.names if self.chain.by_name[n].kind == "continuous"}
        lines += ["configurations:", "  method: list"] + ([f"  limits: {flow(limits)}"] if limits else [])
        lines += ["  points:"] + [f"    - {flow([float(v) for v in p])}" for p in self.points]
        lines += ["requirements:"] + [f"  - {flow(r)}" for r, _ in self.requirements]
        lines += ["design:"] + [f"  {k}: {v}" for k, v in section.items()]
        lines += ["  encoders:"] + [f"    {n}: {flow(d)}" for n, d in design.items()]
        if len(self.filters) > 1:
            lines += ["  filters: {velocity: {families: [first_order, butterworth], orders: 1..3, cutoff: 40}}"]
        self.spec = self.folder / "spec.yaml"
        self.spec.write_text("\n".join(lines) + "\n")

    def best(self, met):
        """The first (filter, choice) of the rules of `qerr help choice`; None without any."""
        def least(values):
            nonlocal met
            met = met & (values <= values[met].min() * (1 + 1e-8))
        if not met.any():
            return None
        if self.minimize in ("figure", "budget"):
            least(self.goal[1])
        costs = np.broadcast_to(self.prices, met.shape)
        met = met & (costs == costs[met].min())
        used = [values / r["at_most"] for r, values in self.requirements]
        for values in [np.max(used, axis=0)] + used:
            least(values)
        s, i = np.argwhere(met)[0]  # quieter filters first, then the choices in order
        return int(s), int(i)

    def unmoved(self, quantity):
        """Whether the joints do not move the coordinate of a requirement, within rounding."""
        return np.abs(self.rows[:, self.coordinates.index(quantity.split(".")[-2]), :]).max() < 1e-12

    def expected(self):
        """The optimum and the runner-up, whose encoders differ."""
        if not self.choices:
            return []
        met = np.all([values <= r["at_most"] for r, values in self.requirements], axis=0)
        if self.minimize == "budget":
            met = met & (self.prices <= self.budget)
        first = self.best(met)
        if first is None:
            return []
        met[:, first[1]] = False
        second = self.best(met)
        return [first] + ([second] if second else [])

    def named(self, choice):
        return {n: self.options[n][o]["name"] for n, o in zip(self.names, choice) if self.options[n][o]["name"]}

    def check_hindrances(self, report, t):
        """The sentences about what hinders: the least value of each requirement alone, and of all together."""
        text = " | ".join(report["obstacles"])
        none = [n for n in self.slow if not self.options[n]]
        for n in none:
            t.check(f"{self.name}: {n} has no encoder that can count", f"joint '{n}': none of" in text, text)
        if none:
            return
        within = self.prices <= self.budget if self.minimize == "budget" else self.prices >= 0
        met = np.all([values <= r["at_most"] for r, values in self.requirements], axis=0)
        if met.any() and not met[:, within].any():
            t.check(f"{self.name}: the budget hinders", "the budget is" in text, text)
            return
        alone = [(r, values.min()) for r, values in self.requirements if values.min() > r["at_most"]]
        for r, least in alone:
            found = [o for o in report["obstacles"] if o.startswith(f"{r['quantity']} {r['statistic']} is ")]
            value = re.search(r" is ([0-9.e+-]+) (\w+)(/s)? at least whatever", found[0]) if found else None
            right = value and abs(float(value[1]) * PREFIXES[value[2]] / least - 1) < 6e-3
            t.check(f"{self.name}: {r['quantity']} hinders alone", right, f"{text}, expected {least}")
        t.check(f"{self.name}: those together that hinder together", ("can be met alone" in text) == (not alone), text)
        used = np.max([values / r["at_most"] for r, values in self.requirements], axis=0)
        nearest = max(f["value"] / f["at_most"] for f in report["finest"]["requirements"])
        t.check(f"{self.name}: the nearest design", abs(nearest / used.min() - 1) < 1e-7, f"{nearest}, expected {used.min()}")


PREFIXES = {"m": 1, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "pm": 1e-12,
            "rad": 1, "mrad": 1e-3, "urad": 1e-6, "nrad": 1e-9, "prad": 1e-12}


def check_problem(qerr, problem, t):
    done = run(qerr, "design", problem.spec, "--format", "json", "-q", "--write-spec", problem.folder / "chosen.yaml", limit=120)
    if done.code == 3 and b"no error reaches" in done.err:
        quantity = re.search(rb"found '([\w.]+)'", done.err)[1].decode()
        t.check(f"{problem.name}: {quantity} is refused where no joint moves it", problem.unmoved(quantity), done.err[:300])
        return
    expected = problem.expected()
    if not t.check(f"{problem.name}: exit code", done.code == (0 if expected else 1), f"{done.code} {done.err[:300]}"):
        return
    report = json.loads(done.out)
    t.check(f"{problem.name}: proven", report["proven"] and not any("margin" in w for w in report["warnings"]), report["warnings"])
    for key, choice in itertools.zip_longest(("optimal", "runner_up"), expected):
        found = report[key] and report[key]["encoders"]
        wanted = problem.named(problem.choices[choice[1]]) if choice else None
        t.check(f"{problem.name}: {key} of {len(problem.choices)}", found == wanted, f"{found}, expected {wanted}")
        if choice and found and len(problem.filters) > 1:
            low_pass, found = problem.filters[choice[0]]["lowpass"], report[key]["filters"]["velocity"]
            t.check(f"{problem.name}: filter of {key}", (found["family"], found["order"]) == (low_pass["family"], low_pass["order"]),
                    f"{found}, expected {low_pass}")
    left_out = " ".join(report["left_out"])
    for n, slow in problem.slow.items():
        t.check(f"{problem.name}: options of {n} that cannot count", not slow or not problem.options[n]
                or f"joint '{n}': {len(slow)} of" in left_out, left_out)
    if not expected:
        problem.check_hindrances(report, t)
        return
    for found, (wanted, values) in zip(report["optimal"]["requirements"], problem.requirements):
        value = values[expected[0]]
        slow = any(problem.options[n][o]["accuracy"] or problem.options[n][o]["gap"]
                   for n, o in zip(problem.names, problem.choices[expected[0][1]]))
        # The mean over the speeds is summed in fewer points.
        tolerance = 1e-4 if slow and wanted["quantity"].startswith("velocity") else 1e-9
        t.check(f"{problem.name}: {wanted['quantity']} {wanted['statistic']}",
                abs(found["value"] - value) <= tolerance * value, f"{found['value']}, expected {value}")
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
    answer("{encoders: {'*': {bits: 8..12}}}", 1, "position.x.worst_case max is", "at least whatever is chosen",
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
    parser.add_argument("--problems", type=int, default=24)
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
