#!/usr/bin/env python3
"""What a tracker sees beside the arm: vibrations and a slow wander must be told, white noise and quantization must not; and an elastic
joint under the arm's own weight, of which no effort is logged.

    check_tip_remainder.py --qerr build/qerr [--rounds 3] [--seed 1] [--verbose]

An arm of two links, by hand: x = a cos q1 + b cos(q1 + q2), y = a sin q1 + b sin(q1 + q2).
"""
import json
import math
import pathlib
import sys
import tempfile

import numpy as np

from tool import run, study_and_tally

URDF = """<robot name="arm"><link name="base"/><link name="upper"/><link name="lower"/><link name="tip"/>
<joint name="q1" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="9" velocity="9"/></joint>
<joint name="q2" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="{a} 0 0"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="9" velocity="9"/></joint>
<joint name="end" type="fixed"><parent link="lower"/><child link="tip"/><origin xyz="{b} 0 0"/></joint></robot>
"""

MASSES = """<robot name="arm"><link name="base"/>
<link name="upper"><inertial><origin xyz="{half_a} 0 0"/><mass value="{m}"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
<link name="lower"><inertial><origin xyz="{half_b} 0 0"/><mass value="{n}"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
<link name="tip"/>
<joint name="q1" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 -1 0"/>
<limit lower="-3" upper="3" effort="90" velocity="9"/></joint>
<joint name="q2" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="{a} 0 0"/><axis xyz="0 -1 0"/>
<limit lower="-3" upper="3" effort="90" velocity="9"/></joint>
<joint name="end" type="fixed"><parent link="lower"/><child link="tip"/><origin xyz="{b} 0 0"/></joint></robot>
"""


def motion(rng, t, speed):
    """Two joints that move by sines, fast or so slowly that counts stay for many rows."""
    return [sum(rng.uniform(0.2, 0.6) * np.sin(2 * math.pi * speed * rng.uniform(0.5, 2) * t + rng.uniform(0, 6)) for _ in range(2)) for _ in range(2)]


def beside(rng, t, size):
    """Name, what moves the tracked point along x [m], and its frequency, None for none."""
    yield "nothing", np.zeros(len(t)), None
    f = rng.uniform(3, 20)
    yield "a hum", size * np.sin(2 * math.pi * f * t), f
    f, stops = rng.uniform(8, 20), np.sort(rng.uniform(0, t[-1], 6))
    since = t - stops[np.clip(np.searchsorted(stops, t) - 1, 0, None)]
    yield "vibrations after stops", 6 * size * np.where(since >= 0, np.exp(-since) * np.sin(2 * math.pi * f * since), 0), f
    w = np.cumsum(rng.standard_normal(len(t)))
    yield "a wander", 2 * size * (w - w.mean()) / np.std(w), 0


def check_sag(t, qerr, rng, folder, case):
    """An arm in a vertical plane: true angle = reading - compliance * moment of the weights."""
    a, b, m, n = rng.uniform(0.3, 0.8), rng.uniform(0.2, 0.6), rng.uniform(1, 5), rng.uniform(1, 3)
    (folder / "arm.urdf").write_text(MASSES.format(a=a, b=b, m=m, n=n, half_a=a / 2, half_b=b / 2))
    counts, time = int(2 ** rng.uniform(16, 19)), np.arange(4000) / 200
    (folder / "s.yaml").write_text(f"qerr: 1\nrobot: {{urdf: arm.urdf}}\nencoders: {{'*': {{counts_per_rev: {counts}}}}}\n")
    read = motion(rng, time, 0.3)
    second = 9.80665 * n * b / 2 * np.cos(read[0] + read[1])
    moments = [9.80665 * (m * a / 2 + n * a) * np.cos(read[0]) + second, second]
    for elastic in (None, 0, 1):
        compliance = rng.uniform(50, 200) * 1e-6
        q = [angle - (compliance * moments[j] if j == elastic else 0) for j, angle in enumerate(read)]
        tip = [a * f(q[0]) + b * f(q[0] + q[1]) + 2e-5 * rng.standard_normal(len(time)) for f in (np.cos, np.sin)]
        rows = np.column_stack([time, *(np.round(angle * counts / (2 * math.pi)) for angle in read), *tip])
        np.savetxt(folder / "log.csv", rows, ["%.4f", "%d", "%d", "%.8f", "%.8f"], ",", comments="",
                   header="time [s],q1.counts,q2.counts,tip.x [m],tip.z [m]")
        d = json.loads(run(qerr, "diagnose", folder / "s.yaml", folder / "log.csv", "--format", "json", "-q").out)
        causes = [c for c in d["causes"] if c["effect"] != "noise"]
        said = f"{d['verdict']} {[(c['effect'], c['joint'], c['parameters']) for c in causes]}"
        if elastic is None:
            t.check(f"{case}: a stiff arm that has masses is clean", not causes and d["verdict"] == "nothing_wrong", said)
            continue
        found = [p["value"] for c in causes for p in c["parameters"] if p["name"] == "compliance"]
        t.check(f"{case}: q{elastic + 1} is elastic, nothing else", d["verdict"] == "explained" and len(causes) == 1 and
                (causes[0]["effect"], causes[0]["joint"]) == ("compliance", f"q{elastic + 1}"), said)
        t.check(f"{case}: its compliance to 2 %", len(found) == 1 and abs(found[0] / compliance - 1) < 0.02, f"{found} for {compliance}")


def check_tracker(t, qerr, rng, folder, case):
    """A tracker that repeats its samples, or is late, beside joints with references, or whose mount gives way or is knocked, without a fault of the arm and beside one."""
    a, b, counts = rng.uniform(0.3, 0.8), rng.uniform(0.2, 0.6), int(2 ** rng.uniform(17, 19))
    (folder / "arm.urdf").write_text(URDF.format(a=a, b=b))
    (folder / "s.yaml").write_text(f"qerr: 1\nrobot: {{urdf: arm.urdf}}\nencoders: {{'*': {{counts_per_rev: {counts}}}}}\n")
    step, time, noise = 2 * math.pi / counts, np.arange(7000) / 400, 5e-5
    sizes, rates, phases = rng.uniform(0.2, 0.5, (2, 2)), rng.uniform(0.15, 0.6, (2, 2)), rng.uniform(0, 6, (2, 2))

    def angles(at):
        return [sum(s * np.sin(2 * math.pi * r * at + p) for s, r, p in zip(*joint)) for joint in zip(sizes, rates, phases)]

    def tip(at):
        q = angles(at)
        return np.array([a * f(q[0]) + b * f(q[0] + q[1]) for f in (np.cos, np.sin)])

    def diagnosed(tracked, references=False):
        columns = {"time [s]": ("%.4f", time)}
        for j, q in enumerate(angles(time)):
            columns[f"q{j + 1}.counts"] = "%d", np.round(q / step)
            if references:
                columns[f"q{j + 1}.reference [rad]"] = "%.9f", q + 0.1 * step * rng.standard_normal(len(time))
        columns |= {"tip.x [m]": ("%.7f", tracked[0]), "tip.y [m]": ("%.7f", tracked[1])}
        np.savetxt(folder / "log.csv", np.column_stack([x for _, x in columns.values()]), [f for f, _ in columns.values()], ",",
                   comments="", header=",".join(columns))
        d = json.loads(run(qerr, "diagnose", folder / "s.yaml", folder / "log.csv", "--format", "json", "-q").out)
        return d, f"{d['verdict']} {[(c['effect'], c['joint']) for c in d['causes']]} {d['unexplained']} {d['data']}"

    white = noise * rng.standard_normal((2, len(time)))
    rows = int(rng.integers(3, 8))
    sampled = np.repeat((tip(time) + white)[:, ::rows], rows, axis=1)[:, :len(time)]
    d, said = diagnosed(sampled)
    t.check(f"{case}: samples held for {rows} rows are told, and no more", not d["causes"] and not d["unexplained"] and
            any(f["kind"] == "repeated" for f in d["data"]), said)
    still = (tip(time) + white)
    still[:, 3000:3300] = still[:, [3000]]
    d, said = diagnosed(still)
    t.check(f"{case}: a lost target is told, and no more", not d["causes"] and not d["unexplained"] and
            any(f["kind"] == "repeated" for f in d["data"]), said)
    lost = tip(time) + white
    hit = rng.choice(len(time), 20, replace=False)
    lost[:, hit] += rng.uniform(0.05, 0.2, (2, len(hit)))
    d, said = diagnosed(lost)
    t.check(f"{case}: single positions far off are told, each of {len(hit)}, and no more", not d["causes"] and not d["unexplained"] and
            any(f["kind"] == "corrupt" and f["what"].startswith(f"{len(hit)} positions") for f in d["data"]), said)
    late = rng.uniform(0.01, 0.04)
    d, said = diagnosed(tip(time - late) + white, references=True)
    delays = [p["value"] for c in d["causes"] for p in c["parameters"] if (c["effect"], c["joint"], p["name"]) == ("latency", "tip", "delay")]
    t.check(f"{case}: a tracker that is late by {late:.4f} s beside references", len(d["causes"]) == 1 and len(delays) == 1 and
            abs(abs(delays[0]) - late) < 5e-4, f"{said} {delays}")
    yields = np.outer(rng.uniform(-1, 1, 2), 20 * noise * (1 - np.exp(-time / rng.uniform(3, 20))))
    d, said = diagnosed(tip(time) + white + yields)
    t.check(f"{case}: a mount that gives way is no fault of the arm", not d["causes"] and
            [u["joint"] for u in d["unexplained"]] == ["tip"], said)
    knock = np.outer(rng.uniform(0.5, 1, 2), 30 * noise * (time > rng.uniform(5, 12)))
    heading, hit = sum(angles(time)), 20 * noise * (time > rng.uniform(5, 12))
    d, said = diagnosed(tip(time) + white + hit * np.array([np.cos(heading), np.sin(heading)]))
    t.check(f"{case}: a target that is knocked is no two joints that lose counts at once", not d["causes"] and
            [u["what"] for u in d["unexplained"]] == ["a step in time"], said)
    scale = rng.uniform(0.01, 0.03)
    for name, moved in (("gives way", yields), ("is knocked", knock)):
        q = angles(time)
        x, y = (a * f(q[0]) + b * f(q[0] + q[1] * (1 - scale)) for f in (np.cos, np.sin))
        d, said = diagnosed(np.array([x, y]) + white + moved)
        found = [p["value"] for c in d["causes"] for p in c["parameters"] if (c["effect"], c["joint"], p["name"]) == ("scale", "q2", "scale")]
        t.check(f"{case}: what {name} hides no scale of {scale:.4f}", len(d["causes"]) == 1 and len(found) == 1 and
                abs((1 + found[0]) * (1 - scale) - 1) < 0.02 * scale and [u["joint"] for u in d["unexplained"]] == ["tip"], f"{said} {found}")


def check_poses(t, qerr, rng, folder, case):
    """Poses of an arm, few or with wrong ones; and motions of one whose encoder follows its neighbour, whose clock runs fast, whose link grows or
    whose tracker stands elsewhere by less than its noise."""
    a, b, counts = rng.uniform(0.3, 0.8), rng.uniform(0.2, 0.6), int(2 ** rng.uniform(17, 19))
    (folder / "arm.urdf").write_text(URDF.format(a=a, b=b))
    (folder / "s.yaml").write_text(f"qerr: 1\nrobot: {{urdf: arm.urdf}}\nencoders: {{'*': {{counts_per_rev: {counts}}}}}\n")
    step, noise = 2 * math.pi / counts, rng.uniform(3e-5, 1e-4)

    def tip(q, a=a, b=b):
        return np.array([a * f(q[0]) + b * f(q[0] + q[1]) for f in (np.cos, np.sin)])

    def diagnosed(read, tracked, time=None):
        rows = np.vstack(([] if time is None else [time]) + [np.round(x / step) for x in read] + [*(tracked + noise * rng.standard_normal(tracked.shape))])
        np.savetxt(folder / "log.csv", rows.T, "%.9f", ",", comments="",
                   header=("" if time is None else "time [s],") + "q1.counts,q2.counts,tip.x [m],tip.y [m]")
        d = json.loads(run(qerr, "diagnose", folder / "s.yaml", folder / "log.csv", "--format", "json", "-q").out)
        return d, [(c["effect"], c["joint"]) for c in d["causes"]], f"{d['verdict']} {d['causes']} {d['unexplained']} {d['data']}"

    poses = rng.uniform(-2.5, 2.5, (2, 24))
    d, named, said = diagnosed(poses, tip(poses))
    t.check(f"{case}: 24 poses are enough to say that nothing is wrong", d["verdict"] == "nothing_wrong", said)
    offset = 30 * noise / (a + b)
    d, named, said = diagnosed(poses + [[offset], [0]], tip(poses))
    t.check(f"{case}: and for an offset", ("offset", "q1") in named or any((x["effect"], x["joint"]) == ("offset", "q1") for x in d["alternatives"]), said)
    poses = rng.uniform(-2.5, 2.5, (2, 45))
    wrong = tip(poses)
    wrong[:, rng.choice(45, 3, replace=False)] += rng.uniform(50, 5000) * noise
    d, named, said = diagnosed(poses, wrong)
    t.check(f"{case}: three wrong positions of 45 are told", not named and any(f["kind"] == "corrupt" for f in d["data"]), said)

    time = np.arange(4000) / 200
    q = np.array(motion(rng, time, 0.3))
    factor = 30 * noise / (a + b) / np.std(q[1])
    d, named, said = diagnosed([q[0] + factor * q[1], q[1]], tip(q), time)
    found = [p["value"] for c in d["causes"] for p in c["parameters"] if p["name"] == "factor"]
    t.check(f"{case}: q1 follows q2 by {factor:.6f}", named == [("coupling_error", "q1")] and abs(found[0] / factor - 1) < 0.05, said)
    rate = 30 * noise / (a + b) / np.std(np.gradient(q[0], time)) / time[-1]
    late = np.array([np.interp(time * (1 + rate), time, x) for x in q])
    d, named, said = diagnosed(late, tip(q), time)
    found = [p["value"] for c in d["causes"] for p in c["parameters"] if p["name"] == "rate"]
    t.check(f"{case}: one clock runs fast by {rate:.2e}", named == [("clock_drift", "tip")] and abs(found[0] / rate - 1) < 0.1, said)
    run(qerr, "diagnose", folder / "s.yaml", folder / "log.csv", "-q", "--write-model", folder / "found.yaml", "--force")
    (folder / "s.yaml").write_text((folder / "found.yaml").read_text())
    d, named, said = diagnosed(late, tip(q), time)
    t.check(f"{case}: and the written model knows it", d["verdict"] == "nothing_wrong", said)
    (folder / "s.yaml").write_text(f"qerr: 1\nrobot: {{urdf: arm.urdf}}\nencoders: {{'*': {{counts_per_rev: {counts}}}}}\n")
    grown = 40 * noise * (1 - np.exp(-time / rng.uniform(4, 12)))
    d, named, said = diagnosed(q, tip(q, a=a + grown), time)
    t.check(f"{case}: the first link grows", not named and [u["what"] for u in d["unexplained"]] == ["the link before q2 grows with time"], said)
    away = noise * rng.choice([-1, 1], 2) * rng.uniform(0.4, 0.8, 2)
    d, named, said = diagnosed(q, tip(q) + away[:, None], time)
    t.check(f"{case}: a tracker that is displaced by less than its noise is told", d["verdict"] != "nothing_wrong" and
            set(named) <= {("frame", "tip"), ("geometry", "q1")}, said)


def main():
    arguments, qerr, t = study_and_tally(rounds=3)
    rng = np.random.default_rng(arguments.seed)
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for round_ in range(arguments.rounds):
            check_poses(t, qerr, np.random.default_rng([arguments.seed, round_]), folder, f"round {round_}, poses")
            check_tracker(t, qerr, rng, folder, f"round {round_}, a tracker")
            check_sag(t, qerr, rng, folder, f"round {round_}, under its weight")
            a, b, counts = rng.uniform(0.3, 0.8), rng.uniform(0.2, 0.6), int(2 ** rng.uniform(12, 17))
            (folder / "arm.urdf").write_text(URDF.format(a=a, b=b))
            (folder / "s.yaml").write_text(f"qerr: 1\nrobot: {{urdf: arm.urdf}}\nencoders: {{'*': {{counts_per_rev: {counts}}}}}\n")
            step, time = 2 * math.pi / counts, np.arange(6000) / 200
            for speed in (0.3, 0.003):
                q = motion(rng, time, speed)
                noise = rng.uniform(0.3, 3) * step * a
                for name, moved, frequency in beside(rng, time, 1.2 * (noise + step * a / 3)):
                    x = a * np.cos(q[0]) + b * np.cos(q[0] + q[1]) + moved + noise * rng.standard_normal(len(time))
                    y = a * np.sin(q[0]) + b * np.sin(q[0] + q[1]) + noise * rng.standard_normal(len(time))
                    rows = np.column_stack([time, *(np.round(angle / step) for angle in q), x, y])
                    np.savetxt(folder / "log.csv", rows, ["%.4f", "%d", "%d", "%.8f", "%.8f"], ",", comments="",
                               header="time [s],q1.counts,q2.counts,tip.x [m],tip.y [m]")
                    d = json.loads(run(qerr, "diagnose", folder / "s.yaml", folder / "log.csv", "--format", "json", "-q").out)
                    left = [u for u in d["unexplained"] if u["joint"] == "tip"]
                    found = {c["effect"] for c in d["causes"]} - {"noise"}
                    case = f"round {round_}, {counts} counts, {'fast' if speed > 0.1 else 'slow'}, {name}"
                    said = f"{d['verdict']} {sorted(found)} {d['unexplained']}"
                    if frequency is None:
                        t.check(f"{case}: nothing is left", not left and not found, said)
                    else:
                        t.check(f"{case}: it is told", d["verdict"] not in ("nothing_wrong", "explained") and left, said)
                        at = [u["frequency"] for u in left if u.get("frequency")]
                        t.check(f"{case}: with its frequency", frequency == 0 or any(abs(f - frequency) < 0.1 * frequency + 0.3 for f in at), said)
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
