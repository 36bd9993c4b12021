#!/usr/bin/env python3
"""Faults of the record itself in the answer of `qerr diagnose`: each fault is made here by formulas of its own and must be
told with its joint, its row and a remedy; records without such a fault must have no finding. Needs numpy only.

    check_data_findings.py --qerr build/qerr [--only NAME] [--verbose]
"""
import argparse
import json
import pathlib
import re
import tempfile

import numpy as np

from tool import Tally, run

STEP = 2 * np.pi / 1e5  # of a count [rad]
ROTARY = """qerr: 1
robot: {joint: {name: table, type: revolute}}
encoders: {table: {counts_per_rev: 2000, gear_ratio: 50}}
"""
LINEAR = """qerr: 1
robot: {joint: {name: table, type: prismatic, limits: [-1, 1]}}
encoders: {table: {counts_per_rev: 5000, gear_ratio: 1, travel_per_rev: 10 mm}}
"""


class Record:
    """A joint with an ideal encoder of 1e5 counts per revolution and a reference sensor with noise of 0.03 counts."""

    def __init__(self, seed, path="sines", rows=5000, rate=1000.0, size=0.9, noise=0.03, step=STEP):
        self.rng = np.random.default_rng(seed)
        self.step, self.rate, self.spec = step, rate, ROTARY
        self.time = np.arange(rows) / rate
        self.x = getattr(self, path)(size)
        self.counts = self.count(self.x)
        self.reference = self.x + noise * step * self.rng.standard_normal(rows)
        self.header, self.column, self.decimals = "table.reference [rad]", "table.counts", 10
        self.timeless, self.time_decimals, self.alone = False, 6, False

    def sines(self, size):
        t = self.time / self.time[-1]
        a, b = self.rng.uniform(0, 2 * np.pi, 2)
        return size * (np.sin(2 * np.pi * 1.7 * t + a) + 0.2 * np.sin(2 * np.pi * 5.3 * t + b)) + 0.1

    def slow(self, size):
        return self.sines(0.25 * self.step * len(self.time) / (2 * np.pi * 1.7))  # a quarter count a row at most

    def ramp(self, size):
        return np.linspace(-size, size, len(self.time)) + 1e-3

    def dwells(self, size):
        """Moves of 0.2 s in random steps, rests of 0.3 s."""
        period, move = int(0.5 * self.rate), int(0.2 * self.rate)
        goals = self.rng.uniform(-size, size, len(self.time) // period + 2)
        k = np.arange(len(self.time))
        u = np.clip((k % period) / move, 0, 1)
        s = u * u * (3 - 2 * u)
        return goals[k // period] * (1 - s) + goals[k // period + 1] * s

    def steps(self, size):
        """A table at even steps, up and down, with some targets left out."""
        k = np.abs((np.arange(len(self.time)) % 200) - 100)
        return np.round(k * 1.003) * size / 100

    def still(self, size):
        return np.full(len(self.time), 0.1234567)

    def poses(self, size):
        return self.rng.uniform(-size, size, len(self.time))

    def count(self, x):
        return np.floor(x / self.step + 0.5)

    def write(self, folder):
        columns = ([] if self.timeless else [("time [s]", self.time, self.time_decimals)]) + [
            (self.column, self.counts, 0)] + ([] if self.alone else [(self.header, self.reference, self.decimals)])
        lines = [",".join("%.*f" % (d, c[k]) for _, c, d in columns) for k in range(len(self.time))]
        (folder / "log.csv").write_text("\n".join([",".join(h for h, _, _ in columns)] + lines) + "\n")
        (folder / "spec.yaml").write_text(self.spec)


def held(x, n):
    return x[(np.arange(len(x)) // n) * n]


def made(change, **options):
    def make(seed):
        r = Record(seed, **options)
        change(r)
        return r
    return make


def hold_counts(n):
    return lambda r: setattr(r, "counts", held(r.counts, n))


def hold_reference(n):
    return lambda r: setattr(r, "reference", held(r.reference, n))


def grid(counts):
    return lambda r: setattr(r, "reference", np.round(r.reference / (counts * r.step)) * counts * r.step)


def noisy(counts):
    def change(r):
        r.reference = r.reference + counts * r.step * r.rng.standard_normal(len(r.x))
    return change


def unit(factor, linear=False):
    def change(r):
        r.reference = r.reference * factor
        if linear:
            r.spec, r.header = LINEAR, "table.reference [m]"
    return change


def spikes(number, size, column="counts", first=50):
    def change(r):
        at = first + np.sort(r.rng.choice(len(r.x) - 2 * first, number, replace=False))
        by = np.round(size * r.rng.uniform(0.5, 1, number)) * r.rng.choice([-1, 1], number)
        x = getattr(r, column).copy()
        x[at] += by * (1 if column == "counts" else r.step)
        setattr(r, column, x)
        r.first = at[0] + 1
    return change


def wrapped(modulus, noise=0.0, walk=0.0, start=0):
    """A counter that overflows; the reference has white noise, and a random walk, in counts."""
    def change(r):
        r.counts = np.mod(r.counts + start, modulus)
        n = len(r.x)
        r.reference = r.reference + r.step * (noise * r.rng.standard_normal(n) + walk * np.cumsum(r.rng.standard_normal(n)))
    return change


def slip(r):
    r.counts = r.count(r.x + 37.4 * STEP * (r.time > 0.6 * r.time[-1]))


def add(size):
    def change(r):
        r.counts = r.count(r.x + size(r))
    return change


def play(r):
    y, out = r.x[0], []
    for v in r.x:
        y = min(max(y, v - 3 * STEP), v + 3 * STEP)
        out.append(y)
    r.counts = r.count(np.array(out))


def thin(points):
    def change(r):
        at = np.linspace(r.x[0], r.x[-1], points)
        error = 2 * STEP * r.rng.standard_normal(points) + 30 * STEP * np.sin(at)
        r.counts = np.round(r.x / STEP)
        r.reference = np.interp(r.x, at, at + error)
    return change


def rounded_stamps(decimals):
    return lambda r: setattr(r, "time_decimals", decimals)


def gap(r):
    r.time = r.time + 0.5 * (np.arange(len(r.time)) >= 4000)
    r.first = 4001


def lost(number, decimals):
    """Some rows are missing, all in the second half: not a clock that drifts."""
    def change(r):
        at = len(r.x) // 2 + 100 * np.arange(1, number + 1)
        for column in ("time", "x", "counts", "reference"):
            setattr(r, column, np.delete(getattr(r, column), at))
        r.time_decimals, r.first = decimals, at[0] + 1
    return change


def repeated(r):
    r.time[3000::7] = r.time[2999:-1:7][:len(r.time[3000::7])]
    r.first = 3001


def late(r, by=3.4e-3):
    start = np.minimum(r.time - by, 0) * (r.x[1] - r.x[0]) * r.rate  # before the record the speed was the same
    r.counts = r.count(np.interp(r.time - by, r.time, r.x) + start)


def jitter(r):
    r.counts = r.count(np.interp(r.time + 3e-4 * r.rng.standard_normal(len(r.x)), r.time, r.x))


def creep(r):
    """After each stop the encoder's side goes on by ten counts."""
    v = np.abs(np.gradient(r.x, r.time))
    y, out = 0.0, []
    for moves in v > 1e-9:
        y = 10 * STEP if moves else y * (1 - 0.01)
        out.append(y)
    r.counts = r.count(r.x - np.array(out))


def reverse(r):
    r.counts = -r.counts


def decode(factor):
    return lambda r: setattr(r, "counts", np.floor(r.counts * factor + 0.5))


def both(*changes):
    def change(r):
        for c in changes:
            c(r)
    return change


DEG = 180 / np.pi
# name, words of the finding (None: no finding at all), causes that must not be named, maker
def alone(r):
    r.alone = True


def stuck(bit):
    return lambda r: setattr(r, "counts", ((r.counts + 2**20).astype(int) | (1 << bit)) - 2**20)


def pause(r):
    at = np.argmax(np.abs(np.diff(r.x))[300:-700]) + 100  # it moves at the end
    r.counts[at:at + 200] = r.counts[at]


def leap(r):
    r.counts[3000:] += 900


def ripple(r):
    r.counts = r.count(r.x + 9 * r.step * np.sin(50 * r.x))


FAULTS = [
    ("alone_spikes", r"7 single readings far", set(), made(both(alone, spikes(7, 3000)))),
    ("alone_held", r"held for about", set(), made(both(alone, hold_counts(5)))),
    ("alone_pause", r"counts stand for (199|200)", set(), made(both(alone, pause))),
    ("alone_leap", r"leaps by (89|90)", set(), made(both(alone, leap))),
    *[(f"alone_bit_{bit}", rf"bit {bit} of the counts", set(), made(both(alone, stuck(bit)))) for bit in (1, 3, 5)],
    ("alone_ripple", r"ripple: (8|9).*order 1", set(), made(both(alone, ripple), path="ramp", size=2.0)),
    ("degrees", r"57\.3", {"scale", "drift", "offset", "decoding"}, made(unit(DEG))),
    ("arcsec", r"2\.06\de\+05|20626", {"scale", "drift"}, made(unit(3600 * DEG))),
    ("mrad", r"1000", {"scale", "drift"}, made(unit(1000))),
    ("turns", r"0\.159|6\.28", {"scale", "drift"}, made(unit(0.5 / np.pi))),
    ("millimetres", r"1000", {"scale", "drift"}, made(unit(1000, True), size=0.1, step=2e-6)),
    ("inches", r"39\.37", {"scale", "drift"}, made(unit(1 / 0.0254, True), size=0.1, step=2e-6)),
    ("degrees_scaled", r"57\.3", {"drift"}, made(both(unit(DEG), add(lambda r: 0.004 * r.x)))),
    ("degrees_x2", r"57\.3", {"scale", "drift"}, made(both(unit(DEG), decode(0.5)))),
    ("reversed", r"direction", {"scale", "drift"}, made(reverse)),
    ("reversed_degrees", r"direction", {"scale", "drift"}, made(both(reverse, unit(DEG)))),
    *[(f"held_{n}", rf"held for {n} rows", {"timing_jitter", "noise", "drift", "scale"}, made(hold_counts(n)))
      for n in (2, 3, 5, 10)],
    ("held_dwells_4", r"held for 4 rows", {"timing_jitter", "noise", "drift"}, made(hold_counts(4), path="dwells")),
    ("held_slow_8", r"held for 8 rows", {"noise", "drift"}, made(hold_counts(8), rows=20000, size=0.12)),
    *[(f"reference_held_{n}", rf"reference is held for {n} rows", {"timing_jitter", "noise", "drift"},
       made(hold_reference(n))) for n in (2, 5, 10)],
    *[(f"grid_{g}", r"coarser than the encoder", {"noise"}, made(grid(g), noise=0)) for g in (2, 3, 10)],
    ("grid_3_dwells", r"coarser than the encoder", {"noise"}, made(grid(3), path="dwells")),
    *[(f"noisy_{n}", r"coarser than the encoder|noise", {"noise", "timing_jitter"}, made(noisy(n))) for n in (1, 3)],
    ("spike_1", r"1 reading", {"missed_counts", "noise", "rollover"}, made(spikes(1, 900))),
    ("spikes_5", r"5 readings", {"missed_counts", "noise", "rollover"}, made(spikes(5, 100))),
    ("spikes_40", r"40 readings", {"missed_counts", "noise", "rollover"}, made(spikes(40, 3000), rows=10000)),
    ("spikes_reference", r"9 readings", {"missed_counts", "noise", "rollover"}, made(spikes(9, 500, "reference"))),
    ("spike_first_row", r"1 reading", {"missed_counts", "noise"},
     made(lambda r: (r.counts.__setitem__(0, r.counts[0] + 700), setattr(r, "first", 1)))),
    *[(f"rollover_{m}", rf"\b{m}\b", {"scale", "drift", "missed_counts"}, made(wrapped(m, start=m // 3)))
      for m in (4096, 2000, 8192)],
    ("rollover_noisy_16384", r"\b16384\b", {"scale", "drift", "missed_counts"}, made(wrapped(16384, noise=500, start=9000))),
    ("rollover_noisy_4096", r"\b4096\b", {"scale", "drift", "missed_counts"}, made(wrapped(4096, noise=400))),
    ("rollover_walk_8192", r"\b8192\b", {"scale", "drift", "missed_counts"}, made(wrapped(8192, walk=40, start=100))),
    ("rollover_once_65536", r"\b65536\b", {"scale", "drift", "missed_counts"},
     made(wrapped(65536, noise=300, start=65000), path="ramp")),
    ("thinned_200", r"\b(19\d|20\d|21\d)\b", set(), made(thin(200), path="ramp", rows=8000)),
    ("stamps_rounded", r"multiples of 0\.01", {"timing_jitter"}, made(rounded_stamps(2))),
    ("stamps_gap", r"gap", {"timing_jitter", "latency"}, made(gap)),
    ("stamps_lost_2", r"^time: 2 gaps, in which 2 rows are missing", {"timing_jitter"}, made(lost(2, 3), rows=20000)),
    ("stamps_lost_9", r"^time: 9 gaps, in which 9 rows are missing", {"timing_jitter"}, made(lost(9, 6))),
    ("stamps_repeated", r"stamp of the previous", {"latency"}, made(repeated)),
    ("few_rows", r"20 rows", set(), made(lambda r: None, rows=20)),
    ("still", r"move", set(), made(lambda r: None, path="still", rows=2000)),
]
KINDS = {"alone_spikes": "corrupt", "alone_held": "repeated", "alone_bit": "corrupt", "alone_ripple": "remark", "spike": "corrupt", "stamps_gap": "missing", "stamps_lost": "missing", "stamps_repeated": "repeated", "held": "repeated",
         "reference_held": "repeated", "degrees": "contradictory", "mrad": "contradictory", "millimetres": "contradictory",
         "grid": "remark", "thinned": "remark", "still": "remark", "stamps_rounded": "remark"}
CLEAN = [
    *[(f"alone_{path}", made(alone, path=path)) for path in ("sines", "slow", "ramp", "dwells")],
    *[(path, made(lambda r: None, path=path)) for path in ("sines", "slow", "ramp", "dwells")],
    ("fast", made(lambda r: None, rows=3000, size=3.0)),
    ("short", made(lambda r: None, rows=200)),
    ("poses_timeless", made(lambda r: setattr(r, "timeless", True), path="poses", rows=300)),
    ("poses", made(lambda r: None, path="poses", rows=300)),
    ("play", made(play)),
    ("slip", made(slip)),
    ("latency", made(late)),
    ("large_eccentricity", made(add(lambda r: 120 * STEP * np.sin(r.x + 0.4)))),
    ("noise", made(add(lambda r: 1.5 * STEP * r.rng.standard_normal(len(r.x))))),
    *[(f"noise_{n}_ramp", made(add(lambda r, n=n: n * STEP * r.rng.standard_normal(len(r.x))), path="ramp",
                                size=0.5 * STEP * 5000 * per_row)) for per_row, n in ((1, 1), (2, 2))],
    ("jitter", made(jitter)),
    *[(f"{name}_dwells", made(change, path="dwells")) for name, change in
      (("jitter", jitter), ("late", late), ("creep", creep), ("play", play), ("slip", slip), ("noise", noisy(0.2)))],
    ("play_ramp", made(play, path="ramp")),
    ("slow_jitter", made(jitter, path="slow")),
    ("noiseless", made(lambda r: None, noise=0)),
    ("noiseless_ramp", made(lambda r: None, noise=0, path="ramp")),
    ("noiseless_dwells", made(lambda r: None, noise=0, path="dwells")),
    ("undersampled", made(lambda r: None, rows=150, noise=0.1)),
    ("hum", made(add(lambda r: 2 * STEP * np.sin(2 * np.pi * 50 * r.time)))),
    ("scale_2_percent", made(add(lambda r: 0.02 * r.x))),
    ("missed", made(add(lambda r: 5 * STEP * np.floor(r.time / 1.7)))),
    ("slow_grid_half", made(grid(0.5), path="slow")),
    ("slow_play", made(play, path="slow", rows=30000)),
    ("even_table", made(lambda r: setattr(r, "reference", r.x), noise=0, path="steps", rows=400)),
    ("coarse_encoder", made(lambda r: setattr(r, "counts", r.count(r.x)), size=0.004)),
]


def answer(qerr, record):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        record.write(folder)
        ran = run(qerr, "diagnose", folder / "spec.yaml", folder / "log.csv", "--format", "json", "--check")
    if ran.code in (0, 1):
        return json.loads(ran.out) | {"code": ran.code}
    return {"verdict": f"exit {ran.code}: {ran.err[-300:]}", "causes": [], "data": []}


def main():
    p = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    p.add_argument("--qerr", required=True)
    p.add_argument("--only", default="")
    p.add_argument("--seeds", type=int, default=1)
    p.add_argument("--verbose", action="store_true")
    o = p.parse_args()
    tally = Tally(False)
    for seed in range(1, o.seeds + 1):
        for name, words, forbidden, make in FAULTS:
            if o.only not in name:
                continue
            record = make(seed)
            a = answer(o.qerr, record)
            told = [f for f in a["data"] if re.search(words, f["what"])]
            causes = {c["effect"] for c in a["causes"]}
            first = getattr(record, "first", None)
            wrong = ([] if told else ["not told"]) + sorted(causes & forbidden)
            wrong += ["no remedy"] if any(not f["remedy"] for f in told) else []
            if told and first is not None and not any(abs(f.get("row", -9) - first) <= 1 for f in told):
                wrong.append(f"row {told[0].get('row')} in place of {first}")
            kind = next((kind for start, kind in KINDS.items() if name.startswith(start)), None)
            wrong += [f"kind {told[0]['kind']}"] if told and kind and told[0]["kind"] != kind else []
            faultless = a["verdict"] == "nothing_wrong" and all(f["kind"] == "remark" for f in a["data"])
            wrong += [f"--check ends with {a['code']}"] if a.get("code") != (0 if faultless else 1) else []
            tally.check(f"{name} (seed {seed})", not wrong,
                        f"{', '.join(wrong)}; {a['verdict']}, {sorted(causes)}, {[f['what'] for f in a['data']]}"[:400])
            if o.verbose:
                print(name, a["verdict"], sorted(causes), [f["what"] for f in a["data"]])
        for name, make in CLEAN:
            if o.only not in name:
                continue
            a = answer(o.qerr, make(seed))
            right = not a["data"] and a.get("code") == (a["verdict"] != "nothing_wrong")
            tally.check(f"no finding about {name} (seed {seed})", right, f"{a['verdict']}, {a['data']}"[:400])
            if o.verbose:
                print("clean", name, a["verdict"], sorted({c["effect"] for c in a["causes"]}), [f["what"] for f in a["data"]])
    return tally.close()


if __name__ == "__main__":
    raise SystemExit(main())
