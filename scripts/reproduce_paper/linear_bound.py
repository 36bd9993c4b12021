"""Sec. IV-B: the linearization remainder of (17), and the dependence of sigma on the quantization intervals."""
import csv
import itertools
import math
import pathlib
import tempfile

import numpy as np

import independent
from claims import LOOSE, Claim, confirmed_if, number
from tool import write_csv

SPEC = "configs/planar_prr/spec.yaml"
RESOLUTIONS = np.array([1e-4, 2 * math.pi / 1e4, 2 * math.pi / 1e4])


def vertices(qerr, out):
    """Compares the exact error at the corners of the quantization box with qerr's bounds."""
    command = qerr("analyze", SPEC, set={"configurations.count": 2000})
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "points.csv"
        command.text("--per-configuration", str(path))
        with path.open(newline="") as stream:
            points = list(csv.DictReader(stream))
    joints = np.array(
        [[float(p["rail [m]"]), float(p["shoulder [rad]"]), float(p["elbow [rad]"])] for p in points]
    )
    largest = np.zeros((len(points), 2))
    for signs in itertools.product((-0.5, 0.5), repeat=3):
        moved = joints + np.array(signs) * RESOLUTIONS
        error = (independent.prr_tip(*moved.T) - independent.prr_tip(*joints.T)).T
        largest = np.maximum(largest, np.abs(error))
    linear = np.array([[float(p[f"{c}.worst_case [m]"]) for c in "xy"] for p in points])
    rigorous = np.array([[float(p[f"{c}.worst_case_rigorous [m]"]) for c in "xy"] for p in points])
    above = (largest > linear * (1 + 1e-9)).mean()
    excess = np.median(largest / linear - 1)
    broken = int((largest > rigorous * (1 + 1e-9)).sum())
    write_csv(
        out / "linear_bound.csv",
        [
            "rail [m]",
            "shoulder [rad]",
            "elbow [rad]",
            "exact_x [m]",
            "linear_x [m]",
            "rigorous_x [m]",
            "exact_y [m]",
            "linear_y [m]",
            "rigorous_y [m]",
        ],
        [
            [*map(float, q), *(float(v) for c in (0, 1) for v in (e[c], b[c], r[c]))]
            for q, e, b, r in zip(joints, largest, linear, rigorous)
        ],
    )
    return Claim(
        "(17)",
        "Worst-case bound in operational space",
        "a bound",
        (
            f"PRR, 2000 configurations, corners of the quantization box: exceeded in {number(100 * above)} %,"
            f" median excess {number(100 * excess, 2)} %; with qerr's second-order remainder exceeded in"
            f" {broken}"
        ),
        LOOSE if above > 0 and excess < 0.01 else confirmed_if(above == 0),
        "The bound of the linearized kinematics, not of the kinematics",
    )


def intervals(qerr, out):
    """sigma_x with all intervals halved, and with one of them halved."""

    def sigma(**resolutions):
        overrides = {f"encoders.{name}": f"{{resolution: {value}}}" for name, value in resolutions.items()}
        overrides["configurations"] = "{method: list, points: [[0, 0.2, 1.9]]}"
        command = qerr("analyze", SPEC, set=overrides)
        return command.json()["position"][0]["sigma"]["max"]

    rail, turn = 1e-4, 2 * math.pi / 1e4
    whole = sigma(rail=rail, shoulder=turn, elbow=turn)
    halves = sigma(rail=rail / 2, shoulder=turn / 2, elbow=turn / 2)
    one = sigma(rail=rail, shoulder=turn / 2, elbow=turn)
    linear_in_all = abs(halves / whole - 0.5) < 1e-9
    return Claim(
        "Sec. V-B",
        "sigma_x is linear in all the quantization intervals; half the intervals, half the sigma",
        "1/2",
        f"all halved: {number(halves / whole, 4)} sigma_x; one halved: {number(one / whole, 4)}",
        LOOSE if linear_in_all else "wrong",
        "Homogeneous of degree 1 in all together; linear in none of them alone (a root of a sum of squares)",
    )
