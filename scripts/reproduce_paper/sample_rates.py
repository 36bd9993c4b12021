"""Figs. 9 and 10: the sample rate, simulation beside theory, and the filters' frequency response."""

import math

from claims import LOOSE, WRONG, Claim, number, numbers
from section_v import ORDERS, SIGMA_X, SPEC, cutoff, line, marks, norms, rate, simulation, spaced
from tool import write_csv

SIMULATED = (250, 500, 1000, 2000, 4000, 10_000, 40_000)  # [Hz]


def make(qerr, out):
    return [*figure_9(qerr, out), *figure_10(qerr, out)]


def figure_9(qerr, out):
    import style

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
    fig, axes = style.figure(2)
    for axis, d, unit, factor in zip(axes, (1, 2), ("$\\sigma_v$ [mm/s]", "$\\sigma_a$ [m/s²]"), (1e3, 1)):
        for n in ORDERS:
            line(axis, rates, [factor * SIGMA_X * theory[f][f"d{d}n{n}"] for f in rates], n)
            marks(axis, SIMULATED, [factor * found[f][f"d{d}n{n}"]["sigma_simulated"] for f in SIMULATED], n)
        axis.set(xlabel="sample rate f [Hz]", ylabel=unit, xscale="log", yscale="log")
        axis.set_title(f"Fig. 9: {('velocity', 'acceleration')[d - 1]} error against sample rate")
    style.legend(axes[-1])
    style.save(fig, out / "figure_9.png")
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
                f"qerr simulate {SPEC} --runs 4 --set motion.sample_rate={top}Hz --set"
                f" filters.d1n2.sample_rate={top}Hz ..."
            ),
            (
                "A motion that stays the same makes fewer counts per sample as f rises, and the error stops"
                " being white"
            ),
        )
    ]


def figure_10(qerr, out):
    import style

    corner = 50 / (2 * math.pi)  # the caption's 50 rad/s [Hz]
    command = qerr("filter", SPEC, set=cutoff(corner))
    rows = [r for r in command.file("--response") if r["filter"] in {f"d2n{n}" for n in ORDERS}]
    write_csv(
        out / "figure_10.csv",
        ["order", "frequency [rad/s]", "magnitude [1/s^2]", "phase [rad]"],
        [
            [
                int(r["filter"][-1]),
                2 * math.pi * float(r["frequency [Hz]"]),
                float(r["magnitude"]),
                float(r["phase [rad]"]),
            ]
            for r in rows
        ],
    )
    fig, axes = style.figure(2)
    gains = {}
    for n in ORDERS:
        mine = [r for r in rows if r["filter"] == f"d2n{n}"]
        omega = [2 * math.pi * float(r["frequency [Hz]"]) for r in mine]
        keep = [i for i, w in enumerate(omega) if w >= 1]
        axes[0].plot(
            [omega[i] for i in keep],
            [float(mine[i]["magnitude"]) for i in keep],
            **style.theory(n),
            label=f"n = {n}",
        )
        axes[1].plot(
            [omega[i] for i in keep],
            [math.degrees(float(mine[i]["phase [rad]"])) for i in keep],
            **style.theory(n),
            label=f"n = {n}",
        )
        nearest = min(range(len(omega)), key=lambda i: abs(math.log(omega[i] / 50)))
        gains[n] = float(mine[nearest]["magnitude"]) / omega[nearest] ** 2
    goal = [1, 50]
    axes[0].plot(goal, [w * w for w in goal], color="0.75", linewidth=6, solid_capstyle="butt", zorder=1)
    axes[0].plot([50, 50], [2500, 1], color="0.75", linewidth=6, zorder=1)
    axes[0].set(
        xlabel=r"$\omega$ [rad/s]", ylabel="magnitude [1/s²]", xscale="log", yscale="log", ylim=(1, 2e6)
    )
    axes[1].set(xlabel=r"$\omega$ [rad/s]", ylabel="phase [°]", xscale="log")
    axes[0].set_title("Fig. 10: acceleration filters, cut-off 50 rad/s")
    axes[1].set_title("Fig. 10: their phase")
    axes[1].plot([], [], color="0.75", linewidth=6, label="goal: $\\omega^2$,\nthen nothing")
    style.legend(axes[1])
    style.save(fig, out / "figure_10.png")
    return [
        Claim(
            "Fig. 10",
            "Cut-off of 50 rad/s; 50 Hz everywhere else",
            "50 rad/s",
            (
                f"gain over omega^2 at 50 rad/s, n = 1..4: {numbers(gains[n] for n in ORDERS)}, that is"
                " 2^(-n/2); a 50 Hz cut-off is 314 rad/s"
            ),
            LOOSE,
            str(
                qerr(
                    "filter",
                    SPEC,
                    "--response",
                    "response.csv",
                    set={"filters.d2n1.lowpass.cutoff": f"{corner:.4g}Hz"},
                )
            ),
            "Either figure can be meant; the plot here is as captioned",
        )
    ]
