"""Norms of the spec's filters from their impulse responses, in long double, by cascades of sections."""
import math

import numpy as np

L = np.longdouble
PI = L("3.14159265358979323846264338327950288")


def one_pole(kind, x):
    """(numerator, denominator) of one low-pass section, ascending in 1/z; x = 2 pi f0 T."""
    one = L(1)
    if kind == "matched":
        a = np.exp(-x)
        return [one - a], [one, -a]
    if kind == "backward_euler":
        a = one / (one + x)
        return [one - a], [one, -a]
    rho = x / 2 if kind == "tustin" else np.tan(x / 2)
    return [rho / (1 + rho), rho / (1 + rho)], [one, (rho - 1) / (rho + 1)]


def butterworth(order, x):
    rho, sections = np.tan(x / 2), []
    for i in range(order // 2):
        c = 2 * np.sin(PI * (2 * i + 1) / (2 * order))
        d = 1 + c / rho + 1 / rho**2
        sections.append(([1 / d, 2 / d, 1 / d], [L(1), (2 - 2 / rho**2) / d, (1 - c / rho + 1 / rho**2) / d]))
    if order % 2:
        sections.append(one_pole("tustin", 2 * rho))
    return sections


def sections_of(f):
    if "numerator" in f:
        a0 = L(f["denominator"][0])
        return [([L(v) / a0 for v in f["numerator"]], [L(v) / a0 for v in f["denominator"]])]
    rate = L(f["sample_rate"])
    sections = [([rate, -rate], [L(1)])] * f["derivative"]
    low = f.get("lowpass")
    if low:
        x = 2 * PI * L(low["cutoff"]) / rate
        if low["family"] == "butterworth":
            sections = sections + butterworth(low["order"], x)
        else:
            sections = sections + [one_pole(low.get("discretization", "matched"), x)] * low["order"]
    return sections


def dc_gain(f):
    value = 1.0
    for b, a in sections_of(f):
        value *= float(math.fsum(map(float, b))) / float(math.fsum(map(float, a)))
    return 0.0 if f.get("derivative", 0) and "numerator" not in f else value


def impulse(f, most=60000):
    sections = sections_of(f)
    states = [([L(0)] * len(b), [L(0)] * (len(a) - 1)) for b, a in sections]
    response, largest, quiet = [], L(0), 0
    for k in range(most):
        value = L(1) if k == 0 else L(0)
        for (b, a), (past_in, past_out) in zip(sections, states):
            past_in.insert(0, value)
            past_in.pop()
            value = sum((c * v for c, v in zip(b, past_in)), L(0)) - sum((c * v for c, v in zip(a[1:], past_out)), L(0))
            if past_out:
                past_out.insert(0, value)
                past_out.pop()
        response.append(value)
        largest = max(largest, abs(value))
        quiet = quiet + 1 if abs(value) <= largest * L(1e-20) else 0
        if quiet > 60:
            break
    return np.array(response)


def norms(f):
    h = impulse(f)
    return float(np.sqrt(np.sum(np.sort(h * h)))), float(np.sum(np.sort(np.abs(h))))
