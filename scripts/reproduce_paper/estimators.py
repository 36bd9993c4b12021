"""Appendix A and Fig. 14: velocity by counts per time (FDM) against time per count (ITM).

In units of Delta f a speed is counts per sample, V. qerr has a few speeds per decade; ITM depends on the
clock only through alpha = Delta f_c/v, so that other clocks give the speeds between them.
"""
import math

import numpy as np

from claims import LOOSE, WRONG, Claim, number, within
from tool import write_csv

SPEC = "configs/paper/quantized_sine.yaml"  # Delta = 1 mm, f = 1 kHz: Delta f = 1 m/s
BOUNDS = ("printed", "varying", "constant")


def make(qerr, out):
    itm, fdm = {b: {} for b in BOUNDS}, {b: {} for b in BOUNDS}
    for step in range(40):
        stretch = 10 ** (step / 40)
        command = qerr("filter", SPEC, "--estimators", "--clock", f"{1000 * stretch:.9g}Hz")
        for row in command.rows():
            v, error = float(row["quanta_per_sample"]), float(row["error"]) if row["error"] else math.inf
            if row["estimator"] == "inverse_time":
                itm[row["bound"]][round(v / stretch, 9)] = error / stretch
            elif step == 0:
                fdm[row["bound"]][v] = error
    rows = [
        [name, bound, v, error, v / error if error > 0 else math.inf]
        for name, table in (("FDM", fdm), ("ITM", itm))
        for bound in BOUNDS
        for v, error in sorted(table[bound].items())
    ]
    write_csv(out / "figure_14.csv", ["estimator", "bound", "v/(Delta f)", "error/(Delta f)", "SNR"], rows)
    out.draw(_plot, itm, fdm)
    return _claims(qerr, itm, fdm)


def itm_printed(v):
    """Eq. 53, SNR = V floor(1/V)."""
    return v * math.floor(1 / v) if v <= 1 else 0.0


def itm_tight(v):
    """V m (m + 1), m = floor(1/V): nearly m + 1 samples between edges are measured as m."""
    m = math.floor(1 / v)
    return v * m * (m + 1)


def simulate_itm(v_max, events, generator):
    """Largest |1/tau - 1/n| of a speed that falls evenly from v_max while the joint makes one count.

    A motion takes tau samples, from 1/v_max (no deceleration) up to twice that (it comes to rest).
    """
    whole = math.floor(1 / v_max) + 1
    tau = np.concatenate([generator.uniform(1 / v_max, longest, events) for longest in (whole, 2 / v_max)])
    begin = generator.uniform(0, 1, 2 * events)
    measured = np.ceil(begin + tau) - np.ceil(begin)
    return np.abs(1 / tau - 1 / measured).max()


def simulate_fdm(v, samples, generator):
    """Largest |V - counts per sample| at constant speed."""
    counts = np.diff(np.rint(generator.uniform() + v * np.arange(samples)))
    return np.abs(counts - v).max()


def _claims(qerr, itm, fdm):
    generator = np.random.default_rng(1)
    command = qerr("filter", SPEC, "--estimators")
    gap = max(abs(v / e - itm_printed(v)) for v, e in itm["printed"].items() if v <= 1)
    gap = max(gap, *(abs(v / e - itm_tight(v)) for v, e in itm["varying"].items() if v < 1))
    used = [
        simulate_itm(v, 200_000, generator) / itm["varying"][v]
        for v in sorted(itm["varying"])
        if 0.05 < v < 0.95
    ]
    counted = [simulate_fdm(v, 20_000, generator) / e for v, e in fdm["constant"].items() if e > 0]
    slow = [v for v in itm["printed"] if 0.5 < v < 1]
    ties = sum(abs(itm["printed"][v] - 1) < 1e-6 for v in slow)
    better = sum(itm["varying"][v] < 1 for v in slow)
    loose = {m: 1 / m * m * (m + 1) for m in (1, 5, 20)}
    cross = command.json()["estimators"][0]["crossing_speed"]
    fine = qerr("filter", SPEC, "--estimators", "--clock", "1MHz").json()["estimators"][0]["crossing_speed"]
    return [
        Claim(
            "(48)",
            "FDM: (x^t_k - x_k) + (x^t_{k-1} - x_{k-1}), at most Delta f",
            "Delta f",
            (
                f"varying speed {number(next(iter(fdm['varying'].values())))} Delta f; constant speed"
                f" max({{V}}, 1 - {{V}}): counted over qerr's {number(min(counted))} to"
                f" {number(max(counted))}"
            ),
            LOOSE,
            "The bound holds; the sign between the brackets must be minus",
        ),
        Claim(
            "(52), (53)",
            "ITM: at most Delta f/floor(alpha)",
            "Delta f/m",
            (
                f"least bound Delta f/(m (m + 1)), m = floor(alpha): (52) is loose by {number(loose[1])},"
                f" {number(loose[5])}, {number(loose[20])} at m = 1, 5, 20; simulated speeds reach"
                f" {number(min(used))} to {number(max(used))} of it"
            ),
            LOOSE if max(used) <= 1 + 1e-9 and min(used) > 0.9 else WRONG,
            "Valid, but loose by m + 1",
        ),
        Claim(
            "(45)",
            "v < Delta f: ITM outperforms FDM",
            "better",
            (
                f"with (49) and (53) both SNRs are equal at {ties} of {len(slow)} speeds between Delta f/2"
                f" and Delta f; with the least bound ITM is better at {better}"
            ),
            LOOSE if better == len(slow) else WRONG,
            "True, but it does not follow from (53)",
        ),
        Claim(
            "(46), Fig. 14",
            "The two cross over at v = Delta f",
            "1",
            (
                f"with least bounds at {number(cross)} Delta f (qerr against own formulas {within(gap, 1e-6)});"
                f" with a clock of 1 MHz, 1000 f, at {number(fine)} Delta f; (49) and (53) as printed are equal from"
                f" {number(min(v for v in slow if abs(itm['printed'][v] - 1) < 1e-6), 2)} Delta f to Delta f"
            ),
            LOOSE if abs(cross - 1) < 1e-9 else WRONG,
            "Only if edges are timed in whole samples, as in the paper; a timer moves it to about sqrt(clock/f) Delta f",
        ),
    ]


def _plot(itm, fdm, out):
    import style

    fig, (axis,) = style.figure(1, width=8.4, height=4.2)
    speeds = np.geomspace(0.05, 1, 4000)
    axis.plot([0.05, 5], [0.05, 5], **style.theory(1), label="FDM, (49)")
    axis.plot(
        speeds, [itm_printed(v) for v in speeds], **{**style.theory(2), "linestyle": "-"}, label="ITM, (53)"
    )
    axis.plot(
        speeds,
        [itm_tight(v) for v in speeds],
        **{**style.theory(3), "linestyle": "-"},
        linewidth=1,
        label="ITM, least bound",
    )
    axis.axvline(1, color="0.6", linewidth=1)
    axis.text(1.03, 0.06, r"above $\Delta f$: ITM has none", fontsize=9, color="0.3")
    for table, bound, n, label in (
        (fdm, "printed", 1, "FDM"),
        (itm, "printed", 2, "ITM, as printed"),
        (itm, "varying", 3, "ITM, least bound"),
    ):
        points = [(v, v / e) for v, e in sorted(table[bound].items()) if 0.05 <= v <= 5 and math.isfinite(e)]
        points = points[::3] if table is itm else points
        axis.plot(*zip(*points), **{**style.simulated(n), "markersize": 4}, label=f"qerr: {label}")
    axis.set(
        xlabel=r"velocity in units of $\Delta f$",
        ylabel="worst-case signal-to-noise ratio",
        xscale="log",
        yscale="log",
        xlim=(0.05, 5),
        ylim=(0.05, 30),
    )
    axis.set_title("Fig. 14: worst-case SNR of a velocity estimate")
    style.legend(axis)
    style.save(fig, out / "figure_14.png")
