"""Figs. 7 to 10: what sigma_x, cut-off, sample rate and order do to a derivative's error; simulation beside theory."""
import math

import independent
from claims import LOOSE, WRONG, Claim, confirmed_if, number, numbers
from tool import write_csv

SPEC = "configs/paper/section_v.yaml"
ORDERS = (1, 2, 3, 4)
ALL = [f"d{d}n{n}" for d in (1, 2, 3) for n in (1, 2, 3, 4, 5)]
SIGMA_X = 1e-4  # [m], the paper's nominal value
SIMULATED_CUTOFFS = (2, 5, 10, 20, 50, 100, 200, 400)
SIMULATED_RATES = (250, 500, 1000, 2000, 4000, 10_000, 40_000)


def spaced(low, high, count):
    return [low * (high / low) ** (i / (count - 1)) for i in range(count)]


def cutoff(value):
    return {f"filters.{name}.lowpass.cutoff": f"{value:.9g}Hz" for name in ALL}


def rate(value):
    return {f"filters.{name}.sample_rate": f"{value:.9g}Hz" for name in ALL}


def norms(command):
    return {f["name"]: f["h2_norm"] for f in command.json()["filters"]}


def simulation(command):
    """Filter name -> what simulate says of x."""
    return {r["filter"]: r for r in command.json()["results"]}


def make(qerr, out):
    return [*figure_7(qerr, out), *figure_8(qerr, out), *figure_9(qerr, out), *figure_10(qerr, out)]


def _line(axis, xs, ys, n, label="theory"):
    import style
    axis.plot(xs, ys, **style.theory(n), label=f"n = {n}, {label}")


def _marks(axis, xs, ys, n):
    import style
    axis.plot(xs, ys, **style.simulated(n), label=f"n = {n}, simulated")


def figure_7(qerr, out):
    import style
    rows, gap = [], 0
    for sigma_x in (2e-5, 4e-5, 6e-5, 8e-5, 1e-4, 1.2e-4, 1.4e-4, 1.6e-4, 1.8e-4, 2e-4):
        step = sigma_x * math.sqrt(12)
        command = qerr("simulate", SPEC, "--runs", 10, set={"encoders.slider": f"{{resolution: {step:.9g}}}"})
        found = simulation(command)
        for n in ORDERS:
            r = found[f"d1n{n}"]
            gap = max(gap, abs(r["sigma_ipqn"] / (sigma_x * independent.h2_by_lyapunov(1, n, 50, 1000)) - 1))
            rows.append([n, sigma_x, r["sigma_ipqn"], r["sigma_simulated"], r["sigma_lower"], r["sigma_upper"]])
    write_csv(out / "figure_7.csv", ["order", "sigma_x [m]", "sigma_v theory [m/s]", "sigma_v simulated [m/s]",
                                     "lower [m/s]", "upper [m/s]"], rows)
    fig, (axis,) = style.figure(1)
    for n in ORDERS:
        mine = [r for r in rows if r[0] == n]
        _line(axis, [1e3 * r[1] for r in mine], [1e3 * r[2] for r in mine], n)
        _marks(axis, [1e3 * r[1] for r in mine], [1e3 * r[3] for r in mine], n)
    axis.set(xlabel=r"$\sigma_x$ [mm]", ylabel=r"$\sigma_v$ [mm/s]", xlim=(0, None), ylim=(0, None))
    axis.set_title("Fig. 7: velocity error against position error")
    style.legend(axis)
    style.save(fig, out / "figure_7.png")
    slopes = {n: {r[2] / r[1] for r in rows if r[0] == n} for n in ORDERS}
    straight = all(max(s) / min(s) - 1 < 1e-6 for s in slopes.values())
    falling = all(max(slopes[n + 1]) < min(slopes[n]) for n in ORDERS[:-1])
    off = max(abs(r[3] / r[2] - 1) for r in rows)
    return [Claim("Fig. 7", "sigma_v is linear in sigma_x for all orders and falls with the order", "linear, falling",
                  f"sigma_v/sigma_x = {numbers((max(slopes[n]) for n in ORDERS), 4)} /s for n = 1..4 (own (37): within "
                  f"{gap:.0e}); simulation within {number(100 * off, 2)} %", confirmed_if(straight and falling),
                  str(command))]


def figure_8(qerr, out):
    import style
    cutoffs = spaced(0.5, 499, 60)
    theory = {f: norms(qerr("filter", SPEC, set=cutoff(f))) for f in cutoffs}
    found = {f: simulation(qerr("simulate", SPEC, "--runs", 10, set=cutoff(f))) for f in SIMULATED_CUTOFFS}
    rows = [[n, float(f), SIGMA_X * theory[f][f"d1n{n}"], ""] for n in ORDERS for f in cutoffs]
    rows += [[n, float(f), found[f][f"d1n{n}"]["sigma_ipqn"], found[f][f"d1n{n}"]["sigma_simulated"]]
             for n in ORDERS for f in SIMULATED_CUTOFFS]
    write_csv(out / "figure_8.csv", ["order", "cutoff [Hz]", "sigma_v theory [m/s]", "sigma_v simulated [m/s]"], rows)
    fig, axes = style.figure(2)
    for axis, scale in zip(axes, ("linear", "log")):
        for n in ORDERS:
            _line(axis, cutoffs, [1e3 * SIGMA_X * theory[f][f"d1n{n}"] for f in cutoffs], n)
            _marks(axis, SIMULATED_CUTOFFS, [1e3 * found[f][f"d1n{n}"]["sigma_simulated"] for f in SIMULATED_CUTOFFS], n)
        axis.set(xlabel=r"cut-off $f_0$ [Hz]", ylabel=r"$\sigma_v$ [mm/s]", xscale=scale, yscale=scale)
        axis.set_title(f"Fig. 8: velocity error against cut-off ({scale} axes)")
    style.legend(axes[-1])
    style.save(fig, out / "figure_8.png")

    low, high = cutoffs[0], cutoffs[10]
    slopes = [math.log(theory[high][f"d1n{n}"] / theory[low][f"d1n{n}"]) / math.log(high / low) for n in ORDERS]
    ends, spreads = {}, {}
    for family in ("matched", "prewarped"):
        overrides = {**cutoff(499), **{f"filters.{name}.lowpass.discretization": family for name in ALL}}
        command = qerr("filter", SPEC, set=overrides)
        found_norms = norms(command)
        ends[family] = [found_norms[f"d1n{n}"] / 1000 for n in ORDERS]
        spreads[family] = max(ends[family]) / min(ends[family]) - 1
    example = "qerr filter " + SPEC + " --set filters.d1n1.lowpass.cutoff=499Hz ..."
    return [
        Claim("Fig. 8", "For low cut-offs the error is roughly linear in f0 for all orders", "linear",
              f"exponents of f0 for n = 1..4, {number(low)} to {number(high)} Hz: {numbers(slopes)}",
              confirmed_if(max(abs(s - 1) for s in slopes) < 0.1),
              "qerr filter " + SPEC + " --set filters.d1n1.lowpass.cutoff=0.5Hz ...",
              "Linear for n = 1 only: d + 1/2 when n > d. On two logarithmic axes all are straight"),
        Claim("Fig. 8", "For cut-offs close to the sample rate all orders yield about the same error", "in words",
              f"f0 = 499 Hz of 1 kHz, n = 1..4: sigma_v/(f sigma_x) = {numbers(ends['matched'])} matched (spread "
              f"{number(100 * spreads['matched'], 2)} %), {numbers(ends['prewarped'], 4)} prewarped "
              f"({number(100 * spreads['prewarped'], 2)} %)", LOOSE if spreads["prewarped"] < 0.02 else WRONG, example,
              "True of a prewarped bilinear low-pass, which vanishes at f/2; half the sample rate is meant"),
    ]


def figure_9(qerr, out):
    import style
    rates = spaced(120, 60_000, 40)
    theory = {f: norms(qerr("filter", SPEC, set=rate(f))) for f in rates}
    found = {}
    for f in SIMULATED_RATES:
        command = qerr("simulate", SPEC, "--runs", max(4, 10_000 // f), set={**rate(f), "motion.sample_rate": f"{f}Hz"})
        found[f] = simulation(command)
    rows = [[d, n, float(f), SIGMA_X * theory[f][f"d{d}n{n}"], "", ""] for d in (1, 2) for n in ORDERS for f in rates]
    rows += [[d, n, float(f), r["sigma_ipqn"], r["sigma_simulated"], r["sigma_exact"]] for d in (1, 2) for n in ORDERS
             for f in SIMULATED_RATES for r in [found[f][f"d{d}n{n}"]]]
    write_csv(out / "figure_9.csv", ["derivative", "order", "sample_rate [Hz]", "sigma theory [m/s^d]",
                                     "sigma simulated [m/s^d]", "sigma exact at this motion [m/s^d]"], rows)
    fig, axes = style.figure(2)
    for axis, d, unit, factor in zip(axes, (1, 2), ("$\\sigma_v$ [mm/s]", "$\\sigma_a$ [m/s²]"), (1e3, 1)):
        for n in ORDERS:
            _line(axis, rates, [factor * SIGMA_X * theory[f][f"d{d}n{n}"] for f in rates], n)
            _marks(axis, SIMULATED_RATES, [factor * found[f][f"d{d}n{n}"]["sigma_simulated"] for f in SIMULATED_RATES], n)
        axis.set(xlabel="sample rate f [Hz]", ylabel=unit, xscale="log", yscale="log")
        axis.set_title(f"Fig. 9: {('velocity', 'acceleration')[d - 1]} error against sample rate")
    style.legend(axes[-1])
    style.save(fig, out / "figure_9.png")
    top = SIMULATED_RATES[-1]
    ratio = {f: found[f]["d1n2"]["sigma_simulated"] / found[f]["d1n2"]["sigma_ipqn"] for f in SIMULATED_RATES}
    return [Claim("Fig. 9", "Simulation agrees with theory at every sample rate", "dotted lines",
                  f"d = 1, n = 2, one motion: simulated over theory {number(ratio[1000])} at 1 kHz, {number(ratio[10_000])} at "
                  f"10 kHz, {number(ratio[top])} at {top // 1000} kHz",
                  LOOSE if abs(ratio[1000] - 1) < 0.05 else WRONG,
                  f"qerr simulate {SPEC} --runs 4 --set motion.sample_rate={top}Hz --set filters.d1n2.sample_rate={top}Hz ...",
                  "A motion that stays the same makes fewer counts per sample as f rises, and the error stops being white"
                  )]


def figure_10(qerr, out):
    import style
    corner = 50 / (2 * math.pi)  # the caption's 50 rad/s [Hz]
    command = qerr("filter", SPEC, set=cutoff(corner))
    rows = [r for r in command.file("--response") if r["filter"] in {f"d2n{n}" for n in ORDERS}]
    write_csv(out / "figure_10.csv", ["order", "frequency [rad/s]", "magnitude [1/s^2]", "phase [rad]"],
              [[int(r["filter"][-1]), 2 * math.pi * float(r["frequency [Hz]"]), float(r["magnitude"]),
                float(r["phase [rad]"])] for r in rows])
    fig, axes = style.figure(2)
    gains = {}
    for n in ORDERS:
        mine = [r for r in rows if r["filter"] == f"d2n{n}"]
        omega = [2 * math.pi * float(r["frequency [Hz]"]) for r in mine]
        keep = [i for i, w in enumerate(omega) if w >= 1]
        axes[0].plot([omega[i] for i in keep], [float(mine[i]["magnitude"]) for i in keep], **style.theory(n),
                     label=f"n = {n}")
        axes[1].plot([omega[i] for i in keep], [math.degrees(float(mine[i]["phase [rad]"])) for i in keep],
                     **style.theory(n), label=f"n = {n}")
        nearest = min(range(len(omega)), key=lambda i: abs(math.log(omega[i] / 50)))
        gains[n] = float(mine[nearest]["magnitude"]) / omega[nearest] ** 2
    goal = [1, 50]
    axes[0].plot(goal, [w * w for w in goal], color="0.75", linewidth=6, solid_capstyle="butt", zorder=1)
    axes[0].plot([50, 50], [2500, 1], color="0.75", linewidth=6, zorder=1)
    axes[0].set(xlabel=r"$\omega$ [rad/s]", ylabel="magnitude [1/s²]", xscale="log", yscale="log", ylim=(1, 2e6))
    axes[1].set(xlabel=r"$\omega$ [rad/s]", ylabel="phase [°]", xscale="log")
    axes[0].set_title("Fig. 10: acceleration filters, cut-off 50 rad/s")
    axes[1].set_title("Fig. 10: their phase")
    axes[1].plot([], [], color="0.75", linewidth=6, label="goal: $\\omega^2$,\nthen nothing")
    style.legend(axes[1])
    style.save(fig, out / "figure_10.png")
    return [Claim("Fig. 10", "Cut-off of 50 rad/s; 50 Hz everywhere else", "50 rad/s",
                  f"gain over omega^2 at 50 rad/s, n = 1..4: {numbers(gains[n] for n in ORDERS)}, that is 2^(-n/2); "
                  "a 50 Hz cut-off is 314 rad/s", LOOSE,
                  str(qerr("filter", SPEC, "--response", "response.csv",
                           set={"filters.d2n1.lowpass.cutoff": f"{corner:.4g}Hz"})),
                  "Either figure can be meant; the plot here is as captioned")]
