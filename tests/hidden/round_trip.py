#!/usr/bin/env python3
"""Does the model that `diagnose` writes reproduce the log? Random specs of one joint with one or two effects are simulated, diagnosed
without them, and what was written is simulated along the same motion. Needs numpy only.

    round_trip.py --qerr build/qerr [--cases 60] [--seed 1] [--keep FOLDER]

Holds where the log and the simulation of the written model differ by no more than quantization and the reported residual allow (both are
rounded: the root of its square and 1/12 of a count, and a tenth more), and where the log has nothing wrong for the written model, or the
verdict is not `explained`.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np


def effect(rng, kind, step, span, speed, ratio):
    """An entry of `effects:` of 2 to 3000 counts, 0.05 rad at most. step: of the encoder [rad], span: of the motion [rad], speed: rms [rad/s]."""
    size = min(0.05, step * math.exp(rng.uniform(math.log(2), math.log(3000))))
    sign = rng.choice([-1.0, 1.0])
    phase = rng.uniform(-3, 3)
    shaft = str(rng.choice(["encoder", "joint"]))
    return {
        "offset": {"offset": sign * (size if rng.random() < 0.5 else rng.uniform(0.1, 2))},
        "scale": {"scale": sign * size / span},
        "eccentricity": {"amplitude": size, "phase": phase, "shaft": shaft},
        "transmission_error": {"amplitude": size, "phase": phase, "order": int(rng.integers(2, 9)), "shaft": shaft},
        "subdivision_error": {"gain": sign * rng.uniform(0.01, 0.1), "phase": rng.uniform(-0.05, 0.05)},
        "state_width": {"phase": sign * rng.uniform(0.2, 0.8)},
        "missed_counts": {"counts": int(sign * rng.integers(2, 40)), "time": rng.uniform(4, 8)},
        "backlash": {"gap": size},
        "latency": {"delay": sign * size / speed},
        "drift": {"amplitude": sign * size, "time_constant": rng.uniform(2, 5)},
        "noise": {"sigma": rng.uniform(0.3, 1.5) * step},
        "timing_jitter": {"sigma": rng.uniform(0.5, 3) * step / speed},
        "clock_drift": {"rate": sign * math.exp(rng.uniform(math.log(1e-5), math.log(3e-3)))},
        "decoding": {"factor": float(rng.choice([0.25, 0.5, 2, 4, -1]))},
        "truncation": {},
        "rollover": {"modulus": 2 ** int(math.log2(max(8, rng.uniform(0.3, 1.5) * span / step)))},
        "stuck_bit": {"bit": int(rng.integers(0, 5)), "value": int(rng.integers(0, 2))},
    }[kind]


KINDS = ("offset", "scale", "eccentricity", "transmission_error", "subdivision_error", "state_width", "missed_counts", "backlash",
         "latency", "drift", "noise", "timing_jitter", "clock_drift", "decoding", "truncation", "rollover", "stuck_bit")


def motion_of(rng):
    """A motion of the spec, its largest distance from zero [rad] and its typical speed [rad/s]: sines, moves with and without rests, one way."""
    kind = rng.choice(["sines", "moves", "velocity"], p=[0.5, 0.4, 0.1])
    if kind == "velocity":
        speed = rng.uniform(0.2, 2)
        return f"velocity: {speed} rad/s", 12 * speed, speed
    if kind == "moves":
        span = rng.uniform(0.5, 3)
        speed, dwell = span / rng.uniform(0.6, 2), rng.choice([0, 0.3])
        moves = ", ".join(f"{{to: {to} rad, velocity: {speed} rad/s, acceleration: {4 * speed} rad/s^2, dwell: {dwell} s}}" for to in span * rng.uniform(-1, 1, 6))
        return f"center: 0, moves: [{moves}]", span, speed
    amplitudes, frequencies = [rng.uniform(0.3, 3), rng.uniform(0.05, 1)], [rng.uniform(0.1, 0.5), rng.uniform(0.4, 1.3)]
    sines = ", ".join(f"{{amplitude: {a} rad, frequency: {f} Hz}}" for a, f in zip(amplitudes, frequencies))
    return f"sines: [{sines}]", sum(amplitudes), math.sqrt(sum((2 * math.pi * f * a) ** 2 / 2 for a, f in zip(amplitudes, frequencies)))


def case(rng, folder):
    """Writes a spec without effects and one with them; returns the kinds, and the step of the encoder."""
    lines = bool(rng.random() < 0.3)
    per_turn, parts = (int(rng.choice([1, 64, 512])), 2 ** int(rng.integers(8, 13))) if lines else (int(rng.choice([1000, 4096, 16384])), 1)
    ratio = 1 if lines or rng.random() < 0.5 else int(rng.choice([10, 50, 100]))
    step = 2 * math.pi / (per_turn * parts * ratio)
    motion, span, speed = motion_of(rng)
    rate = float(rng.choice([200, 500, 1000]))
    kinds = list(rng.choice(KINDS, size=int(rng.integers(1, 3)), replace=False))
    if not lines:
        kinds = [k for k in kinds if k not in ("subdivision_error", "state_width")] or ["scale"]
    if "state_width" in kinds:  # of lines without interpolation
        per_turn, parts, step = 500, 4, 2 * math.pi / 2000
    encoder = f"{{periods_per_rev: {per_turn}, interpolation_bits: {int(math.log2(parts))}}}" if lines and parts > 4 else \
        f"{{counts_per_rev: {per_turn * parts}, gear_ratio: {ratio}}}"
    if "state_width" in kinds:
        encoder = "{lines_per_rev: 500}"
    text = f"""qerr: 1
robot: {{joint: {{name: j, type: revolute}}}}
encoders: {{j: {encoder}}}
coordinates: [rz]
configurations: {{seed: {int(rng.integers(1, 10**6))}}}
motion: {{sample_rate: {rate} Hz, duration: 12 s, joints: {{j: {{{motion}}}}}}}
"""
    effects = [dict(type=str(k), joint="j", **effect(rng, k, step, span, speed, ratio)) for k in kinds]
    (folder / "own.yaml").write_text(text)
    (folder / "true.yaml").write_text(text + "effects:\n" + "".join(f"  - {json.dumps(e)}\n" for e in effects))
    return effects, step


def errors(path, step):
    """Readings less the reference [counts]."""
    header = path.read_text().split("\n", 1)[0].strip().split(",")
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    column = {name.split(" ")[0]: table[:, i] for i, name in enumerate(header)}
    read = column["j.counts"] if "j.counts" in column else column["j.measured"] / step
    return read - column["j.reference"] / step


def run(qerr, *words):
    done = subprocess.run([str(qerr), *map(str, words), "--quiet"], capture_output=True, text=True, timeout=300)
    if done.returncode:
        raise RuntimeError(f"{' '.join(map(str, words))}: {done.stderr.strip()[:300]}")
    return done.stdout


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--qerr", required=True, type=pathlib.Path)
    parser.add_argument("--cases", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, help="this case alone")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the files of the cases that fail")
    arguments = parser.parse_args()
    qerr, held, explained, failed = arguments.qerr.resolve(), 0, 0, 0
    for number in range(arguments.cases) if arguments.only is None else [arguments.only]:
        rng = np.random.default_rng([arguments.seed, number])
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            if arguments.keep:
                folder = arguments.keep / f"{arguments.seed}_{number}"
                folder.mkdir(parents=True, exist_ok=True)
            effects, step = case(rng, folder)
            try:
                run(qerr, "simulate", folder / "true.yaml", "--log", folder / "log.csv", "-o", folder / "a.txt", "--force")
                report = json.loads(run(qerr, "diagnose", folder / "own.yaml", folder / "log.csv", "--json", "--write-model", folder / "found.yaml", "--force"))
                again = json.loads(run(qerr, "diagnose", folder / "found.yaml", folder / "log.csv", "--json"))
                run(qerr, "simulate", folder / "found.yaml", "--log", folder / "again.csv", "-o", folder / "a.txt", "--force")
            except RuntimeError as trouble:
                failed += 1
                print(f"FAIL  {number}: {trouble}")
                continue
            # A wrong decoding multiplies readings; what is left is of right ones.
            read = max([1] + [abs(e["factor"]) for e in effects if e["type"] == "decoding"])
            difference = errors(folder / "log.csv", step) - errors(folder / "again.csv", step)
            difference /= read
            # Noise moves the row of an overflow, and that in which a count has another half of a bit; modulo a low bit all models would agree.
            for span in [e["modulus"] if e["type"] == "rollover" else 2.0 ** e["bit"] for e in effects if e["type"] in ("rollover", "stuck_bit")]:
                if span >= 8:
                    difference -= span * np.round(difference / span)
            miss = math.sqrt(np.mean(difference**2))
            left = report["gain"]["rms_after"] / step
            random = any(e["type"] in ("noise", "timing_jitter") for e in effects)
            allowed = 1.1 * math.sqrt(left**2 + (left**2 if random else 1 / 12)) + 0.02
            good = miss <= allowed and again["verdict"] == "nothing_wrong"
            explained += report["verdict"] == "explained"
            held += good
            if good or report["verdict"] not in ("explained", "nothing_wrong"):
                continue
            failed += 1
            causes, second = ([f"{c['effect']} " + " ".join(f"{p['name']}={p['value']:.6g}" for p in c["parameters"]) for c in r["causes"]]
                              for r in (report, again))
            print(f"FAIL  {number}: {report['verdict']}, {miss:.2f} counts off, {left:.2f} said; true {effects}; found {causes}; "
                  f"again {again['verdict']} {second}")
    print(f"{1 if arguments.only is not None else arguments.cases} cases: {explained} explained, {held} written models reproduce their log, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
