"""The expected output of `analyze` for a case (cases.py), computed independently of qerr."""
import itertools

import numpy as np

import filters
from robot import rotation_vector

ANGULAR = ("rx", "ry", "rz", "roll", "pitch", "yaw")


def statistics(values):
    p = np.percentile(values, [50, 95, 99])
    return {"min": values.min(), "mean": values.mean(), "max": values.max(), "p50": p[0], "p95": p[1], "p99": p[2]}


def expected(case):
    chain, points = case.chain, case.points
    delta, down = case.delta, case.down
    coupling = np.array(case.coupling) if case.coupling is not None else np.eye(len(delta))
    motion = chain.jacobian(points, case.coordinates) @ coupling
    half = 0.5 * np.abs(motion) @ delta
    mean = np.abs(-0.5 * (motion @ (delta * down)))
    variance = motion**2 * (delta**2 / 12)
    total = variance.sum(axis=2)
    sigma = np.sqrt(total)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(total[:, :, None] > 0, variance / total[:, :, None], 0)
    joint_half = 0.5 * np.abs(coupling) @ delta
    joint_mean = np.abs(-0.5 * coupling @ (delta * down))
    result = {
        "coupling": coupling, "half": half, "mean": mean, "worst": half + mean, "sigma": sigma, "share": share,
        "joint_worst": joint_half + joint_mean,
        "joint_half": joint_half, "joint_mean": joint_mean,
        "joint_sigma": np.sqrt(coupling**2 @ (delta**2 / 12)),
        "derivatives": {},
    }
    for name, f in case.filters.items():
        h2, l1 = filters.norms(f)
        dc = filters.dc_gain(f)
        result["derivatives"][name] = {
            "h2": h2, "l1": l1, "dc": dc, "worst": l1 * half + abs(dc) * mean, "sigma": h2 * sigma}
    groups = np.array([c in ANGULAR for c in case.coordinates])
    result["scale"] = np.zeros(len(groups))
    reach = max(case.chain.reach(points), 1e-3)
    angle = float(delta @ np.array([u == "rad" for u in chain.units])) + 1e-300
    travel = float(delta @ np.array([u == "m" for u in chain.units]))
    result["scale"][groups] = angle
    result["scale"][~groups] = angle * reach + travel
    return result


def rigorous_ceiling(case):
    """An upper bound of the second-order remainder, above which a rigorous bound would be useless."""
    coupling = np.array(case.coupling) if case.coupling is not None else np.eye(len(case.delta))
    width = np.abs(coupling) @ case.delta
    spin = travel = 0.0
    for joint in case.chain.joints:
        if joint.kind != "fixed":
            index, factor, _ = case.chain.terms[joint.name]
            if joint.kind == "prismatic":
                travel += abs(factor) * width[index]
            else:
                spin += abs(factor) * width[index]
    reach = case.chain.reach(case.points) + travel
    return np.array([2 * spin**2 if c in ANGULAR else 2 * (reach * spin + travel) * spin for c in case.coordinates])


def box_errors(case, interior=64, seed=5):
    """Largest |error| per configuration and coordinate over all corners and some interior points of the quantization box."""
    n = len(case.delta)
    coupling = np.array(case.coupling) if case.coupling is not None else np.eye(n)
    low = np.where(case.down > 0, -case.delta, -case.delta / 2)
    high = np.where(case.down > 0, 0, case.delta / 2)
    corners = np.array(list(itertools.product(*zip(low, high))))
    inside = low + (high - low) * np.random.default_rng(seed).random((interior, n))
    shifts = np.vstack([corners, inside]) @ coupling.T
    worst = np.zeros((len(case.points), len(case.coordinates)))
    for i, q in enumerate(case.points):
        p0, r0 = case.chain.pose(q[None, :])
        p1, r1 = case.chain.pose(q[None, :] + shifts)
        turn = rotation_vector(r1 @ r0[0].T)
        table = dict(zip(("x", "y", "z"), (p1 - p0).T)) | dict(zip(("rx", "ry", "rz"), turn.T))
        for k, coordinate in enumerate(case.coordinates):
            if coordinate in table:
                worst[i, k] = np.abs(table[coordinate]).max()
    return worst
