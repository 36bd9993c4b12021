#!/usr/bin/env python3
"""An effect is one file and one line: qerr_toy is the program with an effect of the tests, thread_wear.cpp, and one more line in the
list of effects. Every command must know it. Needs numpy only.

    check_toy_effect.py --qerr build/tests/qerr_toy
"""
import argparse
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


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--qerr", required=True, type=pathlib.Path)
    t = Tally(show_passed=False)
    with tempfile.TemporaryDirectory() as folder:
        check(t, arguments.parse_args().qerr.resolve(), pathlib.Path(folder))
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
