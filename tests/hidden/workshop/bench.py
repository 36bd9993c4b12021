"""One joint on the bench: its counter, motion, clock and reference; and the record that is written.

A kind draws a bench, changes what its fault changes, and returns `Record`. `fair` says whether the fault can be seen and
distinguished in this motion at all: a draw that is not fair is drawn again.
"""
import json
import math
from dataclasses import dataclass, field

import numpy as np

from . import arms, counting, paths


class Unfair(Exception):
    """This draw cannot show its fault."""


@dataclass
class Record:
    spec: str
    columns: list                                # (header, values, format)
    truth: dict
    urdf: str = ""
    single: tuple = ()                           # (joint, counter entry) of a record that an arm may surround


@dataclass
class Bench:
    name: str
    counter: counting.Counter
    path: object
    t: np.ndarray
    motion: str
    noise: float                                 # sigma of the reference, rad or m
    extra: list = field(default_factory=list)    # further columns

    @property
    def unit(self):
        return "m" if self.counter.lead else "rad"

    @property
    def count(self):
        return abs(self.counter.step)

    @property
    def q(self):
        return self.path(self.t)

    def column(self, what, unit, values, fmt="%.7g"):
        self.extra.append((f"{self.name}.{what} [{unit}]", values, fmt))

    def reference(self, rng, q=None):
        q = self.q if q is None else q
        return q + self.noise * rng.standard_normal(len(q))

    def record(self, rng, counts, truth, q=None, reference=None, stamps=None, measured=None, limits=True):
        """The log of these counts beside the joint's true positions q (or a complete reference)."""
        reference = self.reference(rng, q) if reference is None else reference
        t = self.t if stamps is None else stamps
        columns = [("time [s]", t, "%.6f")]
        columns.append((f"{self.name}.counts", counts, "%d") if measured is None else measured)
        columns.append((f"{self.name}.reference [{self.unit}]", reference, f"%.{decimals(self.count)}f"))
        kind = "prismatic" if self.counter.lead else "revolute"
        spec = (f"qerr: 1\nrobot: {{joint: {{name: {self.name}, type: {kind}}}}}\n"
                f"encoders:\n  {self.name}: {self.counter.spec()}\n")
        if self.counter.lead and limits:
            spec += f"configurations: {{limits: {{{self.name}: [-2 m, 2 m]}}}}\n"
        moved = np.abs(np.diff(self.q)).sum() / self.count
        truth.update(joint=self.name, motion=self.motion, rows=len(t), rate=round(1 / (self.t[1] - self.t[0]), 3),
                     counts_travelled=round(float(moved)), reference_noise_counts=round(self.noise / self.count, 3))
        return Record(spec, columns + self.extra, truth, single=(self.name, self.counter.spec()))


def decimals(step):
    return max(3, math.ceil(-math.log10(step / 300)))


def draw(rng, motions=None, slide=None, noise=(0.005, 0.1), form=None, rows=(1500, 60000), seconds=(2, 300), fewest=400, finest=3e-7):
    """A bench. noise: of the reference in counts, from and to; fewest: counts of travel in the record."""
    for _ in range(200):
        linear = rng.random() < 0.25 if slide is None else slide
        counter = counting.draw(rng, linear, form, finest)
        motion = str(rng.choice(motions or list(paths.MOTIONS)))
        n, rate = int(math.exp(rng.uniform(*np.log(rows)))), float(rng.choice([50, 100, 200, 250, 500, 1000, 2000, 4000]))
        if not seconds[0] <= n / rate <= seconds[1]:
            continue
        reach = math.exp(rng.uniform(*np.log([5e-3, 0.4] if linear else [0.05, 3])))
        if motion == "one_way":
            reach *= 1 if linear else 3
        t = np.arange(n) / rate
        path = paths.MOTIONS[motion](rng, reach, n / rate)
        centre = rng.uniform(-1, 1) * reach
        shifted = lambda t, path=path, centre=centre: centre + path(t)
        x = shifted(t) / abs(counter.step)
        fastest = np.abs(np.diff(x)).max() * abs(counter.step) * rate
        if np.abs(np.diff(x)).sum() < fewest or np.ptp(x) < 100 or np.ptp(x) > 2e7 or fastest > (2 if linear else 15):
            continue
        name = str(rng.choice(["axis", "carriage", "x"] if linear else ["table", "spindle", "joint_1", "swivel"]))
        sigma = math.exp(rng.uniform(*np.log(noise))) * abs(counter.step)
        return Bench(name, counter, shifted, t, motion, sigma)
    raise Unfair


def size(rng, b, least=0.5, most=200.0):
    """Of a fault, in rad or m: 0.5 to 200 counts, and at most a fiftieth of the range of motion."""
    most = min(most, np.ptp(b.q) / b.count / 50)
    if most < least:
        raise Unfair
    return math.exp(rng.uniform(*np.log([least, most]))) * b.count


def share_of(y, columns):
    """R^2 of the regression of y on the columns and a constant."""
    y = y - y.mean()
    m = np.column_stack([np.ones(len(y)), *columns])
    scaled = m / np.abs(m).max(axis=0).clip(1e-300)
    rest = y - scaled @ np.linalg.lstsq(scaled, y, rcond=None)[0]
    return 1 - rest @ rest / max(y @ y, 1e-300)


def fair(b, error, but=(), limit=0.9):
    """Raises Unfair unless the error stands out of quantization and noise (25 sigma over the record), and is less than `limit`
    like any one of the plain shapes: position, speed, direction, time. `but` are the shapes that it has by its nature."""
    q, n = b.q, len(b.q)
    independent = min(n, max(1.0, np.abs(np.diff(q)).sum() / b.count))
    sigma = math.sqrt(b.count**2 / 12 + b.noise**2)
    if np.std(error) * math.sqrt(independent) < 25 * sigma or np.std(error) < 0.15 * b.count:
        raise Unfair
    v = np.gradient(q)
    way = np.sign(np.where(v == 0, np.nan, v))
    known = np.maximum.accumulate(np.where(np.isnan(way), 0, np.arange(n)))
    shapes = {"position": q, "speed": v, "direction": np.nan_to_num(way[known]), "time": b.t}
    if any(share_of(error, [x]) > limit for k, x in shapes.items() if k not in but):
        raise Unfair
    return error


def in_an_arm(rng, r):
    """The same joint as one of 2 to 6 of an arm; the others are right, and move and are counted in their own way."""
    n = int(rng.integers(2, 7))
    arm = arms.draw(rng, n)
    place, (name, entry), t = int(rng.integers(n)), r.single, r.columns[0][1]
    joint, columns, encoders = arm.names[place], [r.columns[0]], []
    for j, other in enumerate(arm.names):
        if j == place:
            columns += [(h.replace(name + ".", joint + ".", 1), v, f) for h, v, f in r.columns[1:]]
            encoders.append(f"  {other}: {entry}")
            continue
        c = counting.draw(rng)
        x = paths.MOTIONS[str(rng.choice(["sines", "random_moves", "ramps"]))](rng, rng.uniform(0.1, 1.0), t[-1])(t)
        columns.append((f"{other}.counts", c.count(x), "%d"))
        noisy = x + rng.uniform(0.005, 0.1) * abs(c.step) * rng.standard_normal(len(t))
        columns.append((f"{other}.reference [rad]", noisy, f"%.{decimals(abs(c.step))}f"))
        encoders.append(f"  {other}: {c.spec()}")
    spec = "qerr: 1\nrobot: {urdf: robot.urdf}\nencoders:\n" + "\n".join(encoders) + "\ncoordinates: [x, y, z]\n"
    return Record(spec, columns, {**r.truth, "joint": joint, "arm_of": n}, arm.urdf())


def write(r, folder):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "spec.yaml").write_text(r.spec, encoding="utf-8")
    if r.urdf:
        (folder / "robot.urdf").write_text(r.urdf, encoding="utf-8")
    texts = [np.char.mod(f, v) for _, v, f in r.columns]
    with open(folder / "log.csv", "w", encoding="utf-8") as out:
        out.write(",".join(h for h, _, _ in r.columns) + "\n")
        out.writelines(",".join(row) + "\n" for row in zip(*texts))
    plain = lambda x: x.item() if isinstance(x, np.generic) else x.tolist()
    (folder / "truth.json").write_text(json.dumps(r.truth, indent=1, default=plain) + "\n", encoding="utf-8")
