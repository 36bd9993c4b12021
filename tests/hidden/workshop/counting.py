"""An encoder as it counts: geometry of the disc, edges of a line, sine and cosine, and the counter behind it.

`step` is the signed joint coordinate of one count: a negative gear ratio makes the counter fall where the joint rises.
"""
import math
from dataclasses import dataclass

import numpy as np


@dataclass
class Counter:
    per_rev: float = 4096       # counts per revolution of the encoder
    gear: float = 1.0
    lead: float = 0.0           # m per revolution; 0: revolute
    form: str = "counts"        # counts | lines | bits | sincos
    periods: int = 1            # sincos: per revolution
    down: bool = False
    free_zero: bool = False

    @property
    def turn(self):
        return self.lead or 2 * math.pi

    @property
    def step(self):
        return self.turn / (self.per_rev * self.gear)

    def spec(self):
        text = {"counts": f"counts_per_rev: {self.per_rev:.12g}", "lines": f"lines_per_rev: {self.per_rev / 4:.12g}, decoding: x4",
                "bits": f"bits: {round(math.log2(self.per_rev))}",
                "sincos": f"periods_per_rev: {self.periods}, interpolation_bits: {round(math.log2(self.per_rev / self.periods))}"}[self.form]
        text += f", gear_ratio: {self.gear:.12g}" if self.gear != 1 else ""
        text += f", travel_per_rev: {1000 * self.lead:.12g} mm" if self.lead else ""
        text += ", rounding: down" if self.down else ""
        return "{" + text + (", zero: free" if self.free_zero else "") + "}"

    def shaft(self, x):
        return x * (2 * math.pi * self.gear / self.turn)

    def count(self, x, disc=None, edges=None, signals=None, noise=0.0):
        """Counts at the joint coordinate x. disc: shaft angle -> angle under the head; edges: the four edges of a line, in
        counts from their ideal places; signals: sine, cosine -> the signals as they arrive; noise in counts."""
        angle = self.shaft(x)
        if disc is not None:
            angle = disc(angle)
        if signals is not None:
            u = angle * self.periods
            s, c = signals(np.sin(u), np.cos(u))
            off = np.arctan2(s, c) - u
            angle = (u + off - 2 * np.pi * np.round(off / (2 * np.pi))) / self.periods
        at = angle * (self.per_rev / (2 * math.pi)) + noise
        first = 0.0 if self.down else 0.5
        if edges is None:
            return np.floor(at + first).astype(np.int64)
        line = np.floor(at / 4)
        inside, counts = at - 4 * line, (4 * (line - 1)).astype(np.int64)
        for k in range(4):  # the edges of this line and of its two neighbours
            for m in (-1, 0, 1):
                counts += inside - 4 * m >= k + 1 - first + edges[k]
        return counts


def off_centre(radius, phase):
    """Angle under the head (at 1, 0) of a disc whose pattern's centre runs on a circle of `radius` (of the track's) about the shaft."""
    def seen(angle):
        cx, cy = radius * np.cos(angle + phase), radius * np.sin(angle + phase)
        return angle - np.arctan2(-cy, 1 - cx)
    return seen


def draw(rng, slide=False, form=None, finest=3e-7, coarsest=3e-3):
    """A counter as one buys it, on a gear as it is built."""
    while True:
        form_ = form or str(rng.choice(["counts", "counts", "lines", "bits", "sincos"]))
        lead = float(rng.choice([2, 4, 5, 10, 20])) * 1e-3 if slide else 0.0
        gear = float(rng.choice([1, 1, 2.5, -4, 10, -30, 33.25, 50, 80.5, -100, 121, 160.4] if not slide else [1, 1, -1, 2, 3.2]))
        periods = 1
        if form_ == "bits":
            per = 2.0 ** int(rng.integers(12, 21))
            gear = 1.0 if not slide else gear
        elif form_ == "sincos":
            periods = int(rng.choice([1, 32, 128, 512]))
            per = periods * 2.0 ** int(rng.integers(6, 13))
        elif form_ == "lines":
            per = 4.0 * float(rng.choice([100, 360, 500, 1000, 1024, 2500, 5000]))
        else:
            per = float(rng.choice([400, 1000, 2000, 4096, 5000, 10000, 16384]))
        made = Counter(per, gear, lead, form_, periods)
        if finest <= abs(made.step) * (1 if not slide else 30) <= coarsest:
            return made
