"""The same quantities, computed independently of qerr."""
import math

import numpy as np


def impulse_response(d, n, cutoff, rate):
    """d back differences, then n matched one-pole low-passes; long enough for double precision [1/s^d]."""
    a = math.exp(-2 * math.pi * cutoff / rate)
    length = d + 1 + (0 if a == 0 else int(math.ceil((45 + 12 * n) / -math.log(a))))
    h = np.zeros(length)
    for k in range(d + 1):
        h[k] = (-1) ** k * math.comb(d, k) * rate**d
    for _ in range(n):
        state = 0.0
        for k in range(length):
            state = a * state + (1 - a) * h[k]
            h[k] = state
    return h


def h2_by_sum(d, n, cutoff, rate):
    """sqrt(sum h_k^2)."""
    return math.sqrt(math.fsum(impulse_response(d, n, cutoff, rate) ** 2))


def l1_by_sum(d, n, cutoff, rate):
    return math.fsum(abs(impulse_response(d, n, cutoff, rate)))


def controller_form(d, n, cutoff, rate):
    """A, B, C, D of the transfer function in controller canonical form (paper, Eqs. 29 and 30)."""
    a = math.exp(-2 * math.pi * cutoff / rate)
    numerator, denominator = np.array([rate**d * (1 - a) ** n]), np.array([1.0])
    for _ in range(d):
        numerator = np.convolve(numerator, [1.0, -1.0])
    for _ in range(n):
        denominator = np.convolve(denominator, [1.0, -a])
    order = max(d, n)
    b = np.pad(numerator, (0, order + 1 - len(numerator)))
    q = np.pad(denominator, (0, order + 1 - len(denominator)))
    matrix = np.eye(order, k=-1)
    matrix[0] = -q[1:]
    column = np.zeros((order, 1))
    column[0, 0] = 1
    return matrix, column, (b[1:] - b[0] * q[1:]).reshape(1, -1), b[0]


def steady_covariance(a, b):
    """Solves Sigma = A Sigma A^T + B B^T as a linear system (paper, Eq. 37, for unit input variance)."""
    size = len(a)
    return np.linalg.solve(np.eye(size * size) - np.kron(a, a), (b @ b.T).ravel()).reshape(size, size)


def h2_by_lyapunov(d, n, cutoff, rate):
    """The paper's method, Eqs. 37 and 38."""
    a, b, c, direct = controller_form(d, n, cutoff, rate)
    return math.sqrt((c @ steady_covariance(a, b) @ c.T).item() + direct**2)


def premium_tip(angles):
    """Tip of the Phantom Premium [m] for t1, t2, t3 (rows), t3 against the ground (Cavusoglu et al. 2002)."""
    t1, t2, t3 = np.asarray(angles, dtype=float).T
    l1, l2 = 0.210, 0.180
    reach = l1 * np.cos(t2) + l2 * np.sin(t3)
    return np.column_stack(
        [reach * np.sin(t1), l2 - l2 * np.cos(t3) + l1 * np.sin(t2), reach * np.cos(t1) - l1]
    )


def premium_jacobian(angles):
    """d tip / d (t1, t2, t3) [m/rad]."""
    t1, t2, t3 = angles
    l1, l2 = 0.210, 0.180
    reach = l1 * math.cos(t2) + l2 * math.sin(t3)
    return np.array(
        [
            [reach * math.cos(t1), -l1 * math.sin(t2) * math.sin(t1), l2 * math.cos(t3) * math.sin(t1)],
            [0.0, l1 * math.cos(t2), l2 * math.sin(t3)],
            [-reach * math.sin(t1), -l1 * math.sin(t2) * math.cos(t1), l2 * math.cos(t3) * math.cos(t1)],
        ]
    )


def prr_jacobian(q2, q3):
    """d (x, y) / d (q1, q2, q3) of the planar PRR, l = 1 m."""
    return np.array(
        [
            [1.0, -2 * math.sin(q2) - math.sin(q2 + q3), -math.sin(q2 + q3)],
            [0.0, 2 * math.cos(q2) + math.cos(q2 + q3), math.cos(q2 + q3)],
        ]
    )


def prr_tip(q1, q2, q3):
    return np.array([q1 + 2 * np.cos(q2) + np.cos(q2 + q3), 2 * np.sin(q2) + np.sin(q2 + q3)])


def ipqn_sigma(jacobian, resolutions):
    """sqrt(diag(J diag(Delta^2/12) J^T)) (paper, Eqs. 9 and 19)."""
    return np.sqrt(((jacobian * np.asarray(resolutions)) ** 2).sum(axis=1) / 12)


def premium_period_power(offsets, amplitude, step, samples=400):
    """Power spectrum of the error of x over one period of the experiment, the same sine in t1, t2 and t3,
    quantized by rounding, averaged over offsets of the three angles [m^2 per line]."""
    sine = amplitude * np.sin(2 * math.pi * np.arange(samples) / samples)
    power = np.zeros(samples)
    for offset in offsets:
        angles = np.asarray(offset) + sine[:, None]
        error = premium_tip(np.rint(angles / step) * step) - premium_tip(angles)
        power += np.abs(np.fft.fft(error[:, 0]) / samples) ** 2
    return power / len(offsets)


def filtered_sigma(power, d, n, cutoff, rate):
    """Standard deviation of a periodic signal after the filter, from its power spectrum."""
    delay = np.exp(-2j * math.pi * np.arange(len(power)) / len(power))
    a = math.exp(-2 * math.pi * cutoff / rate)
    gain = np.abs(((1 - delay) * rate) ** d * ((1 - a) / (1 - a * delay)) ** n) ** 2
    return math.sqrt((power * gain)[1:].sum())
