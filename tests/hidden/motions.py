"""Motions as analytic paths: position, velocity and acceleration at any instant, so that a delay is an evaluation at t - delay.

Every path has `at(t) -> (q, v, a)`, arrays like t, for any t from before the record's start to after its end.
"""
import numpy as np


class Sines:
    """q(t) = centre + rate t + sum_i A_i sin(2 pi f_i t + p_i)."""

    def __init__(self, centre, sines, rate=0.0):
        self.centre, self.sines, self.rate = centre, sines, rate

    def at(self, t):
        q, v, a = self.centre + self.rate * t, np.full_like(t, self.rate), np.zeros_like(t)
        for amplitude, frequency, phase in self.sines:
            w = 2 * np.pi * frequency
            s, c = amplitude * np.sin(w * t + phase), amplitude * np.cos(w * t + phase)
            q, v, a = q + s, v + w * c, a - w * w * s
        return q, v, a


class Pieces:
    """Phases of constant jerk: within phase k, with s = t - t_k, q = q_k + v_k s + a_k s^2/2 + j_k s^3/6; at rest outside."""

    def __init__(self, start):
        self.knots = [[-np.inf, start, 0.0, 0.0, 0.0]]
        self.end, self.state = 0.0, (start, 0.0)

    def phase(self, length, acceleration=0.0, jerk=0.0):
        if length <= 0:
            return
        q, v = self.state
        self.knots.append([self.end, q, v, acceleration, jerk])
        self.state = (q + length * (v + length * (acceleration / 2 + length * jerk / 6)),
                      v + length * (acceleration + length * jerk / 2))
        self.end += length

    def rest(self, length=0.0):
        self.knots.append([self.end, self.state[0], 0.0, 0.0, 0.0])
        self.state = (self.state[0], 0.0)
        self.end += length

    def move(self, to, speed, ramp, jerk_share=0.0):
        """To `to` with cruise speed at most `speed`, each ramp `ramp` s long, of which the share `jerk_share` at either end
        has finite jerk. Short moves do not reach the speed."""
        distance, sign = abs(to - self.state[0]), np.sign(to - self.state[0])
        speed = min(speed, distance / ramp)
        if distance == 0:
            return
        j = jerk_share * ramp
        peak = speed / (ramp - j)  # the area under the acceleration's trapezoid is the speed
        for way in (1, -1):
            if j > 0:
                self.phase(j, 0.0, sign * way * peak / j)
                self.phase(ramp - 2 * j, sign * way * peak)
                self.phase(j, sign * way * peak, -sign * way * peak / j)
            else:
                self.phase(ramp, sign * way * peak)
            if way == 1:
                self.phase(distance / speed - ramp)

    def at(self, t):
        table = np.array(self.knots)
        k = np.searchsorted(table[:, 0], t, side="right") - 1
        start, q, v, a, j = table[np.maximum(k, 0)].T
        s = np.where(np.isfinite(start), t - start, 0.0)
        return q + s * (v + s * (a / 2 + s * j / 6)), v + s * (a + s * j / 2), a + s * j


class Paths:
    """One path per joint."""

    def __init__(self, joints):
        self.joints = joints

    def at(self, t):
        """(q, v, a), each (joints, samples)."""
        return tuple(np.array(x) for x in zip(*[p.at(t) for p in self.joints]))


def multisine(rng, centre, duration, reach=None):
    """Two to four sines: the slowest has about one or two periods in the record."""
    base = rng.uniform(0.9, 2.2) / duration
    big = reach if reach is not None else min(rng.uniform(0.4, 1.1), 1.6 / (2 * np.pi * base))
    sines = [(big, base, rng.uniform(0, 2 * np.pi))]
    for _ in range(rng.integers(1, 4)):
        frequency = base * rng.uniform(2.2, 6)
        sines.append((big * rng.uniform(0.1, 0.3), frequency, rng.uniform(0, 2 * np.pi)))
    return Sines(centre, sines)


def stops(rng, centre, duration, reach=None, jerk_share=None):
    """Moves at several speeds with pauses between, at the start and at the end."""
    reach = reach if reach is not None else rng.uniform(0.35, 0.9)
    jerk_share = rng.choice([0.0, 0.3]) if jerk_share is None else jerk_share
    path = Pieces(centre)
    path.rest(rng.uniform(0.02, 0.06) * duration)
    side = rng.choice([-1, 1])
    while path.end < duration:
        side = -side if rng.random() < 0.8 else side
        to = centre + side * reach * rng.uniform(0.2, 1.0)
        path.move(to, reach / duration * rng.uniform(4, 14), rng.uniform(0.01, 0.04) * duration, jerk_share)
        path.rest(rng.uniform(0.02, 0.09) * duration)
    return path


def triangle(rng, centre, duration, reach=0.5, turns=5, ramp=1e-3):
    """Back and forth at one speed without pauses; the direction reverses within `ramp` s."""
    speed = 2 * reach * turns / duration
    path = Pieces(centre - reach * rng.uniform(0.3, 0.9))
    path.phase(ramp, speed / ramp)
    path.phase((centre + reach - path.state[0]) / speed)
    sign = -1
    while path.end < duration:
        path.phase(ramp, 2 * sign * speed / ramp)
        path.phase(2 * reach / speed)
        sign = -sign
    path.phase(ramp, 2 * sign * speed / ramp)
    path.phase(duration)
    return path


def constant_speed(centre, speed):
    return Sines(centre, [], speed)


def standstill(centre):
    return Sines(centre, [])


def rich(rng, robot, duration, kind=None):
    """A different motion per joint, so that speed, direction, angle, load and time vary independently."""
    paths = []
    for j, centre in enumerate(robot.centre_angle):
        reach = rng.uniform(0.05, 0.15) if robot.prismatic[j] else None
        which = kind or rng.choice(["sines", "stops"], p=[0.6, 0.4])
        paths.append((multisine if which == "sines" else stops)(rng, centre, duration, reach))
    return Paths(paths)
