"""Physical models of encoders: a table of edges, or sine and cosine with an arctangent; an eccentric disc before them.

Positions are those of the joint [rad or m] that the encoder believes in: shaft angle over gear ratio. One count is `resolution`.
"""
import math
from dataclasses import dataclass, field

import numpy as np

PERIOD = 4  # edges of an A/B pair per line


@dataclass
class Encoder:
    kind: str                    # counts | lines | bits | sincos | resolution
    gear: float = 1.0
    counts: float = 4096         # per encoder revolution, after decoding
    periods: int = 1             # sincos only
    bits: int = 12               # sincos: per period; bits: per revolution
    travel: float = 0.0          # m per revolution; 0: a revolute joint
    rounding: str = "nearest"
    zero: str = "known"
    flaws: dict = field(default_factory=dict)  # deviations from the data sheet

    @property
    def resolution(self):
        return (self.travel or 2 * math.pi) / (self.counts * abs(self.gear))

    @property
    def to_shaft(self):
        """Shaft angle [rad] per joint coordinate."""
        return 2 * math.pi * self.gear / (self.travel or 2 * math.pi)

    def spec(self):
        """The ideal encoder, as the spec states it."""
        stated = {"counts": f"counts_per_rev: {self.counts:.10g}",
                  "lines": f"lines_per_rev: {self.counts / PERIOD:.10g}, decoding: x4",
                  "bits": f"bits: {self.bits}",
                  "resolution": f"resolution: {self.resolution:.10g}",
                  "sincos": f"periods_per_rev: {self.periods}, interpolation_bits: {self.bits}"}[self.kind]
        parts = [stated]
        if self.gear != 1 and self.kind != "resolution":
            parts.append(f"gear_ratio: {self.gear:.10g}")
        if self.travel:
            parts.append(f"travel_per_rev: {self.travel:.10g} m")
        if self.rounding != "nearest":
            parts.append("rounding: down")
        if self.zero != "known":
            parts.append("zero: free")
        return "{" + ", ".join(parts) + "}"

    # -- the disc ------------------------------------------------------------------------------------------------------
    def on_disc(self, x):
        """The angle that the reading head measures on a disc whose pattern is `eccentricity` (over its radius) off centre.

        Head at (1, 0), pattern centre at c = e (cos, sin)(shaft + p): the head lies at the angle atan2(-c_y, 1 - c_x) as
        seen from the pattern, which has turned by the shaft's angle: reading = shaft - that angle.
        """
        e, p = self.flaws.get("eccentricity", (0.0, 0.0))
        if e == 0:
            return x
        shaft = self.to_shaft * x
        return x - np.arctan2(-e * np.sin(shaft + p), 1 - e * np.cos(shaft + p)) / self.to_shaft

    # -- the lines -----------------------------------------------------------------------------------------------------
    def edges(self, low, high):
        """(k, ideal, actual): edge k lies between the counts k - 1 and k.

        Ideal edges lie at (k - 1/2) steps (at k steps when the encoder rounds down). Of an A/B pair k mod 4 is A up, B up,
        A down, B down: a quadrature error [electrical rad] moves both edges of B, a duty error (share of a line) one of each.
        """
        step = self.resolution
        k = np.arange(math.floor(low / step) - 3 * PERIOD, math.ceil(high / step) + 3 * PERIOD)
        ideal = (k if self.rounding == "down" else k - 0.5) * step
        shift = np.zeros(len(k))
        shift[k % 2 == 1] += self.flaws.get("quadrature", 0.0) / (2 * math.pi) * PERIOD
        a, b = self.flaws.get("duty", (0.0, 0.0))
        shift[k % PERIOD == 2] += a * PERIOD
        shift[k % PERIOD == 3] += b * PERIOD
        if self.flaws.get("truncation"):
            shift += 0.5
        return k, ideal, ideal + shift * step

    def interpolated(self, x):
        """Position by atan2 of distorted signals: sine (1 + gain) sin(u + phase) + offset, cosine cos u + offset,
        both clipped, over the signal's period."""
        f = self.flaws.get("heydemann")
        if not f:
            return x
        scale = self.to_shaft * self.periods
        u = scale * x
        limit = f.get("clipping", np.inf)
        sine = np.clip((1 + f.get("gain", 0)) * np.sin(u + f.get("phase", 0)) + f.get("offset_sin", 0), -limit, limit)
        cosine = np.clip(np.cos(u) + f.get("offset_cos", 0), -limit, limit)
        error = np.arctan2(sine, cosine) - u
        return x + (error - 2 * np.pi * np.round(error / (2 * np.pi))) / scale

    def count(self, x, noise=0.0):
        """Counts at the positions x; `noise` is added before the comparators."""
        seen = self.on_disc(x)
        if self.kind == "sincos":
            half = 0.0 if self.rounding == "down" else 0.5
            turn = np.floor((self.interpolated(seen) + noise) / self.resolution + half)
            return turn.astype(np.int64)
        seen = seen + noise
        k, _, actual = self.edges(seen.min(), seen.max())
        per = self.flaws.get("counts_every", 1)  # a x4 encoder read as x1 counts every fourth edge
        used = k % per == 0
        return (k[used][0] - per) // per + np.searchsorted(np.sort(actual[used]), seen, side="right")

    def apparent(self, x):
        """The position of which an ideal encoder would give the same counts (averaged over the comparators' noise).

        Between its edges the position is stretched linearly onto the ideal edges.
        """
        seen = self.on_disc(x)
        if self.kind == "sincos":
            return self.interpolated(seen)
        k, ideal, actual = self.edges(seen.min(), seen.max())
        per = self.flaws.get("counts_every", 1)
        if per > 1:  # edge k of the pair is edge k/per of what is counted
            used = k % per == 0
            return np.interp(seen, actual[used], (k[used] / per - 0.5) * self.resolution)
        return seen if np.array_equal(ideal, actual) else np.interp(seen, actual, ideal)


def random_encoder(rng, prismatic=False, kind=None):
    """Commercial resolutions: a count of 1.5e-5 to 4e-4 rad at the joint."""
    if prismatic:
        return Encoder("counts", float(rng.choice([1, 2, 5])), float(rng.choice([1000, 2000, 4096])), travel=0.02)
    kind = kind or rng.choice(["counts", "lines", "bits", "sincos"], p=[0.4, 0.4, 0.1, 0.1])
    while True:
        if kind == "bits":
            bits = int(rng.integers(14, 18))
            return Encoder("bits", 1.0, 2.0 ** bits, bits=bits)
        gear = float(rng.choice([10, 12, 20, 25, 30, 36, 50, 80, 100]))
        if kind == "sincos":
            periods, bits = int(rng.choice([1, 2, 16, 64])), int(rng.integers(6, 13))
            made = Encoder("sincos", gear, periods * 2.0 ** bits, periods, bits)
        else:
            lines = float(rng.choice([360, 500, 512, 1000, 1024, 1250, 2000]))
            made = Encoder(kind, gear, PERIOD * lines)
        if 1.5e-5 <= made.resolution <= 4e-4:
            return made
