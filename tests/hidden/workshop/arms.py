"""Arms of the workshop: a URDF of plain rods, and where their tool is."""
import numpy as np


class Arm:
    """Joint i at the end of rod i - 1, its axis x, y or z of the frame of the base; rod i lies along `rods[i]` at zero angles."""

    def __init__(self, names, axes, rods, base):
        self.names, self.axes, self.rods, self.base = names, np.array(axes, float), np.array(rods, float), np.array(base, float)

    def tip(self, q, rods=None):
        """Tool positions, (samples, 3): from the tool inwards, each rod added and turned by its joint (Rodrigues)."""
        rods = self.rods if rods is None else rods
        p = np.zeros((q.shape[1], 3))
        for i in reversed(range(len(self.names))):
            p = p + rods[i]
            k, c, s = self.axes[i], np.cos(q[i])[:, None], np.sin(q[i])[:, None]
            p = p * c + np.cross(np.broadcast_to(k, p.shape), p) * s + np.outer(p @ k, k) * (1 - c)
        return p + self.base

    def urdf(self):
        three = lambda v: " ".join(f"{x:.9g}" for x in v)
        text = ['<?xml version="1.0"?>', '<robot name="bench_arm">', '<link name="foot"/>']
        parent, origin = "foot", self.base
        for i, n in enumerate(self.names):
            mass = 4.0 / (i + 1)
            text += [f'<joint name="{n}" type="revolute"><parent link="{parent}"/><child link="rod{i}"/>',
                     f'<origin xyz="{three(origin)}" rpy="0 0 0"/><axis xyz="{three(self.axes[i])}"/>',
                     '<limit lower="-12" upper="12" effort="150" velocity="8"/></joint>',
                     f'<link name="rod{i}"><inertial><origin xyz="{three(self.rods[i] / 2)}" rpy="0 0 0"/><mass value="{mass:.9g}"/>',
                     '<inertia ixx="0.02" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>']
            parent, origin = f"rod{i}", self.rods[i]
        text += ['<link name="flange"/>', f'<joint name="flange_fixed" type="fixed"><parent link="{parent}"/><child link="flange"/>',
                 f'<origin xyz="{three(origin)}" rpy="0 0 0"/></joint>', '</robot>', '']
        return "\n".join(text)


NAMES = ["base_yaw", "shoulder", "elbow", "roll", "bend", "twist"]


def draw(rng, joints):
    """The first joint turns about z; the axes of neighbours differ, except for a shoulder and an elbow."""
    pool = ([0, 0, 1], [0, 1, 0], [0, 1, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0])
    rods = [[0.02, 0, 0.25], [0.05, 0.03, 0.4], [0.35, 0, 0.02], [0.12, 0, 0], [0.1, 0, 0.02], [0.08, 0.03, 0.02]]
    rods = np.array(rods)[:joints] * rng.uniform(0.7, 1.4, (joints, 1))
    return Arm(NAMES[:joints], pool[:joints], np.round(rods, 4), [0, 0, round(rng.uniform(0.1, 0.4), 3)])
