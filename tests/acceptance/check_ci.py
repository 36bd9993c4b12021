#!/usr/bin/env python3
"""The recipes for continuous integration, the action of GitHub, the hook of pre-commit and the presets of CMake.

    check_ci.py --qerr build/qerr [--verbose]

YAML is parsed and its structure checked; what runs `qerr` is run, with other commands of the machine (apt-get, curl) replaced by
ones that write down how they are called.
"""
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

import yaml
from tool import program_and_tally

ROOT = pathlib.Path(__file__).resolve().parents[2]
ACTION = ROOT / ".github" / "actions" / "qerr"
PAGES = ["README.md", "src/cli/topics/ci.md"]
SPEC = """qerr: 1
robot: {urdf: %s/configs/kuka_lwr/kuka_lwr.urdf}
encoders: {'*': {bits: 17}}
configurations: {count: 100}
requirements:
  - {quantity: position.x.worst_case, statistic: max, at_most: %s}
"""


def documents():
    """Name and content of each recipe."""
    for page in PAGES:
        for block in re.findall(r"^```yaml\n(.*?)^```$", (ROOT / page).read_text(), re.M | re.S):
            if re.search(r"^(jobs|stages|repos):", block, re.M):
                yield page, yaml.safe_load(block)
    for path in sorted((ROOT / ".github" / "workflows").glob("*.yml")):
        yield path.name, yaml.safe_load(path.read_text())


class Machine:
    """A folder with a spec, in which commands run: qerr is the program, others write down how they are called."""

    def __init__(self, qerr, folder, limit="1 mm"):
        self.folder, self.bin = pathlib.Path(folder), pathlib.Path(folder) / "bin"
        self.bin.mkdir()
        (self.folder / "robot").mkdir()
        (self.folder / "robot" / "spec.yaml").write_text(SPEC % (ROOT, limit))
        self.qerr = qerr
        self.install_qerr()
        for name in ("apt-get", "curl", "sudo"):
            path = self.bin / name
            path.write_text(f'#!/bin/sh\necho {name} "$@" >> "{folder}/calls"\n')
            path.chmod(0o755)

    def install_qerr(self):
        (self.bin / "qerr").symlink_to(self.qerr)

    def run(self, script, **environment):
        return subprocess.run(["bash", "-c", script], cwd=self.folder, capture_output=True, text=True,
                              env={**os.environ, "PATH": f"{self.bin}:/usr/bin:/bin", "NO_COLOR": "1", **environment})


def check_steps(t, name, steps, inputs):
    for step in steps:
        t.check(f"{name}: a step uses or runs", len({"uses", "run"} & step.keys()) == 1, str(step))
        if "/actions/qerr" in step.get("uses", ""):
            given = step.get("with", {})
            required = {key for key, row in inputs.items() if row.get("required")}
            t.check(f"{name}: the action's inputs", required <= given.keys() <= inputs.keys(), str(given))


def runs(document):
    """Command lines of a recipe that call qerr."""
    if "jobs" in document:
        texts = [step.get("run", "") for job in document["jobs"].values() for step in job["steps"]]
    else:
        texts = [line for job in document.values() if isinstance(job, dict) for line in job.get("script", [])]
    return [line for text in texts for line in text.splitlines() if line.startswith("qerr ")]


def check_recipes(t, qerr, inputs):
    kinds = []
    for name, document in documents():
        if "jobs" in document:
            kinds.append("github")
            for job in document["jobs"].values():
                t.check(f"{name}: a job has a machine and steps", job["runs-on"] and job["steps"] and "container" in job)
                check_steps(t, name, job["steps"], inputs)
        elif "stages" in document:
            kinds.append("gitlab")
            jobs = {key: row for key, row in document.items() if key not in ("stages", "default", "variables")}
            t.check(f"{name}: each job has a stage and a script",
                    all(row["stage"] in document["stages"] and row["script"] for row in jobs.values()))
        else:
            kinds.append("pre-commit")
            known = {row["id"] for row in yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())}
            hooks = [hook for repo in document["repos"] for hook in repo["hooks"] if repo["rev"]]
            t.check(f"{name}: hooks that exist", hooks and {hook["id"] for hook in hooks} <= known)
        for line in runs(document):
            with tempfile.TemporaryDirectory() as folder:
                machine = Machine(qerr, folder)
                done = machine.run(line)
                t.check(f"{name}: {line}", done.returncode == 0 and (machine.folder / "qerr.xml").is_file(), done.stderr)
    t.check("recipes for all three", {"github", "gitlab", "pre-commit"} <= set(kinds) and kinds.count("github") >= 4, str(kinds))


def environment_of(step, inputs, given):
    values = {key: given.get(key, row.get("default", "")) for key, row in inputs.items()}
    return {key: re.sub(r"\$\{\{ inputs\.(\w+) \}\}", lambda m: values[m[1]], text) for key, text in step["env"].items()}


def check_action(t, qerr):
    action = yaml.safe_load((ACTION / "action.yml").read_text())
    inputs, steps = action["inputs"], action["runs"]["steps"]
    install, check = steps
    used = set(re.findall(r"inputs\.(\w+)", json.dumps(action)))
    t.check("the action uses every input, and no other", used == inputs.keys(), str(used ^ inputs.keys()))
    t.check("every input has a description", all(row.get("description") for row in inputs.values()))
    t.check("no expression is part of a script", all("${{" not in step["run"] for step in steps))
    for limit, code, verdict in (("1 mm", 0, "| met |"), ("1 nm", 1, "| **not met** |")):
        with tempfile.TemporaryDirectory() as folder:
            machine = Machine(qerr, folder, limit)
            summary = machine.folder / "summary.md"
            summary.write_text("before\n")
            done = machine.run(check["run"], GITHUB_STEP_SUMMARY=str(summary), **environment_of(check, inputs, {"specs": "robot/*.yaml"}))
            written = summary.read_text()
            t.check(f"{verdict}: exit code {code}", done.returncode == code, done.stderr)
            t.check(f"{verdict}: the summary", written.startswith("before\n") and "`position.x.worst_case max" in written and verdict in written, written)
            t.check(f"{verdict}: annotations", ("::error file=robot/spec.yaml,line=" in done.stdout + done.stderr) == (code == 1))
            t.check(f"{verdict}: JUnit", (machine.folder / "qerr.xml").is_file())
    check_installation(t, qerr, install, inputs)
    return inputs


def check_installation(t, qerr, install, inputs):
    places = [  # the action's folder, its inputs; the exit code, and what is called
        ("/runner/_actions/acme/qerr/v0.1.0/.github/actions/qerr", {}, 0,
         [r"curl .*https://github.com/acme/qerr/releases/download/v0\.1\.0/qerr_0\.1\.0-1_\w+\.deb$", r"apt-get .*qerr_0\.1\.0-1_\w+\.deb$"]),
        ("/__w/_actions/acme/qerr/main/.github/actions/qerr", {}, 2, []),
        ("/runner/arm/arm/tools/qerr/.github/actions/qerr", {"package": "own.deb"}, 0, [r"apt-get .*/own\.deb$"]),
    ]
    for place, given, code, calls in places:
        with tempfile.TemporaryDirectory() as folder:
            machine = Machine(qerr, folder)
            environment = dict(environment_of(install, inputs, given), GITHUB_ACTION_PATH=place, GITHUB_SERVER_URL="https://github.com")
            done = machine.run(install["run"], **environment)
            t.check("qerr that is there is not installed", done.returncode == 0 and not (machine.folder / "calls").exists(), done.stderr)
            (machine.bin / "qerr").unlink()
            done = machine.run(install["run"], **environment)
            called = (machine.folder / "calls").read_text() if (machine.folder / "calls").exists() else ""
            found = [bool(re.search(call, called, re.M)) for call in calls]
            t.check(f"installation from {place}", done.returncode == code and all(found), f"exit {done.returncode}: {called}{done.stdout}{done.stderr}")


def check_hook(t, qerr):
    for hook in yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text()):
        t.check(f"{hook['id']} has what pre-commit asks for", {"id", "name", "entry", "language", "files"} <= hook.keys())
        t.check(f"{hook['id']} is about specs", re.search(hook["files"], "robot/spec.yaml") and not re.search(hook["files"], "robot/arm.urdf"))
        for limit, code in (("1 mm", 0), ("1 nm", 1)):
            with tempfile.TemporaryDirectory() as folder:
                done = Machine(qerr, folder, limit).run(f"{hook['entry']} {shlex.quote('robot/spec.yaml')}")
                t.check(f"{hook['id']} with {limit}: {code}", done.returncode == code, done.stderr)


def check_presets(t):
    presets = json.loads((ROOT / "CMakePresets.json").read_text())
    names = {row["name"] for row in presets["configurePresets"]}
    t.check("each preset is configured", {row["configurePreset"] for kind in ("buildPresets", "testPresets") for row in presets[kind]} <= names)
    options = set(re.findall(r"(?:option|set)\((QERR_\w+)", (ROOT / "CMakeLists.txt").read_text()))
    set_here = {key for row in presets["configurePresets"] for key in row.get("cacheVariables", {}) if key.startswith("QERR_")}
    t.check("presets set options that exist", set_here and set_here <= options, str(set_here - options))
    if shutil.which("cmake"):
        for kind in ("configure", "build", "test"):
            done = subprocess.run(["cmake" if kind != "test" else "ctest", "--list-presets" + (f"={kind}" if kind != "test" else "")],
                                  cwd=ROOT, capture_output=True, text=True)
            t.check(f"CMake reads the presets: {kind}", done.returncode == 0 and '"release"' in done.stdout, done.stderr)


def main():
    qerr, t = program_and_tally()
    inputs = check_action(t, qerr)
    check_recipes(t, qerr, inputs)
    check_hook(t, qerr)
    check_presets(t)
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
