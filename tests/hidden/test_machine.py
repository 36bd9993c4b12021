#!/usr/bin/python3
"""Compares the machines of the generator with formulas derived by hand.

usage: test_machine.py [--shared DIR]     DIR/hidden_examples is skipped, saying so, when absent
"""
import argparse
import json
import math
import pathlib
import sys

import numpy as np

import motions
from encoders import Encoder
from machine import Effect, Machine, play
from robots import SHAPES, random_robot, rotation_about

STEP = 2 * math.pi / (4096 * 20)


def one_joint(effects=(), flaws=None, kind="counts", payload=0.0, **more):
    robot = random_robot(np.random.default_rng(5), "swing_arm")
    encoder = Encoder(kind, 20.0, 4096, flaws=flaws or {}, **more)
    return Machine(robot, [encoder], effects, payload=payload)


def waves(duration=4.0, rows=40000):
    return motions.Paths([motions.Sines(0.2, [(0.5, 0.4, 0.3), (0.07, 1.7, 1.0)])]), np.linspace(0, duration, rows)


def error(machine, paths=None, t=None, seed=0):
    if paths is None:
        paths, t = waves()
    r = machine.record(paths, t, np.random.default_rng(seed))
    return (r.measured - r.reference)[0], r


def near(x, wanted, relative=0.02, absolute=0.0):
    assert abs(x - wanted) <= relative * abs(wanted) + absolute, f"found {x}, expected {wanted}"


def an_ideal_encoder_rounds_to_the_nearest_count():
    e, r = error(one_joint())
    assert np.array_equal(r.counts[0], np.floor(r.link[0] / STEP + 0.5))
    near(np.sqrt(np.mean(e**2)), STEP / math.sqrt(12))
    assert np.array_equal(r.model, r.link)
    for kind in ("counts", "sincos"):
        down, _ = error(one_joint(kind=kind, rounding="down"))
        near(down.mean(), -STEP / 2)
    near(error(one_joint(flaws={"truncation": True}))[0].mean(), -STEP / 2)


def effects_of_no_size_leave_the_ideal_log():
    ideal = error(one_joint())[1].counts
    nothing = [Effect("offset", 0, {"offset": 0.0}), Effect("scale", 0, {"scale": 0.0}), Effect("backlash", 0, {"gap": 0.0}),
               Effect("latency", 0, {"delay": 0.0}), Effect("timing_jitter", 0, {"sigma": 0.0}),
               Effect("compliance", 0, {"compliance": 0.0}), Effect("clock_drift", 0, {"rate": 0.0}),
               Effect("noise", 0, {"sigma": 0.0}), Effect("drift", 0, {"amplitude": 0.0, "time_constant": 1.0}),
               Effect("transmission_error", 0, {"amplitude": 0.0, "phase": 1.0, "order": 2}),
               Effect("missed_counts", 0, {"times": [1.0], "counts": [0]}), Effect("rollover", 0, {"modulus": 2**40})]
    for e in nothing:
        assert np.array_equal(error(one_joint([e]))[1].counts, ideal), e.name
    for flaws in ({"eccentricity": (0.0, 1.0)}, {"quadrature": 0.0}, {"duty": (0.0, 0.0)}, {"counts_every": 1}):
        assert np.array_equal(error(one_joint(flaws=flaws, kind="lines"))[1].counts, ideal), flaws
    heydemann = {"offset_sin": 0.0, "offset_cos": 0.0, "gain": 0.0, "phase": 0.0}
    fine = error(one_joint(flaws={"heydemann": heydemann}, kind="sincos", periods=1, bits=12))[1].counts
    assert np.mean(fine != ideal) < 1e-6


def an_eccentric_disc_has_the_series_of_its_arctangent():
    """atan2(e sin u, 1 - e cos u) = sum_k e^k sin(k u)/k, at the joint over the gear ratio."""
    e, phase, gear = 0.2, 0.7, 20.0
    x = np.linspace(-1, 1, 999)
    u = gear * x + phase
    series = sum(e**k / k * np.sin(k * u) for k in range(1, 60)) / gear
    seen = Encoder("counts", gear, 4096, flaws={"eccentricity": (e, phase)}).on_disc(x)
    assert np.abs(seen - x - series).max() < 1e-14


def a_late_channel_widens_every_second_state():
    """States of 1 + s and 1 - s counts: mean -s/2, variance 1/12 + s^2/4."""
    s = 0.4
    e = error(one_joint(flaws={"quadrature": s * 2 * math.pi / 4}, kind="lines"))[0] / STEP
    near(e.mean(), -s / 2)
    near(e.var(), 1 / 12 + s * s / 4)


def sine_and_cosine_err_as_heydemann_says():
    """o cos u, g/2 sin 2u, f/2 (1 + cos 2u) for small offset of the sine, gain and phase.

    Clipped at c the error atan(sin u/c) - u is largest where cos^2 u + c cos u = 1 + c^2: 8.16 degrees at 0.647."""
    u = np.linspace(0, 2 * np.pi, 3600, endpoint=False)
    make = lambda f: Encoder("sincos", 1.0, 2.0**20, 1, 20, flaws={"heydemann": f}).interpolated(u) - u
    d = 1e-4
    for flaw, formula in [("offset_sin", d * np.cos(u)), ("offset_cos", -d * np.sin(u)), ("gain", d / 2 * np.sin(2 * u)),
                          ("phase", d / 2 * (1 + np.cos(2 * u)))]:
        assert np.abs(make({flaw: d}) - formula).max() < 3 * d * d, flaw
    clipped = make({"clipping": 0.647})
    clipped -= 2 * np.pi * np.round(clipped / (2 * np.pi))
    c = 0.647
    worst = math.acos((math.sqrt(c * c + 4 * (1 + c * c)) - c) / 2)
    near(clipped.max(), math.atan(math.sin(worst) / c) - worst, 1e-4)


def a_gap_is_crossed_before_the_link_moves():
    gap = 1.0
    motor = np.concatenate([[0, 0, 0.3, 0.5, 2.0], [2.0, 2.0], [1.6, 1.0, -3.0]])
    assert np.allclose(play(motor, gap), [0, 0, 0, 0, 1.5, 1.5, 1.5, 1.5, 1.5, -2.5])


def backlash_keeps_its_side_at_rest_and_leads_the_motion():
    gap = 6 * STEP
    path = motions.Pieces(0.0)
    for to in (0.2, 0.0):
        path.rest(0.2)
        path.move(to, 0.5, 0.1)
    path.rest(1.0)
    t = np.linspace(0, 2.0, 20000)
    e, r = error(one_joint([Effect("backlash", 0, {"gap": gap})]), motions.Paths([path]), t)
    v = np.gradient(r.link[0], t)
    near(e[v > 0.1].mean(), gap / 2)
    near(e[v < -0.1].mean(), -gap / 2)
    assert abs(e[t < 0.19]).max() < 0.51 * STEP              # starts at mid-gap
    assert (e[(t > 0.72) & (t < 0.88)] > gap / 2 - 0.51 * STEP).all()  # at rest after the first move: still leading
    assert (e[t > 1.8] < -gap / 2 + 0.51 * STEP).all()


def clocks_shift_by_speed():
    """-v d for a delay; rate t v for a clock that runs fast; jitter of rms sigma v."""
    t, speed = np.linspace(0, 4, 20000), 0.3
    path = motions.Paths([motions.constant_speed(-0.2, speed)])
    near(error(one_joint([Effect("latency", 0, {"delay": 1e-3})]), path, t)[0].mean(), -speed * 1e-3, absolute=0.03 * STEP)
    e = error(one_joint([Effect("clock_drift", 0, {"rate": 1e-3})]), path, t)[0]
    near(e @ t / (t @ t), speed * 1e-3)
    e = error(one_joint([Effect("timing_jitter", 0, {"sigma": 1e-3})]), path, t)[0]
    near(e.var(), STEP**2 / 12 + (speed * 1e-3) ** 2, 0.04)
    e = error(one_joint([Effect("noise", 0, {"sigma": 2 * STEP})]))[0]
    near(e.var(), STEP**2 / 12 + 4 * STEP**2, 0.04)


def slow_and_constant_errors_follow_their_formulas():
    e = error(one_joint([Effect("drift", 0, {"amplitude": 20 * STEP, "time_constant": 1.0})]))[0]
    near(e[9995:10005].mean(), 20 * STEP * (1 - math.exp(-1)), absolute=0.3 * STEP)
    near(error(one_joint([Effect("offset", 0, {"offset": 3.3 * STEP})]))[0].mean(), 3.3 * STEP)
    e, r = error(one_joint([Effect("scale", 0, {"scale": 1e-3})]))
    near(e @ r.link[0] / (r.link[0] @ r.link[0]), 1e-3)
    e, r = error(one_joint([Effect("transmission_error", 0, {"amplitude": 5 * STEP, "phase": 0.4, "order": 2})]))
    near(2 * np.mean(e * np.sin(40 * r.link[0] + 0.4)), 5 * STEP, 0.1)


def a_decoder_can_lose_wrap_and_miss_edges():
    e, r = error(one_joint([Effect("missed_counts", 0, {"times": [1.0, 2.0], "counts": [3, -5]})]))
    t = r.time
    for part, lost in ((t < 1, 0), ((t > 1) & (t < 2), 3), (t > 2, -2)):
        near(e[part].mean(), lost * STEP, absolute=0.02 * STEP)
    assert [c for _, c in r.events["swing"]] == [3, -5]
    r = error(one_joint([Effect("rollover", 0, {"modulus": 4096})]))[1]
    assert r.counts.min() >= -2048 and r.counts.max() < 2048
    ideal = error(one_joint())[1].counts
    assert ((r.counts - ideal) % 4096 == 0).all() and (r.counts != ideal).any()
    for every in (2, 4):
        e, r = error(one_joint(flaws={"counts_every": every}, kind="lines"))
        assert np.abs(r.counts - ideal / every).max() <= 1
        near(np.std((r.measured - r.model)[0]), STEP / math.sqrt(12))
        near(np.std(r.unexpected[0]), every * STEP / math.sqrt(12))


def loads_do_the_work_that_changes_the_energy():
    """sum tau qdot = d(kinetic + potential)/dt for every shape of robot, with a payload."""
    rng, h, t = np.random.default_rng(3), 1e-4, np.linspace(0.0, 1.0, 21)
    for shape in SHAPES:
        robot = random_robot(rng, shape)
        paths = motions.rich(rng, robot, 3.0, "sines")

        def energy(t):
            def bodies(t):
                rotation, position = np.broadcast_to(np.eye(3), (len(t), 3, 3)), np.zeros((len(t), 3))
                for i, (turn, origin) in enumerate(robot._links(paths.at(t)[0])):
                    position = position + np.einsum("tij,tj->ti", rotation, origin)
                    rotation = rotation @ turn
                    yield i, robot.mass[i], position + rotation @ robot.centre[i], rotation
                yield None, 1.7, position + rotation @ robot.tool, rotation
            total = 0.0
            for (i, mass, before, r0), (_, _, now, r1), (_, _, after, r2) in zip(bodies(t - h), bodies(t), bodies(t + h)):
                speed = (after - before) / (2 * h)
                total = total + mass * (np.sum(speed**2, axis=1) / 2 + 9.80665 * now[:, 2])
                if i is not None:
                    spin = np.swapaxes(r1, 1, 2) @ (r2 - r0) / (2 * h)
                    omega = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)
                    total = total + np.sum(omega**2 * robot.inertia[i], axis=1) / 2
            return total
        q, v, a = paths.at(t)
        power = np.sum(robot.effort(q, v, a, 1.7) * v, axis=0)
        change = (energy(t + 1e-3) - energy(t - 1e-3)) / 2e-3
        assert np.abs(power - change).max() < 2e-3 * np.abs(power).max() + 1e-3, shape


def compliance_follows_the_load():
    c = 1e-4
    machine = one_joint([Effect("compliance", 0, {"compliance": c})], payload=2.0)
    paths, t = waves()
    e, r = error(machine, paths, t)
    load = machine.robot.effort(*paths.at(t), 2.0)[0]
    near((e - e.mean()) @ (load - load.mean()) / np.sum((load - load.mean()) ** 2), c)


def a_longer_link_moves_the_tip_along_it():
    robot = random_robot(np.random.default_rng(2), "two_links")
    q = np.array([[0.3, -0.9], [0.4, 1.1]])
    moved = robot.lengthened(1, "x", 0.002).tip(q) - robot.tip(q)
    along = rotation_about(robot.axis[0], q[0]) @ [0.002, 0, 0]
    assert np.allclose(moved, along, atol=1e-15)


def an_encoder_behind_a_differential_errs_on_both_joints():
    robot = random_robot(np.random.default_rng(2), "two_links")
    encoders = [Encoder("counts", 20.0, 4096), Encoder("counts", 20.0, 4096)]
    m = Machine(robot, encoders, [Effect("offset", 0, {"offset": 10 * STEP})], [[1, 0], [1, 1]])
    paths = motions.rich(np.random.default_rng(1), robot, 4.0, "sines")
    r = m.record(paths, np.linspace(0, 4, 20000), np.random.default_rng(0))
    for j in (0, 1):
        near((r.measured - r.reference)[j].mean(), 10 * STEP)


def motions_are_the_integrals_of_their_derivatives():
    rng, t, h = np.random.default_rng(8), np.linspace(0.1, 3.9, 4001), 1e-6
    for path in (motions.multisine(rng, 0.1, 4.0), motions.stops(rng, 0.1, 4.0, jerk_share=0.3),
                 motions.stops(rng, 0.1, 4.0, jerk_share=0.0), motions.triangle(rng, 0.1, 4.0)):
        ahead, behind, (_, v, a) = path.at(t + h), path.at(t - h), path.at(t)
        assert np.abs((ahead[0] - behind[0]) / (2 * h) - v).max() < 0.01 * np.abs(v).max()
        assert np.median(np.abs((ahead[1] - behind[1]) / (2 * h) - a)) < 1e-3 * (1 + np.abs(a).max())
    _, v, _ = motions.triangle(rng, 0.0, 4.0, reach=0.5, turns=5).at(t)
    assert (np.abs(np.abs(v) - 1.25) < 1e-9).mean() > 0.99


def read_log(path):
    lines = [line for line in open(path, encoding="utf-8") if not line.startswith("#")]
    columns = np.array([[float(x) for x in line.split(",")] for line in lines[1:]]).T
    return dict(zip(lines[0].strip().split(","), columns))


def the_examples_have_the_same_signs(folder):
    def shape(name, effect_of):
        truth = json.loads((folder / name / "truth.json").read_text(encoding="utf-8"))
        log, e = read_log(folder / name / "log.csv"), truth["effects"][0]
        j = e["joint"]
        q = log[f"{j}.reference [rad]"]
        return effect_of(log, q, log[f"{j}.counts"] * truth["resolution"][j] - q, e["physical"], truth["resolution"][j], j)

    def eccentric(log, q, e, p, step, j):
        u = 10 * q  # gear ratio 10
        model = np.arctan2(p["ecc"] * np.sin(u + p["phase"]), 1 - p["ecc"] * np.cos(u + p["phase"])) / 10
        near(np.std(e - model), step / math.sqrt(12), 0.05)

    def gap(log, q, e, p, step, j):
        moving = np.gradient(q)
        near(e[moving > step].mean(), p["gap"] / 2, 0.02)
        near(e[moving < -step].mean(), -p["gap"] / 2, 0.02)

    def delay(log, q, e, p, step, j):
        v = np.gradient(q, log["time [s]"])
        near(e @ v / (v @ v), -p["delay"], 0.03)

    def load(log, q, e, p, step, j):
        f = log[f"{j}.effort [N m]"]
        near(np.polyfit(f, e, 1)[0], p["c"], 0.03)
    for name, check in (("eccentricity", eccentric), ("backlash", gap), ("latency", delay), ("compliance", load)):
        shape(name, check)


def run(checks):
    """Runs functions without arguments; returns the number of failures."""
    failed = 0
    for check in checks:
        try:
            check()
            print(f"ok    {check.__name__}")
        except AssertionError as wrong:
            failed += 1
            line = wrong.__traceback__
            while line.tb_next:
                line = line.tb_next
            print(f"FAIL  {check.__name__}, line {line.tb_lineno}: {wrong}")
    print(f"{len(checks) - failed} passed, {failed} failed")
    return failed


CHECKS = [an_ideal_encoder_rounds_to_the_nearest_count, effects_of_no_size_leave_the_ideal_log,
          an_eccentric_disc_has_the_series_of_its_arctangent, a_late_channel_widens_every_second_state,
          sine_and_cosine_err_as_heydemann_says, a_gap_is_crossed_before_the_link_moves,
          backlash_keeps_its_side_at_rest_and_leads_the_motion, clocks_shift_by_speed,
          slow_and_constant_errors_follow_their_formulas, a_decoder_can_lose_wrap_and_miss_edges,
          loads_do_the_work_that_changes_the_energy, compliance_follows_the_load,
          a_longer_link_moves_the_tip_along_it, an_encoder_behind_a_differential_errs_on_both_joints,
          motions_are_the_integrals_of_their_derivatives]


def main():
    a = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    a.add_argument("--shared", type=pathlib.Path,
                   default=pathlib.Path(__file__).resolve().parents[3] / "shared", help="where hidden_examples lies")
    examples = a.parse_args().shared / "hidden_examples"

    def the_examples_of_others_have_the_same_signs():
        the_examples_have_the_same_signs(examples)
    if examples.is_dir():
        return 1 if run([*CHECKS, the_examples_of_others_have_the_same_signs]) else 0
    print(f"skip  the_examples_of_others_have_the_same_signs: no {examples}")
    return 1 if run(CHECKS) else 0


if __name__ == "__main__":
    sys.exit(main())
