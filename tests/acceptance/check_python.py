#!/usr/bin/env python3
"""The Python module against the program: the same reports, errors as exceptions, no file left, no memory lost.

    check_python.py --qerr build/qerr --package build/python [--calls N]

Skipped (exit code 77) without the module (cmake -DQERR_PYTHON=ON).
"""
import argparse
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
        ("sweep", ["sweep", SPEC], lambda: q.sweep(SPEC)),
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
    errors = q.configurations(SPEC, set={"configurations.count": 100})
    t.check("an array a column", len(errors) > 5 and all(len(v) == 100 for v in errors.values()), str(list(errors)[:5]))


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
    for _ in range(50):
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
    parser.add_argument("--calls", type=int, default=200)
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
        check_errors(t, q)
        check_interrupt(t, q)
        check_memory(t, q, arguments.calls)
        t.check("no file is left", os.listdir(folder) == [], str(os.listdir(folder)))
        os.chdir("/")
    print(f"{t.good} passed, {t.bad} failed")
    return 1 if t.bad else 0


if __name__ == "__main__":
    sys.exit(main())
