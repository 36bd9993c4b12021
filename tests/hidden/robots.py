"""Random robots: their URDF, their kinematics and their load. Written for the tests, independent of qerr.

A robot is an open chain. Joint i sits at `xyz[i]`, turned by `rpy[i]` in the frame of the link before it, and moves about (or
along) the unit axis `axis[i]`; link i has mass [kg], centre of mass [m] and principal inertias [kg m^2] in its own frame.
All functions take whole motions: q has the shape (joints, samples).
"""
import math
from dataclasses import dataclass, field

import numpy as np

GRAVITY = 9.80665  # m/s^2, along -z of the base
AXES = {"x": np.array([1.0, 0, 0]), "y": np.array([0, 1.0, 0]), "z": np.array([0, 0, 1.0])}


def rotation_rpy(roll, pitch, yaw):
    """R = Rz(yaw) Ry(pitch) Rx(roll), as URDF has it."""
    (cr, sr), (cp, sp), (cy, sy) = [(math.cos(a), math.sin(a)) for a in (roll, pitch, yaw)]
    return np.array([[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
                     [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
                     [-sp, cp * sr, cp * cr]])


def rotation_about(axis, angle):
    """Rodrigues: R = 1 + sin(a) K + (1 - cos(a)) K^2, one matrix per sample."""
    x, y, z = axis
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    s, c = np.sin(angle)[:, None, None], (1 - np.cos(angle))[:, None, None]
    return np.eye(3) + s * k + c * (k @ k)


@dataclass
class Robot:
    name: str
    joints: list                      # names, in chain order
    xyz: np.ndarray                   # (n, 3) m
    rpy: np.ndarray                   # (n, 3) rad
    axis: np.ndarray                  # (n, 3)
    tool: np.ndarray                  # (3,) m, from the last link
    mass: np.ndarray                  # (n,) kg
    centre: np.ndarray                # (n, 3) m
    inertia: np.ndarray               # (n, 3) kg m^2, principal
    centre_angle: np.ndarray          # (n,) rad or m: where its motions start from
    prismatic: list = field(default_factory=list)

    def __post_init__(self):
        self.prismatic = self.prismatic or [False] * len(self.joints)

    def unit(self, j):
        return "m" if self.prismatic[j] else "rad"

    def _links(self, q):
        """Per joint: rotation (samples, 3, 3) of its link in the link before, and position (samples, 3) of its origin."""
        for i in range(len(self.joints)):
            fixed, origin = rotation_rpy(*self.rpy[i]), np.broadcast_to(self.xyz[i], (q.shape[1], 3))
            if self.prismatic[i]:
                yield np.broadcast_to(fixed, (q.shape[1], 3, 3)), origin + q[i][:, None] * (fixed @ self.axis[i])
            else:
                yield fixed @ rotation_about(self.axis[i], q[i]), origin

    def tip(self, q):
        """Position of the tool in the base frame, (samples, 3) m."""
        rotation, position = np.broadcast_to(np.eye(3), (q.shape[1], 3, 3)), np.zeros((q.shape[1], 3))
        for turn, origin in self._links(q):
            position = position + np.einsum("tij,tj->ti", rotation, origin)
            rotation = rotation @ turn
        return position + rotation @ self.tool

    def effort(self, q, v, a, payload=0.0):
        """Torque [N m] (force [N]) that each joint exerts, (n, samples); Newton-Euler in link frames.

        The base is accelerated upwards by g in place of gravity. `payload` [kg] is a point mass at the tool: part of the
        real robot, unknown to the URDF.
        """
        samples, links = q.shape[1], list(self._links(q))
        omega = alpha = np.zeros((samples, 3))
        linear = np.tile([0, 0, GRAVITY], (samples, 1))
        forces, moments = [], []
        for i, (turn, origin) in enumerate(links):
            linear = linear + np.cross(alpha, origin) + np.cross(omega, np.cross(omega, origin))
            back = lambda x: np.einsum("tji,tj->ti", turn, x)  # into the frame of this link
            omega, alpha, linear = back(omega), back(alpha), back(linear)
            along = np.outer(v[i], self.axis[i])
            if self.prismatic[i]:
                linear = linear + np.outer(a[i], self.axis[i]) + 2 * np.cross(omega, along)
            else:
                alpha = alpha + np.outer(a[i], self.axis[i]) + np.cross(omega, along)
                omega = omega + along
            force = moment = 0.0
            bodies = [(self.mass[i], self.centre[i])]
            if payload and i == len(links) - 1:
                bodies.append((payload, self.tool))
            for mass, arm in bodies:
                f = mass * (linear + np.cross(alpha, arm) + np.cross(omega, np.cross(omega, arm)))
                force, moment = force + f, moment + np.cross(arm, f)
            spin = omega * self.inertia[i]
            forces.append(force)
            moments.append(moment + alpha * self.inertia[i] + np.cross(omega, spin))
        effort, force, moment = np.zeros((len(links), samples)), np.zeros((samples, 3)), np.zeros((samples, 3))
        for i in reversed(range(len(links))):
            force, moment = force + forces[i], moment + moments[i]
            effort[i] = (force if self.prismatic[i] else moment) @ self.axis[i]
            turn, origin = links[i]
            force, moment = np.einsum("tij,tj->ti", turn, force), np.einsum("tij,tj->ti", turn, moment)
            moment = moment + np.cross(origin, force)
        return effort

    def lengthened(self, joint, axis, length):
        """The robot with a geometric error: the origin of `joint` moved by `length` [m] along x, y or z of the frame before."""
        xyz = self.xyz.copy()
        xyz[joint] += length * AXES[axis]
        return Robot(self.name, self.joints, xyz, self.rpy, self.axis, self.tool, self.mass, self.centre,
                     self.inertia, self.centre_angle, self.prismatic)

    def urdf(self):
        three = lambda v: " ".join(f"{x:.10g}" for x in v)
        text = ['<?xml version="1.0"?>', f'<robot name="{self.name}">', '  <link name="base_link"/>']
        parent = "base_link"
        for i, joint in enumerate(self.joints):
            ixx, iyy, izz = self.inertia[i]
            kind, low, high = ("prismatic", -2, 2) if self.prismatic[i] else ("revolute", -6.28, 6.28)
            text += [f'  <link name="link_{i + 1}">', '    <inertial>',
                     f'      <origin xyz="{three(self.centre[i])}" rpy="0 0 0"/>',
                     f'      <mass value="{self.mass[i]:.10g}"/>',
                     f'      <inertia ixx="{ixx:.10g}" ixy="0" ixz="0" iyy="{iyy:.10g}" iyz="0" izz="{izz:.10g}"/>',
                     '    </inertial>', '  </link>', f'  <joint name="{joint}" type="{kind}">',
                     f'    <parent link="{parent}"/>', f'    <child link="link_{i + 1}"/>',
                     f'    <origin xyz="{three(self.xyz[i])}" rpy="{three(self.rpy[i])}"/>',
                     f'    <axis xyz="{three(self.axis[i])}"/>',
                     f'    <limit lower="{low}" upper="{high}" effort="200" velocity="6"/>', '  </joint>']
            parent = f"link_{i + 1}"
        text += ['  <link name="tool0"/>', '  <joint name="tool_fixed" type="fixed">', f'    <parent link="{parent}"/>',
                 '    <child link="tool0"/>', f'    <origin xyz="{three(self.tool)}" rpy="0 0 0"/>', '  </joint>',
                 '</robot>', '']
        return "\n".join(text)


# Robot types: per joint (name, direction of the axis, position of the next joint, usual angle). Lengths are scaled.
SHAPES = {
    "turntable": [("table", "z", (0.15, 0, 0.05), 0.0)],
    "swing_arm": [("swing", "y", (0.30, 0, 0.0), 0.4)],
    "two_links": [("upper", "y", (0.32, 0, 0), -0.5), ("lower", "y", (0.25, 0, 0), 0.9)],
    "leg": [("hip_yaw", "z", (0, 0, -0.08), 0.1), ("hip_pitch", "y", (0, 0, -0.3), 0.4),
            ("knee", "y", (0, 0, -0.28), -0.9)],
    "pan_tilt_lift": [("pan", "z", (0, 0, 0.12), 0.2), ("tilt", "x", (0, 0.22, 0), 0.3),
                      ("boom", "x", (0, 0.2, 0), -0.7)],
    "scara": [("arm_1", "z", (0.3, 0, 0.0), 0.3), ("arm_2", "z", (0.25, 0, 0.0), -0.8),
              ("lift", "slide", (0, 0, -0.1), -0.1), ("spin", "z", (0.05, 0, 0), 0.5)],
    "five_axis": [("waist", "z", (0, 0, 0.25), 0.2), ("shoulder", "y", (0, 0, 0.35), 0.5),
                  ("elbow", "y", (0.3, 0, 0), 0.6), ("pitch", "y", (0.08, 0, 0), -0.4),
                  ("roll", "x", (0.1, 0, 0.02), 0.3)],
    "six_axis": [("j1", "z", (0.05, 0, 0.3), -0.3), ("j2", "y", (0, 0, 0.4), 0.4), ("j3", "y", (0.3, 0, 0.03), 0.3),
                 ("j4", "x", (0.1, 0, 0), 0.5), ("j5", "y", (0.08, 0, 0), 0.8), ("j6", "x", (0.07, 0.02, 0), -0.6)],
    "seven_axis": [("a1", "z", (0, 0, 0.2), 0.3), ("a2", "y", (0, 0, 0.21), 0.5), ("a3", "z", (0, 0, 0.2), -0.4),
                   ("a4", "y", (0, 0, 0.2), -1.1), ("a5", "z", (0, 0, 0.2), 0.6), ("a6", "y", (0, 0, 0.1), 0.9),
                   ("a7", "z", (0.03, 0, 0.1), -0.2)],
}


def random_robot(rng, shape=None):
    """A machine of a given type with random lengths, masses and usual angles."""
    shape = shape or rng.choice(list(SHAPES))
    rows = SHAPES[shape]
    n = len(rows)
    offsets = np.array([r[2] for r in rows]) * rng.uniform(0.75, 1.3, (n, 3))
    xyz = np.vstack([[0, 0, rng.uniform(0.05, 0.3)], offsets[:-1]]).round(4)
    slides = [r[1] == "slide" for r in rows]
    axis = np.array([AXES["z" if r[1] == "slide" else r[1]] * rng.choice([-1, 1]) for r in rows])
    mass = (rng.uniform(1.0, 8.0) * 0.7 ** np.arange(n)).round(3)
    size = np.linalg.norm(offsets, axis=1) + 0.05
    inertia = mass[:, None] * (size[:, None] ** 2) * rng.uniform(0.05, 0.1, (n, 1)) * [0.9, 1.1, 0.7]
    return Robot(shape, [r[0] for r in rows], xyz, np.zeros((n, 3)), axis, offsets[-1].round(4), mass,
                 (offsets / 2).round(4), inertia.round(8),
                 np.array([r[3] for r in rows]) + rng.uniform(-0.2, 0.2, n) * [0.1 if s else 1 for s in slides], slides)
