#!/usr/bin/env python3
"""Acceptance of `qerr robot`: from a URDF to a first report in two commands, from a file or a pipe; files are kept safe.

    check_robot.py --qerr build/qerr [--shared ../shared] [--verbose]
"""
import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

from cases import CORPUS
from tool import Tally, run


def two_commands(t, qerr, folder, urdf):
    spec = folder / "first.yaml"
    made = run(qerr, "robot", urdf, "--write-spec", spec)
    lines = made.out.decode().splitlines()
    t.check(f"{urdf.name}: no line is wider than 80 columns", all(len(line) <= 80 for line in lines),
            max(lines, key=len, default=""))
    ran = run(qerr, "analyze", spec, "--format", "json", "--set", "configurations.count=100")
    if not t.check(f"{urdf.name}: a report in two commands", made.code == 0 and ran.code == 0,
                   (made.err + ran.err).decode(errors="replace")[:400]):
        return
    report, text = json.loads(ran.out), spec.read_text()
    entries = text[text.index("encoders:\n"):text.index("coordinates:")]
    t.check(f"{urdf.name}: an assumption for each encoder, one entry where all are alike", "ASSUMED: " in entries and
            entries.count("ASSUMED: ") <= (len(report["joints"]) if len({j["resolution"] for j in report["joints"]}) > 1 else 1), text)
    coarser = run(qerr, "analyze", spec, "--format", "json", "--set", "configurations.count=100", "--set", "encoders.*.rounding=down")
    t.check(f"{urdf.name}: --set of '*' is accepted", coarser.code == 0 or "'*'" not in entries, coarser.err.decode()[:300])
    t.check(f"{urdf.name}: the tip moves", any(p["sigma"]["max"] > 0 for p in report["position"]), "")
    seen = json.loads(run(qerr, "robot", urdf, "--format", "json").out)
    t.check(f"{urdf.name}: JSON names the same chain", seen["first_spec"] == {k: report["robot"][k] for k in ("base", "tip")},
            str(seen["first_spec"]))


def from_a_pipe(t, qerr, folder):
    urdf = (CORPUS / "arm.urdf").read_bytes()

    def piped(*arguments):
        return subprocess.run([str(qerr), "robot", "-", *map(str, arguments)], input=urdf, capture_output=True, cwd=folder)

    spec = folder / "piped.yaml"
    ran = piped("--write-spec", spec)
    kept = folder / "piped.stdin.urdf"
    t.check("a URDF from a pipe is kept beside the spec, and said", ran.returncode == 0 and kept.exists() and
            kept.read_bytes() == urdf and b"piped.stdin.urdf" in ran.stderr, ran.stderr.decode())
    t.check("the spec of a URDF from a pipe is analyzed", run(qerr, "analyze", spec).code == 0)
    ran = piped("--write-spec", "-")
    t.check("a spec on standard output of a URDF on standard input: 2", ran.returncode == 2 and not ran.stdout, ran.stderr.decode())
    t.check("a URDF from a pipe is shown without a spec", piped().returncode == 0)


def files_are_safe(t, qerr, folder):
    urdf = folder / "own.urdf"
    shutil.copy(CORPUS / "arm.urdf", urdf)
    before = urdf.read_bytes()
    link = folder / "link.urdf"
    os.symlink(urdf, link)
    hard = folder / "hard.urdf"
    os.link(urdf, hard)
    for arguments in (["--write-spec", urdf], ["-o", urdf], ["--write-spec", link], ["--write-spec", hard],
                      ["--write-spec", folder / "x.yaml", "-o", folder / "x.yaml", "--format", "table"],
                      ["--write-spec", "-", "-o", "-"], ["-o", folder / "report.pdf"], ["--format", "html"]):
        ran = run(qerr, "robot", urdf, *arguments)
        t.check(f"robot own.urdf {' '.join(getattr(a, 'name', a) for a in arguments)}: 2, and nothing is written",
                ran.code == 2 and not ran.out and urdf.read_bytes() == before, ran.err.decode())
    ran = run(qerr, "robot", urdf, "--write-spec", "-")
    t.check("the spec on standard output, alone", ran.code == 0 and ran.out.startswith(b"#") and b"Moving joints" not in ran.out, ran.err.decode())
    spec = folder / "edited.yaml"
    spec.write_bytes(ran.out + b"# edited\n")
    edited = spec.read_bytes()
    ran = run(qerr, "robot", urdf, "--write-spec", spec)
    t.check("an edited spec is not replaced: 2", ran.code == 2 and not ran.out and spec.read_bytes() == edited and b"--force" in ran.err, ran.err.decode())
    ran = run(qerr, "robot", urdf, "--write-spec", spec, "--force")
    t.check("but with --force", ran.code == 0 and spec.read_bytes() != edited, ran.err.decode())
    ran = run(qerr, "robot", urdf, "-o", spec, "--format", "table")
    t.check("nor by a report: 2", ran.code == 2 and b"--force" in ran.err, ran.err.decode())
    ran = run(qerr, "robot", urdf, "--write-spec", "-", "-o", folder / "report.txt")
    t.check("the spec on standard output, the report in a file", ran.code == 0 and b"qerr: 1" in ran.out and
            "Moving joints" in (folder / "report.txt").read_text(), ran.err.decode())
    (folder / "below").mkdir()
    run(qerr, "robot", urdf, "--write-spec", folder / "below" / "spec.yaml")
    (folder / "below").rename(folder / "moved")
    t.check("a spec in another folder finds the URDF", run(qerr, "analyze", folder / "moved" / "spec.yaml").code == 0)


def written_specs_hold(t, qerr, folder):
    """A spec that is written elsewhere finds all files that it names; a joint may have a name of any length."""
    shutil.copy(CORPUS / "two_joints.urdf", folder / "one.urdf")
    (folder / "two.urdf").write_text((CORPUS / "two_joints.urdf").read_text().replace("<robot", "<!-- two --><robot"))
    (folder / "cat.csv").write_text("name,bits\na,14\nb,15\n")
    joint = "elbow"
    spec = folder / "names.yaml"
    spec.write_text(f"""qerr: 1
robot: {{urdf: one.urdf}}
encoders: {{'*': {{bits: 16}}}}
configurations: {{count: 20}}
requirements: [{{quantity: position.x.sigma, statistic: max, at_most: 1 m}}]
sweep:
  - {{key: encoders.{joint}, catalogue: cat.csv}}
  - {{key: robot.urdf, values: [one.urdf, two.urdf]}}
design: {{encoders: {{'*': {{catalogue: cat.csv}}}}, minimize: resolution}}
""")
    elsewhere = folder / "elsewhere"
    elsewhere.mkdir()
    ran = run(qerr, "design", "-q", spec, "--write-spec", elsewhere / "w.yaml")
    t.check("design writes a spec into another folder", ran.code == 0, ran.err.decode())
    ran = run(qerr, "sweep", "-q", elsewhere / "w.yaml", "--wide", "-o", folder / "w.csv")
    rows = (folder / "w.csv").read_text().splitlines() if ran.code == 0 else []
    t.check("there every file of its sweep is found", ran.code == 0 and not ran.err and len(rows) == 5 and "../two.urdf" in rows[2], ran.err.decode())
    name = "j" * 1100
    (folder / "long.urdf").write_text((CORPUS / "two_joints.urdf").read_text().replace(f'"{joint}"', f'"{name}"'))
    ran = run(qerr, "robot", folder / "long.urdf", "--write-spec", folder / "long.yaml")
    t.check("the spec of a joint with a name of 1100 characters", ran.code == 0 and run(qerr, "analyze", folder / "long.yaml").code == 0, ran.err.decode()[:300])
    changed = run(qerr, "analyze", "-q", folder / "long.yaml", "--set", f"encoders.{name}.bits=20")
    t.check("and --set of it", changed.code == 0, changed.err.decode()[:300])


def asks(t, qerr, folder):
    urdf = CORPUS / "arm.urdf"
    ran = run(qerr, "analyze", urdf)
    t.check("a URDF in place of a spec: 3, and the command that helps", ran.code == 3 and b"qerr robot" in ran.err, ran.err.decode())
    ran = run(qerr, "robot", urdf, "--tip", "nowhere")
    t.check("an unknown tip: 3", ran.code == 3 and b"--tip" in ran.err and not ran.out, ran.err.decode())
    ran = run(qerr, "robot", urdf, "--base", "nowhere")
    t.check("an unknown base: 3", ran.code == 3 and b"--base: no link" in ran.err and not ran.out, ran.err.decode())
    spec = folder / "package.yaml"
    share = folder / "install" / "share" / "arm_description"
    share.mkdir(parents=True)
    shutil.copy(urdf, share / "arm.urdf")
    run(qerr, "robot", urdf, "--write-spec", spec)
    spec.write_text("".join("  urdf: package://arm_description/arm.urdf\n" if line.startswith("  urdf: ") else line
                            for line in spec.read_text().splitlines(True)))
    found = subprocess.run([str(qerr), "analyze", str(spec)], capture_output=True,
                           env={**os.environ, "AMENT_PREFIX_PATH": str(folder / "install"), "ROS_PACKAGE_PATH": ""})
    t.check("package:// is looked up", found.returncode == 0, found.stderr.decode())
    lost = subprocess.run([str(qerr), "analyze", str(spec)], capture_output=True,
                          env={**os.environ, "AMENT_PREFIX_PATH": "/nowhere", "ROS_PACKAGE_PATH": ""})
    t.check("a package that is not found: 3, with the place in the spec", lost.returncode == 3 and
            b"package.yaml:" in lost.stderr and b"arm_description" in lost.stderr, lost.stderr.decode())


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--qerr", required=True)
    parser.add_argument("--shared", default="", help="folder with public robots, if there is one")
    parser.add_argument("--verbose", action="store_true", help="print the checks that pass, too")
    arguments = parser.parse_args()
    qerr, t = pathlib.Path(arguments.qerr).resolve(), Tally(arguments.verbose)
    robots = [CORPUS / "arm.urdf", CORPUS / "two_joints.urdf", *sorted(CORPUS.parents[1].glob("configs/*/*.urdf")),
              *sorted(pathlib.Path(arguments.shared or "/nowhere").glob("robots/*.urdf"))]
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary).resolve()
        for urdf in robots:
            two_commands(t, qerr, folder, urdf)
        from_a_pipe(t, qerr, folder)
        files_are_safe(t, qerr, folder)
        written_specs_hold(t, qerr, folder)
        asks(t, qerr, folder)
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
