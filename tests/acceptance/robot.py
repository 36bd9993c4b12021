"""URDF reader and forward kinematics, independent of qerr: batched, and valid for complex arguments."""
import math
import xml.etree.ElementTree as ElementTree

import numpy as np


def vector(text, default):
    return np.array([float(v) for v in text.split()] if text else default, dtype=float)


def rotation_rpy(rpy):
    (sr, cr), (sp, cp), (sy, cy) = [(math.sin(a), math.cos(a)) for a in rpy]
    rx = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    ry = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    rz = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return rz @ ry @ rx


class Joint:
    def __init__(self, element):
        self.name, self.kind = element.get("name"), element.get("type")
        self.parent, self.child = element.find("parent").get("link"), element.find("child").get("link")
        origin = element.find("origin")
        attributes = {} if origin is None else origin.attrib
        self.xyz = vector(attributes.get("xyz"), [0, 0, 0])
        self.rotation = rotation_rpy(vector(attributes.get("rpy"), [0, 0, 0]))
        axis = element.find("axis")
        self.axis = vector(None if axis is None else axis.get("xyz"), [1, 0, 0])
        if self.kind != "fixed":
            self.axis = self.axis / np.linalg.norm(self.axis)
        limit = element.find("limit")
        self.lower = self.upper = None
        if limit is not None and self.kind in ("revolute", "prismatic"):
            self.lower, self.upper = float(limit.get("lower", 0)), float(limit.get("upper", 0))
        mimic = element.find("mimic")
        self.mimic = None
        if mimic is not None:
            self.mimic = (mimic.get("joint"), float(mimic.get("multiplier", 1)), float(mimic.get("offset", 0)))


class Chain:
    """The chain from base to tip; `names` are its independent joints in chain order; a mimic's master off the chain follows its first mimic."""

    def __init__(self, path, base=None, tip=None):
        root = ElementTree.parse(path).getroot()
        self.robot = root.get("name")
        self.by_name = {j.get("name"): Joint(j) for j in root.findall("joint")}
        above = {j.child: j for j in self.by_name.values()}
        parents = {j.parent for j in self.by_name.values()}
        links = [l.get("name") for l in root.findall("link")]
        self.base = base or [l for l in links if l not in above][0]
        self.tip = tip or [l for l in links if l not in parents][0]
        chain, link = [], self.tip
        while link != self.base:
            chain.append(above[link])
            link = above[link].parent
        self.joints = chain[::-1]
        self.names, self.terms = [], {}
        for joint in self.joints:
            if joint.kind == "fixed":
                continue
            master, factor, offset = joint.name, 1.0, 0.0
            while self.by_name[master].mimic:
                master, multiplier, shift = self.by_name[master].mimic
                factor, offset = factor * multiplier, factor * shift + offset
            if master not in self.names:
                self.names.append(master)
            self.terms[joint.name] = (self.names.index(master), factor, offset)
        self.units = ["m" if self.by_name[n].kind == "prismatic" else "rad" for n in self.names]

    def reach(self, points):
        """An upper bound of all lever arms of the chain, over the points."""
        total = sum(float(np.linalg.norm(j.xyz)) for j in self.joints)
        for joint in self.joints:
            if joint.kind == "prismatic":
                index, factor, offset = self.terms[joint.name]
                total += float(np.max(np.abs(factor * points[:, index] + offset)))
        return total

    def pose(self, q):
        """q of shape (N, n), real or complex -> positions (N, 3), rotations (N, 3, 3) of the tip in the base frame."""
        q = np.asarray(q)
        count = q.shape[0]
        rotation = np.broadcast_to(np.eye(3, dtype=q.dtype), (count, 3, 3))
        position = np.zeros((count, 3), dtype=q.dtype)
        for joint in self.joints:
            position = position + rotation @ joint.xyz
            rotation = rotation @ joint.rotation
            if joint.kind == "fixed":
                continue
            index, factor, offset = self.terms[joint.name]
            value = factor * q[:, index] + offset
            if joint.kind == "prismatic":
                position = position + value[:, None] * (rotation @ joint.axis)
            else:
                x, y, z = joint.axis
                cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
                sine, cosine = np.sin(value)[:, None, None], np.cos(value)[:, None, None]
                rotation = rotation @ (np.eye(3) + sine * cross + (1 - cosine) * (cross @ cross))
        return position, rotation

    def jacobian(self, q, coordinates):
        """Rows of `coordinates` by complex steps: (N, rows, n)."""
        q = np.asarray(q, dtype=float)
        rows = np.zeros((q.shape[0], len(coordinates), q.shape[1]))
        step = 1e-40
        _, rot = self.pose(q)
        for k in range(q.shape[1]):
            shifted = q.astype(complex)
            shifted[:, k] += 1j * step
            moved, turned = self.pose(shifted)
            dp, dr = moved.imag / step, turned.imag / step
            spin = dr @ np.transpose(rot, (0, 2, 1))
            rows_of = {
                "x": dp[:, 0], "y": dp[:, 1], "z": dp[:, 2],
                "rx": (spin[:, 2, 1] - spin[:, 1, 2]) / 2,
                "ry": (spin[:, 0, 2] - spin[:, 2, 0]) / 2,
                "rz": (spin[:, 1, 0] - spin[:, 0, 1]) / 2,
                "roll": turn_rate(rot[:, 2, 1], rot[:, 2, 2], dr[:, 2, 1], dr[:, 2, 2]),
                "yaw": turn_rate(rot[:, 1, 0], rot[:, 0, 0], dr[:, 1, 0], dr[:, 0, 0]),
                "pitch": -dr[:, 2, 0] / cos_pitch(rot),
            }
            for i, name in enumerate(coordinates):
                rows[:, i, k] = rows_of[name]
        return rows


def cos_pitch(rot):
    return np.hypot(rot[:, 2, 1], rot[:, 2, 2])


def turn_rate(s, c, ds, dc):
    """d atan2(s, c)."""
    return (c * ds - s * dc) / (s * s + c * c)


def rotation_vector(rot):
    """Logarithm of rotations (N, 3, 3), accurate for small angles; angles below pi/2."""
    v = np.stack([rot[:, 2, 1] - rot[:, 1, 2], rot[:, 0, 2] - rot[:, 2, 0], rot[:, 1, 0] - rot[:, 0, 1]], axis=1) / 2
    sine = np.linalg.norm(v, axis=1)
    angle = np.arcsin(np.minimum(sine, 1))
    scale = np.where(sine > 1e-150, angle / np.where(sine > 1e-150, sine, 1), 1)
    return v * scale[:, None]
