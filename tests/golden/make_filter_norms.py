#!/usr/bin/env python3
"""Writes filter_norms.csv: exact norms of filters of the families, by mpmath and without formulas of qerr.

    make_filter_norms.py > filter_norms.csv        (Debian's python3-mpmath; a few seconds)

Every filter is expanded in powers of z^-1 with hundreds of digits. H2: partial fractions, and
sum_k (k^m z^k)(k^n y^k) in closed form (Gram matrix of the modes). l1: h_k itself is a sum of modes; its signs are
found by bisection between sign changes of a polynomial (one multiple real pole) or by summing every term
(Butterworth, few samples). Columns: family, discretization, d, n, sample rate, cut-off, H2, l1.
"""
import sys

from mpmath import mp, mpf, mpc, binomial, exp, factorial, nstr, pi, sqrt, tan

mp.dps = 200


def times(p, q):
    r = [mpf(0)] * (len(p) + len(q) - 1)
    for i, x in enumerate(p):
        for j, y in enumerate(q):
            r[i + j] += x * y
    return r


def power(p, n):
    r = [mpf(1)]
    for _ in range(n):
        r = times(r, p)
    return r


def first_order(kind, d, n, rate, cutoff):
    """Numerator, and the one pole with its multiplicity: H = f^d (1-q)^d g^n (c0 + c1 q)^n / (1 - a q)^n."""
    x = 2 * pi * mpf(cutoff) / rate
    if kind == "matched":
        a, zero = exp(-x), [mpf(1)]
    elif kind == "backward_euler":
        a, zero = 1 / (1 + x), [mpf(1)]
    else:
        t = x / 2 if kind == "tustin" else tan(x / 2)
        a, zero = (1 - t) / (1 + t), [mpf(1) / 2, mpf(1) / 2]
    b = times(power([mpf(rate), -mpf(rate)], d), power([(1 - a) * c for c in zero], n))
    return b, a, n


def butterworth(d, n, rate, cutoff):
    rho = tan(pi * mpf(cutoff) / rate)
    b, poles = power([mpf(rate), -mpf(rate)], d), []
    gain = mpf(1)
    for i in range(n):
        w = -rho * mp.expjpi(mpf(2 * i + 1 - n) / (2 * n))
        poles.append((1 + w) / (1 - w))
        gain *= -w / (1 - w)
    b = [c * gain.real for c in times(b, power([mpf(1), mpf(1)], n))]
    return b, poles


def impulse(b, a, count):
    h = []
    for k in range(count):
        v = b[k] if k < len(b) else mpf(0)
        for j in range(1, min(k, len(a) - 1) + 1):
            v -= a[j] * h[k - j]
        h.append(v)
    return h


def multiple_pole(b, a, n):
    """Head h_0..h_{K-1} and the polynomial P with h_k = P(k) a^k for k >= K = max(len(b) - n, 0)."""
    start = max(len(b) - n, 0)
    den = power([mpf(1), -a], n)
    h = impulse(b, den, start + n)
    # Interpolate P through n points.
    xs = [mpf(start + i) for i in range(n)]
    ys = [h[start + i] / a ** (start + i) for i in range(n)]
    poly = [mpf(0)] * n
    for i in range(n):
        base, scale = [mpf(1)], mpf(1)
        for j in range(n):
            if j != i:
                base = times(base, [-xs[j], mpf(1)])
                scale *= xs[i] - xs[j]
        for j, c in enumerate(base):
            poly[j] += ys[i] * c / scale
    return h[:start], poly, start


def moments(a, degree):
    """sum_{k>=0} k^m a^k, m = 0..degree: k^m = sum_j S(m, j) k!/(k-j)!, sum k!/(k-j)! a^k = j! a^j/(1-a)^(j+1)."""
    return [sum(mp.stirling2(m, j) * factorial(j) * a ** j / (1 - a) ** (j + 1) for j in range(m + 1))
            for m in range(degree + 1)]


def tail_sum(poly, a, start):
    """sum_{k>=start} P(k) a^k."""
    shifted = [sum(poly[j] * binomial(j, i) * mpf(start) ** (j - i) for j in range(i, len(poly)))
               for i in range(len(poly))]
    return a ** start * sum(c * s for c, s in zip(shifted, moments(a, len(poly) - 1)))


def value(poly, k):
    r = mpf(0)
    for c in reversed(poly):
        r = r * k + c
    return r


def sign_changes(poly, start):
    """Integers k > start where P(k - 1) and P(k) differ in sign, by bisection between the changes of P's derivative."""
    if len(poly) <= 1:
        return []
    inner = sign_changes([j * c for j, c in enumerate(poly)][1:], start)
    edges = [start]
    for k in inner:
        edges += [k - 1, k]
    edges.append(max(edges[-1] * 2, 2) + 2 ** 60)
    found = []
    for low, high in zip(edges, edges[1:]):
        s = value(poly, low) > 0
        if (value(poly, high) > 0) == s:
            continue
        while high - low > 1:
            mid = (low + high) // 2
            if (value(poly, mid) > 0) == s:
                low = mid
            else:
                high = mid
        found.append(high)
    return found


def norms_of_multiple_pole(b, a, n):
    head, poly, start = multiple_pole(b, a, n)
    if a < 0:  # fast decay, alternating signs: |h_k| = |P(k)| |a|^k
        head, poly, a = [abs(h) for h in head], poly, -a
    squares = times(poly, poly)
    h2 = sum(h * h for h in head) + tail_sum(squares, a * a, start)
    edges = [start] + sign_changes(poly, start)
    tails = [tail_sum(poly, a, k) for k in edges] + [mpf(0)]
    l1 = sum(abs(h) for h in head) + sum(abs(x - y) for x, y in zip(tails, tails[1:]))
    return sqrt(h2), l1


def norms_of_poles(b, poles):
    a = [mpf(1)]
    for p in poles:
        a = times(a, [mpc(1), -p])
    a = [c.real for c in a]
    slowest = max(abs(p) for p in poles)
    start = max(len(b) - len(poles), 0)
    count = start + int(100 / -mp.log(slowest)) + 1
    h = impulse(b, a, count)
    # Modes from the last samples of the head: c_i by the residues of b(1/p)/prod.
    cs = []
    for i, p in enumerate(poles):
        r = sum(c * p ** -k for k, c in enumerate(b))
        for j, q in enumerate(poles):
            if j != i:
                r /= 1 - q / p
        cs.append(r)
    h2 = sum(x * x for x in h[:start])
    for ci, p in zip(cs, poles):
        for cj, q in zip(cs, poles):
            h2 += (ci * cj * (p * q) ** start / (1 - p * q)).real
    return sqrt(h2), sum(abs(x) for x in h)


def row(family, kind, d, n, rate, cutoff, norms):
    print(",".join([family, kind, str(d), str(n), str(rate), str(cutoff)] + [nstr(x, 25) for x in norms]))


def main():
    print("family,discretization,d,n,sample_rate,cutoff,h2,l1")
    for d in range(5):
        h = [binomial(2 * d, d) ** mpf(0.5) * 5000 ** d, mpf(2) ** d * 5000 ** d]
        row("difference", "", d, 0, 5000, "", h)
    settings = [(1000000, "0.1"), (20000, "3"), (500, "170"), (8000, "1234.5")]
    for kind in ["matched", "tustin", "prewarped", "backward_euler"]:
        for d in range(4):
            for n in range(1, 6):
                for rate, cutoff in [settings[(d + n) % 4], settings[(d + n + 1) % 4]]:
                    b, a, m = first_order(kind, d, n, rate, cutoff)
                    row("first_order", kind, d, n, rate, cutoff, norms_of_multiple_pole(b, a, m))
    for n in range(13, 21):  # slow decay, high order: cut-offs exactly representable as doubles
        for d in range(5):
            kind = ["matched", "tustin", "backward_euler"][(d + n) % 3]
            rate, cutoff = [(1000000, "5"), (400000, "0.96875"), (300000, "1.75"), (1000, "20")][(d + 2 * n) % 4]
            b, a, m = first_order(kind, d, n, rate, cutoff)
            row("first_order", kind, d, n, rate, cutoff, norms_of_multiple_pole(b, a, m))
    for d in range(4):
        for n in range(1, 9):
            rate, cutoff = [(2000, "20"), (500, "170"), (10000, "40"), (100, "49")][(d + n) % 4]
            row("butterworth", "", d, n, rate, cutoff, norms_of_poles(*butterworth(d, n, rate, cutoff)))
            print(f"butterworth {d} {n}", file=sys.stderr)


if __name__ == "__main__":
    main()
