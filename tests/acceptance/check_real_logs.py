#!/usr/bin/env python3
"""Acceptance of `qerr diagnose` on logs with typical deficiencies: a reference interpolated between few points, a clipped resolver
with one reversal, a "load" that the controller computes from the error; and on measured logs.

    check_real_logs.py --qerr build/qerr [--shared DIR] [--every]     DIR/data is skipped, with a message, if absent
Needs numpy only.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from tool import Tally, run

URDF = """<robot name="stage"><link name="base"/><link name="tip"/>
<joint name="shaft" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="7" effort="10" velocity="50"/></joint></robot>
"""
TURN = 2 * np.pi


def answer(qerr, folder, encoder, header, columns, formats):
    """The diagnosis of a log of one joint."""
    (folder / "stage.urdf").write_text(URDF)
    (folder / "spec.yaml").write_text(
        f"qerr: 1\nrobot: {{urdf: stage.urdf}}\nencoders:\n  shaft: {encoder}\nconfigurations: {{method: sobol, count: 100}}\n")
    rows = "\n".join(",".join(f % x for f, x in zip(formats, row)) for row in zip(*columns))
    (folder / "log.csv").write_text(header + "\n" + rows + "\n")
    done = run(qerr, "diagnose", folder / "spec.yaml", folder / "log.csv", "--format", "json", limit=200)
    return json.loads(done.out) if done.code == 0 else {}


def causes(said):
    """{(effect, order or None): its parameters by name} of an answer, in its order."""
    found = {}
    for cause in said.get("causes", []):
        numbers = {p["name"]: p["value"] for p in cause["parameters"]}
        found[cause["effect"], round(numbers["order"]) if "order" in numbers else None] = numbers
    return found


def magnet_table(qerr, folder, tally):
    """One row per count of a 14-bit magnetic encoder; the reference is interpolated between 200 steps of an inaccurate motor."""
    dice = np.random.default_rng(5)
    true = TURN * np.arange(201) / 200
    count = TURN / 2**14
    amplitudes = {1: 9.0, 2: 12.0, 4: 5.0}
    raw = true + count * sum(a * np.sin(k * true + 0.4 * k) for k, a in amplitudes.items())
    stepper = true + count * (3.0 * np.sin(50 * true + 1.0) + dice.normal(0, 0.4, 201))
    at = count * np.arange(2**14)
    reference = np.interp(at, raw, stepper)
    keep = (at > raw[0]) & (at < raw[-1])
    said = answer(qerr, folder, "{bits: 14}", "time [s],shaft.counts,shaft.reference [rad]",
                  [1e-3 * np.arange(keep.sum()), np.arange(2**14)[keep], reference[keep]], ["%.3f", "%d", "%.6f"])
    found = causes(said)
    tally.check("table: the orders of the magnetic encoder are named, the largest first",
                list(found)[:1] == [("transmission_error", 2)] and ("eccentricity", 1) in found and ("transmission_error", 4) in found,
                said.get("causes"))
    sizes = [(found.get(("eccentricity" if k == 1 else "transmission_error", k)) or {}).get("amplitude", 0) / count
             for k in amplitudes]
    tally.check("table: their amplitudes are accurate to 8 %", np.allclose(sizes, list(amplitudes.values()), rtol=0.08), sizes)
    tally.check("table: at 50 periods per revolution the stepper motor is a possible cause",
                "reference_error" in [a["effect"] for a in said.get("alternatives", [])], said.get("alternatives"))
    tally.check("table: 200 points support few causes", len(found) <= 7, list(found))
    tally.check("table: no cause depends on the motion", not {k for k, _ in found} & {"latency", "backlash", "clock_drift", "missed_counts"},
                list(found))


def clipped_resolver(qerr, folder, tally):
    """One revolution forward and backward at 36 deg/s, 35 ms late, both signals clipped at 0.65 of their amplitude."""
    dice = np.random.default_rng(6)
    time = 0.01 * np.arange(3000)
    speed = np.interp(time, [2, 2.1, 12, 12.1, 16, 16.1, 26, 26.1], np.array([0, 1, 1, 0, 0, -1, -1, 0]))
    speed *= TURN / 10
    path = np.concatenate([[0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * 0.01)])
    late = np.interp(time - 0.035, time, path)
    angle = np.unwrap(np.arctan2(np.clip(np.sin(late), -0.65, 0.65), np.clip(np.cos(late), -0.65, 0.65)))
    measured = angle + dice.normal(0, 2e-5, time.size)
    said = answer(qerr, folder, "{bits: 20}", "time [s],shaft.measured [rad],shaft.reference [rad]", [time, measured, path],
                  ["%.2f", "%.9f", "%.9f"])
    found = causes(said)
    first = next((k for k in found if k[0] != "offset"), None)
    tally.check("resolver: the first cause is the fourth order or the subdivision error",
                first in [("transmission_error", 4), ("subdivision_error", None)], list(found))
    tally.check("resolver: the delay is accurate to 2 ms", abs(found.get(("latency", None), {}).get("delay", 0) - 0.035) < 0.002, found)
    tally.check("resolver: neither missed counts nor backlash",
                not {k for k, _ in found} & {"missed_counts", "backlash"}, list(found))
    tally.check("resolver: the gain on held-out blocks is above 8", said.get("gain", {}).get("ratio", 0) > 8, said.get("gain"))


def load_of_the_controller(qerr, folder, tally):
    """The logged "load" of a servo is its gain times the error, and the error is backlash."""
    dice = np.random.default_rng(7)
    time = 0.002 * np.arange(6000)
    path = 2 + 1.2 * np.sin(TURN * 0.4 * time) + 0.3 * np.sin(TURN * 1.3 * time + 1)
    rate = np.gradient(path, time)
    count = TURN / 4096
    read = np.round((path + 3 * count * np.sign(rate)) / count)
    reference = path + dice.normal(0, 0.02 * count, path.size)
    said = answer(qerr, folder, "{counts_per_rev: 4096}", "time [s],shaft.counts,shaft.reference [rad],shaft.effort [N m]",
                  [time, read, reference, 40 * (read * count - reference)], ["%.3f", "%d", "%.9f", "%.9f"])
    found = {k for k, _ in causes(said)}
    tally.check("servo: a load proportional to the error is reported as controller droop", "controller_droop" in found, list(found))
    tally.check("servo: no compliance is reported", "compliance" not in found, list(found))


# Of the three logs of the same kind of magnetic encoder one is enough for the test suite; the resolver is imitated above.
SIMILAR = ("mechaduino_drewtm", "mechaduino_mathias", "resolver_amci_1")
# Answers that are wrong today stay visible here, and one that becomes
# right must leave the list.
KNOWN_WRONG = set()


def measured_logs(qerr, data, every, tally):
    """The measured logs, scored against their expected answers by the script of the data set."""
    if not (data / "score_real.py").is_file():
        print(f"skip  measured logs: no {data}")
        return
    wrong, messages = set(), ""
    for folder in sorted(path.parent for path in data.glob("*/expect.json")):
        if folder.name in SIMILAR and not every:
            continue
        done = subprocess.run([sys.executable, data / "score_real.py", "--qerr", str(qerr), "--dir", folder],
                              capture_output=True, text=True)
        lines = [line for line in done.stdout.splitlines() if line[:3] in ("ok ", "BAD")]
        print("\n".join(lines))
        if not lines or any(line.startswith("BAD") for line in lines):
            wrong.add(folder.name)
        messages += done.stderr
    tally.check("every measured log has an acceptable answer, but those known to be wrong", wrong == KNOWN_WRONG,
                f"wrong: {sorted(wrong)} {messages}")


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--qerr", required=True, type=lambda p: pathlib.Path(p).resolve())
    arguments.add_argument("--shared", type=pathlib.Path, default=pathlib.Path("none"))
    arguments.add_argument("--every", action="store_true", help="all measured logs, also similar ones")
    o = arguments.parse_args()
    tally = Tally()
    for imitation in (magnet_table, clipped_resolver, load_of_the_controller):
        with tempfile.TemporaryDirectory() as folder:
            imitation(o.qerr, pathlib.Path(folder), tally)
    measured_logs(o.qerr, o.shared / "data", o.every, tally)
    return tally.close()


if __name__ == "__main__":
    sys.exit(main())
