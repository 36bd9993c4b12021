#!/usr/bin/env python3
"""Plots the output of `qerr diagnose SPEC LOG --plots FOLDER`: one PNG per joint, in the same folder.

    plot_diagnosis.py FOLDER

measured - reference over angle (by direction) and time, and its spectrum over the joint's orders; before and after subtraction
of the found effects. Needs numpy and matplotlib.
"""
import argparse
import csv
import pathlib
import re
import sys

import numpy as np

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ImportError:
    sys.exit("matplotlib is missing: apt-get install python3-matplotlib")

BEFORE, AFTER = "#d55e00", "#0072b2"
MOST = 20000  # points of a curve; more are not distinguishable


def by_joint(path):
    """{joint: {column: values}}; empty cells are nan."""
    joints = {}
    with open(path, encoding="utf-8", newline="") as f:
        for row in csv.DictReader(f):
            columns = joints.setdefault(row["joint"], {key: [] for key in row})
            for key, value in row.items():
                columns[key].append(value)
    text = ("joint", "unit")
    return {j: {k: v if k in text else np.array([float(x) if x else np.nan for x in v]) for k, v in c.items()}
            for j, c in joints.items()}


def scaled(peak, unit):
    """(factor, unit) by which the peak is between 1 and 1000."""
    for factor, prefix in ((1, ""), (1e3, "m"), (1e6, "u"), (1e9, "n")):
        if peak * factor >= 1:
            return factor, prefix + unit
    return 1e12, "p" + unit


def legend(axes):
    """At the top, with the axis extended so that it covers no points."""
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.2 * (high - low))
    axes.legend(loc="upper center", ncol=3, markerscale=5)


def draw(joint, curve, spectrum, path):
    unit = curve["unit"][0]
    k, name = scaled(max(np.abs(curve["before"]).max(), 1e-12), unit)
    every = max(1, len(curve["before"]) // MOST)
    at, before, after = (curve[c][::every] for c in ("reference", "before", "after"))
    side, time = curve["direction"][::every], curve["time [s]"][::every]
    figure, ((left, right), (bottom, orders)) = plt.subplots(2, 2, figsize=(12, 8), constrained_layout=True)
    right.sharey(left)
    figure.suptitle(f"{joint}: measured - reference, rms {k * np.sqrt(np.mean(curve['before'] ** 2)):.3g} {name} before, "
                    f"{k * np.sqrt(np.mean(curve['after'] ** 2)):.3g} {name} after")
    for axes, values, title in ((left, before, "before"), (right, after, "after")):
        for s, color, label in ((1, BEFORE, "forward"), (-1, AFTER, "backward"), (0, "0.5", "before it moved")):
            if np.any(side == s):
                axes.plot(at[side == s], k * values[side == s], ".", ms=2, color=color, label=label)
        axes.set(xlabel=f"reference [{unit}]", ylabel=f"residual [{name}]", title=title + ", by direction")
        legend(axes)
    x, label = (time, "time [s]") if np.all(np.isfinite(time)) else (np.arange(len(before)) * every, "row")
    bottom.plot(x, k * before, ".", ms=2, color=BEFORE, label="before")
    bottom.plot(x, k * after, ".", ms=2, color=AFTER, label="after")
    bottom.set(xlabel=label, ylabel=f"residual [{name}]", title="in time")
    legend(bottom)
    if spectrum:
        per = "per metre" if unit == "m" else "per revolution of the joint"
        orders.loglog(spectrum["order"], k * spectrum["before"], color=BEFORE, lw=1, label="before")
        orders.loglog(spectrum["order"], k * spectrum["after"], color=AFTER, lw=1, label="after")
        top = k * spectrum["before"].max()
        orders.set(xlabel=f"order, {per}", ylabel=f"amplitude [{name}]", title="spectrum over the position",
                   ylim=(1e-3 * top, 2 * top) if top > 0 else None)
        revolution = spectrum["order"][0] / spectrum["encoder_order"][0]
        if spectrum["order"][0] < revolution < spectrum["order"][-1]:
            orders.axvline(revolution, color="0.4", ls=":", label="one per revolution of the encoder")
        orders.legend(loc="upper right")
    for axes in figure.axes:
        axes.grid(alpha=0.3)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main():
    a = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    a.add_argument("folder", type=pathlib.Path)
    folder = a.parse_args().folder
    try:
        curves, spectra = by_joint(folder / "residual.csv"), by_joint(folder / "spectrum.csv")
    except OSError as fault:
        sys.exit(f"{fault}; make it with `qerr diagnose SPEC LOG --plots {folder}`")
    for joint, curve in curves.items():
        path = folder / (re.sub(r"[^\w.-]", "_", joint) + ".png")
        draw(joint, curve, spectra.get(joint), path)
        print(path)
    return 0 if curves else 1


if __name__ == "__main__":
    sys.exit(main())
