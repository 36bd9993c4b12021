#!/usr/bin/env python3
"""Several tips of one robot, and one relative to another, against an own computation.

    check_tips.py --qerr PATH [--rounds 6] [--seed 1]

Random trees: joints in common, then two or three arms with skew axes, prismatic joints and mimics of joints of any
branch. Own poses and rows (complex steps) at every configuration; a tip relative to another is the pose of the one in
the frame of the other, from the poses of both in the base: errors of joints in common must cancel in it to the last digits.
"""
import csv
import json
import math
import pathlib
import random
import tempfile

import numpy as np

import filters
from robot import Chain
from tool import Worst, run, study_and_tally

COORDINATES = ["x", "y", "z", "rx", "ry", "rz"]
FILTER = {"derivative": 1, "sample_rate": 1000, "lowpass": {"family": "first_order", "order": 2, "cutoff": 50.0}}


class Tree:
    def __init__(self, rng):
        self.rng, self.links, self.joints, self.masters = rng, ["base"], [], []
        trunk = "base"
        for _ in range(rng.randint(0, 2)):
            trunk = self.add(trunk, "trunk")
        self.tips = {}
        for name in ("left", "right", "head")[:rng.randint(2, 3)]:
            link = trunk
            for _ in range(rng.randint(1, 4)):
                link = self.add(link, name)
            self.tips[name] = link
        if not any("prismatic" in j for j in self.joints):
            self.tips["head"] = self.tips["left"]  # two names of one link: nothing moves one against the other

    def add(self, parent, branch):
        r, name = self.rng, f"{branch}_{len(self.joints)}"
        numbers = lambda low, high: " ".join(repr(r.uniform(low, high)) for _ in range(3))
        kind = r.choice(["revolute"] * 3 + ["prismatic"])
        mimic = ""
        if self.masters and r.random() < 0.2:
            mimic = f'<mimic joint="{r.choice(self.masters)}" multiplier="{r.uniform(-1, 1)}" offset="{r.uniform(-0.2, 0.2)}"/>'
        else:
            self.masters.append(name)
        self.links.append(f"link_{name}")
        self.joints.append(f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="link_{name}"/>'
                           f'<origin xyz="{numbers(-0.4, 0.4)}" rpy="{numbers(-3, 3)}"/><axis xyz="{numbers(0.1, 1)}"/>'
                           f'<limit lower="-1" upper="1" effort="1" velocity="1"/>{mimic}</joint>')
        return f"link_{name}"

    def urdf(self):
        return '<robot name="tree">' + "".join(f'<link name="{l}"/>' for l in self.links) + "".join(self.joints) + "</robot>"


def rows_of(chains, names, points, tip, other=None, frame="base"):
    """Derivatives of x .. rz by the joints `names` at the points: (points, 6, joints); in the axes of the base, or of the other tip, or of the tip itself."""
    def pose(q):
        position, rotation = chains[tip].pose(q[:, [names.index(n) for n in chains[tip].names]])
        if other is None:
            return position, rotation
        origin, axes = chains[other].pose(q[:, [names.index(n) for n in chains[other].names]])
        back = np.transpose(axes, (0, 2, 1))
        return (back @ (position - origin)[:, :, None])[:, :, 0], back @ rotation

    step, rows = 1e-40, np.zeros((len(points), 6, len(names)))
    _, rotation = pose(points.astype(complex))
    for k in range(len(names)):
        moved = points.astype(complex)
        moved[:, k] += 1j * step
        position, turned = pose(moved)
        spin = turned.imag / step @ np.transpose(rotation.real, (0, 2, 1))
        rows[:, :3, k] = position.imag / step
        rows[:, 3:, k] = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)
    if frame == "tip":
        back = np.transpose(rotation.real, (0, 2, 1))
        rows = np.concatenate([back @ rows[:, :3], back @ rows[:, 3:]], axis=1)
    return rows


def check_geometry(t, qerr, folder, tree, chains, names, worst, name):
    """A displaced <origin> on the way from one tip up to the branch, and down to the other: the same as in a displaced URDF."""
    passed = [n for n in names if n.startswith(("left", "right")) and f'mimic joint="{n}"' not in tree.urdf()]
    if tree.tips["left"] == tree.tips["right"] or not passed:
        return
    own = list(dict.fromkeys(n for tip in ("left", "right") for n in chains[tip].names))  # of the trunk some cancel
    length = 2e-3
    for joint in passed:
        axis = tree.rng.choice("xyz")
        (folder / "upward.yaml").write_text(
            f"qerr: 1\nrobot: {{urdf: tree.urdf, base: {tree.tips['left']}, tip: {tree.tips['right']}}}\nencoders: {{'*': {{resolution: 1e-9}}}}\n"
            f"effects: [{{type: geometry, joint: {joint}, axis: {axis}, length: {length} m}}]\nconfigurations: {{count: 5}}\n")
        ran = run(qerr, "analyze", "upward.yaml", "-q", "--per-configuration", "each.csv", cwd=folder)
        if not t.check(f"{name} geometry of {joint}", ran.code == 0, ran.err.decode()[:300]):
            continue
        with open(folder / "each.csv", newline="") as f:
            table = [{key.split(" [")[0]: float(cell) for key, cell in row.items()} for row in csv.DictReader(f)]
        at = np.array([[row.get(n, 0.0) for n in own] for row in table])

        def relative(*displaced):
            poses = []
            for tip in ("right", "left"):
                chain = Chain(folder / "tree.urdf", "base", tree.tips[tip])
                for j in chain.joints:
                    if j.name in displaced:
                        j.xyz = j.xyz + length * np.eye(3)["xyz".index(axis)]
                poses.append(chain.pose(at[:, [own.index(n) for n in chain.names]]))
            return (np.transpose(poses[1][1], (0, 2, 1)) @ (poses[0][0] - poses[1][0])[:, :, None])[:, :, 0]

        shift = np.abs(relative(joint) - relative())
        for p, row in enumerate(table):
            for c, coordinate in enumerate("xyz"):
                worst.add(f"{name} geometry of {joint} {coordinate}", row[f"position.{coordinate}.worst_case"], shift[p, c], 5e-8)  # of quantization


def check_tree(t, qerr, folder, rng, worst, name):
    tree = Tree(rng)
    (folder / "tree.urdf").write_text(tree.urdf())
    chains = {tip: Chain(folder / "tree.urdf", "base", link) for tip, link in tree.tips.items()}
    names = list(dict.fromkeys(n for chain in chains.values() for n in chain.names))
    delta = np.array([10 ** rng.uniform(-5, -3) for _ in names])
    points = np.array([[rng.uniform(-0.9, 0.9) for _ in names] for _ in range(5)])
    encoders = "\n".join(f"  {n}: {{resolution: {d!r}}}" for n, d in zip(names, delta.tolist()))
    listed = "[" + ", ".join(str(p) for p in points.tolist()) + "]"
    (folder / "spec.yaml").write_text(
        f"qerr: 1\nrobot: {{urdf: tree.urdf, tips: {{{', '.join(f'{n}: {l}' for n, l in tree.tips.items())}}}}}\nencoders:\n{encoders}\n"
        f"coordinates: [tips]\nfilters: {{v: {{derivative: 1, sample_rate: 1000, lowpass: {{family: first_order, order: 2, cutoff: 50}}}}}}\n"
        f"configurations: {{method: list, points: {listed}}}\n")
    ran = run(qerr, "analyze", "spec.yaml", "-q", "--per-configuration", "each.csv", "--json", cwd=folder)
    if not t.check(f"{name} runs", ran.code == 0, ran.err.decode()[:300]):
        return
    with open(folder / "each.csv", newline="") as f:
        table = [{key.split(" [")[0]: float(cell) for key, cell in row.items()} for row in csv.DictReader(f)]
    check_geometry(t, qerr, folder, tree, chains, names, worst, name)
    pairs = [(tip, None) for tip in tree.tips] + [(a, b) for a in tree.tips for b in tree.tips
                                                  if a != b and tree.tips[a] != tree.tips[b]]
    velocity = filters.impulse(FILTER).astype(float)
    l1, h2 = np.abs(velocity).sum(), math.sqrt((velocity**2).sum())
    ran = run(qerr, "analyze", "spec.yaml", "-q", "--per-configuration", "each.csv", "--set", "frame=tip", cwd=folder)
    t.check(f"{name} runs in the axes of the tips", ran.code == 0, ran.err.decode()[:300])
    with open(folder / "each.csv", newline="") as f:
        in_tip = [{key.split(" [")[0]: float(cell) for key, cell in row.items()} for row in csv.DictReader(f)]
    for tip, other in pairs:
        rows = rows_of(chains, names, points, tip, other, "tip")
        called = tip + (f"-{other}" if other else "")
        for c, coordinate in enumerate(COORDINATES):
            for p, row in enumerate(in_tip):
                worst.add(f"{name} {called}.{coordinate} in the axes of {tip}", row[f"position.{called}.{coordinate}.worst_case"],
                          np.abs(rows[p, c]) @ delta / 2, np.abs(rows).max() * delta.max() * 1e-9)
        rows = rows_of(chains, names, points, tip, other)
        called = tip + (f"-{other}" if other else "")
        for c, coordinate in enumerate(COORDINATES):
            scale = np.abs(rows).max() * delta.max() * 1e-9  # rows that cancel
            for p, row in enumerate(table):
                bound, sigma = np.abs(rows[p, c]) @ delta / 2, math.sqrt(rows[p, c] ** 2 @ delta**2 / 12)
                figure = f"position.{called}.{coordinate}"
                worst.add(f"{name} {figure} {p}", row[figure + ".worst_case"], bound, scale)
                worst.add(f"{name} {figure} {p} sigma", row[figure + ".sigma"], sigma, scale)
                worst.add(f"{name} v.{called}.{coordinate} {p}", row[f"v.{called}.{coordinate}.worst_case"], l1 * bound, l1 * scale)
                worst.add(f"{name} v.{called}.{coordinate} {p} sigma", row[f"v.{called}.{coordinate}.sigma"], h2 * sigma, h2 * scale)
                t.check(f"{name} {figure} rigorous", row[figure + ".worst_case_rigorous"] >= row[figure + ".worst_case"])
    if len(chains["left"].names) <= 3 and np.abs(rows_of(chains, names, points, "left")[:, 0]).max() > 1e-9:  # proofs take long
        check_proof(t, qerr, folder, chains["left"], names, delta, name)


def check_proof(t, qerr, folder, chain, names, delta, name):
    """No error that random readings make exceeds the proven bound of the rigorous worst case."""
    with open(folder / "spec.yaml", "a") as f:
        f.write("requirements:\n  - {quantity: position.left.x.worst_case_rigorous, statistic: proven_max, at_most: 1 m}\n")
    ran = run(qerr, "check", "spec.yaml", "-q", "--json", cwd=folder)
    if not t.check(f"{name} is proven", ran.code == 0, ran.err.decode()[:300]):
        return
    value = json.loads(ran.out)["requirements"][0]["value"]
    rng = np.random.default_rng(1)
    q = rng.uniform(-1, 1, (2000, len(chain.names)))
    own = np.array([delta[names.index(n)] for n in chain.names])
    error = np.abs(chain.pose(q + rng.choice([-0.5, 0.5], q.shape) * own)[0] - chain.pose(q)[0])[:, 0].max()
    t.check(f"{name} proven", error <= value * (1 + 1e-9), f"{error} {value}")


def main():
    arguments, qerr, t = study_and_tally(6)
    worst = Worst(1e-9)
    with tempfile.TemporaryDirectory() as folder:
        for i in range(arguments.rounds):
            check_tree(t, qerr, pathlib.Path(folder), random.Random(f"{arguments.seed} {i}"), worst, f"tree {i}")
    t.check(f"{worst.count} figures of tips", worst.holds() and worst.count > 0, worst.detail())
    return t.close()


if __name__ == "__main__":
    raise SystemExit(main())
