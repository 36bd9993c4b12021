#!/usr/bin/env python3
"""An effect, and a signal, is one file and one line: qerr_toy is the program with an effect and a signal of the tests,
thread_wear.cpp and tilt.cpp, and one more line in each list. Every command must know them. Needs numpy only.

    check_toys.py --qerr build/tests/qerr_toy
"""
import argparse
import csv
import io
import json
import math
import pathlib
import sys
import tempfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "acceptance"))
from check_plan import RICH, diagnosis, plan  # noqa: E402
from stage import SPEC, URDF  # noqa: E402
from tool import Tally, run  # noqa: E402

NAME, PARAMETER, SIZE = "thread_wear", "curvature", 3e-4
EFFECT = f"effects=[{{type: {NAME}, joint: turn, {PARAMETER}: {SIZE}}}]"


def measured(log):
    """Columns turn.* of a log."""
    header = log.read_text().splitlines()[0].split(",")
    return np.loadtxt(log, delimiter=",", skiprows=1)[:, [i for i, title in enumerate(header) if title.startswith("turn.")]]


def check(t, qerr, folder):
    (folder / "stage.urdf").write_text(URDF)
    spec = folder / "stage.yaml"
    spec.write_text(SPEC + RICH)

    def out(*words):
        answer = run(qerr, *words, "--quiet")
        t.check(f"{words[0]} succeeds", answer.code == 0, answer.err.decode())
        return answer.out.decode()

    t.check("list effects", NAME in run(qerr, "list", "effects").out.decode())
    schema = run(qerr, "schema").out.decode()
    t.check("schema has the effect and its parameter", NAME in schema and PARAMETER in schema)
    worn = out("analyze", spec, "--set", EFFECT, "--format", "json")
    t.check("analyze reports the effect", NAME in worn)
    ideal_log, worn_log = folder / "ideal.csv", folder / "worn.csv"
    out("simulate", spec, "--log", ideal_log)
    out("simulate", spec, "--set", EFFECT, "--log", worn_log)
    change = np.abs(measured(worn_log) - measured(ideal_log)).max()
    t.check("simulate writes it into the log", change > 3.5 * SIZE, f"largest change {change}")
    found = diagnosis(qerr, spec, folder, EFFECT, np.random.default_rng(3))
    causes = [c for c in found["causes"] if c["effect"] == NAME and c["joint"] == "turn"]
    t.check("diagnose names it", len(causes) == 1, [c["effect"] for c in found["causes"]])
    values = {p["name"]: p["value"] for c in causes for p in c["parameters"]}
    t.check("diagnose finds its parameter within 5 %", abs(values.get(PARAMETER, 0) / SIZE - 1) < 0.05, values)
    planned = [e for j in plan(qerr, spec)["joints"] for e in j["effects"]]
    t.check("--plan lists it", any(e["effect"] == NAME and e["parameter"] == PARAMETER for e in planned))
    refused = run(qerr, "analyze", spec, "--set", EFFECT.replace(PARAMETER, "slope"), "--quiet")
    t.check("a misspelt parameter is refused", refused.code != 0 and PARAMETER in refused.err.decode(), refused.err.decode())


WRIST = """<robot name="wrist"><link name="base"/><link name="a"/><link name="b"/><link name="tip"/>
<joint name="swing" type="revolute"><parent link="base"/><child link="a"/><origin xyz="0 0 0.3"/><axis xyz="1 0 0"/>
 <limit lower="0.2" upper="1.1" velocity="1" effort="1"/></joint>
<joint name="roll" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 0.2"/><axis xyz="0 0 1"/>
 <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
<joint name="nod" type="revolute"><parent link="b"/><child link="tip"/><origin xyz="0 0 0.1"/><axis xyz="1 0 0"/>
 <limit lower="0.2" upper="0.9" velocity="1" effort="1"/></joint></robot>"""
TILT = """qerr: 1
robot: {urdf: wrist.urdf}
encoders: {'*': {bits: 14}, nod: {bits: 10}}
coordinates: [x, tilt]
filters: {velocity: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: first_order, cutoff: 30 Hz}}}
configurations: {method: sobol, count: 500}
requirements:
  - {quantity: velocity.tilt.sigma, statistic: max, at_most: 1 rad/s}
"""


def tilt_of(swing, roll, nod):
    """z of the tip in the base: Rx(swing) Rz(roll) Rx(nod) e_z."""
    z = np.array([math.sin(roll) * math.sin(nod), -math.cos(roll) * math.sin(nod), math.cos(nod)])
    return math.acos(math.sin(swing) * z[1] + math.cos(swing) * z[2])


def check_signal(t, qerr, folder):
    """A signal that the program does not have: the tilt of the tip, against differences of its own formula."""
    (folder / "wrist.urdf").write_text(WRIST)
    spec = folder / "wrist.yaml"
    spec.write_text(TILT)

    def out(*words, code=0):
        answer = run(qerr, *words, "--quiet")
        t.check(f"{words[0]} of a signal ends with {code}", answer.code == code, answer.err.decode())
        return answer.out.decode()

    report = json.loads(out("analyze", spec, "--json"))
    rows = {row["coordinate"]: row for row in report["position"]}
    points = list(csv.DictReader(io.StringIO(out("analyze", spec, "--per-configuration", "-", "-o", "/dev/null"))))
    delta = [2 * math.pi / 2**14, 2 * math.pi / 2**14, 2 * math.pi / 2**10]
    worst, sigma = [], []
    for p in points:
        q = np.array([float(p[f"{name} [rad]"]) for name in ("swing", "roll", "nod")])
        step = 1e-6
        row = [(tilt_of(*(q + step * e)) - tilt_of(*(q - step * e))) / (2 * step) for e in np.eye(3)]
        worst.append(sum(abs(c) * d / 2 for c, d in zip(row, delta)))
        sigma.append(math.sqrt(sum((c * d) ** 2 / 12 for c, d in zip(row, delta))))
        told = float(p["position.tilt.worst_case [rad]"])
        if abs(told / worst[-1] - 1) > 1e-8:
            t.check("the worst case at a configuration", False, (told, worst[-1]))
    t.check("all configurations are told of", len(points) == 500, len(points))
    for bound, values in (("worst_case", worst), ("sigma", sigma)):
        for statistic, value in (("max", max(values)), ("min", min(values)), ("mean", sum(values) / len(values))):
            t.check(f"{statistic} of {bound}", abs(rows["tilt"][bound][statistic] / value - 1) < 1e-8, (rows["tilt"][bound], value))
    h2 = report["derivatives"][0]["h2_norm"]
    behind = [row for row in report["derivatives"][0]["coordinates"] if row["coordinate"] == "tilt"][0]["sigma"]["max"]
    t.check("sigma behind the filter", abs(behind / (h2 * max(sigma)) - 1) < 1e-8, behind)
    t.check("CSV", "position,,tilt,rad,sigma,max," in out("analyze", spec, "--format", "csv"))
    t.check("the page", "tilt" in out("analyze", spec, "--format", "html"))
    checked = json.loads(out("check", spec, "--json"))["requirements"][0]
    t.check("check", abs(checked["value"] / behind - 1) < 1e-12 and checked["unit"] == "rad/s", checked)
    out("check", spec, "--set", f"requirements[0].at_most={0.999 * behind} rad/s", code=1)
    above = json.loads(out("analyze", spec, "--json", "--above", "position.tilt.worst_case=" + str(sorted(worst)[249]) + " rad"))["exceedances"][0]
    t.check("--above counts half of them", abs(above["above"] - 250) <= 1, above)
    swept = list(csv.DictReader(io.StringIO(out("sweep", spec, "--set", "sweep=[{key: encoders.nod.bits, values: [10, 11]}]", "--wide", "--format", "csv"))))
    columns = [name for name in swept[0] if name.startswith("position.tilt.sigma.max")]
    t.check("sweep has its columns", len(columns) == 1, list(swept[0])[:8])
    t.check("a finer encoder makes it smaller", columns and float(swept[1][columns[0]]) < float(swept[0][columns[0]]))
    limit = 1.0001 * behind
    choice = ["--set", f"requirements[0].at_most={limit} rad/s", "--set",
              "design={encoders: {nod: {bits: [8, 9, 10, 11, 12]}}, minimize: resolution}"]
    chosen = json.loads(out("design", spec, "--json", *choice))
    bits = json.dumps(chosen)
    t.check("design chooses the 10 bits that just meet it", '"bits": 10' in bits or '"10"' in bits or "10 bit" in bits, bits[:600])
    (folder / "a.json").write_text(json.dumps(report))
    t.check("compare", "tilt" in out("compare", folder / "a.json", spec, "--set", "encoders.nod.bits=12"))
    t.check("list coordinates", "tilts" in run(qerr, "list", "coordinates").out.decode())
    t.check("schema", "tilts" in run(qerr, "schema").out.decode())


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--qerr", required=True, type=pathlib.Path)
    t = Tally(show_passed=False)
    with tempfile.TemporaryDirectory() as folder:
        qerr = arguments.parse_args().qerr.resolve()
        check(t, qerr, pathlib.Path(folder))
        check_signal(t, qerr, pathlib.Path(folder))
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
