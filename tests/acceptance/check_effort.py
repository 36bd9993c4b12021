#!/usr/bin/env python3
"""Currents and torques of motors as loads: a pendulum with an elastic gear, whose masses are those of its URDF.

    check_effort.py --qerr build/qerr [--rounds 3] [--verbose]

The pendulum's load is m g l cos q + (I + m l^2) q'', by hand. Its effort is logged as it is, with the opposite sign, in another unit,
as a current, and with the friction and the inertia of a motor in it. The gear's compliance must be found, and nothing else; without
one, nothing is wrong with the machine.
"""
import json
import math
import pathlib
import sys
import tempfile

import numpy as np

from tool import run, study_and_tally

URDF = """<robot name="pendulum"><link name="base"/><link name="rod"><inertial><origin xyz="{l} 0 0"/><mass value="{m}"/>
<inertia ixx="{i}" ixy="0" ixz="0" iyy="{i}" iyz="0" izz="{i}"/></inertial></link><link name="tip"/>
<joint name="swing" type="revolute"><parent link="base"/><child link="rod"/><axis xyz="0 -1 0"/>
<limit lower="-3" upper="3" effort="100" velocity="9"/></joint>
<joint name="end" type="fixed"><parent link="rod"/><child link="tip"/><origin xyz="{l} 0 0"/></joint></robot>
"""
SPEC = "qerr: 1\nrobot: {urdf: arm.urdf}\nencoders: {swing: {counts_per_rev: 4096, gear_ratio: 50}}\n"
STEP = 2 * math.pi / (4096 * 50)


def swing(rng, t):
    """Angle, speed and acceleration of two sines."""
    q, v, a = np.full(len(t), rng.uniform(-0.3, 0.3)), np.zeros(len(t)), np.zeros(len(t))
    for size, low, high in ((rng.uniform(0.7, 1.1), 0.1, 0.2), (rng.uniform(0.2, 0.4), 0.4, 0.7)):
        w, p = 2 * math.pi * rng.uniform(low, high), rng.uniform(0, 6)
        q, v, a = q + size * np.sin(w * t + p), v + size * w * np.cos(w * t + p), a - size * w * w * np.sin(w * t + p)
    return q, v, a


def efforts(rng, load, v, a):
    """Name, unit, effort, and words of which one tells what it is."""
    size = np.ptp(load)
    friction = rng.uniform(0.08, 0.2) * size * np.sign(v) + 0.1 * size * v / np.abs(v).max()
    rotor = rng.uniform(0.05, 0.15) * size * a / np.abs(a).max()
    amperes = rng.uniform(3, 20)
    yield "load", "N m", load, []
    yield "heavier than the URDF", "N m", 4 * load, []
    yield "reversed", "N m", -load, ["opposite sign"]
    yield "motor side", "N m", load / 50, ["N m by the masses"]
    yield "current", "A", load / amperes, ["1 A is"]
    yield "motor", "N m", load + friction + rotor, ["more than the load"]
    yield "current of the motor", "A", (load + friction + rotor) / amperes, ["1 A is", "more than the load"]


def main():
    arguments, qerr, t = study_and_tally(rounds=3)
    rng = np.random.default_rng(arguments.seed)
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        (folder / "s.yaml").write_text(SPEC)
        for round_ in range(arguments.rounds):
            m, l, i = rng.uniform(1, 8), rng.uniform(0.2, 0.6), rng.uniform(0.01, 0.1)
            (folder / "arm.urdf").write_text(URDF.format(m=m, l=l, i=i))
            time = np.arange(6000) / 200
            q, v, a = swing(rng, time)
            load = m * 9.80665 * l * np.cos(q) + (i + m * l * l) * a
            for name, unit, effort, words in efforts(rng, load, v, a):
                for compliance in (rng.uniform(6, 20) * STEP / np.std(load), 0):
                    counts = np.round((q + compliance * load) / STEP + rng.uniform(-0.5, 0.5))
                    sensed = effort + 0.003 * np.std(effort) * rng.standard_normal(len(effort))
                    rows = np.column_stack([time, counts, q, sensed])
                    np.savetxt(folder / "log.csv", rows, ["%.6f", "%d", "%.9f", "%.7g"], ",", comments="",
                               header=f"time [s],swing.counts,swing.reference [rad],swing.effort [{unit}]")
                    ran = run(qerr, "diagnose", folder / "s.yaml", folder / "log.csv", "--format", "json", "-q")
                    d = json.loads(ran.out)
                    causes = {c["effect"]: c["parameters"] for c in d["causes"] if c["effect"] != "offset"}
                    found = next((p["value"] for p in causes.get("compliance", [])), 0)
                    case = f"round {round_}, {name}, {compliance * 1e6:.3g} urad/(N m)"
                    t.check(f"{case}: that, and nothing else", set(causes) == ({"compliance"} if compliance else set()),
                            f"{d['verdict']} {causes} {d['unexplained']}")
                    true = compliance / 4 if name.startswith("heavier") else compliance
                    t.check(f"{case}: the size", abs(found - true) <= 0.06 * true, f"{found}")
                    said = " ".join(x["what"] for x in d["data"])
                    # What a motor turns besides the load does not matter to a stiff gear.
                    silent = not words or (words == ["more than the load"] and not compliance)
                    t.check(f"{case}: what the effort is", not said if silent else any(word in said for word in words), said)
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
