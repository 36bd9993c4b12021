"""Errors outside the catalogue: functions of (instant, angle, speed, effort) that add to the motor's angle [rad].

Each maker takes (rng, size [rad], context) and returns (function, what is physically there, also_accept). The context tells
duration [s], the angle's range, the encoder's shaft ratio, the largest effort and speed, and the planned path.
"""
from dataclasses import dataclass

import numpy as np


@dataclass
class Context:
    duration: float
    low: float
    high: float
    to_shaft: float
    effort: float
    speed: float
    path: object


def fractional_order(rng, size, c):
    """A belt or a second stage: periodic in the angle at an order that is no whole number of any shaft."""
    order, phase = rng.uniform(3, 12) + 0.0, rng.uniform(0, 2 * np.pi)
    if abs(order - round(order)) < 0.12:
        order += 0.25
    accept = [{"effect": "transmission_error", "orders": [order, order * c.to_shaft], "tolerance": 0.004}]
    return lambda t, q, v, f: size * np.sin(order * c.to_shaft * q + phase), {"order": order}, accept


def slow_wander(rng, size, c):
    """A sum of slow sines, none of them a drift that settles."""
    rows = [(rng.normal() / k, (k + rng.uniform(-0.3, 0.3)) / c.duration, rng.uniform(0, 2 * np.pi)) for k in range(2, 8)]
    wave = lambda t: sum(a * np.sin(2 * np.pi * f * t + p) for a, f, p in rows)
    peak = np.abs(wave(np.linspace(0, c.duration, 2000))).max()
    return lambda t, q, v, f: size / peak * wave(t), {"periods": len(rows)}, []


def random_walk(rng, size, c):
    """Brownian motion on 200 knots, smoothly joined."""
    knots = np.linspace(-0.01, 1.01, 200) * c.duration
    walk = np.cumsum(rng.standard_normal(200))
    walk -= walk[0]
    walk *= size / np.abs(walk).max()
    return lambda t, q, v, f: np.interp(t, knots, walk), {}, []


def vibration(rng, size, c):
    """12 Hz or so, only while moving."""
    frequency, phase = rng.uniform(9, 16), rng.uniform(0, 2 * np.pi)
    moving = lambda v: np.tanh(np.abs(v) / (0.05 * c.speed))
    return (lambda t, q, v, f: size * moving(v) * np.sin(2 * np.pi * frequency * t + phase),
            {"frequency": frequency}, [])


def order_under_load(rng, size, c):
    """A tooth mesh whose error grows with the torque through it."""
    order, phase = rng.integers(2, 6) + 0.37, rng.uniform(0, 2 * np.pi)
    return (lambda t, q, v, f: size * (f / c.effort) * np.sin(order * c.to_shaft * q + phase), {"order": order}, [])


def creep(rng, size, c):
    """After each reversal towards + the joint creeps away and settles; towards - it does not."""
    settle = c.duration * rng.uniform(0.01, 0.03)
    grid = np.linspace(-0.02, 1.02, 8000) * c.duration
    speed = c.path.at(grid)[1]
    value, level, last = np.zeros(len(grid)), 0.0, 0.0
    for k in range(1, len(grid)):
        sign = np.sign(speed[k]) if abs(speed[k]) > 1e-3 * c.speed else last
        if sign > 0 > last:
            level = 1.0
        level *= np.exp(-(grid[k] - grid[k - 1]) / settle)
        value[k], last = level, sign
    return lambda t, q, v, f: size * np.interp(t, grid, value), {"time_constant": settle}, []


def bump(rng, size, c):
    """A damaged tooth: an error at one angle."""
    centre, width = rng.uniform(0.3, 0.7), rng.uniform(0.03, 0.06) * (c.high - c.low)
    centre = c.low + centre * (c.high - c.low)
    return lambda t, q, v, f: size * np.exp(-0.5 * ((q - centre) / width) ** 2), {"angle": centre}, []


def bent_scale(rng, size, c):
    """A nonlinear scale: the cube of the angle about the middle of its range."""
    middle, half = (c.low + c.high) / 2, (c.high - c.low) / 2
    u = lambda q: (q - middle) / half
    return lambda t, q, v, f: size * (4 * u(q) ** 3 - 3 * u(q)), {}, []


def noisy_sector(rng, size, c):
    """Contamination: random errors within one sector of the angle."""
    centre, width = rng.uniform(0.35, 0.65), 0.12 * (c.high - c.low)
    centre = c.low + centre * (c.high - c.low)
    rate = rng.uniform(150, 260)
    return (lambda t, q, v, f: size * (np.abs(q - centre) < width) * np.sin(2 * np.pi * rate * t + 40 * np.sin(90 * t)),
            {"angle": centre}, [])


def beat_in_time(rng, size, c):
    """Aliased mains interference: a sine in time, independent of the motion."""
    frequency, phase = rng.uniform(3, 30), rng.uniform(0, 2 * np.pi)
    return lambda t, q, v, f: size * np.sin(2 * np.pi * frequency * t + phase), {"frequency": frequency}, []


FOREIGN = {f.__name__: f for f in (fractional_order, slow_wander, random_walk, vibration, order_under_load, creep, bump,
                                   bent_scale, noisy_sector, beat_in_time)}
