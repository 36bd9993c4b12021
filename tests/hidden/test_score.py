#!/usr/bin/python3
"""Tests the generator's files against their truth, and the scoring with constructed answers.

usage: test_score.py
"""
import json
import pathlib
import sys
import tempfile

import numpy as np

import generate
import write
from case import estimated_velocity
from score import binomial_upper, score
from test_machine import near, read_log, run


def the_controllers_velocity_is_right_at_constant_speed():
    case = generate.make(1, 0, "a", "multisine")
    v = estimated_velocity(case, 0.3 * np.arange(500) / case.rate, 0)
    assert np.allclose(v, 0.3)


def the_same_seed_gives_the_same_case_and_its_truth():
    for kind in "abcde":
        first, again = generate.make(11, 3, kind), generate.make(11, 3, kind)
        assert np.array_equal(first.record.counts, again.record.counts)
        assert json.dumps(first.truth, default=write.plain) == json.dumps(again.truth, default=write.plain)


def the_log_holds_what_the_truth_says():
    with tempfile.TemporaryDirectory() as folder:
        for name in ("eccentricity", "latency", "drift"):
            case = generate.make(4, 0, "b", name)
            write.case_files(case, pathlib.Path(folder) / name)
            log = read_log(pathlib.Path(folder) / name / "log.csv")
            for j, known in case.truth["gain"]["joints"].items():
                unit = case.robot.unit(case.robot.joints.index(j))
                if case.coupling is None and case.reference != "tip":
                    e = log[f"{j}.counts"] * case.truth["resolution"][j] - log[f"{j}.reference [{unit}]"]
                    near(np.sqrt(np.mean(e**2)), known["rms_before"], 0.002)


def answers_are_scored_as_written():
    truth = {"kind": "b", "sub": "backlash", "reference": "joints", "tolerated": [{"effect": "offset", "joint": "j"}],
             "effects": [{"effect": "backlash", "joint": "j", "amplitude_counts": 2, "also_accept": [],
                          "parameters": [{"name": "gap", "values": [1e-3], "unit": "rad", "aliases": ["width"]}]}],
             "gain": {"joints": {"j": {"rms_before": 2.0, "rms_after": 1.0, "ratio": 2.0}}, "all_joints": {"ratio": 2.0}}}
    cause = {"effect": "backlash", "joint": "j", "gain": {"rms_before": 2.0, "rms_after": 1.0},
             "parameters": [{"name": "gap", "lower": 0.9e-3, "upper": 1.1e-3}]}
    good = score(truth, {"verdict": "explained", "causes": [{"effect": "offset", "joint": "j"}, cause], "gain": {"ratio": 1.9}})
    assert good["right"] and good["first_right"] and good["intervals"][0][3] and abs(good["gain"] - 0.95) < 1e-12
    for other in ({**cause, "joint": "k"}, {**cause, "effect": "latency"}):
        assert not score(truth, {"verdict": "explained", "causes": [other]})["right"]
    assert not score(truth, {"verdict": "explained", "causes": [cause, {"effect": "drift", "joint": "j"}]})["right"]
    ambiguous = {"verdict": "ambiguous", "causes": [{"effect": "latency", "joint": "j"}],
            "alternatives": [{"instead_of": "latency", "effect": "backlash", "joint": "j"}]}
    assert score(truth, ambiguous)["right"]
    assert not score(truth, {**ambiguous, "verdict": "explained"})["right"]
    assert not score(truth, {"verdict": "nothing_wrong"})["right"]
    narrow = {**cause, "parameters": [{"name": "width", "lower": 1.01e-3, "upper": 1.1e-3}]}
    assert not score(truth, {"verdict": "explained", "causes": [narrow]})["intervals"][0][3]
    clean = {"kind": "a", "sub": "stops", "effects": [], "tolerated": []}
    assert not score(clean, {"verdict": "nothing_wrong", "causes": [{"effect": "slow_motion"}]})["false_alarm"]
    assert score(clean, {"verdict": "unexplained"})["false_alarm"]
    pair = {"kind": "e", "sub": "p", "effects": truth["effects"], "tolerated": [], "pair": [["backlash", "latency"]]}
    assert score(pair, ambiguous)["right"] and score(pair, {"verdict": "ambiguous", "causes": [cause]})["right"]
    assert not score(pair, {"verdict": "explained", "causes": [cause]})["right"]
    foreign = {"kind": "d", "sub": "f", "tolerated": [], "effects": [
        {"effect": "outside:f", "joint": "j", "also_accept": [{"effect": "transmission_error", "orders": [7.3], "tolerance": 0.01}]}]}
    named = lambda order: {"verdict": "explained", "causes": [{"effect": "transmission_error", "joint": "j",
                                                               "parameters": [{"name": "order", "value": order}]}]}
    assert not score(foreign, named(7.31))["misnamed"] and score(foreign, named(7))["misnamed"]
    near(binomial_upper(0, 60), 1 - 0.05 ** (1 / 60), 1e-9)


CHECKS = [the_controllers_velocity_is_right_at_constant_speed, the_same_seed_gives_the_same_case_and_its_truth,
          the_log_holds_what_the_truth_says, answers_are_scored_as_written]

if __name__ == "__main__":
    sys.exit(1 if run(CHECKS) else 0)
