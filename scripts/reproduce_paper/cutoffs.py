"""Figs. 7 and 8: a velocity's error against that of position, and against the cut-off, with simulation."""

import math

import independent
from claims import LOOSE, WRONG, Claim, confirmed_if, number, numbers, within
from section_v import ORDERS, SIGMA_X, SPEC, ALL, cutoff, line, marks, norms, simulation, spaced
from tool import write_csv

SIMULATED = (2, 5, 10, 20, 50, 100, 200, 400)  # [Hz]


def figure_7(qerr, out):
    rows, gap = [], 0
    for sigma_x in (2e-5, 4e-5, 6e-5, 8e-5, 1e-4, 1.2e-4, 1.4e-4, 1.6e-4, 1.8e-4, 2e-4):
        step = sigma_x * math.sqrt(12)
        command = qerr("simulate", SPEC, "--runs", 10, set={"encoders.slider": f"{{resolution: {step:.9g}}}"})
        found = simulation(command)
        for n in ORDERS:
            r = found[f"d1n{n}"]
            gap = max(gap, abs(r["sigma_ipqn"] / (sigma_x * independent.h2_by_lyapunov(1, n, 50, 1000)) - 1))
            rows.append(
                [n, sigma_x, r["sigma_ipqn"], r["sigma_simulated"], r["sigma_lower"], r["sigma_upper"]]
            )
    write_csv(
        out / "figure_7.csv",
        [
            "order",
            "sigma_x [m]",
            "sigma_v theory [m/s]",
            "sigma_v simulated [m/s]",
            "lower [m/s]",
            "upper [m/s]",
        ],
        rows,
    )
    out.draw(_plot_7, rows)
    slopes = {n: {r[2] / r[1] for r in rows if r[0] == n} for n in ORDERS}
    straight = all(max(s) / min(s) - 1 < 1e-6 for s in slopes.values())
    falling = all(max(slopes[n + 1]) < min(slopes[n]) for n in ORDERS[:-1])
    off = max(abs(r[3] / r[2] - 1) for r in rows)
    return [
        Claim(
            "Fig. 7",
            "sigma_v is linear in sigma_x for all orders and falls with the order",
            "linear, falling",
            (
                f"sigma_v/sigma_x = {numbers((max(slopes[n]) for n in ORDERS), 4)} /s for n = 1..4 (own (37):"
                f" {within(gap, 1e-8)}); simulation within {number(100 * off, 2)} %"
            ),
            confirmed_if(straight and falling),
        )
    ]


def _plot_7(rows, out):
    import style

    fig, (axis,) = style.figure(1)
    for n in ORDERS:
        mine = [r for r in rows if r[0] == n]
        line(axis, [1e3 * r[1] for r in mine], [1e3 * r[2] for r in mine], n)
        marks(axis, [1e3 * r[1] for r in mine], [1e3 * r[3] for r in mine], n)
    axis.set(xlabel=r"$\sigma_x$ [mm]", ylabel=r"$\sigma_v$ [mm/s]", xlim=(0, None), ylim=(0, None))
    axis.set_title("Fig. 7: velocity error against position error")
    style.legend(axis)
    style.save(fig, out / "figure_7.png")


def figure_8(qerr, out):
    cutoffs = spaced(0.5, 499, 60)
    theory = {f: norms(qerr("filter", SPEC, set=cutoff(f))) for f in cutoffs}
    found = {f: simulation(qerr("simulate", SPEC, "--runs", 10, set=cutoff(f))) for f in SIMULATED}
    rows = [[n, float(f), SIGMA_X * theory[f][f"d1n{n}"], ""] for n in ORDERS for f in cutoffs]
    rows += [
        [n, float(f), found[f][f"d1n{n}"]["sigma_ipqn"], found[f][f"d1n{n}"]["sigma_simulated"]]
        for n in ORDERS
        for f in SIMULATED
    ]
    write_csv(
        out / "figure_8.csv",
        ["order", "cutoff [Hz]", "sigma_v theory [m/s]", "sigma_v simulated [m/s]"],
        rows,
    )
    out.draw(_plot_8, cutoffs, theory, found)

    low, high = cutoffs[0], cutoffs[10]
    slopes = [
        math.log(theory[high][f"d1n{n}"] / theory[low][f"d1n{n}"]) / math.log(high / low) for n in ORDERS
    ]
    ends, spreads = {}, {}
    for family in ("matched", "prewarped"):
        overrides = {**cutoff(499), **{f"filters.{name}.lowpass.discretization": family for name in ALL}}
        command = qerr("filter", SPEC, set=overrides)
        found_norms = norms(command)
        ends[family] = [found_norms[f"d1n{n}"] / 1000 for n in ORDERS]
        spreads[family] = max(ends[family]) / min(ends[family]) - 1
    return [
        Claim(
            "Fig. 8",
            "For low cut-offs the error is roughly linear in f0 for all orders",
            "linear",
            f"exponents of f0 for n = 1..4, {number(low)} to {number(high)} Hz: {numbers(slopes)}",
            confirmed_if(max(abs(s - 1) for s in slopes) < 0.1),
            "Linear for n = 1 only: d + 1/2 when n > d. On two logarithmic axes all are straight",
        ),
        Claim(
            "Fig. 8",
            "For cut-offs close to the sample rate all orders yield about the same error",
            "in words",
            (
                f"f0 = 499 Hz of 1 kHz, n = 1..4: sigma_v/(f sigma_x) = {numbers(ends['matched'])} matched"
                f" (spread {number(100 * spreads['matched'], 2)} %),"
                f" {numbers(ends['prewarped'], 4)} prewarped ({number(100 * spreads['prewarped'], 2)} %)"
            ),
            LOOSE if spreads["prewarped"] < 0.02 else WRONG,
            "True of a prewarped bilinear low-pass, which vanishes at f/2; half the sample rate is meant",
        ),
    ]


def _plot_8(cutoffs, theory, found, out):
    import style

    fig, axes = style.figure(2)
    for axis, scale in zip(axes, ("linear", "log")):
        for n in ORDERS:
            line(axis, cutoffs, [1e3 * SIGMA_X * theory[f][f"d1n{n}"] for f in cutoffs], n)
            marks(axis, SIMULATED, [1e3 * found[f][f"d1n{n}"]["sigma_simulated"] for f in SIMULATED], n)
        axis.set(xlabel=r"cut-off $f_0$ [Hz]", ylabel=r"$\sigma_v$ [mm/s]", xscale=scale, yscale=scale)
        axis.set_title(f"Fig. 8: velocity error against cut-off ({scale} axes)")
    style.legend(axes[-1])
    style.save(fig, out / "figure_8.png")
