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
  settling: 1 s
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
    """Mean, half width and sigma of an error at one joint; `gain(filter)` is the ratio of its sigma after the filter to sigma, or None
    where the motion determines it."""

    def __init__(self, joint, mean, half, sigma, gain):
        self.joint, self.mean, self.half, self.sigma, self.gain = NAMES.index(joint), mean, half, sigma, gain


def white(f):
    return filters.norms(f)[0]


def constant(f):
    return abs(filters.dc_gain(f))


def along_motion(errors, case_filters):
    """Peak and variance of the tip's error, by exact kinematics, and behind the filters; `errors` are signals at joints."""
    chain = Chain(CORPUS / "arm.urdf")
    time = np.arange(8000) / 1000
    q = np.zeros((len(time), 4))
    q[:, 0] = 0.2 + 0.8 * np.sin(math.pi * time)
    q[:, 1] = 0.3 + 0.5 * np.sin(4 * math.pi * time + 1)
    q[:, 3] = -1 + 0.4 * time
    added = np.zeros_like(q)
    for name, signal in errors.items():
        added[:, NAMES.index(name)] = signal(time, q[:, NAMES.index(name)])
    # The Jacobian at the middle of the error: exact to its third order.
    x = np.einsum("kcj,kj->kc", chain.jacobian(q + added / 2, ["x", "y", "z", "rx", "ry", "rz"]), added)
    out = {None: x, "joints": added}
    for name, f in case_filters.items():
        h = filters.impulse(f).astype(float)
        y = np.stack([np.convolve(h, x[:, c] - x[0, c])[:len(time)] for c in range(6)], axis=1)
        out[name] = y + filters.dc_gain(f) * x[0]
    return {k: (np.abs(v[1000:]).max(axis=0), v[1000:].var(axis=0)) for k, v in out.items()}


def expected(sources, case_filters, errors=None):
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
    known = along_motion(errors or {}, case_filters)
    result = {"worst": half + np.abs(mean) + known[None][0], "sigma": np.sqrt(total + known[None][1]), "half": half, "mean": mean,
              "filters": {}, "share": ((parts + added) / total[:, :, None]).mean(axis=0), "joints": known["joints"]}
    for name, f in case_filters.items():
        h2, l1 = filters.norms(f)
        variance = h2**2 * parts.sum(axis=2)
        for s in sources:
            if s.gain:
                variance = variance + (s.gain(f) * j[:, :, s.joint] * s.sigma) ** 2
        peak, power = known[name]
        known_sigma = all(s.gain for s in sources)
        result["filters"][name] = (l1 * half + abs(filters.dc_gain(f)) * np.abs(mean) + peak,
                                   np.sqrt(variance + power) if known_sigma else None)
    return result


def compare(t, label, found, sources, figures=1e-9, behind=1e-9, errors=None):
    case_filters = {"velocity": numeric(FO), "smooth": {"sample_rate": 1000.0, "derivative": 0, "lowpass": {
        "family": "first_order", "order": 1, "cutoff": 20.0}}}
    e = expected(sources, case_filters, errors)
    peak, power = e["joints"]
    position, joints, derivative = Worst(figures), Worst(figures), Worst(behind)
    for i, name in enumerate(NAMES):
        own = [s for s in sources if s.joint == i]
        mean = sum(s.mean for s in own)
        joints.add(f"{name}.mean", found["joints"][i]["mean"], mean, 1e-18)
        joints.add(f"{name}.worst_case", found["joints"][i]["worst_case"], DELTA[i] / 2 + sum(s.half for s in own) + abs(mean) + peak[i])
        joints.add(f"{name}.sigma", found["joints"][i]["sigma"], math.sqrt(DELTA[i] ** 2 / 12 + sum(s.sigma**2 for s in own) + power[i]))
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
            if sigma is None:
                derivative.add(f"{d['filter']}.{p['coordinate']}.sigma is null", 0 if p["sigma"] is None and d["covariance"] is None else 1, 0)
                continue
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
    half = (high - low) / 2
    compare(t, "limits", found, [
        Source("elbow", 1e-3, 0, 0, constant), Source("lift", 0, 20e-6, 5e-6, white),
        Source("wrist", 0, 12e-3, 12e-3 / math.sqrt(3), None),
        Source("shoulder", 1e-3 * (low + high) / 2, 1e-3 * (half + DELTA[0] / 2), 1e-3 * half / math.sqrt(3), None)])  # of any zero within a count
    t.check("limits: a warning says why sigma behind a filter is null and what to add",
            any("sigma behind a filter is not given" in w and "add `motion:`" in w for w in found["warnings"]), str(found["warnings"]))
    found = report(t, qerr, spec(folder, ["{type: offset, joint: elbow, offset: 1 mrad}", "{type: noise, joint: lift, sigma: 5 um}"]))
    compare(t, "constant and white", found, [Source("elbow", 1e-3, 0, 0, constant), Source("lift", 0, 20e-6, 5e-6, white)])


def check_motion(t, qerr, folder):
    found = report(t, qerr, spec(folder, [
        "{type: latency, joint: shoulder, delay: 1 ms}", "{type: scale, joint: elbow, scale: -1e-3}",
        "{type: backlash, joint: elbow, gap: 2 mrad}", "{type: timing_jitter, joint: shoulder, sigma: 0.1 ms}",
        "{type: eccentricity, joint: wrist, amplitude: 1 mrad, phase: 1}", "{type: missed_counts, joint: wrist, counts: -6, time: 3 s}",
        "{type: log_rounding, joint: wrist, step: 1 deg}", "{type: reference_error, joint: wrist, amplitude: 1 deg, order: 50}"], MOTION))
    def elbow(time, q):
        # Backlash in the gear, then scale at the disc.
        moved = q + 1e-3 * np.concatenate([[0], np.sign(np.diff(q))])
        return moved * (1 - 1e-3) - q

    def wrist(time, q):
        return 1e-3 * np.sin(q + 1) - 6 * DELTA[3] * (time >= 3)

    speed = 0.8 * math.pi
    time = np.arange(1000, 8000) / 1000
    rms = speed * math.sqrt(np.mean(np.cos(math.pi * time) ** 2))
    # Half a count of the zero changes what depends on the position; it adds nothing to sigma.
    changes = [Source(name, 0, 1e-3 * DELTA[NAMES.index(name)] / 2, 0, white) for name in ("elbow", "wrist")]
    compare(t, "motion", found, [Source("shoulder", 0, 4e-4 * speed, 1e-4 * rms, white), *changes], 1e-5, 1e-4, {
        "shoulder": lambda time, q: 0.8 * (np.sin(math.pi * (time - 1e-3)) - np.sin(math.pi * time)), "elbow": elbow, "wrist": wrist})
    found_scale = [e for e in found["effects"] if e["effect"] == "scale"][0]
    q = 0.3 + 0.5 * np.sin(4 * math.pi * time + 1)
    t.check("motion: mean and sigma of scale are those over the motion",
            abs(found_scale["mean"] + 1e-3 * q.mean()) < 1e-12 and abs(found_scale["sigma"] - 1e-3 * q.std()) < 1e-12, str(found_scale))
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
                if c[bound] is None:
                    t.check(f"{header[column]}: cells are empty", all(r[column] == "" for r in rows), str(rows[0]))
                    continue
                worst.add(f"{d['filter']}.{c['coordinate']}.{bound}", c[bound]["max"], max(float(r[column]) for r in rows), 1e-15)
    t.check("--per-configuration includes the effects", worst.holds(), worst.detail())
    table = run(qerr, "analyze", path, "--no-color").out.decode()
    t.check("the table shows the effects", all(w in table for w in ("Effects: errors that they add", "gap 10.0 mrad", "sigma 1.00 mrad")), table[:800])
    bytes_of = [run(qerr, "analyze", path, "--format", "json", "--threads", n).out for n in (1, 3)]
    t.check("the same bytes for --threads 1 and 3", bytes_of[0] == bytes_of[1] and bytes_of[0])
    rows = json.loads(run(qerr, "list", "effects", "--format", "json").out)
    text, csv = (run(qerr, "list", "effects", "--format", f).out.decode() for f in ("table", "csv"))
    t.check("list effects: stage and typical size of every one", len(rows) >= 20 and all(
        r["stage"] and r["typical"] and r["typical"] in " ".join(text.split()) and (f"\n{r['name']},,,," in csv) for r in rows), text[:300])


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
