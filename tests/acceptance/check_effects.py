#!/usr/bin/env python3
"""Acceptance of the effects in `qerr analyze`, `check` and `list`, against an independent computation. Needs numpy only.

    check_effects.py --qerr build/qerr
"""
import argparse
import json
import math
import pathlib
import sys
import tempfile

import numpy as np

import filters
from cases import CORPUS, FO, numeric
from robot import Chain
from tool import Tally, Worst, run

POINTS = [[0.3, -0.7, 0.05, 1.0], [-1.1, 0.4, -0.02, -2.0], [2.0, 1.9, 0.12, 0.1], [-0.2, -2.0, 0.0, 3.0]]
DELTA = np.array([2 * math.pi / 2**14, 2 * math.pi / 2**14, 1e-5, 2 * math.pi / 2**14])
NAMES = ["shoulder", "elbow", "lift", "wrist"]
MOTION = """motion:
  sample_rate: 1 kHz
  duration: 8 s
  joints:
    shoulder: {center: 0.2, sines: [{amplitude: 0.8, frequency: 0.5 Hz}]}
    elbow: {center: 0.3, sines: [{amplitude: 0.5, frequency: 2 Hz, phase: 1}]}
    wrist: {center: -1, velocity: 0.4}
"""


def spec(folder, effects, extra="", name="spec.yaml"):
    path = folder / name
    path.write_text(
        f"qerr: 1\nrobot: {{urdf: {CORPUS / 'arm.urdf'}}}\nencoders:\n  '*': {{bits: 14}}\n  lift: {{resolution: 10 um}}\n"
        "coordinates: [x, y, z, rx, ry, rz]\n"
        "filters:\n  velocity: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: first_order, order: 2, cutoff: 50 Hz}}\n"
        "  smooth: {sample_rate: 1 kHz, lowpass: {family: first_order, order: 1, cutoff: 20 Hz}}\n"
        f"configurations:\n  method: list\n  limits: {{wrist: [-180 deg, 180 deg]}}\n  points: {POINTS}\n"
        + extra + "effects:\n" + "".join(f"  - {e}\n" for e in effects) + ("" if effects else "  []\n"))
    return path


def report(t, qerr, path, *more):
    ran = run(qerr, "analyze", path, "--format", "json", *more)
    t.check(f"{path.name}: runs", ran.code == 0, ran.err.decode(errors="replace")[:300])
    return json.loads(ran.out) if ran.code == 0 else None


class Source:
    """Mean, half width and sigma of an error at one joint; `gain(filter)` is the ratio of its sigma after the filter to sigma."""

    def __init__(self, joint, mean, half, sigma, gain):
        self.joint, self.mean, self.half, self.sigma, self.gain = NAMES.index(joint), mean, half, sigma, gain


def magnitude(f, omega):
    h = filters.impulse(f).astype(float)
    return abs(np.sum(h * np.exp(-1j * omega / f["sample_rate"] * np.arange(len(h)))))


def white(f):
    return filters.norms(f)[0]


def constant(f):
    return abs(filters.dc_gain(f))


def at(omega):
    return lambda f: magnitude(f, omega)


def square_wave(omega):
    """Gain for a square wave, from its harmonics up to many times the sample rate, aliased into one period of frequencies."""
    def gain(f):
        m = np.arange(1, 400001, 2)
        grid = np.linspace(0, math.pi, 20001)
        h = filters.impulse(f).astype(float)
        table = np.abs(np.fft.rfft(h, 40000))
        phase = np.abs((m * omega / f["sample_rate"] + math.pi) % (2 * math.pi) - math.pi)
        return math.sqrt(np.sum(8 / (math.pi * m) ** 2 * np.interp(phase, grid, table) ** 2))
    return gain


def expected(sources, case_filters):
    chain = Chain(CORPUS / "arm.urdf")
    j = chain.jacobian(np.array(POINTS), ["x", "y", "z", "rx", "ry", "rz"])
    half, mean = 0.5 * np.abs(j) @ DELTA, 0 * (j @ DELTA)
    parts = j**2 * DELTA**2 / 12
    added = np.zeros_like(parts)
    for s in sources:
        half = half + np.abs(j[:, :, s.joint]) * s.half
        mean = mean + j[:, :, s.joint] * s.mean
        added[:, :, s.joint] += (j[:, :, s.joint] * s.sigma) ** 2
    total = (parts + added).sum(axis=2)
    result = {"worst": half + np.abs(mean), "sigma": np.sqrt(total), "half": half, "mean": mean, "filters": {},
              "share": ((parts + added) / total[:, :, None]).mean(axis=0)}
    for name, f in case_filters.items():
        h2, l1 = filters.norms(f)
        variance = h2**2 * parts.sum(axis=2)
        for s in sources:
            variance = variance + (s.gain(f) * j[:, :, s.joint] * s.sigma) ** 2
        result["filters"][name] = (l1 * half + abs(filters.dc_gain(f)) * np.abs(mean), np.sqrt(variance))
    return result


def compare(t, label, found, sources, figures=1e-9, behind=1e-9):
    case_filters = {"velocity": numeric(FO), "smooth": {"sample_rate": 1000.0, "derivative": 0, "lowpass": {
        "family": "first_order", "order": 1, "cutoff": 20.0}}}
    e = expected(sources, case_filters)
    position, joints, derivative = Worst(figures), Worst(figures), Worst(behind)
    for i, name in enumerate(NAMES):
        own = [s for s in sources if s.joint == i]
        mean = sum(s.mean for s in own)
        joints.add(f"{name}.mean", found["joints"][i]["mean"], mean, 1e-18)
        joints.add(f"{name}.worst_case", found["joints"][i]["worst_case"], DELTA[i] / 2 + sum(s.half for s in own) + abs(mean))
        joints.add(f"{name}.sigma", found["joints"][i]["sigma"], math.sqrt(DELTA[i] ** 2 / 12 + sum(s.sigma**2 for s in own)))
    for c, p in enumerate(found["position"]):
        for s in ("mean", "max", "min"):
            position.add(f"{p['coordinate']}.worst.{s}", p["worst_case"][s], float(getattr(np, s)(e["worst"][:, c])), 1e-15)
            position.add(f"{p['coordinate']}.sigma.{s}", p["sigma"][s], float(getattr(np, s)(e["sigma"][:, c])), 1e-15)
        for i, name in enumerate(NAMES):
            position.add(f"{p['coordinate']}.share.{name}", p["share"][name], float(e["share"][c, i]), 1e-9)
        if not p["worst_case_rigorous"]["min"] >= e["worst"][:, c].min() * (1 - 1e-12):
            position.add(f"{p['coordinate']}: rigorous below the linear bound", None, 0)
    for d in found["derivatives"]:
        worst, sigma = e["filters"][d["filter"]]
        for c, p in enumerate(d["coordinates"]):
            derivative.add(f"{d['filter']}.{p['coordinate']}.worst", p["worst_case"]["max"], float(worst[:, c].max()), 1e-12)
            derivative.add(f"{d['filter']}.{p['coordinate']}.sigma", p["sigma"]["mean"], float(sigma[:, c].mean()), 1e-12)
            largest = np.array(d["covariance"]["mean"])[c, c]
            derivative.add(f"{d['filter']}.{p['coordinate']}.covariance", float(largest), float((sigma[:, c] ** 2).mean()), 1e-15)
    t.check(f"{label}: joints", joints.holds(), joints.detail())
    t.check(f"{label}: position", position.holds(), position.detail())
    t.check(f"{label}: derivatives", derivative.holds(), derivative.detail())


def check_limits(t, qerr, folder):
    """Without a motion: positions over the listed points, speeds up to the URDF's limits (shoulder 2, wrist 6 rad/s)."""
    found = report(t, qerr, spec(folder, [
        "{type: offset, joint: elbow, offset: 1 mrad}", "{type: noise, joint: lift, sigma: 5 um}",
        "{type: latency, joint: wrist, delay: -2 ms}", "{type: scale, joint: shoulder, scale: 1e-3}"]))
    low, high = min(p[0] for p in POINTS), max(p[0] for p in POINTS)
    half, rate = (high - low) / 2, 2 / ((high - low) / 2)
    turn = [p[3] for p in POINTS]
    wrist = 6 / ((max(turn) - min(turn)) / 2)
    compare(t, "limits", found, [
        Source("elbow", 1e-3, 0, 0, constant), Source("lift", 0, 20e-6, 5e-6, white),
        Source("wrist", 0, 12e-3, 12e-3 / math.sqrt(3), at(wrist)),
        Source("shoulder", 1e-3 * (low + high) / 2, 1e-3 * half, 1e-3 * half / math.sqrt(3), at(rate))])


def check_motion(t, qerr, folder):
    found = report(t, qerr, spec(folder, [
        "{type: latency, joint: shoulder, delay: 1 ms}", "{type: scale, joint: elbow, scale: -1e-3}",
        "{type: backlash, joint: elbow, gap: 2 mrad}", "{type: timing_jitter, joint: shoulder, sigma: 0.1 ms}",
        "{type: eccentricity, joint: wrist, amplitude: 1 mrad, phase: 1}", "{type: missed_counts, joint: wrist, counts: -6, time: 3 s}",
        "{type: log_rounding, joint: wrist, step: 1 deg}", "{type: reference_error, joint: wrist, amplitude: 1 deg, order: 50}"], MOTION))
    fast, slow = 2 * math.pi * 0.5 * 0.8, 2 * math.pi * 0.5
    gap = 1e-3
    # Scale acts after the gear: the range of its position includes the backlash.
    widened = 0.5 + gap
    found_scale = [e for e in found["effects"] if e["effect"] == "scale"][0]
    t.check("motion: scale includes the backlash before it", abs(found_scale["worst_case"] - 1e-3 * (0.3 + widened)) < 5e-8, str(found_scale))
    compare(t, "motion", found, [
        Source("shoulder", 0, 1e-3 * fast, 1e-3 * fast / math.sqrt(2), at(slow)),
        Source("shoulder", 0, 4e-4 * fast, 1e-4 * fast / math.sqrt(2), white),
        Source("elbow", -1e-3 * 0.3, 1e-3 * widened, found_scale["sigma"], at(4 * math.pi)),
        Source("elbow", 0, gap, gap, square_wave(4 * math.pi)),
        Source("wrist", 0, 1e-3, 1e-3 / math.sqrt(2), at(0.4)),
        Source("wrist", -3 * DELTA[3], 3 * DELTA[3], 3 * DELTA[3], constant)], 1e-4, 1e-3)
    t.check("motion: sigma of scale", abs(found_scale["sigma"] - 1e-3 * 0.5 / math.sqrt(2)) < 2e-6, str(found_scale))
    counted = {e["effect"]: e["counted"] for e in found["effects"]}
    t.check("motion: effects of the file and the reference are not counted",
            [n for n, c in counted.items() if not c] == ["log_rounding", "reference_error"], str(counted))


def check_identities(t, qerr, folder):
    none = ["{type: offset, joint: elbow, offset: 0}", "{type: backlash, joint: elbow, gap: 0}", "{type: noise, joint: lift, sigma: 0}",
            "{type: latency, joint: wrist, delay: 0}", "{type: geometry, joint: elbow, axis: y, length: 0}",
            "{type: clock_drift, joint: elbow, rate: 0}", "{type: decoding, joint: wrist, factor: 1}",
            "{type: eccentricity, joint: shoulder, amplitude: 0}", "{type: log_rounding, joint: wrist, step: 1 mrad}"]
    for label, motion in (("no motion", ""), ("motion", MOTION)):
        a = report(t, qerr, spec(folder, none, motion))
        b = report(t, qerr, spec(folder, [], motion))
        same = [k for k in b if k not in ("effects", "spec", "warnings") and a[k] != b[k]]
        t.check(f"effects of magnitude zero change no figure ({label})", not same and len(a["effects"]) == len(none), str(same))
    # Clock drift needs a duration, which the limits do not provide.
    a = report(t, qerr, spec(folder, ["{type: clock_drift, joint: elbow, rate: 1e-4}"]))
    same = [k for k in b if k in ("joints", "position") and a[k] != b[k]]
    entry = a["effects"][0]
    t.check("an effect of unknown magnitude is null, not counted, and a warning is given",
            not same and entry["sigma"] is None and entry["worst_case"] is None and not entry["counted"]
            and any("clock_drift" in w and "motion" in w for w in a["warnings"]), str(entry))
    # A displaced origin, by hand: y of the shoulder's parent is y of the base.
    a = report(t, qerr, spec(folder, ["{type: geometry, joint: shoulder, axis: y, length: 0.25 mm}"]))
    for p, q in zip(a["position"], b["position"]):
        shift = 0.25e-3 if p["coordinate"] == "y" else 0
        t.check(f"geometry: {p['coordinate']} grows by {shift}", abs(p["worst_case"]["max"] - q["worst_case"]["max"] - shift) < 1e-12
                and all(math.isclose(p["sigma"][k], q["sigma"][k], rel_tol=1e-13) for k in ("min", "mean", "max", "p50", "p99")),
                f"{p['worst_case']['max']} {q['worst_case']['max']}")


def check_rest(t, qerr, folder):
    requirement = "requirements: [{quantity: position.x.worst_case, statistic: max, at_most: 0.5 mm}]\n"
    codes = [run(qerr, "check", spec(folder, e, requirement)).code for e in ([], ["{type: backlash, joint: shoulder, gap: 10 mrad}"])]
    t.check("check includes effects", codes == [0, 1], str(codes))
    path = spec(folder, ["{type: backlash, joint: shoulder, gap: 10 mrad}", "{type: noise, joint: elbow, sigma: 1 mrad}"])
    each = folder / "each.csv"
    a = report(t, qerr, path, "--per-configuration", each)
    header, *rows = [line.split(",") for line in each.read_text().splitlines()]
    worst = Worst(1e-12)
    for d in a["derivatives"]:
        for c in d["coordinates"]:
            for bound in ("worst_case", "sigma"):
                column = header.index(f"{d['filter']}.{c['coordinate']}.{bound} [{c['unit']}]")
                worst.add(f"{d['filter']}.{c['coordinate']}.{bound}", c[bound]["max"], max(float(r[column]) for r in rows), 1e-15)
    t.check("--per-configuration includes the effects", worst.holds(), worst.detail())
    table = run(qerr, "analyze", path, "--no-color").out.decode()
    t.check("the table shows the effects", all(w in table for w in ("Effects: errors that they add", "gap 10.0 mrad", "sigma 1.00 mrad")), table[:800])
    bytes_of = [run(qerr, "analyze", path, "--format", "json", "--threads", n).out for n in (1, 3)]
    t.check("the same bytes for --threads 1 and 3", bytes_of[0] == bytes_of[1] and bytes_of[0])
    rows = json.loads(run(qerr, "list", "effects", "--format", "json").out)
    text, csv = (run(qerr, "list", "effects", "--format", f).out.decode() for f in ("table", "csv"))
    t.check("list effects: stage and typical size of every one", len(rows) >= 20 and all(
        r["stage"] and r["typical"] and r["typical"] in text and (f"\n{r['name']},,,," in csv) for r in rows), text[:300])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--qerr", required=True)
    qerr, t = pathlib.Path(parser.parse_args().qerr).resolve(), Tally()
    with tempfile.TemporaryDirectory() as temporary:
        for check in (check_limits, check_motion, check_identities, check_rest):
            check(t, qerr, pathlib.Path(temporary))
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
