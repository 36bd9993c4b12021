"""Motions as functions of time, so that a delayed reading is the path at an earlier instant. All positions in rad or m."""
import numpy as np


class Sines:
    """Sum of sines about zero, with a constant velocity."""

    def __init__(self, parts, speed=0.0):
        self.parts, self.speed = parts, speed

    def __call__(self, t):
        return self.speed * t + sum(a * np.sin(2 * np.pi * f * t + p) for a, f, p in self.parts)


class Knots:
    """Moves between stated positions: x(t) linear, or 10 s^3 - 15 s^4 + 6 s^5 (least jerk) from knot to knot; at rest outside."""

    def __init__(self, times, places, smooth=True):
        self.times, self.places, self.smooth = np.array(times, float), np.array(places, float), smooth

    def __call__(self, t):
        k = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.times) - 2)
        s = np.clip((t - self.times[k]) / (self.times[k + 1] - self.times[k]), 0, 1)
        if self.smooth:
            s = s * s * s * (10 - 15 * s + 6 * s * s)
        return self.places[k] + (self.places[k + 1] - self.places[k]) * s


def sines(rng, reach, duration):
    f = rng.uniform(1.5, 5) / duration
    parts = [(reach, f, rng.uniform(0, 6.28))]
    parts += [(reach * rng.uniform(0.05, 0.3), f * rng.uniform(2.3, 9), rng.uniform(0, 6.28)) for _ in range(rng.integers(0, 4))]
    return Sines(parts)


def random_moves(rng, reach, duration, rests=True):
    """Least-jerk moves to random targets, in random times, with rests between most of them."""
    times, places = [0.0], [rng.uniform(-1, 1) * reach]
    while times[-1] < duration:
        far = rng.uniform(-1, 1) * reach
        slow = rng.uniform(0.02, 0.1) * duration * (0.3 + abs(far - places[-1]) / (2 * reach))
        times.append(times[-1] + slow)
        places.append(far)
        if rests and rng.random() < 0.7:
            times.append(times[-1] + rng.uniform(0.005, 0.04) * duration)
            places.append(far)
    return Knots(times, places)


def ramps(rng, reach, duration):
    """There and back at constant speeds with a dwell at either end; the speeds differ."""
    times, places, end = [0.0, 0.02 * duration], [-reach, -reach], 1
    while times[-1] < duration:
        times.append(times[-1] + duration * rng.uniform(0.04, 0.15))
        places.append(end * reach * rng.uniform(0.7, 1))
        times.append(times[-1] + duration * rng.uniform(0.01, 0.03))
        places.append(places[-1])
        end = -end
    return Knots(times, places, smooth=False)


def stop_and_go(rng, reach, duration):
    """Equal indexing steps up and down again, with a stop after each."""
    n = int(rng.integers(6, 16))
    steps = np.concatenate([np.linspace(-reach, reach, n), np.linspace(reach, -reach, n)[1:]])
    pitch = duration / len(steps)
    go = pitch * rng.uniform(0.3, 0.7)
    times, places = [0.0], [steps[0]]
    for k, x in enumerate(steps[1:], 1):
        times += [k * pitch, k * pitch + go]
        places += [places[-1], x]
    return Knots(times, places)


def one_way(rng, reach, duration):
    """Turns on in one direction, with a speed that varies but does not change its sign."""
    speed = 2 * reach / duration
    parts = []
    for share in rng.uniform(0.1, 0.4, 2):
        f = rng.uniform(1, 7) / duration
        parts.append((share * speed / (2 * np.pi * f), f, rng.uniform(0, 6.28)))
    return Sines(parts, speed * rng.choice([-1, 1]))


def both_sides(rng, reach, duration):
    """The test for lost motion: each target is approached from below and from above, with overshoot and dwell, at two speeds."""
    targets = np.linspace(-0.8, 0.8, int(rng.integers(4, 9))) * reach
    over, times, places = reach * 0.15, [0.0], [-reach]
    pitch = duration / (2 * len(targets))
    for k, x in enumerate(np.tile(targets, 2)):
        brisk = 0.12 if k < len(targets) else 0.22
        for to in (x - over, x, x + over, x):
            times += [times[-1] + brisk * pitch, times[-1] + (brisk + 0.02) * pitch]
            places += [to, to]
    return Knots(times, places)


def jogging(rng, reach, duration):
    """By hand: strokes of very different length and pace, with pauses, and a tremor while it moves."""
    times, places = [0.0], [0.0]
    while times[-1] < duration:
        to = np.clip(places[-1] + rng.normal() * reach * float(rng.choice([0.1, 0.4, 1])), -reach, reach)
        times.append(times[-1] + duration * rng.uniform(0.008, 0.05))
        places.append(to)
        if rng.random() < 0.5:
            times.append(times[-1] + duration * rng.uniform(0.002, 0.03))
            places.append(to)
    tremor = Sines([(0.01 * reach, rng.uniform(20, 60) / duration, 0.0)])
    stroke = Knots(times, places)
    return lambda t: stroke(t) + tremor(t)


def poses(rng, reach, duration):
    """Static poses: short moves, long rests."""
    n = int(rng.integers(12, 30))
    x, pitch = rng.uniform(-1, 1, n) * reach, duration / n
    times, places = [0.0], [x[0]]
    for k in range(1, n):
        times += [k * pitch, k * pitch + 0.15 * pitch]
        places += [places[-1], x[k]]
    return Knots(times, places)


MOTIONS = {"sines": sines, "random_moves": random_moves, "ramps": ramps, "stop_and_go": stop_and_go, "one_way": one_way,
           "both_sides": both_sides, "jogging": jogging, "poses": poses}
REVERSING = ["sines", "random_moves", "ramps", "both_sides", "jogging"]
LIVELY = ["sines", "random_moves", "jogging"]  # speeds vary within a stroke
