#!/usr/bin/env python3
"""scripts/plot_diagnosis.py: a picture of each joint that moves, with verdict and fit; none of a joint at rest. Exit code 77: there is no
matplotlib.

    check_plots.py --qerr build/qerr [--verbose]
"""
import importlib.util
import json
import pathlib
import struct
import subprocess
import sys
import tempfile

from tool import program_and_tally, run

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts/plot_diagnosis.py"
JOINTS = """<robot name="two"><link name="base"/><link name="arm"/><link name="tip"/>
<joint name="a &amp; $b$" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint><joint name="rest" type="revolute"><parent link="arm"/><child link="tip"/>
<origin xyz="0.2 0 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""
SPEC = """qerr: 1
robot: {{urdf: two.urdf}}
encoders: {{'*': {{counts_per_rev: 2048, gear_ratio: 50}}}}
motion:
  sample_rate: 500 Hz
  duration: 10 s
  joints: {{{moved}}}
"""
MOVED = "'a & $b$': {sines: [{amplitude: 30 deg, frequency: 0.2 Hz}, {amplitude: 4 deg, frequency: 1.1 Hz}]}"
FAULT = "effects=[{type: backlash, joint: 'a & $b$', gap: 2 arcmin}]"


def plotted(*arguments):
    return subprocess.run([sys.executable, str(SCRIPT), *map(str, arguments)], capture_output=True, text=True, timeout=120)


def diagnosed(t, qerr, folder, moved, *effects):
    (folder / "two.urdf").write_text(JOINTS)
    spec, log, plots = folder / "two.yaml", folder / "log.csv", folder / "plots"
    spec.write_text(SPEC.format(moved=moved))
    simulated = run(qerr, "simulate", spec, "--log", log, "-o", folder / "s.txt", "--quiet",
                    *(word for effect in effects for word in ("--set", effect)))
    t.check("simulate", simulated.code == 0, simulated.err.decode())
    made = run(qerr, "diagnose", spec, log, "--plots", plots, "-o", folder / "report.json", "--quiet")
    t.check("diagnose", made.code == 0, made.err.decode())
    return plots


def height(png):
    return struct.unpack(">I", png.read_bytes()[20:24])[0]


def check_pictures(t, qerr, folder):
    plots = diagnosed(t, qerr, folder, MOVED, FAULT)
    made = plotted(plots)
    picture = plots / "a____b_.png"
    t.check("without a report: a picture", made.returncode == 0 and picture.exists(), made.stderr + made.stdout)
    t.check("the joint at rest is named, and has no picture",
            "rest: does not move" in made.stdout and [p.name for p in plots.glob("*.png")] == [picture.name], made.stdout)
    alone = height(picture)
    made = plotted(plots, folder / "report.json")
    t.check("with a report: a row more, for the cause's fit", made.returncode == 0 and height(picture) > alone, made.stderr)
    (plots / "report.json").write_text((folder / "report.json").read_text())
    made = plotted("--format", "pdf", plots)
    t.check("the report in the folder is found", made.returncode == 0 and (plots / "a____b_.pdf").exists(), made.stderr)
    made = plotted(plots, plots / "residual.csv")
    t.check("a report that is none is refused", made.returncode != 0 and "no JSON" in made.stderr, made.stderr)


def check_rest(t, qerr, folder):
    plots = diagnosed(t, qerr, folder, "rest: {sines: [{amplitude: 0 deg, frequency: 1 Hz}]}")
    made = plotted(plots)
    t.check("nothing moves: no picture, exit code 1", made.returncode == 1 and not list(plots.glob("*.png")) and not made.stderr,
            made.stdout + made.stderr)


def check_words(t, qerr, folder):
    """Verdict and causes stand above the pictures, as in the report."""
    plots = diagnosed(t, qerr, folder, MOVED, FAULT)
    spec = importlib.util.spec_from_file_location("plot_diagnosis", SCRIPT)
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    report = json.loads((folder / "report.json").read_text())
    joint = report["causes"][0]["joint"]
    curve = script.by_joint(plots / "residual.csv")[joint]
    words = script.heading(joint, curve, 1e6, "urad", report, script.parts_of(report, joint))
    gap = next(p["value"] for p in report["causes"][0]["parameters"] if p["name"] == "gap")
    t.check("the verdict", report["verdict"].replace("_", " ").upper() in words, words)
    t.check("the cause with its size", f"backlash: gap {gap * 1e6:.5g}" in words, words)
    at, mean = script.means(curve["reference"], curve["before"] - curve["after"])
    t.check("the fit is half the gap at most", 0 < max(abs(mean)) <= 0.5 * gap * 1.01, f"{max(abs(mean))} of {gap}")


if __name__ == "__main__":
    program, tally = program_and_tally()
    if importlib.util.find_spec("matplotlib") is None:
        print("skipped: no matplotlib (scripts/setup.sh --plots)")
        raise SystemExit(77)
    for check in (check_pictures, check_rest, check_words):
        with tempfile.TemporaryDirectory() as work:
            check(tally, program, pathlib.Path(work))
    raise SystemExit(tally.close())
