#!/usr/bin/python3
"""Measures how well `qerr diagnose` finds hidden effects: runs it on many cases with a known truth, and scores the answers.

usage: study.py --qerr PATH [--cases 400 --seed S --jobs 2 --out DIR]      generates the cases first
       study.py --qerr PATH --dir DIR                                      scores the cases in DIR
       study.py --qerr PATH --quick [--cases 60]                           few cases, for the test suite
       study.py --qerr PATH --workshop [--cases 120 --seed S --dir DIR]    records of the second generator, by its own judge

Every case is diagnosed; its extended model diagnoses the second log and, if the truth permits, is simulated. The tables go to
standard output; cases.csv, confusion.csv, intervals.csv and every answer to the folder of --out. Exit code 0: all
criteria met (with --quick: none missed significantly, and no crash); 1: not met; 2: qerr could not be run.
"""
import argparse
import concurrent.futures
import csv
import json
import math
import os
import pathlib
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

import generate
import tables
from score import causes_of, score
from workshop import judge as workshop_judge
from workshop import workshop


def run(command, limit):
    """(exit code or None, standard output, error or '')"""
    try:
        done = subprocess.run([str(c) for c in command], stdin=subprocess.DEVNULL, capture_output=True, timeout=limit,
                              env=dict(os.environ, NO_COLOR="1"))
    except subprocess.TimeoutExpired:
        return None, "", f"no answer within {limit:g} s"
    except OSError as fault:
        return None, "", str(fault)
    text, said = done.stdout.decode("utf-8", "replace"), done.stderr.decode("utf-8", "replace").strip()
    if done.returncode < 0:
        return done.returncode, text, f"killed by signal {-done.returncode}"
    if done.returncode:
        return done.returncode, text, f"exit code {done.returncode}: {said.splitlines()[0][:200] if said else 'no message'}"
    return 0, text, ""


def diagnose(qerr, spec, log, limit, *more):
    """(answer or {}, fault or '')"""
    _, text, fault = run([*qerr, "diagnose", spec, log, "--format", "json", *more], limit)
    if fault:
        return {}, fault
    try:
        answer = json.loads(text)
        return (answer, "") if isinstance(answer, dict) else ({}, "the answer is no JSON object")
    except ValueError as wrong:
        return {}, f"the answer is no JSON: {wrong}"


def simulated_rms(qerr, model, truth, folder, limit):
    """Ratio of the rms that `simulate` computes with the extended model to the true machine's, for the joints with effects."""
    log = folder / "simulated.csv"
    _, _, fault = run([*qerr, "simulate", model, "--format", "json", "--log", log, "--quiet"], limit)
    if fault or not log.exists():
        return math.inf
    joints, samples = sorted({e["joint"] for e in truth["effects"]}), 0
    sums = dict.fromkeys(joints, 0.0)
    try:
        with open(log, encoding="utf-8") as f:
            for row in csv.DictReader((line for line in f if not line.startswith("#")), strict=True):
                if None in row or None in row.values():
                    return math.inf  # a ragged row
                samples += 1
                encoders = {i: float(row[i + ".counts"]) * step for i, step in truth["resolution"].items()}
                for j in joints:
                    reference = next(float(v) for k, v in row.items() if k.startswith(j + ".reference"))
                    measured = sum(factor * encoders[i] for i, factor in truth["coupling"][j].items())
                    sums[j] += (measured - reference) ** 2
        ratios = [math.sqrt(sums[j] / samples) / truth["simulate_rms"][j] for j in joints]
    except (KeyError, ValueError, StopIteration, ZeroDivisionError, csv.Error):
        return math.inf
    finally:
        log.unlink()
    return max(ratios, key=lambda x: abs(x - 1))


def judge(qerr, case, out, limit):
    """Runs and scores one case; errors of qerr are recorded, not raised."""
    truth = json.loads((case / "truth.json").read_text(encoding="utf-8"))
    folder = out / "answers" / case.name
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(case / "robot.urdf", folder / "robot.urdf")  # the extended model refers to it
    model, spec = folder / "model.yaml", case / "spec.yaml"
    model.unlink(missing_ok=True)
    start = time.monotonic()
    answer, fault = diagnose(qerr, spec, case / "log.csv", limit, "--write-model", model)
    result = {"case": case.name, "truth": truth, "seconds": time.monotonic() - start, "fault": fault,
              "command": shlex.join([*qerr, "diagnose", str(spec), str(case / "log.csv")])}
    (folder / "answer.json").write_text(json.dumps(answer, indent=1) + "\n", encoding="utf-8")
    try:
        result["score"] = score(truth, answer) if answer else {}
    except (TypeError, ValueError, KeyError, AttributeError) as wrong:
        result["score"], result["fault"] = {}, f"the answer has not the contract's form: {wrong!r}"
    extended = model if model.exists() else spec
    if truth["kind"] in "bc" and (case / "log2.csv").exists():
        second, fault = diagnose(qerr, extended, case / "log2.csv", limit)
        result["second"] = second.get("verdict") or fault
        result["second_causes"] = " ".join(str(c.get("effect")) for c in causes_of(second))
    if truth["kind"] in "bc" and truth.get("simulate_rms"):
        result["simulated"] = simulated_rms(qerr, extended, truth, folder, limit)
    return result


def workshop_study(qerr, folders, out, jobs, limit):
    """Diagnoses the workshop's records and prints the table; whether at least 85 % are right and at most 5 % wrong."""
    def one(case):
        answer, fault = diagnose(qerr, case / "spec.yaml", case / "log.csv", limit)
        (case / "answer.json").write_text(json.dumps(answer, indent=1) + "\n", encoding="utf-8")
        truth = json.loads((case / "truth.json").read_text(encoding="utf-8"))
        grade, why = workshop_judge.judge(truth, answer) if answer else ("wrong", fault)
        return {"case": case, "sub": truth["sub"], "clean": bool(truth.get("clean")), "grade": grade, "why": why,
                "unfounded": workshop_judge.unfounded(truth, answer),
                "command": shlex.join([*qerr, "diagnose", str(case / "spec.yaml"), str(case / "log.csv")])}
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        results = list(pool.map(one, folders))
    print(workshop_judge.table(results))
    print(f"records and answers: {out}")
    return workshop_judge.passed(results)


def wrong_cases(results):
    """A line and a command for every case that is not right."""
    for r in results:
        s = r["score"]
        if s.get("right") and r.get("second", "nothing_wrong") == "nothing_wrong":
            continue
        hidden = ", ".join(f"{e['effect']}@{e['joint']} {e['amplitude_counts']:.2g}" for e in r["truth"]["effects"]) or "nothing"
        said = r["fault"] or f"{s.get('verdict')}: {', '.join(s.get('causes', [])) or '-'}"
        if r.get("second", "nothing_wrong") != "nothing_wrong":
            said += f"; second log: {r['second']} {r['second_causes']}"
        yield f"{'wrong' if not s.get('right') else 'later'} {r['truth']['kind']} {r['truth']['sub']}: hidden {hidden}; said {said}"
        yield f"      {r['command']}"


def report(results, quick):
    checks = tables.criteria(results)
    print(f"\n{len(results)} records\n")
    print("\n".join(c.line() for c in checks))
    print("beside them")
    print("\n".join(tables.asides(results)))
    print("\nOne hidden effect\n" + tables.effect_table(results))
    print("\nConfusion\n" + tables.confusion_text(results))
    slowest = max(results, key=lambda r: r["seconds"])
    print(f"\ntime of a diagnosis: mean {sum(r['seconds'] for r in results) / len(results):.2f} s, "
          f"longest {slowest['seconds']:.2f} s ({slowest['case']})")
    if quick:
        return not any(c.surely_missed() for c in checks) and not any(r["fault"] for r in results)
    return all(c.met() is not False for c in checks)


def main():
    a = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    a.add_argument("--qerr", required=True, help="the program, with arguments if need be")
    a.add_argument("--dir", type=pathlib.Path, help="a folder of cases (with truth.json) instead of generated ones")
    a.add_argument("--cases", type=int, help="default: 400, with --quick 60")
    a.add_argument("--seed", type=int, default=1)
    a.add_argument("--kind", action="append", choices=sorted(generate.SHARES), help="only this kind; may be repeated")
    a.add_argument("--name", help="only this effect, record or pair (generate.py --list)")
    a.add_argument("--jobs", type=int, default=2)
    a.add_argument("--timeout", type=float, default=120, help="s for each run of qerr")
    a.add_argument("--out", type=pathlib.Path, help="where cases, answers and tables go; default: a new folder")
    a.add_argument("--quick", action="store_true")
    a.add_argument("--workshop", action="store_true", help="the records of workshop/, with their own judge")
    o = a.parse_args()
    if o.workshop and o.name and o.name not in workshop.NAMES:
        a.error(f"the workshop has no {o.name!r}; generate.py --list shows its names")
    out = o.out or pathlib.Path(tempfile.mkdtemp(prefix="qerr_hidden_"))
    out.mkdir(parents=True, exist_ok=True)
    if o.dir:
        folders = sorted(p.parent for p in o.dir.rglob("truth.json") if (p.parent / "log.csv").exists())
    else:
        kinds = "w" if o.workshop else "".join(sorted(set(o.kind))) if o.kind else "abcde"
        if o.name and not o.kind and not o.workshop:
            kinds = "".join(k for k, n in generate.NAMES.items() if o.name in n) or kinds
        folders = [pathlib.Path(f) for f in generate.generate(out / "cases", o.cases or (60 if o.quick else 400), o.seed, kinds,
                                                              o.name, o.jobs)]
    if not folders:
        print(f"no case (truth.json beside log.csv) under {o.dir}", file=sys.stderr)
        return 2
    qerr = shlex.split(o.qerr)
    if shutil.which(qerr[0]) is None:
        print(f"cannot run {qerr[0]}", file=sys.stderr)
        return 2
    if o.workshop:
        return 0 if workshop_study(qerr, folders, out, o.jobs, o.timeout) else 1
    with concurrent.futures.ThreadPoolExecutor(o.jobs) as pool:
        results = list(pool.map(lambda f: judge(qerr, f, out, o.timeout), folders))
    print("\n".join(wrong_cases(results)))
    good = report(results, o.quick)
    tables.write_csv(results, out)
    if o.quick and good and not o.out:
        shutil.rmtree(out)  # the test suite leaves nothing behind
    else:
        print(f"cases, answers and tables: {out}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
