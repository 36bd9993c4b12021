"""Mechanics between the encoder and the joint, stepped in time or in travel."""
import numpy as np


def play(drive, gap, side=0.0):
    """The driven side of a coupling with the clearance `gap`: it stays where it is until a flank pushes it."""
    at, half, out = drive[0] - side * gap / 2, gap / 2, np.empty(len(drive))
    for k, x in enumerate(drive.tolist()):
        if x - at > half:
            at = x - half
        elif at - x > half:
            at = x + half
        out[k] = at
    return out


FINE = 8  # steps of the clearance per row: it turns between the rows, too


def play_along(path, t, gap, side=0.0):
    """The driven side at the instants t, for a driver that follows `path`."""
    grid = np.interp(np.arange(FINE * (len(t) - 1) + 1) / FINE, np.arange(len(t)), t)
    return play(path(grid), gap, side)[::FINE]


def presliding(x, width, travel):
    """Dahl's friction: z approaches sign(dx) over the travel, dz = (sign - z) |dx| / travel; lag = width/2 z."""
    z, out = 0.0, np.empty(len(x))
    for k, dx in enumerate(np.diff(x, prepend=x[0]).tolist()):
        if dx:
            s = 1.0 if dx > 0 else -1.0
            z = s - (s - z) * np.exp(-abs(dx) / travel)
        out[k] = z
    return width / 2 * out


def spring_mass(motor, t, inertia, stiffness, damping, load):
    """Link behind a spring: I q'' = k (m - q) + d (m' - q') + load(q); midpoint steps of at most a fortieth of the period.

    Returns (q, torque in the spring) at the instants t."""
    step = t[1] - t[0]
    fine = max(1, int(np.ceil(step * np.sqrt(stiffness / inertia) / (2 * np.pi) * 40)))
    h = step / fine
    grid = t[0] + h / 2 * np.arange(2 * fine * (len(t) - 1) + 1)
    m = motor(grid)
    dm = np.gradient(m, h / 2)
    m, dm = m.tolist(), dm.tolist()
    q, v = m[0] + load(m[0]) / stiffness, dm[0]
    out = [q]
    for k in range(fine * (len(t) - 1)):
        i = 2 * k
        a = (stiffness * (m[i] - q) + damping * (dm[i] - v) + load(q)) / inertia
        qm, vm = q + h / 2 * v, v + h / 2 * a
        a = (stiffness * (m[i + 1] - qm) + damping * (dm[i + 1] - vm) + load(qm)) / inertia
        q, v = q + h * vm, v + h * a
        if (k + 1) % fine == 0:
            out.append(q)
    q = np.array(out)
    return q, stiffness * (motor(t) - q)


def warmth(t, constant, final, start=0.0):
    """Temperature rise of a body that is heated from `start`: dT/dt = (final - T)/constant, implicit steps."""
    out, at, last = np.empty(len(t)), 0.0, t[0]
    for k, now in enumerate(t.tolist()):
        h = now - last
        if now >= start:
            at = (at + h / constant * final) / (1 + h / constant)
        out[k], last = at, now
    return out


def settling(x, t, constant, size, still):
    """Creep after a stop: at rest an error grows towards the side it came from, size (1 - exp(-s/constant)); a move clears it."""
    out, at, way = np.zeros(len(x)), 0.0, 1.0
    for k in range(1, len(x)):
        dx, h = x[k] - x[k - 1], t[k] - t[k - 1]
        if abs(dx) > still * h:
            way, at = np.sign(dx), 0.0
        else:
            at += (way * size - at) * (1 - np.exp(-h / constant))
        out[k] = at
    return out
