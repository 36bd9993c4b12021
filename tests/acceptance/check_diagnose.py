#!/usr/bin/env python3
"""Acceptance of the interface of `qerr diagnose`: the form of its answers, its errors, its files. tests/hidden measures how well
it finds causes. Needs numpy only.

    check_diagnose.py --qerr build/qerr
"""
import argparse
import csv
import io
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from stage import SPEC as STAGE, STEP, URDF
from tool import Tally, run

SPEC = STAGE + """motion:
  sample_rate: 500 Hz
  duration: 3 s
  joints:
    turn: {sines: [{amplitude: 1.2 rad, frequency: 0.7 Hz}, {amplitude: 0.2 rad, frequency: 1.9 Hz}]}
    reach: {sines: [{amplitude: 0.1 m, frequency: 0.5 Hz}, {amplitude: 0.02 m, frequency: 1.3 Hz}]}
"""
EFFECTS = "effects=[{type: eccentricity, joint: turn, amplitude: 2 mrad, phase: 0.7}, {type: backlash, joint: reach, gap: 60 um}]"
NUMBER = (int, float)
FORM = {
    "verdict": str,
    "simulation": [{"joint": str, "statistic": str, "observed": NUMBER, "expected": NUMBER, "p_value": NUMBER}],
    "causes": [{"effect": str, "joint": str, "p_value": NUMBER,
                "parameters": [{"name": str, "value": NUMBER, "lower": NUMBER, "upper": NUMBER, "unit": str}],
                "gain": {"rms_before": NUMBER, "rms_after": NUMBER, "unit": str}}],
    "alternatives": [{"instead_of": str, "effect": str, "joint": str, "record": str}],
    "unexplained": [{"joint": str, "what": str, "order": (*NUMBER, type(None)), "amplitude": NUMBER, "unit": str}],
    "gain": {"held_out": bool, "rms_before": NUMBER, "rms_after": NUMBER, "ratio": NUMBER, "lower": NUMBER, "upper": NUMBER,
             "unit": str},
    "extended_model": (str, type(None)),
}
VERDICTS = ["nothing_wrong", "explained", "partly_explained", "ambiguous", "unexplained", "cannot_judge"]


def misshapen(value, form, path="answer"):
    """The parts of a value that violate the contract's form; [] if none."""
    if isinstance(form, dict):
        if not isinstance(value, dict):
            return [f"{path} is no object"]
        return [x for k, f in form.items()
                for x in (misshapen(value[k], f, f"{path}.{k}") if k in value else [f"{path}.{k} is missing"])]
    if isinstance(form, list):
        if not isinstance(value, list):
            return [f"{path} is no list"]
        return [x for i, v in enumerate(value) for x in misshapen(v, form[0], f"{path}[{i}]")]
    right = isinstance(value, form) and not (isinstance(value, bool) and form is not bool)
    return [] if right else [f"{path} is {value!r}"]


def strict(text):
    def refuse(word):
        raise ValueError(f"{word} is no JSON")

    return json.loads(text, parse_constant=refuse)


def columns(path):
    with open(path, encoding="utf-8", newline="") as f:
        return list(csv.DictReader(line for line in f if not line.startswith("#")))


def make(qerr, folder):
    (folder / "stage.urdf").write_text(URDF)
    (folder / "spec.yaml").write_text(SPEC)
    for name, more in (("clean", []), ("log", ["--set", EFFECTS])):
        ran = run(qerr, "simulate", folder / "spec.yaml", *more, "--log", folder / f"{name}.csv", "-o", folder / "r.txt")
        if ran.code != 0:
            sys.exit(f"cannot simulate: {ran.err.decode()}")


def check_answer(t, qerr, folder):
    spec, log = folder / "spec.yaml", folder / "log.csv"
    ran = run(qerr, "diagnose", spec, log, "--format", "json")
    if not t.check("diagnose runs", ran.code == 0, ran.err.decode()[:300]):
        return None
    answer = strict(ran.out)
    wrong = misshapen(answer, FORM)
    t.check("the JSON has the contract's keys and types", not wrong, "; ".join(wrong[:5]))
    t.check("the verdict is one of the contract's", answer["verdict"] in VERDICTS, answer["verdict"])
    t.check("without --write-model there is no extended model", answer["extended_model"] is None, "")
    found = {(c["effect"], c["joint"]): c for c in answer["causes"]}
    t.check("both effects are named", {("eccentricity", "turn"), ("backlash", "reach")} <= set(found), str(list(found)))
    units = {p["name"]: p["unit"] for c in found.values() for p in c["parameters"]}
    t.check("units are those of the joints", units.get("amplitude") == "rad" and units.get("gap") == "m", str(units))
    t.check("gains are in the joints' units", found.get(("backlash", "reach"), {}).get("gain", {}).get("unit") == "m", "")
    again = run(qerr, "diagnose", spec, log, "--format", "json", "--threads", 4)
    t.check("the same bytes for any number of threads", again.out == ran.out, "")
    clean = strict(run(qerr, "diagnose", spec, folder / "clean.csv", "--format", "json").out)
    t.check("the answer to a clean log has the contract's form", not misshapen(clean, FORM), "; ".join(misshapen(clean, FORM)[:5]))
    t.check("a clean log: nothing wrong", clean["verdict"] == "nothing_wrong" and not clean["causes"], clean["verdict"])
    table = run(qerr, "diagnose", spec, log).out.decode()
    words = answer["verdict"].upper().replace("_", " ")
    t.check("the table starts with the verdict", table.splitlines()[2].startswith(words + ": "), table[:200])
    t.check("no colours unless on a terminal", "\x1b" not in table, "")
    rows = list(csv.reader(io.StringIO(run(qerr, "diagnose", spec, log, "--format", "csv").out.decode(), newline="")))
    t.check("the CSV is tidy", len({len(r) for r in rows}) == 1 and len(rows) > 5, str(rows[:3]))
    return answer


def check_model(t, qerr, folder, answer):
    elsewhere = folder / "models"
    elsewhere.mkdir()
    model = elsewhere / "found.yaml"
    ran = run(qerr, "diagnose", folder / "spec.yaml", folder / "log.csv", "--write-model", model, "--format", "json")
    t.check("--write-model runs", ran.code == 0, ran.err.decode()[:300])
    t.check("the answer names the model's file", strict(ran.out)["extended_model"] == str(model), "")
    text = model.read_text()
    t.check("comments of the spec are kept", all(c in text for c in ("# a rotary stage", "# beside this file", "# a scale")), text)
    t.check("the path of the URDF is relative to the model's folder", "urdf: ../stage.urdf" in text, text)
    for command in ("simulate", "analyze"):
        ran = run(qerr, command, model, "--format", "json", "--quiet")
        t.check(f"the model is read by {command}", ran.code == 0, ran.err.decode()[:300])
    effects = strict(run(qerr, "analyze", model, "--format", "json", "--quiet").out)["effects"]
    t.check("the model has all causes", [e["effect"] for e in effects] == [c["effect"] for c in answer["causes"]], str(effects)[:300])
    for e, c in zip(effects, answer["causes"]):
        wrote = {p["name"]: p["value"] for p in e["parameters"]}
        t.check(f"{c['effect']} is written with the estimated parameters", all(wrote[p["name"]] == p["value"] for p in c["parameters"]), str(wrote))
    log = folder / "again.csv"
    run(qerr, "simulate", model, "--log", log, "-o", folder / "r.txt", "--quiet")
    was, now = columns(folder / "log.csv"), columns(log)
    for joint, step in STEP.items():
        rms = [np.sqrt(np.mean([(float(r[f"{joint}.counts"]) * step - float(v)) ** 2 for r in rows
                                for k, v in r.items() if k.startswith(f"{joint}.reference")])) for rows in (was, now)]
        t.check(f"simulated with the model, {joint} has the rms of the record", abs(rms[1] / rms[0] - 1) < 0.05, str(rms))
    more = run(qerr, "diagnose", folder / "spec.yaml", folder / "log.csv", "--set", "encoders.turn.gear_ratio=3",
               "--set", "configurations.count=50", "--write-model", "-", "-o", folder / "report.txt")
    t.check("overrides are written into the model", more.code == 0 and b"count: 50}" in more.out, more.err.decode()[:300])
    odd = folder / "odd.yaml"
    odd.write_text(SPEC.replace("  turn: {counts_per_rev: 4000, gear_ratio: 3}",
                                "  turn:\n    counts_per_rev: 4000\n    gear_ratio: 3"))
    ran = run(qerr, "diagnose", odd, folder / "clean.csv", "--set", "encoders.turn={bits: 14}", "--write-model", folder / "lines.yaml",
              "-o", folder / "report.txt")
    again = run(qerr, "analyze", folder / "lines.yaml", "-q", "--format", "json")
    t.check("an override over an entry in several lines is written into the model",
            ran.code == 0 and b"bits: 14" in (folder / "lines.yaml").read_bytes() and again.code == 0, ran.err.decode() + again.err.decode())


def check_table(t, qerr, folder):
    table, plots = folder / "table.csv", folder / "plots"
    ran = run(qerr, "diagnose", folder / "spec.yaml", folder / "log.csv", "--write-table", table, "--plots", plots, "-o", folder / "r")
    if not t.check("--write-table and --plots run", ran.code == 0, ran.err.decode()[:300]):
        return
    rows = [r for r in columns(table) if r["joint"] == "turn"]
    at, add = (np.array([float(r[c]) for r in rows]) for c in ("encoder_angle [rad]", "correction"))
    log = columns(folder / "log.csv")
    reference = np.array([float(v) for r in log for k, v in r.items() if k.startswith("turn.reference")])
    measured = np.array([float(r["turn.counts"]) for r in log]) * STEP["turn"]
    corrected = measured + np.interp(np.mod(3 * measured, 2 * np.pi), at, add)
    rms = np.sqrt(np.mean((corrected - reference) ** 2)) / (STEP["turn"] / np.sqrt(12))
    t.check("after the look-up table only quantization remains", rms < 1.1, f"{rms:.3f} of it")
    t.check("the table names the effects that it cannot contain", "# not in this table: backlash of reach" in table.read_text(), "")
    curves = columns(plots / "residual.csv")
    after = np.array([float(r["after"]) for r in curves if r["joint"] == "turn"])
    t.check("the residual after correction is that of the table", np.sqrt(np.mean(after**2)) < 1.1 * STEP["turn"] / np.sqrt(12), "")
    spectrum = [r for r in columns(plots / "spectrum.csv") if r["joint"] == "turn"]
    peak = max(spectrum, key=lambda r: float(r["before"]))
    t.check("the spectrum peaks at one period per revolution of the encoder", abs(float(peak["encoder_order"]) - 1) < 0.25, str(peak))


def check_tip(t, qerr, folder):
    """A log whose only reference sensor is a tracker at the tip."""
    rows = list(csv.reader(io.StringIO((folder / "log.csv").read_text())))
    keep = [i for i, h in enumerate(rows[0]) if ".reference" not in h]
    log, plots = folder / "tip.csv", folder / "tip_plots"
    log.write_text("".join(",".join(row[i] for i in keep) + "\n" for row in rows))
    ran = run(qerr, "diagnose", folder / "spec.yaml", log, "--plots", plots, "--format", "json")
    if not t.check("a log with a tip only is diagnosed", ran.code == 0, ran.err.decode()[:300]):
        return
    answer = strict(ran.out)
    gain = answer["gain"]
    t.check("an encoder's effect is named, although a constant coordinate of the tip has no decimals",
            ("eccentricity", "turn") in {(c["effect"], c["joint"]) for c in answer["causes"]}, str(answer["causes"])[:300])
    t.check("the gain is in metres, without counts", gain["unit"] == "m" and gain["counts_before"] is None, str(gain))
    t.check("there is no joint's residual to plot, and a message says so", not list(plots.iterdir()) and b"--plots" in ran.err,
            ran.err.decode()[:300])


def check_own_clean_log(t, qerr, folder):
    """A joint without a link: the log has a tip that rests on the axis, about which nothing is to be said."""
    spec, log = folder / "joint.yaml", folder / "joint.csv"
    spec.write_text("qerr: 1\nrobot: {joint: {name: j, type: revolute}}\nencoders: {j: {counts_per_rev: 4096, gear_ratio: 10}}\n"
                    "motion: {sample_rate: 500 Hz, duration: 5 s, joints: {j: {sines: [{amplitude: 20 deg, frequency: 0.5 Hz}]}}}\n")
    run(qerr, "simulate", spec, "--log", log, "-o", folder / "r.txt")
    ran = run(qerr, "diagnose", spec, log, "--check")
    t.check("the program's own clean log of one joint passes its check", ran.code == 0, ran.out.decode()[:400])
    # A tip that moves where no joint can move it stays unjudged.
    rows = log.read_text().splitlines()
    log.write_text("\n".join(rows[:1] + [f"{row.rsplit(',', 3)[0]},{k % 7 * 0.001},0,0" for k, row in enumerate(rows[1:])]) + "\n")
    t.check("a tip that moves without its joint does not", run(qerr, "diagnose", spec, log, "--check").code == 1, "")


def check_limits(t, qerr, folder):
    log = (folder / "log.csv").read_text().splitlines(keepends=True)
    (folder / "short.csv").write_text("".join(log[:2]))
    ran = run(qerr, "diagnose", folder / "spec.yaml", folder / "short.csv", "--format", "json")
    t.check("one row: no verdict",
            ran.code == 0 and strict(ran.out)["verdict"] == "cannot_judge" and strict(ran.out)["causes"] == [], ran.err.decode()[:200])
    before = (folder / "log.csv").read_bytes()
    for option in ("-o", "--write-model", "--write-table"):
        ran = run(qerr, "diagnose", folder / "spec.yaml", folder / "log.csv", option, folder / "log.csv")
        t.check(f"{option} does not overwrite the log", ran.code == 2 and (folder / "log.csv").read_bytes() == before,
                ran.err.decode()[:200])


def check_errors(t, qerr, folder):
    spec, log = folder / "spec.yaml", folder / "log.csv"
    good = log.read_text().splitlines()

    def bad(name, lines, code, *words):
        path = folder / "bad.csv"
        path.write_text("\n".join(lines) + "\n")
        ran = run(qerr, "diagnose", spec, path)
        said = ran.err.decode()
        t.check(f"{name}: exit code {code}, a message, nothing on standard output",
                ran.code == code and not ran.out and all(w in said for w in words) and len(said.splitlines()) <= 20, said[:300])

    bad("a ragged row", [*good[:5], good[5] + ",1", *good[6:9]], 3, "bad.csv:6")
    bad("not a number", [*good[:5], good[5].replace(good[5].split(",")[2], "nan"), *good[6:9]], 3, "bad.csv:6")
    bad("time that runs backwards", [*good[:5], good[3], *good[6:9]], 3, "bad.csv:6")
    bad("counts that are missing", [",".join(r.split(",")[:1] + r.split(",")[2:]) for r in good[:9]], 3, "turn")
    bad("no rows", good[:1], 3, "bad.csv")
    for name, code, *arguments in [("no such log", 4, spec, folder / "none.csv"), ("no such spec", 4, folder / "none.yaml", log),
                                   ("both from standard input", 2, "-", "-"), ("a log is missing", 2, spec),
                                   ("two results on standard output", 2, spec, log, "--write-table", "-"),
                                   ("an unknown option", 2, spec, log, "--modle", "x"),
                                   ("a folder that is not there", 4, spec, log, "--write-model", folder / "none" / "m.yaml"),
                                   ("plots into a file", 4, spec, log, "--plots", spec)]:
        ran = run(qerr, "diagnose", *arguments)
        t.check(f"{name}: exit code {code}", ran.code == code and not ran.out and ran.err, f"{ran.code}: {ran.err.decode()[:200]}")


def check_forms_of_logs(t, qerr, folder):
    """One log wide, long, in two files, with stamps of an epoch, and with empty cells: one answer."""
    spec, log = folder / "spec.yaml", folder / "log.csv"
    rows = list(csv.reader(io.StringIO(log.read_text())))
    head = rows[0]

    def write(name, lines):
        (folder / name).write_text("".join(",".join(line) + "\n" for line in lines))
        return folder / name

    long = write("long.csv", [["time [s]", "signal", "value"],
                              *([row[0], name, row[k]] for k, name in enumerate(head) if k > 0 for row in rows[1:])])
    first, second = write("first.csv", [row[:2] for row in rows]), write("second.csv", [row[:1] + row[2:] for row in rows])
    epoch = write("epoch.csv", [["time [ns]", *head[1:]],
                                *([str(1700000000000000000 + round(float(row[0]) * 1e9)), *row[1:]] for row in rows[1:])])
    empty = write("empty.csv", [rows[0], rows[1], *([*a[:-1], "" if a[-1] == b[-1] else a[-1]] for b, a in zip(rows[1:], rows[2:]))])

    def answer(*arguments):
        ran = run(qerr, "diagnose", spec, *arguments, "--format", "json")
        return json.loads(ran.out) if ran.code == 0 else ran.err.decode()[:300]

    wide = answer(log)
    for name, found in (("long format", answer(long)), ("two files", answer(first, second)), ("empty cells", answer(empty, "--hold"))):
        t.check(f"{name}: the causes and the gain of the wide log",
                isinstance(found, dict) and (found["causes"], found["gain"]) == (wide["causes"], wide["gain"]), str(found)[:300])
    found = answer(epoch)
    t.check("an epoch in ns: the causes of the wide log", isinstance(found, dict) and
            [c["effect"] for c in found["causes"]] == [c["effect"] for c in wide["causes"]], str(found)[:300])
    t.check("its first stamp is as recorded", isinstance(found, dict) and found["log"]["first_time"] == 1.7e9, str(found)[:300])
    ran = run(qerr, "diagnose", spec, first, log)
    t.check("a column in two files: both are named", ran.code == 3 and all(w in ran.err.decode() for w in ("first.csv", "log.csv")), ran.err.decode())
    ran = run(qerr, "diagnose", spec, "--plan", "--hold")
    t.check("--hold is not for a plan", ran.code == 2 and b"--hold" in ran.err, ran.err.decode())


def check_pipes(t, qerr, folder):
    spec, log = folder / "spec.yaml", folder / "log.csv"

    def piped(data, *arguments):
        return subprocess.run([str(qerr), "diagnose", *map(str, arguments)], input=data, capture_output=True, timeout=60, cwd=folder)

    whole = run(qerr, "diagnose", spec, log, "--format", "json").out
    from_log, from_spec = (piped(log.read_bytes(), spec, "-", "--format", "json"), piped(spec.read_bytes(), "-", log, "--format", "json"))
    for name, ran in (("log", from_log), ("spec", from_spec)):
        t.check(f"the {name} may be read from standard input",
                ran.returncode == 0 and json.loads(ran.stdout)["causes"] == json.loads(whole)["causes"], ran.stderr.decode()[:200])
    model = piped(spec.read_bytes(), "-", log, "--write-model", "-", "-o", "report.json")
    t.check("a spec from standard input becomes a model on standard output", model.returncode == 0 and b"effects:" in model.stdout, "")
    t.check("and is valid relative to the working folder", subprocess.run(
        [str(qerr), "analyze", "-", "--quiet"], input=model.stdout, capture_output=True, cwd=folder).returncode == 0, "")
    closed = subprocess.run(f"'{qerr}' diagnose '{spec}' '{log}' --format json | true; echo ${{PIPESTATUS[0]}}", shell=True,
                            executable="/bin/bash", capture_output=True, timeout=60)
    t.check("a closed pipe is not an error", closed.stdout.strip() in (b"0", b"141") and not closed.stderr, str(closed))


def main():
    a = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    a.add_argument("--qerr", required=True, type=lambda p: pathlib.Path(p).resolve())
    qerr = a.parse_args().qerr
    t = Tally()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        make(qerr, folder)
        answer = check_answer(t, qerr, folder)
        if answer:
            check_model(t, qerr, folder, answer)
        check_table(t, qerr, folder)
        check_tip(t, qerr, folder)
        check_own_clean_log(t, qerr, folder)
        check_limits(t, qerr, folder)
        check_errors(t, qerr, folder)
        check_forms_of_logs(t, qerr, folder)
        check_pipes(t, qerr, folder)
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
