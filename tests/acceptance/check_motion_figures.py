#!/usr/bin/env python3
"""Figures along a motion against a simulation of its own: a slider with an encoder and one or two random effects, decoded at many
positions of the encoder's zero. Needs numpy only.

    check_motion_figures.py --qerr build/qerr --count 400
"""
import argparse
import json
import math
import pathlib
import sys
import tempfile

import numpy as np

import filters
from tool import Tally, run

PEAK_ZEROS, SIGMA_ZEROS = 200, 2000
TRAVEL = 0.02  # of the encoder's revolution [m]
MASS = 2.0
URDF = f"""<robot name="s"><link name="base"/><link name="t"><inertial><mass value="{MASS}"/><inertia ixx="1" iyy="1" izz="1" ixy="0"
ixz="0" iyz="0"/></inertial></link><joint name="slider" type="prismatic"><parent link="base"/><child link="t"/><axis xyz="1 0 0"/>
<limit lower="-10" upper="10" effort="100" velocity="20"/></joint></robot>"""
GAUSSIAN = 4  # standard deviations that bounds of noise include


class Motion:
    """center + velocity t + sines."""

    def __init__(self, rng, step, duration):
        self.center, self.velocity, self.sines = rng.uniform(-0.05, 0.05), 0.0, []
        kind = rng.choice(["ramp", "slow ramp", "sine", "sines"])
        if "ramp" in kind:
            counts_a_sample = 10 ** rng.uniform(-2, 1.2) if kind == "ramp" else 10 ** rng.uniform(-3, -1.5)
            self.velocity = rng.choice([-1, 1]) * min(counts_a_sample * step * 1000, 2.0)
        for _ in range({"sine": 1, "sines": 2}.get(kind, 0)):
            frequency = rng.uniform(0.5, 8)
            peak = 10 ** rng.uniform(-1.5, 1) * step * 1000
            self.sines.append((min(peak / (2 * math.pi * frequency), 0.3), frequency, rng.uniform(0, 6)))
        self.duration = duration

    def text(self):
        sines = ", ".join(f"{{amplitude: {a!r}, frequency: {f!r}, phase: {p!r}}}" for a, f, p in self.sines)
        return f"{{center: {self.center!r}, velocity: {self.velocity!r}, sines: [{sines}]}}"

    def at(self, t):
        return self.center + self.velocity * t + sum(a * np.sin(2 * math.pi * f * t + p) for a, f, p in self.sines)

    def speed(self, t):
        return self.velocity + sum(2 * math.pi * f * a * np.cos(2 * math.pi * f * t + p) for a, f, p in self.sines)

    def acceleration(self, t):
        return -sum(((2 * math.pi * f) ** 2 * a * np.sin(2 * math.pi * f * t + p) for a, f, p in self.sines), 0 * t)


def encoder(rng):
    """(text, resolution, counts per line)."""
    if rng.random() < 0.6:
        lines = int(rng.integers(20, 400))
        return f"{{lines_per_rev: {lines}, travel_per_rev: {TRAVEL}}}", TRAVEL / (4 * lines), 4
    periods, bits = int(rng.integers(5, 60)), int(rng.integers(3, 9))
    return (f"{{periods_per_rev: {periods}, interpolation_bits: {bits}, travel_per_rev: {TRAVEL}}}",
            TRAVEL / (periods * 2**bits), 2**bits)


def random_effect(rng, kind, step, per_line, duration):
    d = lambda low, high: step * 10 ** rng.uniform(math.log10(low), math.log10(high))
    angle = lambda: rng.uniform(-3, 3)
    p = {
        "offset": lambda: {"offset": d(0.1, 50)},
        "scale": lambda: {"scale": rng.uniform(-0.05, 0.05)},
        "eccentricity": lambda: {"amplitude": d(0.1, 30), "phase": angle(), "shaft": rng.choice(["encoder", "joint"])},
        "transmission_error": lambda: {"amplitude": d(0.1, 10), "phase": angle(), "order": int(rng.integers(2, 9))},
        "missed_counts": lambda: {"counts": int(rng.integers(1, 40)), "time": rng.uniform(0, duration)},
        "decoding": lambda: {"factor": rng.choice([0.25, 0.5, 2.0, 4.0, -1.0, 1.5])},
        "truncation": lambda: {},
        "backlash": lambda: {"gap": d(0.1, 30), "side": rng.choice(["drive", "load"])},
        "compliance": lambda: {"compliance": d(0.1, 20) / 30},
        "latency": lambda: {"delay": rng.uniform(1e-4, 5e-3)},
        "timing_jitter": lambda: {"sigma": 10 ** rng.uniform(-5.5, -3.5)},
        "clock_drift": lambda: {"rate": rng.uniform(-1e-3, 1e-3)},
        "noise": lambda: {"sigma": d(0.02, 5)},
        "drift": lambda: {"amplitude": d(0.1, 30), "time_constant": rng.uniform(0.1, 3)},
        "rollover": lambda: {"modulus": int(2 ** rng.integers(3, 10))},
        "geometry": lambda: {"axis": "x", "length": d(0.1, 30)},
        "state_width": lambda: {"phase": rng.uniform(-1, 1)},
        "subdivision_error": lambda: rng.choice([{"gain": rng.uniform(-0.1, 0.1), "phase": rng.uniform(-0.1, 0.1)},
                                                 {"clipping": rng.uniform(0.6, 0.95)},
                                                 {"offset_sin": rng.uniform(-0.1, 0.1), "offset_cos": 0.02}]),
    }[kind]()
    return {"type": kind, **{k: v.item() if hasattr(v, "item") else v for k, v in p.items()}}


STAGES = {"latency": 0, "timing_jitter": 0, "clock_drift": 0, "compliance": 1, "backlash": 2, "transmission_error": 2, "scale": 3,
          "offset": 3, "eccentricity": 3, "drift": 3, "subdivision_error": 4, "state_width": 4, "noise": 5, "truncation": 5,
          "decoding": 6, "rollover": 6, "missed_counts": 6, "geometry": 9}
KINDS = list(STAGES)


class Slider:
    """The slider's encoder: its readings at `zeros` positions of its zero over a line, as a decoder makes them."""

    def __init__(self, step, per_line, effects, motion, rate):
        self.step, self.per_line, self.motion = step, per_line, motion
        self.effects = sorted(effects, key=lambda e: STAGES[e["type"]])
        self.time = np.arange(round(motion.duration * rate)) / rate
        self.line = per_line if any(STAGES[e["type"]] == 4 for e in effects) else 1

    def errors(self, rng, zeros, limit=None, of_joint=True):
        """Errors [sample][zero]; `limit`: of random numbers, in standard deviations. The zeros are those of the joint, as in `simulate`,
        or of the encoder's counts: not the same for effects that depend on the position."""
        place = (np.arange(zeros) + rng.random(zeros)) / zeros * self.line
        in_line, zero = np.floor(place), (place % 1 - 0.5) * self.step
        u, of_counts = (zero, 0) if of_joint else (0, zero)

        def normal():
            n = rng.standard_normal((len(self.time), zeros))
            return n if limit is None else np.clip(n, -limit, limit)

        t = self.time[:, None]
        true = self.motion.at(t) + u
        instant, below = t, 0.5
        x = None
        effects = list(self.effects)
        for e in effects:
            if e["type"] == "latency":
                instant = instant - e["delay"]
            elif e["type"] == "clock_drift":
                instant = instant + e["rate"] * t
            elif e["type"] == "timing_jitter":
                instant = instant + e["sigma"] * normal()
            elif e["type"] == "truncation":
                below = 0.0
        x = joint = self.motion.at(instant) + u
        counts, shape = None, (len(self.time), zeros)
        for e in effects:
            kind = e["type"]
            if kind == "compliance":
                x = x + e["compliance"] * MASS * self.motion.acceleration(instant)
            elif kind == "backlash":
                x = x + self.backlash(e, x, np.broadcast_to(instant, x.shape))
            elif kind in ("transmission_error", "eccentricity"):
                ratio = e.get("order", 1) * (1 if e.get("shaft") == "joint" else 2 * math.pi / TRAVEL)
                x = x + e["amplitude"] * np.sin(ratio * (joint if e.get("shaft") == "joint" else x) + e["phase"])
            elif kind == "scale":
                x = x * (1 + e["scale"])
            elif kind == "offset":
                x = x + e["offset"]
            elif kind == "drift":
                x = x + e["amplitude"] * -np.expm1(-t / e["time_constant"])
        line = [e for e in effects if STAGES[e["type"]] == 4]
        noise = sum((e["sigma"] * normal() for e in effects if e["type"] == "noise"), 0)
        y = (x + of_counts) / self.step
        if line and line[0]["type"] == "subdivision_error":
            y = y + self.subdivision(line[0], y + in_line)
        if line and line[0]["type"] == "state_width":
            # Two states of the widths 1 + shift and 1 - shift, stretched to one count each: noise acts behind the line.
            shift = line[0]["phase"] / (2 * math.pi) * 4
            p = y + below + in_line
            base = 2 * np.floor(p / 2)
            first = p - base < 1 + shift
            y = base + np.where(first, (p - base) / (1 + shift), 1 + (p - base - 1 - shift) / (1 - shift)) - below - in_line
        counts = np.floor(y + noise / self.step + below + 1e-9)
        for e in self.spec_order(effects):
            if e["type"] == "decoding":
                counts = np.floor(e["factor"] * counts + 0.5)
            elif e["type"] == "rollover":
                counts = counts - e["modulus"] * np.floor(counts / e["modulus"] + 0.5)
            elif e["type"] == "missed_counts":
                counts = np.where(t >= e["time"] - 1e-12, counts + e["counts"], counts)
        built = sum(e["length"] for e in effects if e["type"] == "geometry")
        return counts * self.step - of_counts - true - built

    @staticmethod
    def spec_order(effects):
        return [e for e in effects if STAGES[e["type"]] == 6]

    def subdivision(self, e, y):
        """Displacement in counts: the angle that atan2 gives for the distorted signals, minus the true one."""
        a = 2 * math.pi * y / self.per_line
        s = (1 + e.get("gain", 0)) * np.sin(a + e.get("phase", 0)) + e.get("offset_sin", 0)
        c = np.cos(a) + e.get("offset_cos", 0)
        clip = e.get("clipping", 1)
        if clip < 1:
            s, c = np.clip(s, -clip, clip), np.clip(c, -clip, clip)
        return np.angle(np.exp(1j * (np.arctan2(s, c) - a))) * self.per_line / (2 * math.pi)

    @staticmethod
    def backlash(e, x, instant):
        """Displacement by the play; it depends on the motion's direction alone."""
        gap, out = e["gap"], np.zeros_like(x)
        at = x[0].copy()
        side = np.zeros_like(x[0])
        for n in range(1, len(x)):
            if e["side"] == "load":
                at = np.clip(at, x[n] - gap / 2, x[n] + gap / 2)
                out[n] = at - x[n]
            else:
                # Jitter may exchange the instants of two readings.
                side = np.where(x[n] == x[n - 1], side, np.sign((x[n] - x[n - 1]) * (instant[n] - instant[n - 1])))
                out[n] = side * gap / 2
        return out


def filtered(f, e):
    """The filter's output, from the steady state of the first error."""
    y = e - e[0]
    for b, a in filters.sections_of(f):
        b, a = [float(v) for v in b], [float(v) for v in a]
        out = np.empty_like(y)
        past_in, past_out = [np.zeros_like(y[0])] * 2, [np.zeros_like(y[0])] * 2
        for n in range(len(y)):
            new = b[0] * y[n]
            for k in range(1, len(b)):
                new = new + b[k] * past_in[k - 1]
            for k in range(1, len(a)):
                new = new - a[k] * past_out[k - 1]
            past_in, past_out = [y[n], past_in[0]], [new, past_out[0]]
            out[n] = new
        y = out
    return y + filters.dc_gain(f) * e[0]


FILTERS = [
    {"derivative": 1, "sample_rate": 1000, "lowpass": {"family": "first_order", "order": 2, "cutoff": 50}},
    {"derivative": 1, "sample_rate": 1000, "lowpass": {"family": "first_order", "order": 3, "cutoff": 10}},
    {"derivative": 2, "sample_rate": 1000, "lowpass": {"family": "butterworth", "order": 4, "cutoff": 30}},
    {"derivative": 0, "sample_rate": 1000, "lowpass": {"family": "first_order", "order": 2, "cutoff": 20}},
    {"derivative": 1, "sample_rate": 1000},
]
SETTLING, DURATION = 0.3, 1.3


def filter_text(f):
    low = f.get("lowpass")
    text = ", lowpass: {family: %s, order: %d, cutoff: %r}" % (low["family"], low["order"], low["cutoff"]) if low else ""
    derivative = f"derivative: {f['derivative']}, " if f["derivative"] or low is None else ""
    return f"{{{derivative}sample_rate: {f['sample_rate']}{text}}}"


def write_spec(folder, name, encoder_text, motion, effects, chosen):
    path = folder / name
    effect = lambda e: "{" + ", ".join(f"{k}: {v!r}" if not isinstance(v, str) else f"{k}: {v}" for k, v in e.items()) + ", joint: slider}"
    path.write_text(
        f"qerr: 1\nrobot: {{urdf: slider.urdf}}\nencoders: {{slider: {encoder_text}}}\ncoordinates: [x]\n"
        "configurations: {method: list, points: [[0]]}\n"
        + "filters: {" + ", ".join(f"f{i}: {filter_text(FILTERS[i])}" for i in chosen) + "}\n"
        f"motion: {{sample_rate: 1 kHz, duration: {DURATION}, settling: {SETTLING}, joints: {{slider: {motion.text()}}}}}\n"
        f"effects: [{', '.join(map(effect, effects))}]\n")
    return path


def compatible(kinds, per_line):
    if "state_width" in kinds and (per_line != 4 or "subdivision_error" in kinds):
        return False
    return not ("subdivision_error" in kinds and per_line == 4)


def one_case(t, qerr, folder, seed, worst):
    rng = np.random.default_rng(seed)
    text, step, per_line = encoder(rng)
    while True:
        # Effects within a line as often as all others together.
        pool = KINDS if rng.random() < 0.5 else ["state_width", "subdivision_error", "noise", "timing_jitter", "rollover", "decoding"]
        kinds = list(dict.fromkeys(rng.choice(pool if i == 0 else KINDS) for i in range(rng.integers(1, 3))))
        if compatible(kinds, per_line):
            break
    motion = Motion(rng, step, DURATION)
    effects = [random_effect(rng, k, step, per_line, DURATION) for k in kinds]
    chosen = sorted(rng.choice(len(FILTERS), 2, replace=False).tolist())
    name = f"{seed}.yaml"
    path = write_spec(folder, name, text, motion, effects, chosen)
    ran = run(qerr, "analyze", path, "--prove", "--format", "json", "-q")
    what = f"{seed} {'+'.join(kinds)}"
    if not t.check(f"{what}: runs", ran.code == 0, ran.err.decode(errors="replace")[:300]):
        return
    report = json.loads(ran.out)
    slider = Slider(step, per_line, effects, motion, 1000)
    settled = round(SETTLING * 1000)
    peaks = slider.errors(rng, PEAK_ZEROS, GAUSSIAN)
    position = report["position"][0]
    bounds = {"worst_case": position["worst_case"]["max"], "rigorous": position["worst_case_rigorous"]["max"],
              "proven": position["worst_case"]["proven"]["upper"]}
    peak = np.abs(peaks[settled:]).max()
    for bound, value in bounds.items():
        t.check(f"{what}: position {bound}", peak <= value * (1 + 1e-9), f"{peak / value:.5f} of it")
    many = slider.errors(rng, SIGMA_ZEROS, of_joint=False)
    for i, derivative in zip(chosen, report["derivatives"]):
        x = derivative["coordinates"][0]
        peak, value = np.abs(filtered(FILTERS[i], peaks)[settled:]).max(), x["worst_case"]["max"]
        t.check(f"{what}: f{i} worst case", peak <= value * (1 + 1e-9), f"{peak / value:.5f} of it")
        proven = x["worst_case"]["proven"]["upper"]
        t.check(f"{what}: f{i} proven", peak <= proven * (1 + 1e-9), f"{peak / proven:.5f} of it")
        y = filtered(FILTERS[i], many)[settled:]
        truth, said = y.std(), x["sigma_in_motion"]["max"]
        # The truth's own error, from independent groups of its zeros.
        groups = [y[:, k::10].std() for k in range(10)]
        tolerance = 0.005 * truth + 3 * np.std(groups) / math.sqrt(10) + 1e-9 * filters.norms(FILTERS[i])[0] * step
        t.check(f"{what}: f{i} sigma in motion", abs(said - truth) <= tolerance, f"{said:.6g} for {truth:.6g}: {said / truth if truth else 0:.4f}")
        if truth > 0:
            worst.append((abs(said / truth - 1), what, i))


def check_intervals(t, qerr, folder, count):
    """How often the interval of `simulate --runs` covers sigma over all zeros."""
    cases = [("a fast sine", "{sines: [{amplitude: 50 mm, frequency: 1.37 Hz}]}", "", 8),
             ("a slow ramp", "{center: 0.0131, velocity: 0.0007}", "", 2),
             ("a ramp", "{center: 0.0131, velocity: 0.0127}", "", 4),
             ("noise", "{center: 0.0131, velocity: 0.0127}", "effects: [{type: noise, joint: slider, sigma: 0.2 mm}]\n", 3),
             ("a slow sine", "{sines: [{amplitude: 2 mm, frequency: 0.7 Hz}]}", "", 16),
             ("many runs", "{center: 0.0131, velocity: 0.0127}", "", 100)]
    for name, motion, effects, runs in cases:
        path = folder / "interval.yaml"
        path.write_text(
            "qerr: 1\nrobot: {urdf: slider.urdf}\nencoders: {slider: {resolution: 1 mm}}\ncoordinates: [x]\n"
            "filters: {v: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: first_order, order: 2, cutoff: 50 Hz}},"
            " s: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: first_order, order: 3, cutoff: 5 Hz}}}\n"
            "configurations: {method: list, points: [[0]]}\n"
            f"motion: {{sample_rate: 1 kHz, duration: 0.8 s, settling: 0.1 s, joints: {{slider: {motion}}}}}\n{effects}")
        many = json.loads(run(qerr, "simulate", path, "--runs", 6000, "--format", "json", "-q").out)
        truths = [r["sigma_simulated"] for r in many["results"]]
        covered = np.zeros(len(truths))
        for seed in range(count):
            ran = run(qerr, "simulate", path, "--runs", runs, "--seed", seed, "--format", "json", "-q")
            for k, r in enumerate(json.loads(ran.out)["results"]):
                covered[k] += r["sigma_lower"] <= truths[k] * (1 + 1e-9) and truths[k] <= r["sigma_upper"] * (1 + 1e-9)
        for k, r in enumerate(many["results"]):
            part = covered[k] / count
            # Within 92 to 98 %, give or take three standard deviations of the count.
            slack = 3 * math.sqrt(0.05 * 0.95 / count)
            t.check(f"interval of {runs} runs, {name}, {r['filter']}: {100 * part:.1f} % cover", 0.92 - slack <= part <= 0.98 + slack)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--qerr", required=True)
    parser.add_argument("--count", type=int, default=400, help="random specs")
    parser.add_argument("--first", type=int, default=0, help="seed of the first")
    parser.add_argument("--intervals", type=int, default=200, help="seeds of `simulate --runs`, of each of six motions")
    parser.add_argument("--verbose", action="store_true")
    arguments = parser.parse_args()
    t, worst = Tally(arguments.verbose), []
    qerr = pathlib.Path(arguments.qerr).resolve()
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        (folder / "slider.urdf").write_text(URDF)
        for seed in range(arguments.first, arguments.first + arguments.count):
            one_case(t, qerr, folder, seed, worst)
        if arguments.intervals:
            check_intervals(t, qerr, folder, arguments.intervals)
    for deviation, what, i in sorted(worst, reverse=True)[:5 if arguments.verbose else 0]:
        print(f"sigma in motion {100 * deviation:.2f} % off: {what}, f{i}")
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
