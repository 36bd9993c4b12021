"""Secs. V-B and V-C: what is said of Figs. 7 and 8 for acceleration, and of a smaller cut-off."""
import math

import independent
from claims import LOOSE, WRONG, Claim, confirmed_if, number, numbers, within
from section_v import ALL, ORDERS, SPEC, cutoff, norms, spaced
from tool import write_csv


def make(qerr, out):
    cutoffs = spaced(0.5, 499, 60)
    found = {f: norms(qerr("filter", SPEC, set=cutoff(f))) for f in cutoffs}
    rows = [[int(name[1]), int(name[3]), float(f), found[f][name]] for name in ALL for f in cutoffs]
    write_csv(out / "acceleration.csv", ["derivative", "order", "cutoff [Hz]", "sigma over sigma_x [1/s^d]"], rows)
    return [_falls(qerr), _exponents(qerr, cutoffs, found), _smaller_cutoff(qerr, cutoffs, found)]


def _falls(qerr):
    found = norms(qerr("filter", SPEC))
    series = [found[f"d2n{n}"] for n in ORDERS]
    gap = max(abs(s / independent.h2_by_lyapunov(2, n, 50, 1000) - 1) for s, n in zip(series, ORDERS))
    falling = all(found[f"d{d}n{n + 1}"] < found[f"d{d}n{n}"] for d in (2, 3) for n in (1, 2, 3, 4))
    return Claim(
        "Fig. 7",
        "The same for higher derivatives, such as acceleration: linear in sigma_x, falling with the order",
        "in words",
        f"sigma_a/sigma_x = {numbers(series, 4)} /s^2 for n = 1..4 (own (37): {within(gap, 1e-9)}); d = 3 falls, too",
        confirmed_if(falling),
    )


def _exponents(qerr, cutoffs, found):
    low, high = cutoffs[0], cutoffs[10]

    def slope(name):
        return math.log(found[high][name] / found[low][name]) / math.log(high / low)

    slopes = {d: [slope(f"d{d}n{n}") for n in ORDERS] for d in (2, 3)}
    prewarped = {**cutoff(499), **{f"filters.{name}.lowpass.discretization": "prewarped" for name in ALL}}
    ends = [norms(qerr("filter", SPEC, set=prewarped))[f"d2n{n}"] / 1e6 for n in ORDERS]
    return Claim(
        "Fig. 8",
        "The same type of behaviour for the acceleration: linear in f0 for low cut-offs, orders alike close to f",
        "linear",
        (
            f"exponents of f0 for n = 1..4, {number(low)} to {number(high)} Hz: acceleration {numbers(slopes[2])};"
            f" third derivative {numbers(slopes[3])}; f0 = 499 Hz of 1 kHz, prewarped: sigma_a/(f^2 sigma_x) ="
            f" {numbers(ends, 4)}"
        ),
        WRONG if max(abs(s - 1) for s in slopes[2]) > 0.1 else LOOSE,
        "min(n, d + 1/2), so that only n = 1 is linear; orders are alike close to f/2, if prewarped",
    )


def _smaller_cutoff(qerr, cutoffs, found):
    falls = all(found[low][name] < found[high][name] for name in ALL for low, high in zip(cutoffs, cutoffs[1:]))
    ratios, errors = {}, {}
    for f0 in (25, 50):
        filters = qerr("filter", SPEC, "--at", "5Hz", set=cutoff(f0)).json()["filters"]
        ratios[f0] = {f["name"]: f["h2_norm"] for f in filters}
        errors[f0] = {f["name"]: f["at"][0]["tracking_error"] for f in filters}
    less = [ratios[25][f"d2n{n}"] / ratios[50][f"d2n{n}"] for n in ORDERS]
    price = [100 * errors[25][f"d2n{n}"] for n in ORDERS], [100 * errors[50][f"d2n{n}"] for n in ORDERS]
    return Claim(
        "Sec. V-C",
        "A smaller cut-off rolls off sooner, so that the contribution of the noise is smaller",
        "in words",
        (
            f"d = 1..3, n = 1..5, 60 cut-offs: sigma falls with f0 {'in all' if falls else 'not in all'}; acceleration,"
            f" n = 1..4, 25 Hz in place of 50 Hz: sigma times {numbers(less)}, tracking error at 5 Hz"
            f" {numbers(price[0], 2)} % in place of {numbers(price[1], 2)} %"
        ),
        confirmed_if(falls),
        "The price is the tracking error, which the paper does not weigh",
    )
