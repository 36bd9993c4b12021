"""The specs of the acceptance run: public robots from ../shared if present, and the robots of the corpus."""
import math
import pathlib

import numpy as np

from robot import Chain, cos_pitch

CORPUS = pathlib.Path(__file__).resolve().parent.parent / "corpus"
UNITS = {"m": 1, "mm": 1e-3, "um": 1e-6, "rad": 1, "mrad": 1e-3, "deg": math.pi / 180, "arcmin": math.pi / 10800,
         "Hz": 1, "kHz": 1e3}
DECODING = {"x1": 1, "x2": 2, "x4": 4}

FO = {"derivative": 1, "sample_rate": "1 kHz", "lowpass": {"family": "first_order", "order": 2, "cutoff": "50 Hz"}}


def first_order(discretization, derivative=1, order=1, rate="1 kHz", cutoff="50 Hz"):
    low = {"family": "first_order", "order": order, "cutoff": cutoff}
    if discretization:
        low["discretization"] = discretization
    return {"derivative": derivative, "sample_rate": rate, "lowpass": low}


def butter(derivative, order, rate="1 kHz", cutoff="30 Hz"):
    return {"derivative": derivative, "sample_rate": rate,
            "lowpass": {"family": "butterworth", "order": order, "cutoff": cutoff}}


VELOCITY = {"velocity": FO}
ALL_FIRST = {"matched": first_order(None), "tustin": first_order("tustin", 1, 2), "pre": first_order("prewarped", 2, 3),
             "euler": first_order("backward_euler", 2, 2, "500 Hz", 20)}
MIXED = {"acc": butter(2, 4), "vel": butter(1, 3, "2 kHz", "111 Hz"), "smooth": first_order("matched", 0, 1),
         "raw": {"derivative": 1, "sample_rate": 250}}
DIRECT = {"logged": {"sample_rate": "1 kHz", "numerator": [0.2, 0.15, 0.05], "denominator": [2, -1.5, 0.3]},
          "stated": {"sample_rate": "1 kHz", "derivative": 1, "numerator": [100, -20, -80], "denominator": [1, -0.9]}}


def si(value):
    if isinstance(value, (int, float)):
        return float(value)
    number, unit = value.split()
    return float(number) * UNITS[unit]


def resolution(encoder, unit):
    if "resolution" in encoder:
        return si(encoder["resolution"])
    if "bits" in encoder:
        counts = 2.0 ** encoder["bits"]
    elif "periods_per_rev" in encoder:
        counts = encoder["periods_per_rev"] * 2.0 ** encoder["interpolation_bits"]
    elif "lines_per_rev" in encoder:
        counts = encoder["lines_per_rev"] * DECODING[encoder.get("decoding", "x4")]
    else:
        counts = encoder["counts_per_rev"]
    turn = 2 * math.pi if unit == "rad" else si(encoder["travel_per_rev"])
    return turn / (counts * abs(encoder.get("gear_ratio", 1)))


def flow(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f"{k}: {flow(v)}" for k, v in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(flow(v) for v in value) + "]"
    return repr(value) if isinstance(value, float) else str(value)


class Case:
    def __init__(self, name, urdf, encoders, base=None, tip=None, coordinates=None, filters=VELOCITY, coupling=None,
                 count=25, limits=None, points=None):
        self.name, self.urdf = name, pathlib.Path(urdf).resolve()
        self.chain = Chain(self.urdf, base, tip)
        self.coordinates = coordinates or ["x", "y", "z"]
        self.coupling, self.base, self.tip = coupling, base, tip
        chosen = [encoders.get(n, encoders.get("*")) for n in self.chain.names]
        self.delta = np.array([resolution(e, u) for e, u in zip(chosen, self.chain.units)])
        self.down = np.array([1.0 if e.get("rounding") == "down" else 0.0 for e in chosen])
        self.filters = {k: numeric(v) for k, v in filters.items()}
        self.limits = limits or {}
        self.points = np.array(points, dtype=float) if points is not None else self.draw(count)
        self.text = self.spec(encoders, coordinates, filters)

    def draw(self, count):
        """Seeded points inside the limits, away from gimbal lock if roll or yaw is among the coordinates."""
        rng = np.random.default_rng(len(self.name) * 1000 + len(self.chain.names))
        low, high = [], []
        for n in self.chain.names:
            joint = self.chain.by_name[n]
            a, b = self.limits.get(n, (joint.lower, joint.upper))
            low.append(-math.pi if a is None else a)
            high.append(math.pi if b is None else b)
            if joint.kind == "continuous":
                self.limits[n] = (low[-1], high[-1])
        low, high = np.array(low), np.array(high)
        points = low + (high - low) * (0.01 + 0.98 * rng.random((60 * count, len(low))))
        if "yaw" in self.coordinates or "roll" in self.coordinates:
            points = points[np.abs(cos_pitch(self.chain.pose(points)[1])) > 0.1]
        return points[:count]

    def spec(self, encoders, coordinates, filters):
        lines = ["qerr: 1", "robot:", f"  urdf: {self.urdf}"]
        lines += [f"  base: {self.base}"] if self.base else []
        lines += [f"  tip: {self.tip}"] if self.tip else []
        lines += ["encoders:"] + [f"  {n if n != '*' else chr(39) + '*' + chr(39)}: {flow(e)}" for n, e in encoders.items()]
        lines += [f"coupling: {flow(self.coupling)}"] if self.coupling is not None else []
        lines += [f"coordinates: {flow(coordinates)}"] if coordinates else []
        lines += ["filters:"] + [f"  {n}: {flow(f)}" for n, f in filters.items()] if filters else []
        lines += ["configurations:", "  method: list"]
        if self.limits:
            lines += [f"  limits: {flow({k: [float(a), float(b)] for k, (a, b) in self.limits.items()})}"]
        lines += ["  points:"] + [f"    - {flow([float(v) for v in p])}" for p in self.points]
        return "\n".join(lines) + "\n"


def numeric(f):
    out = dict(f, sample_rate=si(f["sample_rate"]))
    if "lowpass" in f:
        out["lowpass"] = dict(f["lowpass"], cutoff=si(f["lowpass"]["cutoff"]))
    return out


def own_cases():
    wide = {"*": {"counts_per_rev": 4096, "gear_ratio": 100}}
    six = ["x", "y", "z", "rx", "ry", "rz"]
    lift = {"counts_per_rev": 4096, "gear_ratio": 5, "travel_per_rev": "10 mm"}
    arm = {"*": {"lines_per_rev": 500, "decoding": "x2", "gear_ratio": 12.5}, "lift": lift, "wrist": {"bits": 9}}
    return [
        Case("arm: kinds of encoders", CORPUS / "arm.urdf", arm, coordinates=six, filters=ALL_FIRST),
        Case("arm: coupling and rounding down", CORPUS / "arm.urdf",
             {"shoulder": {"bits": 10, "rounding": "down"}, "elbow": {"resolution": "0.2 deg"},
              "lift": {"resolution": "0.2 mm", "rounding": "down"}, "wrist": {"resolution": "3 arcmin"}},
             coordinates=six, filters=MIXED | DIRECT,
             coupling=[[1, 0, 0, 0], [-1, 1, 0, 0], [0, 0, 1, 0], [0.25, -0.5, 0, 1]]),
        Case("tree: skew axes, mimic master off the chain", CORPUS / "tree.urdf", wide | {"drive": {"bits": 12}}, tip="tool_a",
             coordinates=six + ["roll", "pitch", "yaw"], filters=MIXED),
        Case("tree: a prismatic mimic of a revolute", CORPUS / "tree.urdf", {"*": {"bits": 11}}, base="hub", tip="tool_b",
             coordinates=["z", "x", "rz"], filters={}),
        Case("prr: the paper's example", CORPUS / "prr.urdf",
             {"*": {"counts_per_rev": 10000}, "slide": {"resolution": "0.1 mm"}}, coordinates=["x", "y"],
             filters={"one": first_order(None), "two": FO}, points=[[0.0, math.radians(11.7), math.radians(110)]]),
        Case("arm: roll pitch yaw", CORPUS / "arm.urdf",
             {"*": {"periods_per_rev": 128, "interpolation_bits": 4, "gear_ratio": -3}, "lift": lift | {"gear_ratio": -7}},
             coordinates=["roll", "pitch", "yaw"], filters=DIRECT, count=50),
    ]


def public_cases(robots):
    gear = {"counts_per_rev": 4096, "gear_ratio": 100}
    six = ["x", "y", "z", "rx", "ry", "rz"]
    rpy = ["x", "y", "z", "roll", "pitch", "yaw"]
    finger = {"bits": 12}
    screw = {"counts_per_rev": 2000, "gear_ratio": -4, "travel_per_rev": "12 mm"}
    r = pathlib.Path(robots)
    wam = [[0.0] * 7 for _ in range(7)]
    for i in range(7):
        wam[i][i] = 1.0
    wam[1][1], wam[1][2], wam[2][1], wam[2][2] = 0.5, -0.5, -0.84, -0.84
    wam[4][4], wam[4][5], wam[5][4], wam[5][5] = 0.5, 0.5, -0.5, 0.5
    leg = {"*": {"bits": 10, "gear_ratio": 2}, "leg_left_4_joint": {"bits": 9, "gear_ratio": 1, "rounding": "down"},
           "leg_left_5_joint": {"resolution": "4 mrad", "rounding": "down"}}
    return [
        Case("ur5", r / "ur5.urdf", {"*": gear, "elbow_joint": {"lines_per_rev": 1024, "decoding": "x4", "gear_ratio": -101},
             "wrist_3_joint": {"lines_per_rev": 900, "decoding": "x1", "gear_ratio": 50.5}}, tip="ee_link",
             coordinates=six, filters=ALL_FIRST, count=40),
        Case("panda", r / "panda.urdf", {"*": {"bits": 17}, "panda_joint4": {"bits": 13}}, tip="panda_hand_tcp",
             coordinates=rpy, filters=MIXED),
        Case("panda's mimic finger", r / "panda.urdf", {"*": {"bits": 14}, "panda_finger_joint1": screw},
             tip="panda_rightfinger", filters=VELOCITY | DIRECT),
        Case("iiwa14", r / "kuka_iiwa14.urdf", {"*": {"resolution": "0.125 mrad"}, "iiwa_joint_3": {"resolution": "0.01 deg"},
             "iiwa_joint_7": {"resolution": "1 arcmin", "rounding": "down"}}, tip="iiwa_link_ee", coordinates=rpy, filters=DIRECT),
        Case("kinova gen3", r / "kinova_gen3.urdf", {"*": {"periods_per_rev": 32, "interpolation_bits": 12}, "Actuator2": {"bits": 11}},
             coordinates=six, filters=ALL_FIRST),
        Case("fetch with its torso", r / "fetch.urdf", {"*": gear, "torso_lift_joint": {"resolution": "5 um"},
             "elbow_flex_joint": {"bits": 14, "rounding": "down"}}, base="base_link", tip="wrist_roll_link",
             coordinates=six, filters=MIXED),
        Case("talos leg, coarse", r / "talos_full_v2.urdf", leg, tip="left_sole_link", coordinates=six, filters=VELOCITY | DIRECT),
        Case("romeo thumb: skew axes, mimic", r / "nasty/romeo_skew_axes.urdf", {"*": gear}, tip="LThumb3Link", coordinates=six),
        Case("bullet humanoid leg", r / "nasty/bullet_humanoid_axes.urdf", {"*": {"bits": 12}}, tip="right_foot",
             coordinates=six, count=20),
        Case("bullet humanoid arm", r / "nasty/bullet_humanoid_axes.urdf", {"*": {"lines_per_rev": 256, "decoding": "x1"}},
             tip="left_lower_arm", coordinates=rpy),
        Case("robotiq left pad", r / "robotiq_2f85.urdf", {"*": {"bits": 8}}, tip="left_inner_finger_pad", coordinates=six),
        Case("robotiq right pad", r / "robotiq_2f85.urdf", {"*": finger}, tip="right_inner_finger_pad",
             coordinates=["y", "z", "rx"], filters=DIRECT),
        Case("pr2 arm with torso", r / "pr2.urdf", {"*": gear, "torso_lift_joint": screw}, tip="r_gripper_tool_frame",
             coordinates=six, filters=MIXED, count=20),
        Case("pr2 mimic finger tip", r / "pr2.urdf", {"*": {"lines_per_rev": 1000}, "torso_lift_joint": {"resolution": "0.02 mm"}},
             tip="r_gripper_l_finger_tip_frame", base="r_wrist_roll_link", coordinates=six),
        Case("scara", r / "scara_rrp.urdf", {"*": {"lines_per_rev": 2500}, "joint4": {"bits": 12, "travel_per_rev": "20 mm"}},
             coordinates=["z", "x", "y", "rz"], filters=ALL_FIRST),
        Case("allegro thumb", r / "allegro_left.urdf", {"*": {"bits": 9, "rounding": "down"}}, tip="link_15.0_tip",
             coordinates=six, filters=DIRECT, count=50),
        Case("wam with differentials", r / "wam7_jhu.urdf", {"*": {"counts_per_rev": 4096, "gear_ratio": 28.25},
             "wam/base_yaw_joint": {"counts_per_rev": 4096, "gear_ratio": 42}}, coordinates=six, coupling=wam, filters=ALL_FIRST),
        Case("nao right leg: mimic hip", r / "nasty/nao_nonunit_axes.urdf", {"*": {"counts_per_rev": 4096}}, tip="r_sole",
             base="torso", coordinates=rpy),
        Case("so101", r / "so101.urdf", {"*": {"bits": 12}, "shoulder_pan": {"bits": 12, "rounding": "down"}},
             tip="gripper_frame_link", coordinates=six, filters=VELOCITY, count=50),
        Case("puma 560", r / "puma560.urdf", {"*": {"counts_per_rev": 1000, "gear_ratio": 62.611}}, filters=MIXED,
             coupling=[[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0], [0, 0, 0, 1, 0, 0], [0, 0, 0, 0.0139, 1, 0],
                       [0, 0, 0, 0.0133, -0.1806, 1]]),
        Case("baxter left arm", r / "baxter.urdf", {"*": {"bits": 13}}, tip="left_gripper", coordinates=six),
    ]
