"""The record of a machine with hidden effects: planned path -> gear -> disc -> edges -> decoder -> log. Physics, no regressors.

Signs, as the contract has them: measured - reference is +A sin(order shaft + phase) of an eccentric disc with A = e/gear at the
joint, +-gap/2 on the side of the last motion, +compliance effort, q(t - delay) - q(t), q(t + rate t) - q(t).
"""
from dataclasses import dataclass, field

import numpy as np

FINE = 8  # steps of the play operator per sample


def play(motor, gap, start=None):
    """Play operator: the link does not move until the motor has crossed the gap.

    link_k = clip(link_(k-1), motor_k - gap/2, motor_k + gap/2): exact between two turning points. Starts mid-gap.
    """
    link = np.empty_like(motor)
    at, half = motor[0] if start is None else start, gap / 2
    for k, m in enumerate(motor):
        at = min(max(at, m - half), m + half)
        link[k] = at
    return link


@dataclass
class Effect:
    """name: as in the contract, or 'outside:...'; joint: index; p: physical parameters, at the joint, SI."""
    name: str
    joint: int
    p: dict = field(default_factory=dict)


@dataclass
class Record:
    """The content of the log, and quantities known to the generator only (`link`, `model`). Arrays are (joints, samples)."""
    time: np.ndarray
    counts: np.ndarray
    measured: np.ndarray      # C counts resolution, or its value rounded in the log
    reference: np.ndarray
    effort: np.ndarray
    link: np.ndarray
    model: np.ndarray         # measured without quantization and noise: the expectation of the true model
    velocity: np.ndarray
    tip: np.ndarray           # (samples, 3), of the machine as it was built, with the tracker's noise
    events: dict = field(default_factory=dict)
    unexpected: np.ndarray = None  # residual of the true model


class Machine:
    def __init__(self, robot, encoders, effects=(), coupling=None, reference_noise=None, payload=0.0, tip_noise=0.0):
        n = len(robot.joints)
        self.robot, self.encoders, self.effects = robot, encoders, list(effects)
        self.coupling = np.eye(n) if coupling is None else np.array(coupling, float)
        self.reference_noise = np.zeros(n) if reference_noise is None else reference_noise
        self.payload, self.tip_noise = payload, tip_noise
        self.as_built = robot
        for e in self.of("geometry"):
            self.as_built = self.as_built.lengthened(e.joint, e.p["axis"], e.p["length"])

    def of(self, name, joint=None):
        return [e for e in self.effects if e.name == name and joint in (None, e.joint)]

    @property
    def resolution(self):
        """Resolutions of the encoders, at the joint side."""
        return np.array([e.resolution for e in self.encoders])

    # -- from the plan to the shafts -----------------------------------------------------------------------------------
    def link(self, paths, t):
        """The links' true angles: the plan after the play operator."""
        q = paths.at(t)[0]
        for e in self.of("backlash"):
            grid = np.linspace(t[0], t[-1], FINE * (len(t) - 1) + 1)
            plan = paths.joints[e.joint].at(grid)[0]
            start = plan[0] - e.p.get("side", 0) * e.p["gap"] / 2  # mid-gap unless the record starts at one side
            q[e.joint] = np.interp(t, grid, play(plan, e.p["gap"], start))
        return q

    def clock(self, joint, t, rng=None):
        """The instants at which the encoder of this joint is sampled."""
        when = t.copy()
        for e in self.of("clock_drift", joint):
            when = when + e.p["rate"] * t
        for e in self.of("latency", joint):
            when = when - e.p["delay"]
        for e in self.of("timing_jitter", joint):
            if rng is not None:
                when = when + e.p["sigma"] * rng.standard_normal(len(t))
        return when

    def motor(self, paths, t, rng=None):
        """Angles at the motor side of link and gear, scaled to the joint."""
        n = len(self.encoders)
        out = np.empty((n, len(t)))
        for j in range(n):
            when = self.clock(j, t, rng)
            mine = [e for e in self.effects if e.joint == j]
            angle = None  # of the gear, without its own errors: its orders are one Fourier series
            out[j] = paths.joints[j].at(when)[0]
            q, v, a = paths.at(when) if any(e.name == "compliance" or "outside" in e.name for e in mine) else (0, 0, 0)
            for e in mine:
                if e.name == "compliance":
                    out[j] += e.p["compliance"] * self.robot.effort(q, v, a, self.payload)[j]
                elif e.name.startswith("outside:"):
                    effort = self.robot.effort(q, v, a, self.payload)[j]
                    out[j] += e.p["shape"](when, q[j], v[j], effort)
                elif e.name == "transmission_error":
                    turn = 1.0 if e.p.get("shaft") == "joint" else self.encoders[j].to_shaft
                    angle = out[j] + 0.0 if angle is None else angle
                    out[j] = out[j] + e.p["amplitude"] * np.sin(e.p["order"] * turn * angle + e.p["phase"])
                elif e.name == "controller_droop":
                    out[j] += e.p["droop"](when)
        return out

    def at_disc(self, i, x, t):
        """Slow and constant errors of encoder i's zero, and its wrong gear ratio."""
        for e in self.effects:
            if e.joint != i:
                continue
            if e.name == "offset":
                x = x + e.p["offset"]
            elif e.name == "scale":
                x = x * (1 + e.p["scale"])
            elif e.name == "drift":
                x = x - e.p["amplitude"] * np.expm1(-t / e.p["time_constant"])
        return x

    # -- counting ------------------------------------------------------------------------------------------------------
    def decoded(self, i, counts, t):
        """Counts lost or gained, and a counter that wraps; (counts, added counts)."""
        out = counts.copy()
        for e in self.of("missed_counts", i):
            for when, lost in zip(e.p["times"], e.p["counts"]):
                out = out + lost * (t >= when)
        for e in self.of("rollover", i):
            m = int(e.p["modulus"])
            out = (out + m // 2) % m - m // 2
        return out, out - counts

    def record(self, paths, t, rng, stamps=None):
        """Samples all signals at the instants t; `stamps` are the times in the log."""
        n, step = len(self.encoders), self.resolution
        to_encoders = np.linalg.inv(self.coupling)
        expected, real = to_encoders @ self.motor(paths, t), to_encoders @ self.motor(paths, t, rng)
        counts, model = np.empty((n, len(t)), np.int64), np.empty((n, len(t)))
        events = {}
        for i, encoder in enumerate(self.encoders):
            noise = sum(e.p["sigma"] for e in self.of("noise", i)) * rng.standard_normal(len(t))
            counts[i] = encoder.count(self.at_disc(i, real[i], t), noise)
            model[i] = encoder.apparent(self.at_disc(i, expected[i], t))
            counts[i], added = self.decoded(i, counts[i], t)
            model[i] += added * step[i]
            events[self.robot.joints[i]] = [(float(t[k + 1]), int(added[k + 1] - added[k]))
                                            for k in np.flatnonzero(np.diff(added))]
        link, (q, v, a) = self.link(paths, t), paths.at(t)
        reference = link + self.reference_noise[:, None] * rng.standard_normal((n, len(t)))
        measured = self.coupling @ (counts * step[:, None])
        # A count that represents several edges has the uncertainty of all of them.
        coarser = np.array([e.flaws.get("counts_every", 1) for e in self.encoders])
        unknown = self.coupling @ ((coarser - 1)[:, None] * (counts * step[:, None] - model))
        model = self.coupling @ model
        expected_reference = link.copy()
        for e in self.of("reference_error"):
            wave = e.p["amplitude"] * np.sin(e.p["order"] * link[e.joint] + e.p["phase"])
            reference[e.joint] += wave
            expected_reference[e.joint] += wave
        for e in self.of("log_rounding"):
            measured[e.joint] = np.round(measured[e.joint] / e.p["step"]) * e.p["step"]
        effort = self.robot.effort(q, v, a, self.payload)
        effort = effort + 0.01 * effort.std(axis=1, keepdims=True) * rng.standard_normal(effort.shape)
        tip = self.as_built.tip(link) + self.tip_noise * rng.standard_normal((len(t), 3))
        return Record(t if stamps is None else stamps, counts, measured, reference, effort, link, model, v, tip,
                      {j: e for j, e in events.items() if e},
                      measured - reference - (model - expected_reference) + unknown)

    def gain(self, record):
        """rms of measured - reference (mean included) before and after subtracting the true model, per joint and over all."""
        def figures(before, after):
            b, a = (float(np.sqrt(np.mean(np.square(x)))) for x in (before, after))
            return {"rms_before": b, "rms_after": a, "ratio": b / a if a > 0 else None}
        before, after = record.measured - record.reference, record.unexpected
        out = {"samples": len(record.time),
               "joints": {j: figures(before[i], after[i]) for i, j in enumerate(self.robot.joints)},
               "all_joints": figures(before, after)}
        if self.tip_noise:
            taken = record.measured - (record.model - record.link)
            out["tip"] = figures(self.robot.tip(record.measured) - record.tip, self.as_built.tip(taken) - record.tip)
        if record.events:
            out["events"] = {j: [{"time": t, "counts": c} for t, c in e] for j, e in record.events.items()}
        return out
