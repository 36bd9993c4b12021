#!/usr/bin/env python3
"""The Python module against the program: the same reports, errors as exceptions, no file left, no memory lost.

    check_python.py --qerr build/qerr --package build/python [--calls N]

Skipped (exit code 77) without the module (cmake -DQERR_PYTHON=ON).
"""
import argparse
import csv
import datetime
import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import threading
import time
import warnings

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
CONFIGS = ROOT / "configs"
SPEC = CONFIGS / "scara" / "spec.yaml"

MISTAKES = [  # (function, arguments, part of the message)
    ("analyze", ("gone.yaml",), {}, "gone.yaml"),
    ("analyze", (SPEC,), {"set": {"encoders.rail.bitz": 3}}, "bitz"),
    ("analyze", (SPEC,), {"set": {"encoders.nobody.bits": 3}}, "nobody"),
    ("analyze", (SPEC,), {"threads": -1}, "--threads"),
    ("analyze", (SPEC,), {"above": {"position.q.sigma": "1 mm"}}, "position.q.sigma"),
    ("check", (CONFIGS / "filters" / "filters.yaml",), {"baseline": "gone.json"}, "gone.json"),
    ("design", (SPEC,), {}, "design"),
    ("robot", (SPEC,), {"at": {"nobody": 1}}, "nobody"),
    ("robot", (SPEC,), {"at": {"rail": "1 deg"}}, "length"),
    ("diagnose", (SPEC, "gone.csv"), {}, "gone.csv"),
    ("sweep", (CONFIGS / "kuka_lwr" / "spec.yaml",), {"set": {"sweep": "[{key: nothing, values: [1]}]"}}, "nothing"),
    ("list", ("colours",), {}, "colours"),
]
# (KEY, VALUE, part of the message): each alone is a mistake of a spec.
WRONG_VALUES = [
    ("robot.tip", "nowhere", "nowhere"), ("robot.base", "nowhere", "nowhere"), ("robot.urdf", "gone.urdf", "gone.urdf"),
    ("robot.tool", "{xyz: [0, 0]}", "tool"), ("coordinates", "[q]", "'q'"), ("coordinates", "[]", "empty"), ("frame", "world", "world"),
    ("encoders.wrist.bits", -1, "-1"), ("encoders.wrist.bits", "many", "many"), ("encoders.wrist.bits", 500, "500"),
    ("encoders.rail.resolution", "3 kg", "3 kg"), ("encoders.rail.resolution", 0, "resolution"), ("encoders.elbow.gear_ratio", 0, "gear_ratio"),
    ("encoders.shoulder.decoding", "x3", "x3"), ("encoders.lift.travel_per_rev", "10 deg", "10 deg"), ("configurations.count", 0, "count"),
    ("configurations.method", "dice", "dice"), ("configurations.limits", "{elbow: [1, 0]}", "above"),
    ("configurations.limits", "{elbow: [-9, 9]}", "exceed"), ("configurations.limits", "{knee: [0, 1]}", "knee"),
    ("configurations.seed", 0.5, "seed"), ("filters.velocity.derivative", 9, "derivative"),
    ("filters.velocity.sample_rate", "fast", "fast"), ("filters.velocity.lowpass.family", "magic", "magic"),
    ("filters.velocity.lowpass.cutoff", "3 kHz", "cutoff"), ("filters.velocity.lowpass.order", 99, "order"),
    ("filters.velocity.lowpass.ordr", 2, "ordr"), ("requirements.0.quantity", "position.x.worst", "worst"),
    ("requirements.0.statistic", "p98.7.6", "p98.7.6"), ("requirements.0.at_most", "8 deg", "8 deg"), ("requirements.9.at_most", 1, "9"),
    ("motion.duration", -1, "duration"), ("motion.joints.knee", "{center: 0}", "knee"), ("threshold.length", "1 s", "1 s"),
    ("effects", "[{type: gremlins, joint: elbow}]", "gremlins"), ("effects", "[{type: backlash, joint: knee, gap: 1 mrad}]", "knee"),
    ("effects", "[{type: backlash, joint: elbow}]", "gap"), ("control", "{sample_rate: 1 kHz, joints: {knee: {kp: 1}}}", "knee"),
    ("qerr", 2, "version"), ("log", "{missing: guess}", "guess"), ("coupling", "[[1, 0]]", "coupling"), ("nothing", 1, "nothing"),
]
MISTAKES += [("analyze", (SPEC,), {"set": {key: value}}, part) for key, value, part in WRONG_VALUES]


class Tally:
    good = bad = 0

    def check(self, title, holds, found=""):
        Tally.good += bool(holds)
        Tally.bad += not holds
        if not holds:
            print(f"FAIL  {title}: {found}")


def of_program(qerr, *words):
    return subprocess.run([qerr, *map(str, words)], capture_output=True, text=True)


def check_reports(t, q, qerr):
    for name, words, call in [
        ("analyze", ["analyze", SPEC], lambda: q.analyze(SPEC)),
        ("analyze with changes", ["analyze", SPEC, "--set", "encoders.wrist.bits=12", "--seed", "4"],
         lambda: q.analyze(str(SPEC), set={"encoders.wrist.bits": 12}, seed=4)),
        ("check", ["check", SPEC], lambda: q.check(SPEC)),
        ("filter", ["filter", SPEC], lambda: q.filter(SPEC)),
        ("simulate", ["simulate", SPEC], lambda: q.simulate(SPEC)),
        # The noise along the motion is most of the time of a variant.
        ("sweep", ["sweep", SPEC, "--set", "motion.duration=0.2"], lambda: q.sweep(SPEC, set={"motion.duration": 0.2})),
        ("threshold", ["threshold", SPEC], lambda: q.threshold(SPEC)),
        ("compare", ["compare", SPEC, CONFIGS / "kuka_lwr" / "spec.yaml"],
         lambda: q.compare(SPEC, CONFIGS / "kuka_lwr" / "spec.yaml")),
        ("robot", ["robot", CONFIGS / "scara" / "scara.urdf"], lambda: q.robot(CONFIGS / "scara" / "scara.urdf")),
        ("list", ["list", "effects"], lambda: q.list("effects")),
    ]:
        report = call()
        for form in ("json", "csv"):
            ran = of_program(qerr, *words, "--format", form)
            t.check(f"{name}: {form}", report.text(form).replace("\r\n", "\n") == ran.stdout and report.code == ran.returncode,
                    f"{len(report.text(form))} and {len(ran.stdout)} characters, exit {report.code} and {ran.returncode}")
    report = q.analyze(SPEC)
    t.check("the page", report.page.startswith("<!DOCTYPE html>") or report.page.startswith("<!doctype html>"), report.page[:40])
    t.check("the table", "Tip, estimate minus true" in str(report), str(report)[:80])
    largest = [row["value"] for row in report.figures if row.get("statistic") == "max"]
    t.check("figures are numbers", largest and all(isinstance(v, (int, float)) for v in largest), str(report.figures[:1]))


def check_arrays(t, q, qerr):
    log = q.simulated_log(CONFIGS / "diagnosis" / "spec.yaml")
    t.check("a log is arrays", len({len(v) for v in log.values()}) == 1 and all(isinstance(v, np.ndarray) for v in log.values()), str(list(log)[:4]))
    found = q.diagnose(CONFIGS / "diagnosis" / "spec.yaml", log)
    t.check("arrays are diagnosed", found.json["verdict"] in ("nothing_wrong", "explained", "partly_explained"), found.json["verdict"])
    few = {name: np.asarray(values)[:40] for name, values in log.items()}
    rows = zip(*few.values())
    path = pathlib.Path("log.csv")
    path.write_text(",".join(few) + "\n" + "\n".join(",".join(repr(float(x)).removesuffix(".0") for x in row) for row in rows) + "\n")
    of_file, of_arrays = (q.diagnose(CONFIGS / "diagnosis" / "spec.yaml", given).json for given in (path, few))
    path.unlink()
    for report in (of_file, of_arrays):
        del report["log"]["file"]
    t.check("arrays are the file of the same numbers", of_file == of_arrays, str({k for k in of_file if of_file[k] != of_arrays[k]}))
    time = few["time [s]"]
    stamps = np.round((time - time[0]) * 1e9).astype("m8[ns]")
    others = {name: values for name, values in few.items() if name != "time [s]"}
    duration = time[-1] - time[0]
    for name, values in (("time", stamps), ("time [ms]", stamps.astype("m8[us]")), ("time", np.datetime64("2026-11-26") + stamps),
                         ("time", [datetime.datetime(2026, 11, 26) + datetime.timedelta(microseconds=int(s) / 1000) for s in stamps.astype(int)])):
        found = q.diagnose(CONFIGS / "diagnosis" / "spec.yaml", {name: values, **others}).json["log"]
        span = found["last_time"] - found["first_time"]
        t.check(f"{type(values[0])} is the time", abs(span - duration) < 1e-5, f"{span} {duration}")
    hidden = np.zeros(len(time), bool)
    hidden[5:9] = True
    last = list(others)[-1]
    masked = {"time [s]": time, **others, last: np.ma.MaskedArray(others[last], hidden)}
    found = q.diagnose(CONFIGS / "diagnosis" / "spec.yaml", masked, set={"log.missing": "drop"})
    t.check("what is masked is missing", any("4 of 40 rows" in w for w in found.warnings), str(found.warnings))
    plain, numpys = (q.check(SPEC, set={"configurations.count": n, "configurations.seed": 7}).json for n in (100, np.int64(100)))
    t.check("numbers of NumPy are numbers", plain == numpys, str(plain)[:200])
    for wrong in ({"elbow": np.zeros((5, 2))}, {"elbow": np.zeros(5) * 1j}, {"elbow": ["one"] * 5}, {1: np.zeros(5)}, {"elbow": 5.0}, 5, np.zeros((5, 2))):
        try:
            q.diagnose(CONFIGS / "diagnosis" / "spec.yaml", wrong)
            t.check("a wrong log is refused", False, str(wrong))
        except (TypeError, ValueError) as e:
            t.check("says what is wanted", "wanted" in str(e) and "found" in str(e) or "text" in str(e), str(e))
    errors = q.configurations(SPEC, set={"configurations.count": 100})
    t.check("an array a column", len(errors) > 5 and all(len(v) == 100 for v in errors.values()), str(list(errors)[:5]))
    q.analyze(SPEC, set={"configurations.count": 100}, per_configuration="each.csv")
    with open("each.csv", newline="") as f:
        table = list(csv.DictReader(f))
    os.remove("each.csv")
    equal = list(errors) == list(table[0]) and all([float(row[name]) for row in table] == v.tolist() for name, v in errors.items())
    t.check("the arrays are the columns of --per-configuration", equal, str(list(errors)[:3]))


def check_speed(t, q):
    """Reading 1e6 rows: the last value is a mistake, so that nothing is diagnosed."""
    pathlib.Path("one.yaml").write_text("qerr: 1\nrobot: {joint: {name: a, type: revolute}}\nencoders: {a: {bits: 14}}\n")
    time_of = np.arange(1000000) * 1e-3
    true = 0.6 * np.sin(time_of)
    log = {"time [s]": time_of, "a.counts": np.round(true * 2**14 / (2 * np.pi)), "a.reference [rad]": np.append(true[:-1], np.inf)}
    spent = []
    for _ in range(3):
        begin = time.process_time()
        try:
            q.diagnose("one.yaml", log)
        except q.Error as e:
            t.check("the last row is read", ":1000000: a.reference" in str(e), str(e))
        spent.append(time.process_time() - begin)
    os.remove("one.yaml")
    t.check("1e6 rows of arrays in 0.3 s of CPU", min(spent) < 0.3, str(spent))


def check_signatures(t, q):
    import inspect
    parameters = inspect.signature(q.filter).parameters
    t.check("options are in the signature", {"set", "motion_band", "threads", "quiet"} <= set(parameters) and "options" not in parameters, str(parameters))
    t.check("an option of two values", q.filter(SPEC, motion_band=("0.5 Hz", "5 Hz")).code == 0)
    stub = (pathlib.Path(q.__file__).parent / "__init__.pyi").read_text()
    compile(stub, "__init__.pyi", "exec")
    t.check("the stub has every function", all(f"def {name}(" in stub for name in ("analyze", "diagnose", "simulated_log", "list")) and "motion_band: tuple" in stub, stub[:500])


def check_errors(t, q):
    for name, given, options, part in MISTAKES:
        try:
            getattr(q, name)(*given, **options)
            t.check(f"{name}{options}: an exception", False, "none")
        except q.Error as e:
            t.check(f"{name}{options}: names '{part}'", part in str(e), str(e))
            t.check(f"{name}{options}: faults", e.faults and {"file", "line", "rule", "remedy"} <= set(e.faults[0]) and e.code >= 2, str(e.faults))
    try:
        q.analyze(SPEC, colour=True)
        t.check("an unknown argument", False, "none")
    except TypeError as e:
        t.check("an unknown argument", "colour" in str(e), str(e))


def check_interrupt(t, q):
    threading.Timer(0.5, lambda: os.kill(os.getpid(), 2)).start()
    begin = time.monotonic()
    try:
        q.analyze(CONFIGS / "kuka_lwr" / "spec.yaml", set={"configurations.count": 2000000000}, threads=1)
        t.check("Ctrl-C", False, "ran to its end")
    except KeyboardInterrupt:
        t.check("Ctrl-C ends the work", time.monotonic() - begin < 20, f"{time.monotonic() - begin} s")
    t.check("and another call goes on", q.analyze(SPEC).code == 0)


def check_memory(t, q, calls):
    few, spec = {"configurations.count": 10}, CONFIGS / "puma560" / "spec.yaml"
    for _ in range(20):
        q.analyze(spec, set=few, quiet=True)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for i in range(calls):
        if i % 10:
            q.analyze(spec, set=few, quiet=True)
        else:
            try:
                q.analyze(spec, set={"nothing": 1})
            except q.Error:
                pass
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    t.check(f"memory after {calls} calls", grown < 4000, f"{grown} kB more")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--qerr", required=True)
    parser.add_argument("--package", required=True)
    parser.add_argument("--calls", type=int, default=80)
    arguments = parser.parse_args()
    if not list(pathlib.Path(arguments.package).glob("qerr/_qerr*.so")):
        print("skipped: the module is not built (-DQERR_PYTHON=ON)")
        return 77
    sys.path.insert(0, arguments.package)
    import qerr as q

    t = Tally()
    with tempfile.TemporaryDirectory() as folder:
        qerr = str(pathlib.Path(arguments.qerr).resolve())
        os.chdir(folder)
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            q.analyze(SPEC)
            t.check("warnings are Python's", said and all(issubclass(w.category, q.Warning) for w in said), str(said))
        warnings.simplefilter("ignore", q.Warning)
        check_reports(t, q, qerr)
        check_arrays(t, q, qerr)
        check_speed(t, q)
        check_signatures(t, q)
        check_errors(t, q)
        check_interrupt(t, q)
        check_memory(t, q, arguments.calls)
        t.check("no file is left", os.listdir(folder) == [], str(os.listdir(folder)))
        os.chdir("/")
    print(f"{t.good} passed, {t.bad} failed")
    return 1 if t.bad else 0


if __name__ == "__main__":
    sys.exit(main())
