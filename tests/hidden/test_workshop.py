#!/usr/bin/python3
"""Compares the workshop's physics with formulas derived by hand, its records with their truth, and its judge with made answers.

usage: test_workshop.py
"""
import json
import math
import pathlib
import sys
import tempfile

import numpy as np

from test_machine import near, read_log, run
from workshop import arms, bench, counting, judge, mechanics, workshop


def a_counter_counts_edges():
    c = counting.Counter(4000, -2.5, form="lines")
    x = np.linspace(-1, 1, 20001)
    assert np.array_equal(c.count(x), np.floor(x / c.step + 0.5)) and c.step < 0
    assert np.array_equal(c.count(x, edges=np.zeros(4)), c.count(x))
    wide = c.count(x, edges=np.array([0.0, 0.4, 0.0, 0.4]))  # B is late: states of 1.4, 0.6, 1.4, 0.6 counts
    share = np.bincount(wide % 4, minlength=4) / len(x)
    assert np.allclose(np.sort(share), [0.15, 0.15, 0.35, 0.35], atol=2e-3)
    slide = counting.Counter(1000, 2.0, 0.01)
    assert slide.count(np.array([0.0, 0.005, -0.005])).tolist() == [0, 1000, -1000]


def a_disc_off_centre_errs_by_its_radius_once_a_turn():
    a = np.linspace(0, 2 * math.pi, 1000, endpoint=False)
    e = counting.off_centre(0.01, 0.3)(a) - a
    near(2 * abs(np.mean(e * np.exp(-1j * a))), 0.01, 1e-3)
    near(2 * abs(np.mean(e * np.exp(-2j * a))), 0.01**2 / 2, 1e-2)  # atan2's series: r^k/k
    near(np.angle(np.mean(e * np.exp(-1j * a))), 0.3 - math.pi / 2, 1e-2)


def clearance_loses_its_width_at_each_turn():
    x = np.concatenate([np.linspace(0, 1, 500), np.linspace(1, 0, 500)])
    y = mechanics.play(x, 0.1)
    near(y[499], 0.95, 1e-9)
    near(y[-1], 0.05, 1e-9)
    fine = mechanics.play_along(lambda t: np.sin(20 * t), np.linspace(0, 1, 60), 0.2)
    near(fine.max(), 0.9, 2e-3)  # of the turning point, which lies between two rows


def presliding_has_its_width_and_its_travel():
    x = np.concatenate([np.linspace(0, 1, 2000), np.linspace(1, 0, 2000)])
    z = mechanics.presliding(x, 0.02, 0.05)
    near(z[1999], 0.01, 1e-6)
    near(z[2000 + 100], 0.01 * (-1 + 2 * math.exp(-x[100] / 0.05)), 2e-2)
    near(z[-1], -0.01, 1e-6)


def a_spring_sags_and_rings():
    t = np.arange(4000) / 1000
    q, torque = mechanics.spring_mass(lambda t: np.full(len(t), 0.2), t, 1.0, 900.0, 0.0, lambda q: -9.0)
    assert np.allclose(q, 0.2 - 0.01) and np.allclose(torque, 9.0)
    q, _ = mechanics.spring_mass(lambda t: 0.01 * (t > 0), t, 1.0, 900.0, 0.0, lambda q: 0.0)
    near(np.abs(np.fft.rfft(q - q.mean())).argmax() / 4.0, 30 / (2 * math.pi), 0.03)  # sqrt(k/I) = 30 rad/s


def warmth_and_creep_approach_exponentially():
    t = np.linspace(0, 10, 20001)
    near(mechanics.warmth(t, 2.0, 5.0)[4000], 5 * (1 - math.exp(-1)), 1e-3)
    x = np.clip(t, 0, 1)
    near(mechanics.settling(x, t, 0.5, 0.1, 1e-9)[np.searchsorted(t, 1.5)], 0.1 * (1 - math.exp(-1)), 5e-3)


def an_arm_reaches_where_its_rods_lie():
    arm = arms.Arm(["a", "b"], [[0, 0, 1], [0, 1, 0]], [[0.5, 0, 0], [0.3, 0, 0]], [0, 0, 0.2])
    tip = arm.tip(np.array([[0, math.pi / 2, 0], [0, 0, math.pi / 2]]))
    assert np.allclose(tip, [[0.8, 0, 0.2], [0, 0.8, 0.2], [0.5, 0, -0.1]])


def every_kind_can_be_drawn_and_repeats():
    for name in workshop.NAMES:
        first, again = workshop.make(5, 1, name), workshop.make(5, 1, name)
        assert first.spec == again.spec and json.dumps(first.truth, default=float) == json.dumps(again.truth, default=float)
        assert all(np.array_equal(a[1], b[1]) for a, b in zip(first.columns, again.columns)), name
    assert len({workshop.chosen(1, i).__name__ for i in range(150)}) > 0.8 * len(workshop.NAMES)
    clean = sum(workshop.make(1, i).truth.get("clean", False) for i in range(100))
    assert clean >= 25, clean


def the_log_holds_what_the_truth_says():
    with tempfile.TemporaryDirectory() as folder:
        record = workshop.make(2, 0, "missed")
        bench.write(record, pathlib.Path(folder))
        log, joint = read_log(pathlib.Path(folder) / "log.csv"), record.truth["joint"]
        values = record.truth["causes"][0]["values"]
        reference = next(v for k, v in log.items() if k.startswith(joint + ".reference"))
        counts, late = log[joint + ".counts"], log["time [s]"] >= values["time"]
        step = np.polyfit(counts[~late], reference[~late], 1)[0]
        near(np.mean((counts - reference / step)[late]) - np.mean((counts - reference / step)[~late]), values["counts"], 0.1)


def answers_are_judged_as_written():
    truth = {"joint": "j", "causes": [{"effects": ["backlash"], "values": {"gap": 1.0}}], "tolerated": ["offset"], "says": ["hysteresis"]}
    cause = lambda e, gap=1.1, joint="j": {"effect": e, "joint": joint, "parameters": [{"name": "gap", "value": gap}]}
    grade = lambda verdict, *causes, t=truth, **more: judge.judge(t, {"verdict": verdict, "causes": list(causes), **more})[0]
    assert grade("explained", cause("backlash"), cause("offset")) == "right"
    assert grade("explained", cause("backlash", 1.5)) == "acceptable"
    assert grade("partly_explained", cause("backlash")) == "acceptable"
    assert grade("explained", cause("backlash"), cause("scale")) == "wrong"
    assert grade("explained", cause("backlash", joint="k")) == "wrong"
    assert grade("nothing_wrong") == "wrong" and grade("unexplained") == "acceptable"
    assert grade("unexplained", unexplained=[{"joint": "j", "what": "hysteresis"}]) == "right"
    swap = [{"instead_of": "latency", "effect": "backlash", "joint": "j"}]
    assert grade("ambiguous", cause("latency"), alternatives=swap) == "right"
    clean = {"joint": "j", "clean": True}
    assert grade("nothing_wrong", t=clean) == "right" and grade("cannot_judge", t=clean) == "acceptable"
    assert grade("unexplained", t=clean) == "wrong" and grade("explained", cause("noise"), t=clean) == "wrong"


CHECKS = [a_counter_counts_edges, a_disc_off_centre_errs_by_its_radius_once_a_turn, clearance_loses_its_width_at_each_turn,
          presliding_has_its_width_and_its_travel, a_spring_sags_and_rings, warmth_and_creep_approach_exponentially,
          an_arm_reaches_where_its_rods_lie, every_kind_can_be_drawn_and_repeats, the_log_holds_what_the_truth_says,
          answers_are_judged_as_written]

if __name__ == "__main__":
    sys.exit(1 if run(CHECKS) else 0)
