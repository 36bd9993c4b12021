"""Figs. 9 and 10: the sample rate, simulation against theory, and the filters' frequency response."""

import math

from claims import LOOSE, WRONG, Claim, number, numbers
from section_v import ORDERS, SIGMA_X, SPEC, cutoff, line, marks, norms, rate, simulation, spaced
from tool import write_csv

SIMULATED = (250, 500, 1000, 2000, 4000, 10_000, 40_000)  # [Hz]


def figure_9(qerr, out):
    rates = spaced(120, 60_000, 40)
    theory = {f: norms(qerr("filter", SPEC, set=rate(f))) for f in rates}
    found = {}
    for f in SIMULATED:
        command = qerr(
            "simulate", SPEC, "--runs", max(4, 10_000 // f), set={**rate(f), "motion.sample_rate": f"{f}Hz"}
        )
        found[f] = simulation(command)
    rows = [
        [d, n, float(f), SIGMA_X * theory[f][f"d{d}n{n}"], "", ""]
        for d in (1, 2)
        for n in ORDERS
        for f in rates
    ]
    rows += [
        [d, n, float(f), r["sigma_ipqn"], r["sigma_simulated"], r["sigma_exact"]]
        for d in (1, 2)
        for n in ORDERS
        for f in SIMULATED
        for r in [found[f][f"d{d}n{n}"]]
    ]
    write_csv(
        out / "figure_9.csv",
        [
            "derivative",
            "order",
            "sample_rate [Hz]",
            "sigma theory [m/s^d]",
            "sigma simulated [m/s^d]",
            "sigma exact at this motion [m/s^d]",
        ],
        rows,
    )
    out.draw(_plot_9, rates, theory, found)
    top = SIMULATED[-1]
    ratio = {f: found[f]["d1n2"]["sigma_simulated"] / found[f]["d1n2"]["sigma_ipqn"] for f in SIMULATED}
    return [
        Claim(
            "Fig. 9",
            "Simulation agrees with theory at every sample rate",
            "dotted lines",
            (
                f"d = 1, n = 2, one motion: simulated over theory {number(ratio[1000])} at 1 kHz,"
                f" {number(ratio[10_000])} at 10 kHz, {number(ratio[top])} at {top // 1000} kHz"
            ),
            LOOSE if abs(ratio[1000] - 1) < 0.05 else WRONG,
            (
                "A motion that stays the same makes fewer counts per sample as f rises, and the error stops"
                " being white"
            ),
        )
    ]


def _plot_9(rates, theory, found, out):
    import style

    fig, axes = style.figure(2)
    for axis, d, unit, factor in zip(axes, (1, 2), ("$\\sigma_v$ [mm/s]", "$\\sigma_a$ [m/s²]"), (1e3, 1)):
        for n in ORDERS:
            line(axis, rates, [factor * SIGMA_X * theory[f][f"d{d}n{n}"] for f in rates], n)
            marks(axis, SIMULATED, [factor * found[f][f"d{d}n{n}"]["sigma_simulated"] for f in SIMULATED], n)
        axis.set(xlabel="sample rate f [Hz]", ylabel=unit, xscale="log", yscale="log")
        axis.set_title(f"Fig. 9: {('velocity', 'acceleration')[d - 1]} error against sample rate")
    style.legend(axes[-1])
    style.save(fig, out / "figure_9.png")


def figure_10(qerr, out):
    corner = 50 / (2 * math.pi)  # the caption's 50 rad/s [Hz]
    command = qerr("filter", SPEC, set=cutoff(corner))
    rows = [
        [
            int(r["filter"][-1]),
            2 * math.pi * float(r["frequency [Hz]"]),
            float(r["magnitude"]),
            float(r["phase [rad]"]),
        ]
        for r in command.file("--response")
        if r["filter"] in {f"d2n{n}" for n in ORDERS}
    ]
    header = ["order", "frequency [rad/s]", "magnitude [1/s^2]", "phase [rad]"]
    write_csv(out / "figure_10.csv", header, rows)
    out.draw(_plot_10, rows)
    at = qerr("filter", SPEC, "--at", f"{corner:.17g}Hz", set=cutoff(corner)).json()["filters"]
    gains = {f["name"]: 1 + f["at"][0]["gain_error"] for f in at}
    return [
        Claim(
            "Fig. 10",
            "Cut-off of 50 rad/s; 50 Hz everywhere else",
            "50 rad/s",
            (
                f"gain over omega^2 at 50 rad/s, n = 1..4: {numbers((gains[f'd2n{n}'] for n in ORDERS), 4)}, that is"
                f" 2^(-n/2); a 50 Hz cut-off is {number(100 * math.pi)} rad/s"
            ),
            LOOSE,
            "Either figure can be meant; the plot here is as captioned",
        )
    ]


def _plot_10(rows, out):
    import style

    fig, axes = style.figure(2)
    for n in ORDERS:
        mine = [r for r in rows if r[0] == n and r[1] >= 1]
        omega = [r[1] for r in mine]
        axes[0].plot(omega, [r[2] for r in mine], **style.theory(n), label=f"n = {n}")
        axes[1].plot(omega, [math.degrees(r[3]) for r in mine], **style.theory(n), label=f"n = {n}")
    goal = {"color": "0.75", "linewidth": 6, "zorder": 1}
    axes[0].plot([1, 50], [1, 2500], solid_capstyle="butt", **goal)
    axes[0].plot([50, 50], [2500, 1], **goal)
    axes[1].plot([], [], label="ideal: $\\omega^2$\nup to the cut-off", **goal)
    axes[0].set(ylabel="magnitude [1/s²]", yscale="log", ylim=(1, 2e6))
    axes[1].set(ylabel="phase [°]")
    axes[0].set_title("Fig. 10: acceleration filters, cut-off 50 rad/s")
    axes[1].set_title("Fig. 10: their phase")
    for axis in axes:
        axis.set(xlabel=r"$\omega$ [rad/s]", xscale="log")
    style.legend(axes[1])
    style.save(fig, out / "figure_10.png")
