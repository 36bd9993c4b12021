#!/usr/bin/env python3
"""Writes filters.json: H2 norms and impulse responses of filters, independent of qerr's sources.

Every filter is built in the z plane by mpmath with 400 digits: textbook prototypes and the bilinear transform, Riccati
equations by doubling, fits by their normal equations. Where scipy.signal has the design, its response must agree to
1e-8, so that the names mean what they mean there. H2 is by Astrom's recursion on the coefficients in z, or by a Lyapunov equation.

    /usr/bin/python3 make_filters.py > filters.json        (Debian's python3-scipy, python3-mpmath; some seconds)
"""
import json
import random
import sys

import mpmath as mp
import numpy as np
from scipy import signal

mp.mp.dps = 400
RATE, SAMPLES = 1000, 12


def times(*factors):
    product = [mp.mpf(1)]
    for f in factors:
        longer = [mp.mpf(0)] * (len(product) + len(f) - 1)
        for i, x in enumerate(product):
            for j, y in enumerate(f):
                longer[i + j] += x * y
        product = longer
    return product


def real(c):
    return [mp.re(x) for x in c]


def h2_of(b, a):
    """sqrt(sum h_k^2) of b(q)/a(q), q = 1/z (Astrom 1970, ch. 5, discrete)."""
    n = max(len(a), len(b))
    a, b = a + [mp.mpf(0)] * (n - len(a)), b + [mp.mpf(0)] * (n - len(b))
    lead, total = a[0], mp.mpf(0)
    while a:
        alpha, beta = a[-1] / a[0], b[-1] / a[0]
        total += b[-1] ** 2 / a[0]
        n = len(a)
        b = [b[i] - beta * a[n - 1 - i] for i in range(n - 1)]
        a = [a[i] - alpha * a[n - 1 - i] for i in range(n - 1)]
    return mp.sqrt(total / lead)


def impulse_of(b, a, count=SAMPLES):
    h = []
    for k in range(count):
        value = b[k] if k < len(b) else mp.mpf(0)
        for j in range(1, min(k, len(a) - 1) + 1):
            value -= a[j] * h[k - j]
        h.append(value / a[0])
    return h


def bilinear(poles, zeros, gain, cutoff, rate):
    """The prototype at s = (1/rho)(1 - q)/(1 + q), gain at 0 Hz."""
    rho = mp.tan(mp.pi * mp.mpf(cutoff) / mp.mpf(rate))
    b, a = [mp.mpf(gain)], [mp.mpf(1)]
    for p in poles:  # 1 - s/p
        a = times(a, [1 - 1 / (rho * p), 1 + 1 / (rho * p)])
    for z in zeros:
        b = times(b, [1 - 1 / (rho * z), 1 + 1 / (rho * z)])
    b = times(b, *[[1, 1]] * (len(poles) - len(zeros)))
    return real(b), real(a)


def bessel(order, normalization):
    c = [mp.factorial(2 * order - k) / (2 ** (order - k) * mp.factorial(k) * mp.factorial(order - k)) for k in range(order + 1)]
    with mp.workdps(60):
        poles = [mp.mpc(p) for p in mp.polyroots(c[::-1], maxsteps=500, extraprec=600)]
        scale = mp.mpf(1)
        if normalization == "phase":
            scale = c[0] ** (-mp.mpf(1) / order)
        if normalization == "magnitude":
            power = lambda x: mp.log(abs(mp.polyval(c[::-1], 1j * x) / c[0]) ** 2 / 2)
            scale = 1 / mp.findroot(power, mp.sqrt((2 * order - 1) * mp.log(2)), tol=1e-50)
    return [p * scale for p in poles], [], 1


def chebyshev1(order, ripple):
    epsilon = mp.sqrt(mp.mpf(10) ** (mp.mpf(ripple) / 10) - 1)
    mu = mp.asinh(1 / epsilon) / order
    poles = [-mp.sinh(mu + 1j * mp.pi * m / (2 * order)) for m in range(1 - order, order, 2)]
    return poles, [], 1 if order % 2 else mp.mpf(10) ** (-mp.mpf(ripple) / 20)


def chebyshev2(order, attenuation):
    mu = mp.asinh(mp.sqrt(mp.mpf(10) ** (mp.mpf(attenuation) / 10) - 1)) / order
    zeros = [1j / mp.sin(mp.pi * m / (2 * order)) for m in range(1 - order, order, 2) if m]
    poles = [-1 / mp.sinh(mu + 1j * mp.pi * m / (2 * order)) for m in range(1 - order, order, 2)]
    return [mp.conj(p) for p in poles], zeros, 1


def elliptic(order, ripple, attenuation):
    """By mpmath's elliptic functions: k from the degree equation by root finding."""
    with mp.workdps(60):
        ratio = lambda m: mp.ellipk(1 - m) / mp.ellipk(m)
        epsilon2 = mp.mpf(10) ** (mp.mpf(ripple) / 10) - 1
        m1 = epsilon2 / (mp.mpf(10) ** (mp.mpf(attenuation) / 10) - 1)
        nome = mp.exp(-mp.pi * ratio(m1) / order)
        m = mp.mfrom(q=nome)
        assert abs(order * ratio(m) / ratio(m1) - 1) < 1e-45
        k, period = mp.sqrt(m), mp.ellipk(m)
        v = mp.ellipf(mp.atan(1 / mp.sqrt(epsilon2)), 1 - m1) / (order * mp.ellipk(m1))
        poles, zeros = [], []
        for i in range(1, order // 2 + 1):
            u = mp.mpf(2 * i - 1) / order
            p = 1j * mp.ellipfun("cd", (u - 1j * v) * period, m=m)
            z = 1j / (k * mp.ellipfun("cd", u * period, m=m))
            poles += [p, mp.conj(p)]
            zeros += [z, mp.conj(z)]
        if order % 2:
            poles.append(mp.re(1j * mp.ellipfun("sn", 1j * v * period, m=m)))
    return poles, zeros, 1 if order % 2 else mp.mpf(10) ** (-mp.mpf(ripple) / 20)


PROTOTYPES = {
    "bessel": (bessel, lambda o, normalization: dict(
        args=(signal.bessel, o), norm={"phase": "phase", "delay": "delay", "magnitude": "mag"}[normalization])),
    "chebyshev1": (chebyshev1, lambda o, ripple: dict(args=(signal.cheby1, o, ripple))),
    "chebyshev2": (chebyshev2, lambda o, attenuation: dict(args=(signal.cheby2, o, attenuation))),
    "elliptic": (elliptic, lambda o, ripple, attenuation: dict(args=(signal.ellip, o, ripple, attenuation))),
}


def check_with_scipy(b, a, family, parameters, cutoff, rate):
    more = {k: v for k, v in parameters.items() if k != "order"}
    call = PROTOTYPES[family][1](parameters["order"], **more)
    design, *rest = call.pop("args")
    sos = design(*rest, 2 * cutoff / rate, output="sos", **call)
    for frequency in (0.0, 0.3 * cutoff, cutoff, 2 * cutoff, 0.45 * rate):
        q = mp.expjpi(-2 * mp.mpf(frequency) / rate)
        ours = complex(mp.polyval(b[::-1], q) / mp.polyval(a[::-1], q))
        theirs = signal.sosfreqz(sos, worN=[2 * np.pi * frequency / rate])[1][0]
        assert abs(ours - theirs) < 1e-8, (family, parameters, frequency, ours, theirs)


def emit(rows, h2, impulse, **what):
    rows.append({**what, "h2": mp.nstr(h2, 25), "impulse": [mp.nstr(x, 20) for x in impulse]})


def numbers_and_choices(parameters):
    return {"numbers": {k: v for k, v in parameters.items() if not isinstance(v, str)},
            "choices": {k: v for k, v in parameters.items() if isinstance(v, str)}}


def lowpasses(rows):
    cases = [("bessel", dict(order=o, normalization=n)) for o in (1, 2, 5, 8) for n in ("phase", "delay", "magnitude")]
    cases += [("chebyshev1", dict(order=o, ripple=r)) for o, r in ((1, 1.0), (2, 0.5), (3, 1.0), (6, 3.0), (7, 0.01))]
    cases += [("chebyshev2", dict(order=o, attenuation=a)) for o, a in ((1, 20.0), (2, 40.0), (3, 40.0), (6, 60.0), (7, 25.0))]
    cases += [("elliptic", dict(order=o, ripple=r, attenuation=a))
              for o, r, a in ((1, 1.0, 40.0), (2, 0.5, 40.0), (3, 1.0, 40.0), (4, 0.1, 60.0), (7, 3.0, 90.0), (10, 0.5, 80.0))]
    cases += [("bessel", dict(order=20, normalization="phase"))]
    for family, parameters in cases:
        design = PROTOTYPES[family][0]
        prototype = design(**parameters)
        for cutoff, rate, derivative in ((50, 1000, 1), (220, 1000, 2), (0.1, 1e6, 1), (0.1, 1e6, 2)):
            b, a = bilinear(*prototype, cutoff, rate)
            if cutoff >= 50 and parameters["order"] < 12:
                check_with_scipy(b, a, family, parameters, cutoff, rate)
            b = times(b, *[[mp.mpf(rate), -mp.mpf(rate)]] * derivative)
            emit(rows, h2_of(b, a), impulse_of(b, a), family=family, derivative=derivative, sample_rate=rate,
                 **numbers_and_choices({**parameters, "cutoff": cutoff}))


def averages(rows):
    for rate, parameters in ((1000, {"alpha": 0.3}), (1000, {"alpha": 1}), (1e6, {"time_constant": 1.5}), (1000, {"time_constant": 0.004}), (1000, {"span": 9}), (1e6, {"span": 3e6})):
        if "alpha" in parameters:
            alpha = mp.mpf(parameters["alpha"])
        elif "span" in parameters:
            alpha = 2 / (mp.mpf(parameters["span"]) + 1)
        else:
            alpha = 1 - mp.exp(-1 / (mp.mpf(rate) * mp.mpf(parameters["time_constant"])))
        for derivative in (0, 1, 3):
            b, a = times([alpha], *[[mp.mpf(rate), -mp.mpf(rate)]] * derivative), [mp.mpf(1), alpha - 1]
            emit(rows, h2_of(b, a), impulse_of(b, a), family="exponential_moving_average", derivative=derivative,
                 sample_rate=rate, **numbers_and_choices(parameters))


def fitted(points, order, derivative, at, weights=None):
    """Weights of samples at `points` in the derivative at `at` of the polynomial that fits them."""
    powers = mp.matrix([[(x - at) ** j for j in range(order + 1)] for x in points])
    unit = mp.matrix(order + 1, 1)
    unit[derivative] = mp.factorial(derivative)
    return list(powers * mp.lu_solve(powers.T * powers, unit))


def taps(rows):
    def row(family, derivative, parameters, h):
        h = [x * mp.mpf(RATE) ** derivative for x in h]
        emit(rows, mp.sqrt(sum(x * x for x in h)), (h + [mp.mpf(0)] * SAMPLES)[:SAMPLES], family=family,
             derivative=derivative, sample_rate=RATE, **numbers_and_choices(parameters))

    for window, order, derivative, position in ((5, 2, 1, "center"), (21, 3, 1, "center"), (21, 2, 0, "end"), (21, 3, 2, "end"),
                                                (8, 3, 1, "center"), (101, 6, 3, "end"), (51, 10, 4, "end"), (400, 2, 1, "end")):
        at = mp.mpf(window - 1) / 2 if position == "center" else window - 1
        with mp.workdps(120):
            h = fitted([mp.mpf(window - 1 - k) for k in range(window)], order, derivative, at)
        theirs = signal.savgol_coeffs(window, order, deriv=derivative, pos=float(at) if window % 2 == 0 else int(at), use="conv")
        # scipy solves ill-conditioned normal equations in double: at order 10 no digit is correct.
        assert order > 6 or max(abs(float(x) - y) for x, y in zip(h, theirs)) < 1e-6 * max(abs(theirs)), (window, order)
        row("savitzky_golay", derivative, dict(window=window, polynomial_order=order, position=position), h)
    for window, order, derivative in ((2, 1, 1), (10, 1, 1), (30, 2, 1), (30, 2, 2), (15, 1, 0)):
        h = fitted([mp.mpf(window - 1 - k) for k in range(window)], order, derivative, window - 1)
        row("least_squares", derivative, dict(window=window, polynomial_order=order), h)
    for span, accuracy, derivative in ((1, 1, 1), (1, 1, 4), (7, 1, 1), (5, 1, 3), (1, 2, 1), (2, 3, 2), (1, 8, 4), (3, 1, 0)):
        order = derivative + accuracy - 1 if derivative else 0
        points = fitted([-mp.mpf(span * k) for k in range(order + 1)], order, derivative, 0)
        h = [mp.mpf(0)] * (order * span + 1)
        h[::span] = points
        row("finite_difference", derivative, dict(span=span, accuracy=accuracy), h)


def doubled_riccati(a, c, q, r):
    """P of the steady-state prediction, by the structure-preserving doubling algorithm."""
    n = a.rows
    A, G, H = a.T, c.T * c / r, q
    for _ in range(60):
        w = (mp.eye(n) + G * H) ** -1
        A, G, H, before = A * w * A, G + A * w * G * A.T, H + A.T * H * w * A, H
        if mp.mnorm(H - before) < mp.mnorm(H) * mp.mpf(10) ** -100:
            break
    return H


def observer(a, gain, derivative):
    """Norm and impulse response of a state of x(k|k) = A x(k-1|k-1) + gain (y - C A x(k-1|k-1))."""
    n = a.rows
    c = mp.matrix(1, n)
    c[0] = 1
    closed = (mp.eye(n) - gain * c) * a
    lyapunov = mp.matrix(n * n)
    constant = mp.matrix(n * n, 1)
    for i in range(n):
        for j in range(n):
            constant[i * n + j] = gain[i] * gain[j]
            for k in range(n):
                for l in range(n):
                    lyapunov[i * n + j, k * n + l] = (1 if (i, j) == (k, l) else 0) - closed[i, k] * closed[j, l]
    p = mp.lu_solve(lyapunov, constant)
    x, h = gain.copy(), []
    for _ in range(SAMPLES):
        h.append(x[derivative])
        x = closed * x
    return mp.sqrt(p[derivative * n + derivative]), h


def trackers(rows):
    def kinematics(n):
        return mp.matrix([[1 / mp.factorial(j - i) if j >= i else 0 for j in range(n)] for i in range(n)])

    def row(family, n, rate, parameters, gain):
        for derivative in range(n):
            h2, h = observer(kinematics(n), gain, derivative)
            f = mp.mpf(rate) ** derivative
            emit(rows, h2 * f, [x * f for x in h], family=family, derivative=derivative, sample_rate=rate,
                 **numbers_and_choices(parameters))

    def kalman_gain(n, q, r):
        c = mp.matrix(1, n)
        c[0] = 1
        p = doubled_riccati(kinematics(n), c, q, r)
        return p * c.T / ((c * p * c.T)[0] + r)

    models = {2: "constant_velocity", 3: "constant_acceleration"}
    for n in (2, 3):
        for index in (1e-9, 1e-4, 0.1, 1.0, 50.0):
            g = mp.matrix([mp.mpf(1) / 2, 1] if n == 2 else [mp.mpf(1) / 2, 1, 1])
            gain = kalman_gain(n, mp.mpf(index) ** 2 * g * g.T, mp.mpf(1))
            row("kalman", n, RATE, dict(model=models[n], tracking_index=index), gain)
            row("alpha_beta" if n == 2 else "alpha_beta_gamma", n, RATE, dict(tracking_index=index), gain)
        for rate, noise, sigma in ((1000, 0.3, 1e-5), (1e6, 1e-3, 1e-4), (10, 4.0, 0.5)):
            q = mp.matrix(n)  # int_0^1 of the powers: white noise into the last state
            for i in range(n):
                for j in range(n):
                    p = 2 * n - 1 - i - j
                    q[i, j] = 1 / (mp.mpf(p) * mp.factorial(n - 1 - i) * mp.factorial(n - 1 - j))
            scale = mp.mpf(noise) / mp.mpf(rate) ** (2 * n - 1) / mp.mpf(sigma) ** 2
            parameters = dict(model=models[n], process_noise=noise, measurement_noise=sigma)
            row("kalman", n, rate, parameters, kalman_gain(n, scale * q, mp.mpf(1)))
    for alpha, beta in ((0.5, 0.1), (0.9, 0.7), (1.5, 0.9), (0.01, 2e-5)):
        row("alpha_beta", 2, RATE, dict(alpha=alpha, beta=beta), mp.matrix([mp.mpf(alpha), mp.mpf(beta)]))
    for alpha, damping in ((0.3, 1), (0.75, 0.8), (0.02, 3)):
        a = mp.mpf(alpha)
        beta = mp.findroot(lambda b: a**2 - mp.mpf(damping) ** 2 * b * (4 - 2 * a - b), (a / 2 / damping) ** 2 * 4 / (4 - 2 * a))
        row("alpha_beta", 2, RATE, dict(alpha=alpha, damping=damping), mp.matrix([a, beta]))
    for alpha, beta, gamma in ((0.5, 0.2, 0.05), (0.875, 0.5625, 0.25), (1.2, 0.6, 0.2)):  # the second: a triple pole at 1/2
        row("alpha_beta_gamma", 3, RATE, dict(alpha=alpha, beta=beta, gamma=gamma),
            mp.matrix([mp.mpf(alpha), mp.mpf(beta), mp.mpf(gamma) / 2]))


def representations(rows):
    dice = random.Random(11)
    exact = lambda row: [mp.mpf(x) for x in row]
    for case in range(24):
        count, gap = 1 + case % 6, 10.0 ** -(1 + case % 9)
        sos = []
        for _ in range(count):
            modulus, angle = 1 - gap * (1 + dice.random()), mp.pi * (0.05 + 0.9 * dice.random())
            sos.append([dice.uniform(-1, 1), dice.uniform(-1, 1), dice.uniform(-1, 1), 2.0, float(-4 * modulus * mp.cos(angle)), 2 * modulus**2])
        b, a = times(*[exact(s[:3]) for s in sos]), times(*[exact(s[3:]) for s in sos])
        emit(rows, h2_of(b, a), impulse_of(b, a), representation="sos", values={"sos": sos})
    for case in range(24):
        gap = 10.0 ** -(1 + case % 9)
        poles, zeros = [], []
        for _ in range(1 + case % 4):
            modulus, angle = 1 - gap * (1 + dice.random()), dice.uniform(0.001, 3.1)
            re, im = modulus * float(mp.cos(angle)), modulus * float(mp.sin(angle))
            poles += [[re, im], [re, -im]]
        poles += [[1 - gap * dice.random()]] * (case % 3) + [[dice.uniform(-0.9, 0.9)]]
        zeros += [[1]] * (case % 2) + [[dice.uniform(-1, 1)]] + ([[0.3, 0.8], [0.3, -0.8]] if case % 3 else [])
        zeros = zeros[:len(poles)] if len(zeros) <= len(poles) else []
        root = lambda r: mp.mpc(*r)
        b = times([mp.mpf(0.5)], *[[mp.mpf(0), 1]] * (len(poles) - len(zeros)), *[[1, -root(z)] for z in zeros])
        a = times(*[[1, -root(p)] for p in poles])
        b, a = real(b), real(a)
        emit(rows, h2_of(b, a), impulse_of(b, a), representation="zpk", values={"zeros": zeros, "poles": poles, "gain": [[0.5]]})
    for case in range(16):
        n, gap = 1 + case % 8, 10.0 ** -(1 + case % 9)
        with mp.workdps(30):
            noise = mp.matrix(n, n).apply(lambda _: mp.mpf(dice.uniform(-1, 1)))
            turn = mp.qr(noise)[0] if n > 1 else mp.eye(1)
            diagonal = mp.matrix(n)
            for i in range(n):
                diagonal[i, i] = 1 - gap * (1 + dice.random()) if i == 0 else dice.uniform(-0.9, 0.95)
            state = turn * diagonal * turn.T
        A = [[float(state[i, j]) for j in range(n)] for i in range(n)]
        B, C = [dice.uniform(-1, 1) for _ in range(n)], [dice.uniform(-1, 1) for _ in range(n)]
        D = dice.uniform(-1, 1) if case % 2 else 0.0
        a, b, c = mp.matrix(A), mp.matrix(B), mp.matrix([C])
        lyapunov, constant = mp.matrix(n * n), mp.matrix(n * n, 1)
        with mp.workdps(80):
            for i in range(n):
                for j in range(n):
                    constant[i * n + j] = b[i] * b[j]
                    for k in range(n):
                        for l in range(n):
                            lyapunov[i * n + j, k * n + l] = (1 if (i, j) == (k, l) else 0) - a[i, k] * a[j, l]
            p = mp.lu_solve(lyapunov, constant)
            square = mp.mpf(D) ** 2 + sum(c[i] * c[j] * p[i * n + j] for i in range(n) for j in range(n))
        x, h = b, [mp.mpf(D)]
        for _ in range(SAMPLES - 1):
            h.append((c * x)[0])
            x = a * x
        emit(rows, mp.sqrt(square), h, representation="state_space",
             values={"A": A, "B": [[x] for x in B], "C": [C], "D": [[D]]})


def main():
    rows = []
    for part in (lowpasses, averages, taps, trackers, representations):
        part(rows)
        print(part.__name__, len(rows), file=sys.stderr)
    print("[\n" + ",\n".join(json.dumps(row) for row in rows) + "\n]")


if __name__ == "__main__":
    main()
