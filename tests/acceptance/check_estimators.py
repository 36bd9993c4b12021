#!/usr/bin/env python3
"""Checks `qerr simulate --estimators` against an own event-driven simulation.

    check_estimators.py --qerr PATH [--count 10] [--seed 1]

Random motions of one joint (sums of sines, some with a constant velocity) and discs (bits, rounding, unequal states,
eccentricity). Edges: all thresholds that the motion crosses between two of its turning points, by bisection of all at
once. Estimators: by their definitions, sample by sample. Compared: rms, largest error, delay, noise and what the delay makes.
"""
import argparse
import bisect
import json
import math
import pathlib
import random
import tempfile

import numpy as np

from tool import Tally, Worst, run


class Case:
    def __init__(self, rng):
        u = rng.uniform
        self.rate = rng.choice([500, 1000, 2000])
        self.duration = u(2, 5)
        self.settling = 0.25 * self.duration
        self.sines = [(math.radians(10 ** u(-0.3, 1.5)), 10 ** u(-0.7, 0.5), u(-math.pi, math.pi)) for _ in range(rng.randint(1, 3))]
        self.velocity = u(-0.5, 0.5) if rng.random() < 0.4 else 0.0
        self.bits = rng.randint(9, 16)
        self.delta = 2 * math.pi / 2**self.bits
        self.rounding = rng.choice(["nearest", "nearest", "down"])
        self.phase = u(-0.6, 0.6) if rng.random() < 0.5 else 0.0
        self.eccentricity = (u(0, 5) * self.delta, u(-math.pi, math.pi)) if rng.random() < 0.4 else None
        self.clock = 10 ** rng.choice([5, 6, 7, 8])
        self.window = rng.choice([1, 2, 5]) / self.rate
        self.timeout = rng.choice([None, 0.02, 0.1])
        self.longest, self.band = rng.randint(2, 24), rng.choice([0.5, 1, 1.5])
        self.time_constant = rng.choice([0.0, 0.002, 0.01])
        self.bandwidth = 10 ** u(1.5, 2.6)

    def spec(self):
        sines = ", ".join(f"{{amplitude: {a!r}, frequency: {f!r}, phase: {p!r}}}" for a, f, p in self.sines)
        effects = []
        if self.phase:
            effects.append(f"{{type: state_width, joint: j, phase: {self.phase!r}}}")
        if self.eccentricity:
            effects.append(f"{{type: eccentricity, joint: j, amplitude: {self.eccentricity[0]!r}, phase: {self.eccentricity[1]!r}}}")
        timeout = "" if self.timeout is None else f", timeout: {self.timeout}"
        return (f"qerr: 1\nrobot: {{joint: {{name: j, type: revolute, limits: [-1e4, 1e4]}}}}\n"
                f"encoders: {{j: {{counts_per_rev: {2**self.bits}, rounding: {self.rounding}}}}}\ncoordinates: [rz]\n"
                f"filters: {{loop: {{derivative: 1, sample_rate: {self.rate}, lowpass: {{family: tracking_loop, bandwidth: {self.bandwidth!r} rad/s}}}}}}\n"
                f"estimators:\n  edges: {{kind: edge_timing, clock: {self.clock}{timeout}}}\n"
                f"  lines: {{kind: edge_timing, clock: {self.clock}, edges: line{timeout}}}\n"
                f"  counted: {{kind: count_and_time, window: {self.window!r}, clock: {self.clock}{timeout}}}\n"
                f"  ends: {{kind: adaptive_window, longest: {self.longest}, band: {self.band} count, fit: end}}\n"
                f"  fitted: {{kind: adaptive_window, longest: {self.longest}, band: {self.band}, fit: line}}\n"
                f"  held: {{kind: held_difference, time_constant: {self.time_constant}}}\n"
                f"effects: [{', '.join(effects)}]\n"
                f"motion: {{sample_rate: {self.rate}, duration: {self.duration!r}, settling: {self.settling!r}, "
                f"joints: {{j: {{sines: [{sines}], velocity: {self.velocity!r}}}}}}}\n")

    def position(self, t):
        return self.velocity * t + sum(a * np.sin(2 * np.pi * f * t + p) for a, f, p in self.sines)

    def speed(self, t):
        return self.velocity + sum(2 * np.pi * f * a * np.cos(2 * np.pi * f * t + p) for a, f, p in self.sines)

    def shown(self, t):
        """What the disc shows, in counts: the count is its floor, with edges displaced by `shift`."""
        x = self.position(t)
        if self.eccentricity:
            x = x + self.eccentricity[0] * np.sin(x + self.eccentricity[1])
        return x / self.delta + (0.5 if self.rounding == "nearest" else 0.0)

    def threshold(self, k):
        """Of the edge between the counts k - 1 and k."""
        return k + np.where(k % 2 == 1, 4 * self.phase / (2 * math.pi), 0.0)

    def count(self, t):
        y = self.shown(t)
        k = np.floor(y)
        k = np.where(y < self.threshold(k), k - 1, k)
        return np.where(y >= self.threshold(k + 1), k + 1, k)

    def edges(self):
        t = np.linspace(0, self.duration, int(self.duration * 20000))
        v = self.speed(t)
        turns = []
        for i in np.nonzero(v[:-1] * v[1:] < 0)[0]:
            low, high, sign = t[i], t[i + 1], v[i]
            for _ in range(60):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if self.speed(middle) * sign > 0 else (low, middle)
            turns.append(low)
        ends = [0.0, *turns, self.duration]
        times, directions = [], []
        for start, end in zip(ends, ends[1:]):
            first, last = float(self.count(start)), float(self.count(end))
            if first == last:
                continue
            up = last > first
            k = np.arange(first + 1, last + 1) if up else np.arange(first, last, -1)
            goal = self.threshold(k)
            low, high = np.full(len(k), start), np.full(len(k), end)
            for _ in range(70):
                middle = 0.5 * (low + high)
                before = self.shown(middle) < goal if up else self.shown(middle) > goal
                low, high = np.where(before, middle, low), np.where(before, high, middle)
            times.extend(high)
            directions.extend([1 if up else -1] * len(k))
        return np.array(times), np.array(directions)


def edge_timing(case, t, times, directions, span):
    stamps = np.floor(times * case.clock) / case.clock
    out = []
    for now in t:
        b = bisect.bisect_right(times, now) - 1
        if b < span or len(set(directions[b - span:b + 1])) > 1:
            out.append(0.0)
            continue
        lasted, since = max(stamps[b] - stamps[b - span], 1 / case.clock), now - stamps[b]
        v = span * case.delta / lasted
        if since > lasted:
            v = min(v, span * case.delta / since)
        out.append(0.0 if case.timeout is not None and since > case.timeout else directions[b] * v)
    return np.array(out)


def count_and_time(case, t, times, directions):
    stamps, sums = np.floor(times * case.clock) / case.clock, np.concatenate(([0], np.cumsum(directions)))
    out, v = [], 0.0
    for now in t:
        first, end = bisect.bisect_right(times, now - case.window), bisect.bisect_right(times, now)
        if end > first and first > 0:
            v = (sums[end] - sums[first]) * case.delta / max(stamps[end - 1] - stamps[first - 1], 1 / case.clock)
        elif end == first and end > 0:
            since = now - stamps[end - 1]
            v = math.copysign(min(abs(v), case.delta / since), v)
            if case.timeout is not None and since > case.timeout:
                v = 0.0
        else:
            v = 0.0
        out.append(v)
    return np.array(out)


def adaptive_windows(case, counts):
    """For every sample the longest window of differences that ends there and has all its counts near the line between its ends."""
    lengths, grows = np.ones(len(counts), int), np.ones(len(counts), bool)
    for n in range(1, case.longest):
        windows = np.lib.stride_tricks.sliding_window_view(counts, n + 2)
        lines = windows[:, :1] + (windows[:, -1:] - windows[:, :1]) * np.arange(n + 2) / (n + 1)
        grows[:n + 1] = False
        grows[n + 1:] &= np.abs(lines - windows).max(axis=1) <= case.band + 1e-9
        lengths[grows] = n + 1
    return lengths


def adaptive_window(case, counts, lengths, fit):
    out = [0.0]
    for k in range(1, len(counts)):
        n = lengths[k]
        window = counts[k - n:k + 1]
        x = np.arange(n + 1) - 0.5 * n
        slope = x @ window / (x @ x) if fit else (window[-1] - window[0]) / n
        out.append(slope * case.delta * case.rate)
    return np.array(out)


def held_difference(case, t, counts):
    out, v, last, when = [], 0.0, counts[0], t[0]
    for now, x in zip(t, counts):
        if x != last:
            keep = math.exp(-(now - when) / case.time_constant) if case.time_constant else 0.0
            v = keep * v + (1 - keep) * (x - last) * case.delta / (now - when)
            last, when = x, now
        out.append(v)
    return np.array(out)


def tracking_loop(case, counts, at_rest=False):
    kp, ki, period = 2 * case.bandwidth, case.bandwidth**2, 1 / case.rate
    x, v, out = 0.0 if at_rest else counts[0] * case.delta, 0.0, []
    for q in counts * case.delta:
        x += period * v
        r = q - x
        x, v = x + period * kp * r, v + period * ki * r
        out.append(v)
    return np.array(out)


def figures(case, t, estimate):
    late = t >= math.ceil(case.settling * case.rate - 1e-9) / case.rate - 1e-12
    t, estimate = t[late], estimate[late]
    error = estimate - case.speed(t)

    def about(delay, every=1):
        return np.sqrt(np.mean((estimate - case.speed(t - delay))[::every] ** 2))
    return np.sqrt(np.mean(error**2)), np.abs(error).max(), about


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--qerr", required=True)
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    qerr, tally = pathlib.Path(arguments.qerr).resolve(), Tally(False)
    rms, largest = Worst(0.02), Worst(0.05)
    for index in range(arguments.count):
        case = Case(random.Random(1000 * arguments.seed + index))
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "spec.yaml").write_text(case.spec())
            ran = run(qerr, "simulate", "spec.yaml", "-q", "--estimators", "--json", cwd=folder)
            if index == 0:
                changed = run(qerr, "simulate", "spec.yaml", "--estimators", "--json", "--set", "estimators.edges.timeout=1 us", cwd=folder)
                tally.check("an override of an estimator is told to change nothing only where it does not",
                            changed.code == 0 and (b"changes no figure" in changed.err) == (
                                json.loads(changed.out)["estimators"] == json.loads(ran.out)["estimators"]), changed.err.decode())
        if not tally.check(f"{index} runs", ran.code == 0, ran.err.decode()):
            continue
        found = {e["estimator"]: e for e in json.loads(ran.out)["estimators"]}
        t = np.arange(int(math.floor(case.duration * case.rate + 0.5))) / case.rate
        counts, (times, directions) = case.count(t), case.edges()
        lengths = adaptive_windows(case, counts)
        wanted = {"edges": edge_timing(case, t, times, directions, 1), "lines": edge_timing(case, t, times, directions, 4),
                  "counted": count_and_time(case, t, times, directions), "ends": adaptive_window(case, counts, lengths, False),
                  "fitted": adaptive_window(case, counts, lengths, True), "held": held_difference(case, t, counts),
                  "loop": tracking_loop(case, counts)}
        for name, estimate in wanted.items():
            square, worst, about = figures(case, t, estimate)
            e = found[name]
            rms.add(f"{index} {name} rms", e["rms"], square)
            largest.add(f"{index} {name} worst", e["worst"], worst)
            if e["delay"] is not None:
                rms.add(f"{index} {name} noise", e["noise"], about(e["delay"]))
                step = 0.01 / case.rate
                every = math.ceil((len(t) - math.ceil(case.settling * case.rate - 1e-9)) / 4000)  # of which qerr fits it
                tally.check(f"{index} {name} the delay fits best", about(e["delay"], every) <= min(
                    about(e["delay"] - step, every), about(e["delay"] + step, every)) * (1 + 1e-9), f"{e['delay']}")
        order = [e["rms"] for e in json.loads(ran.out)["estimators"]]
        tally.check(f"{index} the least error is first", order == sorted(order))
        if not case.phase and not case.eccentricity:
            loop = tracking_loop(case, np.concatenate(([1.0], np.zeros(20000))) / case.delta, at_rest=True)
            rms.add(f"{index} bound", found["loop"]["worst_case"], np.abs(loop).sum() * case.delta / 2)
    tally.check("rms within 2 %", rms.holds(), rms.detail())
    tally.check("largest errors within 5 %", largest.holds(), largest.detail())
    print(f"rms: {rms.ratio * 0.02:.2g} at most off in {rms.count} values, largest errors: {largest.ratio * 0.05:.2g}")
    return tally.close()


if __name__ == "__main__":
    raise SystemExit(main())
