#!/usr/bin/env python3
"""Acceptance of `qerr simulate` against an independent computation from its own log. Needs numpy only.

    check_simulate.py --qerr build/qerr
"""
import argparse
import csv
import io
import json
import pathlib
import sys
import tempfile

import numpy as np

import filters
from robot import Chain, rotation_vector
from tool import Tally, Worst, run

ROOT = pathlib.Path(__file__).resolve().parents[2]
RATE = 1000.0
FILTERS = {
    "velocity": ("{derivative: 1, sample_rate: 1 kHz, lowpass: {family: first_order, order: 2, cutoff: 50 Hz}}",
                 {"derivative": 1, "sample_rate": RATE, "lowpass": {"family": "first_order", "order": 2, "cutoff": 50.0}}),
    "acceleration": ("{derivative: 2, sample_rate: 1 kHz, lowpass: {family: butterworth, order: 3, cutoff: 30 Hz}}",
                     {"derivative": 2, "sample_rate": RATE, "lowpass": {"family": "butterworth", "order": 3, "cutoff": 30.0}}),
}

# robot, coupling, encoders ('*' for the revolute joints): YAML and resolution; amplitude of the motion
SLIDE = ("{counts_per_rev: 2000, gear_ratio: 5, travel_per_rev: 20 mm}", 0.02 / 1e4)
CASES = [
    ("kuka_lwr", None, {"*": ("{counts_per_rev: 4096, gear_ratio: 20}", 2 * np.pi / 81920)}, 0.3),
    ("puma560", None, {"*": ("{bits: 14}", 2 * np.pi / 2**14)}, 0.4),
    ("scara", None, {"*": ("{lines_per_rev: 500, gear_ratio: 50}", 2 * np.pi / 1e5), "rail": SLIDE, "lift": SLIDE}, 0.05),
    ("phantom_premium", [[1, 0, 0], [0, 1, 0], [0, -1, 1]], {"*": ("{resolution: 1 mrad}", 1e-3)}, 0.2),
]


def text_of(name, coupling, encoders, motion, extra="", folder=ROOT):
    lines = ["qerr: 1", f"robot: {{urdf: {ROOT}/configs/{name}/{name}.urdf}}", "encoders:"]
    lines += [f"  '{joint}': {kind}" for joint, (kind, _) in encoders.items()]
    if coupling:
        lines.append(f"coupling: {coupling}")
    lines += ["coordinates: [x, y, z, rx, ry, rz]", "filters:"]
    lines += [f"  {k}: {v}" for k, (v, _) in FILTERS.items()]
    lines += ["motion:", "  sample_rate: 1 kHz", "  duration: 2 s", "  settling: 0.5 s", "  joints:"] + motion
    return "\n".join(lines) + "\n" + extra


def motion_of(chain, amplitude, rng):
    lines = []
    for joint in chain.names:
        j = chain.by_name[joint]
        low, high = (-1.0, 1.0) if j.lower is None else (j.lower, j.upper)
        a = min(amplitude, 0.3 * (high - low))
        center = rng.uniform(low + 1.1 * a, high - 1.1 * a)
        lines.append(f"    {joint}: {{center: {center:.6f}, sines: [{{amplitude: {a:.6f}, "
                     f"frequency: {rng.uniform(0.5, 2):.4f} Hz, phase: {rng.uniform(0, 6):.3f}}}]}}")
    return lines


def read_log(text):
    rows = list(csv.reader(io.StringIO(text, newline="")))
    return rows[0], np.array(rows[1:], dtype=float)


def column(header, data, name):
    """A column of any unit."""
    return data[:, [i for i, h in enumerate(header) if h.split(" [")[0] == name][0]]


def filtered(name, signal):
    h = np.asarray(filters.impulse(FILTERS[name][1]), dtype=float)
    return np.convolve(signal, h)[: len(signal)]


def check_against_log(t, qerr, folder):
    """Sigma, mean and peak of every coordinate and filter, from counts and references with independent kinematics."""
    rng = np.random.default_rng(7)
    for name, coupling, encoders, amplitude in CASES:
        chain = Chain(ROOT / f"configs/{name}/{name}.urdf")
        spec, log = folder / f"{name}.yaml", folder / f"{name}.csv"
        spec.write_text(text_of(name, coupling, encoders, motion_of(chain, amplitude, rng)))
        ran = run(qerr, "simulate", spec, "--format", "json", "--log", log, "--seed", 3)
        if not t.check(f"{name}: runs", ran.code == 0, ran.err.decode()[:300]):
            continue
        report = json.loads(ran.out)
        raw = log.read_bytes().decode()
        header, data = read_log(raw)
        t.check(f"{name}: line ends of the log conform to RFC 4180", raw.count("\r\n") == raw.count("\n") == 2001,
                f"{raw.count(chr(13))} and {raw.count(chr(10))}")
        t.check(f"{name}: time", np.array_equal(data[:, 0], np.arange(2000) / RATE), "")
        counts = np.stack([column(header, data, n + ".counts") for n in chain.names], 1)
        truth = np.stack([column(header, data, n + ".reference") for n in chain.names], 1)
        t.check(f"{name}: counts are integers", np.array_equal(counts, np.round(counts)), "")
        steps = np.array([encoders.get(n, encoders["*"])[1] for n in chain.names])
        estimate = (counts * steps) @ np.array(coupling or np.eye(len(steps)), dtype=float).T
        (p, r), (pe, re) = chain.pose(truth), chain.pose(estimate)
        tip = np.stack([column(header, data, f"tip.{c}") for c in "xyz"], 1)
        t.check(f"{name}: tip", np.abs(tip - p).max() < 1e-12, f"{np.abs(tip - p).max()}")
        error = np.concatenate([pe - p, rotation_vector(re @ np.transpose(r, (0, 2, 1)))], axis=1)
        worst = Worst(1e-7)
        by = {(x["filter"], x["coordinate"]): x for x in report["results"]}
        for f in ["position", *FILTERS]:
            for i, c in enumerate(["x", "y", "z", "rx", "ry", "rz"]):
                signal = error[:, i] if f == "position" else filtered(f, error[:, i])
                entry, kept = by[f, c], signal[500:]
                floor = 1e-13 * (1 if f == "position" else 1e5)
                worst.add(f"{f} {c} sigma", entry["sigma_simulated"], float(np.std(kept)), floor)
                worst.add(f"{f} {c} mean", entry["mean_simulated"], float(np.mean(kept)), np.std(kept) + floor)
                worst.add(f"{f} {c} peak", entry["peak_simulated"], float(np.abs(kept).max()), floor)
                product = np.prod(list(entry["ladder"].values())) * entry["sigma_ipqn"]
                worst.add(f"{f} {c} ladder", product, entry["sigma_simulated"], floor)
                t.check(f"{name} {f} {c}: within the worst case along the path",
                        entry["peak_simulated"] <= entry["worst_case_path"] * (1 + 1e-9) + floor, str(entry))
        t.check(f"{name}: {worst.count} figures of the report against its log", worst.holds(), worst.detail())
        check_theory(t, name, chain, steps, coupling, truth, by)


def check_theory(t, name, chain, steps, coupling, truth, by):
    """IPQN along the path from complex-step Jacobians."""
    names = ["x", "y", "z", "rx", "ry", "rz"]
    weighted = chain.jacobian(truth[500:], names) @ np.array(coupling or np.eye(len(steps)), float) * steps
    worst = Worst(1e-6)
    for i, c in enumerate(names):
        sigma = np.sqrt((weighted[:, i] ** 2).sum(1).mean() / 12)
        worst.add(f"position {c}", by["position", c]["sigma_ipqn_path"], float(sigma), 1e-12)
        for f in FILTERS:
            h = np.asarray(filters.impulse(FILTERS[f][1]), dtype=float)
            worst.add(f"{f} {c}", by[f, c]["sigma_ipqn_path"], float(sigma * np.sqrt((h**2).sum())), 1e-9)
    t.check(f"{name}: {worst.count} sigmas of IPQN along the path", worst.holds(), worst.detail())


NOTHING = {
    "offset": "offset: 0", "scale": "scale: 0", "eccentricity": "amplitude: 0, phase: 1",
    "transmission_error": "amplitude: 0, order: 2", "subdivision_error": "offset_sin: 0, clipping: 1",
    "state_width": "phase: 0", "missed_counts": "counts: 0, time: 0.5", "decoding": "factor: 1", "backlash": "gap: 0",
    "compliance": "compliance: 0", "latency": "delay: 0", "timing_jitter": "sigma: 0", "clock_drift": "rate: 0",
    "noise": "sigma: 0", "drift": "amplitude: 0, time_constant: 1", "rollover": "modulus: 1e12",
    "lost_counts": "fraction: 0", "geometry": "axis: x, length: 0", "reference_error": "amplitude: 0, order: 50", "log_rounding": "step: 0",
}


def check_nothing(t, qerr, folder):
    """An effect of magnitude zero changes no byte of the log."""
    chain = Chain(ROOT / "configs/puma560/puma560.urdf")
    motion = motion_of(chain, 0.3, np.random.default_rng(3))
    joint, encoders = chain.names[1], {"*": ("{lines_per_rev: 1024, gear_ratio: 10}", None)}
    spec, log = folder / "plain.yaml", folder / "plain.csv"
    spec.write_text(text_of("puma560", None, encoders, motion))
    run(qerr, "simulate", spec, "--log", log)
    plain = log.read_bytes()
    for effect, numbers in NOTHING.items():
        spec.write_text(text_of("puma560", None, encoders, motion,
                                f"effects:\n  - {{type: {effect}, joint: {joint}, {numbers}}}\n"))
        ran = run(qerr, "simulate", spec, "--log", log)
        t.check(f"{effect} of magnitude zero changes no byte", ran.code == 0 and log.read_bytes() == plain,
                ran.err.decode()[:200])
    known = json.loads(run(qerr, "list", "effects", "--format", "json").out)
    names = {e["name"] for e in (known if isinstance(known, list) else next(v for v in known.values() if isinstance(v, list)))}
    t.check("every effect is tested", names - {"truncation", "stuck_bit"} <= set(NOTHING), str(names - set(NOTHING)))


def check_reproducible(t, qerr, folder):
    spec = ROOT / "configs/phantom_premium/experiment.yaml"
    seen = set()
    for threads in (1, 2, 3):
        log = folder / "threads.csv"
        ran = run(qerr, "simulate", spec, "--runs", 5, "--threads", threads, "--format", "json", "--log", log)
        seen.add((ran.out, log.read_bytes()))
    t.check("same bytes for 1, 2 and 3 threads", len(seen) == 1, f"{len(seen)} different outputs")
    other = run(qerr, "simulate", spec, "--runs", 5, "--seed", 2, "--format", "json")
    t.check("another seed gives other phases", all(other.out != s[0] for s in seen), "")
    table = run(qerr, "simulate", spec, "--format", "csv").out.decode()
    rows = list(csv.DictReader(io.StringIO(table, newline="")))
    report = json.loads(run(qerr, "simulate", spec, "--format", "json").out)
    same = all(float(row[k]) == r[k] for row, r in zip(rows, report["results"])
               for k in ("sigma_simulated", "sigma_exact", "worst_case_path", "peak_simulated"))
    t.check("CSV and JSON agree", same and len(rows) == len(report["results"]), "")


def check_interface(t, qerr, folder):
    still = ROOT / "configs/table_iv/premium.yaml"
    spec = ROOT / "configs/phantom_premium/experiment.yaml"
    for label, arguments, code, word in [
            ("no motion", [still], 3, "motion"),
            ("two things on standard output", [spec, "--log", "-"], 2, "--log"),
            ("no runs", [spec, "--runs", "0"], 2, "runs"),
            ("a folder that is not there", [spec, "--log", folder / "no" / "log.csv"], 4, "log.csv"),
            ("a wrong flag", [spec, "--rnus", "3"], 2, "--rnus"),
            ("a motion outside the limits", [spec, "--set", "motion.joints.waist.center=3"], 3, "limits"),
            ("a rate that does not divide", [spec, "--set", "motion.sample_rate=1.5 kHz"], 3, "rate")]:
        ran = run(qerr, "simulate", *arguments)
        t.check(f"{label}: exit {code}", ran.code == code and word in ran.err.decode() and not ran.out,
                f"exit {ran.code}: {ran.err.decode()[:200]}")


def check_coupled_log(t, qerr, folder):
    """The positions of one joint are rounded in the log, which an other joint's encoder needs."""
    spec, log = ROOT / "configs/phantom_premium/experiment.yaml", folder / "coupled.csv"
    names = Chain(ROOT / "configs/phantom_premium/phantom_premium.urdf").names
    run(qerr, "simulate", "-q", spec, "--log", log, "-o", folder / "r.txt", "--set",
        f"effects=[{{type: log_rounding, joint: {names[1]}, step: 0.1 mrad}}]")
    header = log.read_text().splitlines()[0]
    t.check("positions of both coupled joints, counts of the third", [f"{names[0]}.counts" in header] +
            [f"{n}.measured" in header for n in names[1:]] == [True] * 3, header)
    ran = run(qerr, "diagnose", "-q", spec, log)
    t.check("diagnose reads the log of coupled joints", ran.code == 0, ran.err.decode()[:200])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--qerr", required=True)
    arguments = parser.parse_args()
    t = Tally()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        check_against_log(t, arguments.qerr, folder)
        check_nothing(t, arguments.qerr, folder)
        check_reproducible(t, arguments.qerr, folder)
        check_interface(t, arguments.qerr, folder)
        check_coupled_log(t, arguments.qerr, folder)
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
