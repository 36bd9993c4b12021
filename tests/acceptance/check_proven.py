#!/usr/bin/env python3
"""Acceptance of `qerr analyze --prove`: no configuration exceeds the proven bound, and `lower` is reached where it says.

    check_proven.py --qerr build/qerr [--shared ../shared] [--chains 12] [--samples 2e4] [--gap 0.02] [--verbose]

The search is independent of qerr: numpy kinematics, random samples (with the ends of the ranges), and a pattern search along
the joints and random directions from the best of them. Random chains have 3 to 7 joints, prismatic ones, limited ranges, parallel
and intersecting axes, tools, mimics, couplings, counters that round down; with --shared then every robot of its robots/ that
check_analyze.py has (minutes).

The study of the acceptance: --chains 1000 --samples 1e5 --program-samples 1e7 --gap 0.01 --mimics-up-to 7 --summary, which adds the maxima of 1e7 samples of another seed
by the program itself as starts of the independent search. It prints the gaps and the seconds by the number of joints.
"""
import argparse
import collections
import itertools
import json
import math
import pathlib
import sys
import tempfile
import time

import numpy as np

from cases import flow, public_cases
from robot import Chain
from tool import Tally, run

ROUNDING = 1e-9  # of the figures by numpy, relative to the largest of their unit
COORDINATES = ["x", "y", "z", "rx", "ry", "rz"]
LENGTHS = {"xyz": [0, 1, 2], "rxyz": [3, 4, 5]}


class Figures:
    """Worst case and sigma of a chain's coordinates and lengths at many configurations, by geometric Jacobians."""

    def __init__(self, chain, delta, down, coupling):
        self.chain, self.delta = chain, np.asarray(delta)
        self.mean = -0.5 * self.delta * np.asarray(down)
        self.coupling = np.eye(len(delta)) if coupling is None else np.array(coupling, dtype=float)
        signs = list(itertools.product([1.0], *([[-1.0, 1.0]] * (len(delta) - 1))))
        self.corners = np.array(signs).T  # encoders x corners, one of each opposite pair

    def columns(self, q):
        """J of the independent joints: (6, n, N)."""
        count = q.shape[0]
        rotation = np.repeat(np.eye(3)[:, :, None], count, axis=2)
        position = np.zeros((3, count))
        axes = []
        for joint in self.chain.joints:
            position = position + np.einsum("ijn,j->in", rotation, joint.xyz)
            rotation = np.einsum("ijn,jk->ikn", rotation, joint.rotation)
            if joint.kind == "fixed":
                continue
            index, factor, offset = self.chain.terms[joint.name]
            value = factor * q[:, index] + offset
            axis = np.einsum("ijn,j->in", rotation, joint.axis)
            axes.append((joint.kind == "prismatic", index, factor, axis, position))
            if joint.kind == "prismatic":
                position = position + value * axis
            else:
                x, y, z = joint.axis
                cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
                turned = (np.eye(3)[:, :, None] + np.sin(value) * cross[:, :, None] +
                          (1 - np.cos(value)) * (cross @ cross)[:, :, None])
                rotation = np.einsum("ijn,jkn->ikn", rotation, turned)
        out = np.zeros((6, len(self.delta), count))
        for prismatic, index, factor, axis, origin in axes:
            if prismatic:
                out[:3, index] += factor * axis
            else:
                out[:3, index] += factor * np.cross(axis, position - origin, axis=0)
                out[3:, index] += factor * axis
        return out

    def __call__(self, q):
        """{(coordinate, bound): values}"""
        columns = np.einsum("rjn,je->ren", self.columns(q), self.coupling)
        weighted = columns * self.delta[None, :, None]
        mean = np.einsum("ren,e->rn", columns, self.mean)
        worst = 0.5 * np.abs(weighted).sum(axis=1) + np.abs(mean)
        sigma = np.sqrt((weighted ** 2).sum(axis=1) / 12)
        figures = {}
        for i, name in enumerate(COORDINATES):
            figures[name, "worst_case"], figures[name, "sigma"] = worst[i], sigma[i]
        for name, rows in LENGTHS.items():
            figures[name, "sigma"] = np.sqrt((sigma[rows] ** 2).sum(axis=0))
            longest = 0
            for corner in self.corners.T:
                at = 0.5 * np.einsum("ren,e->rn", weighted[rows], corner)
                for sign in (1, -1) if self.mean.any() else (1,):
                    longest = np.maximum(longest, ((at + sign * mean[rows]) ** 2).sum(axis=0))
            figures[name, "worst_case"] = np.sqrt(longest)
        return figures


def samples(rng, low, high, count):
    unit = rng.random((count, len(low)))
    ends = rng.random(unit.shape)
    unit = np.where(ends < 0.1, 0, np.where(ends > 0.9, 1, unit))  # maxima are often at ends of the ranges
    return low + (high - low) * unit


def improved(rng, figures, key, points, low, high):
    """The largest value of a figure by pattern search from some points, all at once."""
    points, value, width = points.copy(), figures(points)[key], high - low
    joints = points.shape[1]
    for step in 0.25 * 0.6 ** np.arange(34):
        for _ in range(2):
            random = rng.normal(size=(6, joints))
            random /= np.linalg.norm(random, axis=1)[:, None]
            moves = np.concatenate([np.eye(joints), -np.eye(joints), random]) * step * width
            tried = np.clip(points[:, None, :] + moves[None], low, high)
            there = figures(tried.reshape(-1, joints))[key].reshape(len(points), -1)
            best = there.argmax(axis=1)
            better = there[np.arange(len(points)), best] > value
            points[better] = tried[np.arange(len(points)), best][better]
            value = np.maximum(value, there[np.arange(len(points)), best])
    return value.max()


def random_chain(rng, folder, seed, mimics_up_to):
    """A URDF of 3 to 7 joints, and what of it the search needs."""
    joints = int(rng.integers(3, 8))
    links = ["base"] + [f"link{k}" for k in range(joints)] + ["tool"]
    lines, moving = [], []
    square = rng.random() < 0.6  # as most arms: right angles and axes along coordinates

    def direction():
        if square:
            return rng.permutation([1.0, 0.0, 0.0]) * rng.choice([-1, 1])
        v = rng.normal(size=3)
        return v / np.linalg.norm(v)

    for k in range(joints):
        name, kind = f"joint{k}", "prismatic" if rng.random() < 0.15 else "revolute"
        xyz = direction() * rng.choice([0, rng.uniform(0.05, 0.5)], p=[0.25, 0.75])
        rpy = rng.choice([0, math.pi / 2, -math.pi / 2], size=3) if square else rng.uniform(-math.pi, math.pi, size=3)
        if kind == "prismatic":
            lower, upper = -rng.uniform(0, 0.3), rng.uniform(0.05, 0.4)
        else:
            lower, upper = -rng.uniform(0.2, math.pi), rng.uniform(0.2, math.pi)
        mimic = ""
        if moving and joints <= mimics_up_to and rng.random() < 0.15:
            mimic = f'<mimic joint="{rng.choice(moving)}" multiplier="{rng.choice([-1, 1, 0.5])}" offset="{rng.uniform(-0.3, 0.3)}"/>'
        else:
            moving.append(name)
        lines.append(f'<joint name="{name}" type="{kind}"><parent link="{links[k]}"/><child link="{links[k + 1]}"/>'
                     f'<origin xyz="{" ".join(map(repr, map(float, xyz)))}" rpy="{" ".join(map(repr, map(float, rpy)))}"/>'
                     f'<axis xyz="{" ".join(map(repr, map(float, direction())))}"/>'
                     f'<limit lower="{lower!r}" upper="{upper!r}" effort="1" velocity="1"/>{mimic}</joint>')
    tool = rng.uniform(-0.2, 0.2, size=3) * rng.choice([0, 1], size=3)
    lines.append(f'<joint name="tool" type="fixed"><parent link="{links[-2]}"/><child link="tool"/>'
                 f'<origin xyz="{" ".join(map(repr, map(float, tool)))}" rpy="0 0 0"/></joint>')
    urdf = folder / f"chain{seed}.urdf"
    urdf.write_text('<robot name="chain">' + "".join(f'<link name="{l}"/>' for l in links) + "".join(lines) + "</robot>")
    chain = Chain(urdf)
    delta = 1e-4 * 10 ** rng.uniform(0, 1, size=len(chain.names))
    down = (rng.random(len(chain.names)) < 0.1).astype(float)
    coupling = None
    if rng.random() < 0.1:
        coupling = np.eye(len(delta)) + 0.2 * rng.uniform(-1, 1, size=(len(delta), len(delta))) * (rng.random((len(delta),) * 2) < 0.2)
    low, high = (np.array([getattr(chain.by_name[n], end) for n in chain.names]) for end in ("lower", "upper"))
    return f"chain {seed}", urdf, {}, chain, delta, down, coupling, low, high


def shared_robots(robots):
    for case in public_cases(robots):
        low, high = [], []
        for name in case.chain.names:
            joint = case.chain.by_name[name]
            a, b = case.limits.get(name, (joint.lower, joint.upper))
            low.append(-math.pi if a is None else a)
            high.append(math.pi if b is None else b)
        yield (case.name, case.urdf, {"base": case.base, "tip": case.tip}, case.chain, case.delta, case.down, case.coupling,
               np.array(low), np.array(high))


def spec_of(urdf, ends, chain, delta, down, coupling, low, high, coordinates):
    encoders = {n: {"resolution": float(d), **({"rounding": "down"} if r else {})} for n, d, r in zip(chain.names, delta, down)}
    lines = ["qerr: 1", f"robot: {flow({'urdf': str(urdf), **{k: v for k, v in ends.items() if v}})}",
             f"encoders: {flow(encoders)}", f"coordinates: {flow(coordinates)}"]
    if coupling is not None:
        lines.append(f"coupling: {flow(np.asarray(coupling, dtype=float).tolist())}")
    limits = {n: [float(a), float(b)] for n, a, b in zip(chain.names, low, high)}
    lines.append(f"configurations: {{count: 1000, limits: {flow(limits)}}}")
    return "\n".join(lines) + "\n"


class Study:
    """Checks proofs, and collects gaps and seconds."""

    def __init__(self, t, arguments):
        self.t, self.arguments = t, arguments
        self.gaps, self.seconds = collections.defaultdict(list), collections.defaultdict(list)
        self.shortfall = 0.0

    def robot(self, folder, seed, name, urdf, ends, chain, delta, down, coupling, low, high):
        t, a = self.t, self.arguments
        coordinates = ["xyz", "rxyz"] if a.rotations else ["xyz"]
        spec = folder / "spec.yaml"
        spec.write_text(spec_of(urdf, ends, chain, delta, down, coupling, low, high, coordinates))
        start = time.monotonic()
        ran = run(a.qerr, "analyze", spec, "-q", "--prove", repr(a.gap), "--threads", "1", "--format", "json", limit=3600)
        seconds = time.monotonic() - start
        if not t.check(f"{name}: runs", ran.code == 0, ran.err.decode(errors="replace")[:400]):
            return
        report = json.loads(ran.out)
        rng = np.random.default_rng(seed + 10 ** 6)
        figures = Figures(chain, delta, down, coupling)
        starts = self.starts(figures, rng, low, high, spec, chain)
        joints = len(chain.names)
        self.seconds[joints].append(seconds)
        largest = {p["unit"]: max(q["worst_case"]["max"] for q in report["position"] if q["unit"] == p["unit"])
                   for p in report["position"]}
        for p in report["position"]:
            for bound in ("worst_case", "sigma"):
                self.figure(f"{name}: {p['coordinate']} {bound}", p[bound], (p["coordinate"], bound), figures, starts, rng, low,
                            high, chain, ROUNDING * largest[p["unit"]], joints)

    def starts(self, figures, rng, low, high, spec, chain):
        best, a = {}, self.arguments
        for _ in range(max(1, int(a.samples / 1e4))):
            q = samples(rng, low, high, int(min(a.samples, 1e4)))
            for key, values in figures(q).items():
                order = np.argsort(values)[-12:]
                best.setdefault(key, []).append((values[order], q[order]))
        starts = {}
        for key, parts in best.items():
            values, points = np.concatenate([v for v, _ in parts]), np.concatenate([q for _, q in parts])
            starts[key] = points[np.argsort(values)[-12:]]
        if a.program_samples:
            ran = run(a.qerr, "analyze", spec, "-q", "--seed", "271828", "--set", f"configurations.count={int(a.program_samples)}",
                      "--format", "json", limit=3600)
            for p in json.loads(ran.out)["position"]:
                for bound in ("worst_case", "sigma"):
                    at = [[p[bound]["at_max"][n] for n in chain.names]]
                    key = p["coordinate"], bound
                    starts[key] = np.concatenate([starts[key], at])
        return starts

    def figure(self, title, reported, key, figures, starts, rng, low, high, chain, floor, joints):
        t, proven = self.t, reported.get("proven")
        if not t.check(f"{title}: has a proof", proven is not None):
            return
        lower, upper = proven["lower"], proven["upper"]
        at = np.array([[proven["at"][n] for n in chain.names]])
        there = figures(at)[key][0]
        t.check(f"{title}: lower is reached", abs(there - lower) <= 1e-9 * lower + floor, f"{lower!r}, but {there!r} at {proven['at']}")
        t.check(f"{title}: the configuration is in the ranges", bool(np.all(at >= low - 1e-12) and np.all(at <= high + 1e-12)))
        t.check(f"{title}: not below the sample", lower >= reported["max"])
        if not t.check(f"{title}: has an upper bound", upper is not None):
            return
        told = upper / lower - 1 if lower > 0 else None
        t.check(f"{title}: the gap is told", proven["gap"] is None if told is None else abs(proven["gap"] - told) <= 1e-12 * (1 + told))
        found = improved(rng, figures, key, starts[key], low, high)
        t.check(f"{title}: no configuration exceeds the bound", found <= upper * (1 + 1e-12) + 1e-3 * floor,
                f"{found!r} found, {upper!r} proven")
        if found > floor:
            self.shortfall = max(self.shortfall, found / lower - 1)
            t.check(f"{title}: the search of the program is not poor", lower >= found * (1 - 2e-3), f"{lower!r}, but {found!r} found")
            self.gaps[joints, key[0], key[1]].append(upper / lower - 1)

    def summary(self):
        print(f"largest excess of the independent search over `lower`: {100 * self.shortfall:.3g} %")
        for joints, seconds in sorted(self.seconds.items()):
            print(f"{joints} joints: {len(seconds)} robots, {np.mean(seconds):.2f} s on average, {max(seconds):.2f} s at most")
        for (joints, coordinate, bound), gaps in sorted(self.gaps.items()):
            print(f"  {joints} joints {coordinate} {bound}: gap {100 * np.median(gaps):.3g} % median, {100 * max(gaps):.3g} % at most")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--qerr", required=True)
    parser.add_argument("--shared")
    parser.add_argument("--chains", type=int, default=12)
    parser.add_argument("--first", type=int, default=0, help="seed of the first chain")
    parser.add_argument("--samples", type=float, default=2e4)
    parser.add_argument("--program-samples", type=float, default=0)
    parser.add_argument("--gap", type=float, default=0.02)
    parser.add_argument("--mimics-up-to", type=int, default=4, help="joints of chains with mimics, whose proofs take long")
    parser.add_argument("--rotations", action="store_true", help="prove rotations, too")
    parser.add_argument("--summary", action="store_true")
    parser.add_argument("--verbose", action="store_true")
    arguments = parser.parse_args()
    arguments.qerr = pathlib.Path(arguments.qerr).resolve()
    t = Tally(arguments.verbose)
    study = Study(t, arguments)
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for seed in range(arguments.first, arguments.first + arguments.chains):
            study.robot(folder, seed, *random_chain(np.random.default_rng(seed), folder, seed, arguments.mimics_up_to))
        robots = pathlib.Path(arguments.shared or "nowhere") / "robots"
        if robots.is_dir():
            for i, robot in enumerate(shared_robots(robots)):
                study.robot(folder, i, *robot)
        elif arguments.shared:
            print(f"skipped: {robots} is not here")
    if arguments.summary or arguments.verbose:
        study.summary()
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
