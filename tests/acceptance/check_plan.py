#!/usr/bin/env python3
"""Acceptance of `qerr diagnose --plan`: its predictions hold. Effects of twice the identifiable magnitude are simulated along the
motion, with the planned noise of the reference, and `qerr diagnose` must name them; effects that the plan cannot distinguish must
be among the alternatives. Needs numpy only.

    check_plan.py --qerr build/qerr
    check_plan.py --qerr build/qerr --factor 1 --seeds 20    # rate of identification at the magnitude itself
"""
import argparse
import csv
import io
import json
import pathlib
import sys
import tempfile

import numpy as np

from stage import SPEC, STEP, URDF
from tool import Tally, run

RICH = """motion:
  sample_rate: 500 Hz
  duration: 4 s
  joints:
    turn: {sines: [{amplitude: 2 rad, frequency: 0.51 Hz}, {amplitude: 0.4 rad, frequency: 1.9 Hz}]}
    reach: {sines: [{amplitude: 0.1 m, frequency: 0.5 Hz}, {amplitude: 0.02 m, frequency: 1.3 Hz}]}
"""
ONE_WAY = """motion:
  sample_rate: 500 Hz
  duration: 3 s
  joints: {turn: {center: -1 rad, velocity: 0.7 rad/s}}
"""
NOISE = 0.05


def plan(qerr, spec, *more):
    answer = run(qerr, "diagnose", spec, "--plan", "--format", "json", "--quiet", *more)
    assert answer.code == 0, answer.err
    return json.loads(answer.out)


def effect_text(entry, joint, size, rng):
    fields = {"type": entry["effect"], "joint": joint, entry["parameter"]: size}
    for key in ("order", "shaft", "time_constant"):
        if key in entry:
            fields[key] = entry[key]
    if entry["parameter"] == "amplitude" and "order" in entry:
        fields["phase"] = float(rng.uniform(-3.1, 3.1))
    if entry["effect"] == "missed_counts":
        fields["time"] = 1.9
    return "effects=[{" + ", ".join(f"{k}: {v}" for k, v in fields.items()) + "}]"


def diagnosis(qerr, spec, folder, effect, rng):
    """The answer to a log with the effect, the references with noise, no tip."""
    log = folder / "log.csv"
    answer = run(qerr, "simulate", spec, "--log", log, "--set", effect, "--quiet")
    assert answer.code == 0, answer.err
    rows = list(csv.reader(io.StringIO(log.read_text())))
    keep = [i for i, h in enumerate(rows[0]) if not h.startswith("tip.")]
    table = np.array([[float(r[i]) for i in keep] for r in rows[1:]])
    header = [rows[0][i] for i in keep]
    for i, h in enumerate(header):
        if ".reference" in h:
            table[:, i] += NOISE * STEP[h.split(".")[0]] * rng.standard_normal(len(table))
    lines = [",".join(repr(float(v)) if not h.endswith(".counts") else str(int(v)) for h, v in zip(header, row)) for row in table]
    log.write_text("\r\n".join([",".join(header)] + lines) + "\r\n")
    answer = run(qerr, "diagnose", spec, log, "--format", "json", "--quiet")
    assert answer.code == 0, answer.err
    return json.loads(answer.out)


def named(answer, effect, joint):
    return any(c["effect"] == effect and c["joint"] == joint for c in answer["causes"])


def alternative(answer, effect, joint):
    return any(a["effect"] == effect and a["joint"] == joint for a in answer["alternatives"])


def check_promises(t, qerr, folder, factor, seeds):
    """One entry of each effect; with several seeds every order of every joint."""
    spec = folder / "rich.yaml"
    spec.write_text(SPEC + RICH)
    answer = plan(qerr, spec)
    hits = {}
    for joint in answer["joints"]:
        for entry in joint["effects"]:
            if entry["named"] is None or (seeds == 1 and any(key.split()[0] == entry["effect"] for key in hits)):
                continue
            for seed in range(seeds):
                rng = np.random.default_rng(1000 * seed + len(hits))
                size = entry["named"] * (1 if entry["effect"] == "missed_counts" else factor)
                found = diagnosis(qerr, spec, folder, effect_text(entry, joint["joint"], size, rng), rng)
                right = named(found, entry["effect"], joint["joint"])
                key = f"{entry['effect']} {entry.get('order', entry.get('time_constant', ''))} {entry.get('shaft', '')} of {joint['joint']}"
                hits.setdefault(key, []).append(right)
                if seeds == 1:
                    t.check(f"{key}, {size:.3g} {entry['unit']} ({factor} times the identifiable magnitude of the plan)", right,
                            f"{found['verdict']} {[c['effect'] for c in found['causes']]}")
    return hits


def check_twins(t, qerr, folder):
    spec = folder / "one_way.yaml"
    spec.write_text(SPEC + ONE_WAY)
    answer = plan(qerr, spec)
    turn = answer["joints"][0]
    backlash = next(e for e in turn["effects"] if e["effect"] == "backlash")
    twins = {r["effect"] for r in backlash["alike"] if r["told_apart"] is None}
    t.check("one direction at one speed: backlash is indistinguishable from offset and latency", {"offset", "latency"} <= twins, twins)
    t.check("and identifiable at no magnitude", backlash["named"] is None, backlash["named"])
    t.check("the plan has no effects of a joint at rest",
            answer["joints"][1]["moves"] is False and answer["joints"][1]["effects"] == [], answer["joints"][1])
    rng = np.random.default_rng(1)
    found = diagnosis(qerr, spec, folder, f"effects=[{{type: backlash, joint: turn, gap: {20 * backlash['seen']}}}]", rng)
    known = {c["effect"] for c in found["causes"]} | {a["effect"] for a in found["alternatives"]}
    t.check("diagnose reports one of them", "backlash" in known and known & {"offset", "latency"}, known)
    better = answer["better"]
    t.check("there is a better motion", better is not None and "turn" in better["changed"], better)
    (folder / "better.yaml").write_text(SPEC + better["motion"])
    again = plan(qerr, folder / "better.yaml")
    t.check("the plan of the better motion is the one that was predicted",
            [j["effects"] for j in again["joints"]] == [j["effects"] for j in better["joints"]])
    after = next(e for e in again["joints"][0]["effects"] if e["effect"] == "backlash")
    t.check("it identifies backlash", after["named"] is not None, after)
    size = 2 * after["named"]
    found = diagnosis(qerr, folder / "better.yaml", folder, f"effects=[{{type: backlash, joint: turn, gap: {size}}}]", rng)
    t.check("and so does diagnose", named(found, "backlash", "turn") and not alternative(found, "offset", "turn"),
            found["causes"])


def check_interface(t, qerr, folder):
    spec = folder / "rich.yaml"
    (folder / "still.yaml").write_text(SPEC)
    for arguments, code, words in (
            ([spec], 2, ["LOG", "--plan"]),
            ([spec, folder / "log.csv", "--plan"], 2, ["--plan"]),
            ([spec, "--plan", "--write-model", folder / "m.yaml"], 2, ["--write-model"]),
            ([spec, "--plan", "--reference-noise", "nil"], 2, ["--reference-noise"]),
            ([folder / "still.yaml", "--plan"], 3, ["motion", "add motion:"])):
        answer = run(qerr, "diagnose", *arguments)
        t.check(f"{' '.join(str(a) for a in arguments[1:]) or 'no log'}: exit {code} and a remedy",
                answer.code == code and not answer.out and all(w in answer.err.decode() for w in words), answer.err)
    table = run(qerr, "diagnose", spec, "--plan").out.decode()
    t.check("the table is less than 140 columns wide", max(map(len, table.split("\n"))) < 140 and "Smallest identifiable size" in table, table)
    rows = list(csv.reader(io.StringIO(run(qerr, "diagnose", spec, "--plan", "--format", "csv").out.decode())))
    t.check("the CSV is rectangular", len(rows) > 20 and {len(r) for r in rows} == {13}, rows[:2])
    louder = plan(qerr, spec, "--reference-noise", "0.5")
    quiet = plan(qerr, spec)
    t.check("a worse reference detects no smaller magnitude",
            all(b["seen"] >= a["seen"] for a, b in zip(quiet["joints"][0]["effects"], louder["joints"][0]["effects"])))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--qerr", type=pathlib.Path, required=True)
    parser.add_argument("--factor", type=float, default=2)
    parser.add_argument("--seeds", type=int, default=1)
    o = parser.parse_args()
    t = Tally()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "stage.urdf").write_text(URDF)
        hits = check_promises(t, o.qerr, folder, o.factor, o.seeds)
        if o.seeds > 1:
            for key, right in hits.items():
                print(f"{key:50} {sum(right)}/{len(right)}")
            total = [x for right in hits.values() for x in right]
            print(f"{sum(total)}/{len(total)}")
            return 0
        check_twins(t, o.qerr, folder)
        check_interface(t, o.qerr, folder)
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
