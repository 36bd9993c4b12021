#!/usr/bin/env python3
"""Plots the output of `qerr diagnose SPEC LOG --plots FOLDER`: one PNG (or PDF) per joint that moves, in the same folder.

    plot_diagnosis.py [--format png|pdf] FOLDER [REPORT.json]

measured - reference over angle (by direction, with the fitted effects drawn through it) and time, and its spectrum over the joint's
orders; before and after subtraction of the found effects. With the report, which `-o REPORT.json` writes in the same run of qerr
(FOLDER/report.json is found by itself), also the verdict, each cause with its interval, and the residual against the quantity that
the cause depends on. A joint that does not move is named and left out. Needs numpy and matplotlib.
"""
import argparse
import csv
import json
import pathlib
import re
import sys
import textwrap

import numpy as np

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ImportError:
    sys.exit("matplotlib is missing: apt-get install python3-matplotlib")

BEFORE, AFTER, FIT = "#d55e00", "#0072b2", "black"
MOST = 20000  # points of a curve; more are not distinguishable
BINS = 200    # of the mean fit


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
    """(factor, unit) by which the peak is between 1 and 1000; of a quantity that is 0, the unit itself."""
    if not peak > 0:
        return 1, unit
    for factor, prefix in ((1, ""), (1e3, "m"), (1e6, "u"), (1e9, "n")):
        if peak * factor >= 1:
            return factor, prefix + unit
    return 1e12, "p" + unit


def legend(axes):
    """At the top, with the axis extended so that it covers no points."""
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.25 * (high - low))
    axes.legend(loc="upper center", ncol=3, fontsize=8)


def moves(curve):
    """Whether the joint moves: rows in time have a direction then; poses, which have no order, differ."""
    if np.all(np.isfinite(curve["time [s]"])):
        return bool(np.any(curve["direction"] != 0))
    return np.ptp(curve["reference"]) > 0


def corrected(columns):
    """Whether a found effect was subtracted."""
    return bool(np.any(columns["before"] != columns["after"]))


def means(x, y):
    """Middles of equal intervals of x, and the means of y in them."""
    edges = np.linspace(x.min(), x.max(), BINS + 1)
    number = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, BINS - 1)
    count = np.bincount(number, minlength=BINS)
    there = count > 0
    return (0.5 * (edges[:-1] + edges[1:]))[there], (np.bincount(number, y, BINS)[there] / count[there])


def draw_positions(axes, curve, column, k, unit, name):
    every = max(1, len(curve["before"]) // MOST)
    for side, color, label in ((1, BEFORE, "forward"), (-1, AFTER, "backward"), (0, "0.5", "before it moved")):
        rows = curve["direction"] == side
        if not np.any(rows) or (side == 0 and np.mean(rows) < 0.01):
            continue
        label = label if np.any(curve["direction"]) else "poses"
        at, values = curve["reference"][rows], k * curve[column][rows]
        axes.plot(at[::every], values[::every], ".", ms=2, color=color, label=label)
        fit = k * (curve["before"] - curve["after"])[rows]
        if column == "before" and np.any(fit) and at.size > 1 and np.ptp(at) > 0:
            axes.plot(*means(at, fit), color=FIT, lw=1.2, ls="-" if side == 1 else "--", label=f"fit, {label}")
    axes.set(xlabel=f"reference [{unit}]", ylabel=f"residual [{name}]", title=f"{column}, by direction")
    legend(axes)


def draw_time(axes, curve, k, name):
    every = max(1, len(curve["before"]) // MOST)
    time = curve["time [s]"]
    x, label = (time, "time [s]") if np.all(np.isfinite(time)) else (np.arange(len(time)), "row")
    axes.plot(x[::every], k * curve["before"][::every], ".", ms=2, color=BEFORE, label="before")
    if corrected(curve):
        axes.plot(x[::every], k * curve["after"][::every], ".", ms=2, color=AFTER, label="after")
    axes.set(xlabel=label, ylabel=f"residual [{name}]", title="in time")
    legend(axes)


def draw_spectrum(axes, spectrum, k, unit, name):
    per = "per metre" if unit == "m" else "per revolution of the joint"
    axes.loglog(spectrum["order"], k * spectrum["before"], color=BEFORE, lw=1, label="before")
    if corrected(spectrum):
        axes.loglog(spectrum["order"], k * spectrum["after"], color=AFTER, lw=1, label="after")
    top = k * spectrum["before"].max()
    axes.set(xlabel=f"order, {per}", ylabel=f"amplitude [{name}]", title="spectrum over the position",
             ylim=(1e-3 * top, 2 * top) if top > 0 else None)
    revolution = spectrum["order"][0] / spectrum["encoder_order"][0]
    if spectrum["order"][0] < revolution < spectrum["order"][-1]:
        axes.axvline(revolution, color="0.4", ls=":", label="one per revolution of the encoder")
    axes.legend(loc="upper right", fontsize=8)


def values_of(numbers):
    return np.array([np.nan if x is None else x for x in numbers], float)


def draw_curve(axes, title, curve, k, name):
    """The residual against the quantity that a cause depends on, and the fit through it."""
    unit = f" [{curve['unit']}]" if curve["unit"] else ""
    without = "residual without this" if curve["fit"] else "residual"
    axes.plot(curve["at"], k * values_of(curve["residual"]), "o", ms=3.5, color=BEFORE, label=without)
    if curve["fit"]:
        axes.plot(curve["at"], k * values_of(curve["fit"]), color=FIT, lw=1.2, label="fit")
    axes.set(xlabel=curve["against"] + unit, ylabel=f"residual [{name}]", title=title)
    legend(axes)


def parameter_text(p):
    """`gap 582 +- 0.15 urad`: value and half the 95 % interval."""
    value, lower, upper = (p[key] for key in ("value", "lower", "upper"))
    if value is None:
        return p["name"]
    k, unit = scaled(abs(value), p["unit"]) if p["unit"] else (1, "")
    half = "" if lower is None or upper is None or lower == upper else f" ± {k * (upper - lower) / 2:.2g}"
    return f"{p['name']} {k * value:.5g}{half} {unit}".rstrip()


def parts_of(report, joint):
    """Causes and what is left at a joint: [(text, curve or None)]."""
    causes = [(f"{c['effect']}: " + ", ".join(map(parameter_text, c["parameters"])), c["effect"], c["curve"])
              for c in report.get("causes", []) if c["joint"] == joint]
    left = [(f"unidentified: {u['what']}", "unidentified: " + u["what"], u["curve"])
            for u in report.get("unexplained", []) if u["joint"] == joint]
    return causes + left


def heading(joint, curve, k, name, report, parts):
    rms = [k * np.sqrt(np.mean(curve[c] ** 2)) for c in ("before", "after")]
    lines = [f"{joint}: measured - reference, rms {rms[0]:.3g} {name}" +
             (f" before, {rms[1]:.3g} {name} after" if corrected(curve) else "")]
    if report:
        verdict = report["verdict"].replace("_", " ").upper()
        lines.append("verdict of the log: " + verdict + (f": {report['reason']}" if report["reason"] else ""))
        lines += [text for text, _, _ in parts] or ["no cause at this joint"]
    # Names are text: a dollar sign begins no formula.
    return "\n".join(part for line in lines for part in textwrap.wrap(line, 150)).replace("$", r"\$")


def draw(joint, curve, spectrum, report, path):
    unit = curve["unit"][0]
    k, name = scaled(np.abs(curve["before"]).max(), unit)
    parts = parts_of(report, joint)
    columns = ("before", "after") if corrected(curve) else ("before",)
    panels = [lambda a, c=c: draw_positions(a, curve, c, k, unit, name) for c in columns]
    panels.append(lambda a: draw_time(a, curve, k, name))
    if spectrum:
        panels.append(lambda a: draw_spectrum(a, spectrum, k, unit, name))
    for _, title, values in parts:
        if values:
            panels.append(lambda a, title=title, values=values: draw_curve(a, title, values, k, name))
    rows = (len(panels) + 1) // 2
    figure, all_axes = plt.subplots(rows, 2, figsize=(12, 4 * rows), constrained_layout=True, squeeze=False)
    figure.suptitle(heading(joint, curve, k, name, report, parts), fontsize=10)
    for axes, panel in zip(all_axes.flat, panels):
        panel(axes)
        axes.grid(alpha=0.3)
    for axes in all_axes.flat[len(panels):]:
        axes.remove()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def file_name(joint, taken):
    """Of the joint; joints whose names differ in other characters alone are numbered."""
    plain = re.sub(r"[^\w.-]", "_", joint)
    name = plain
    while name in taken:
        name = f"{plain}_{len(taken)}"
    taken.add(name)
    return name


def main():
    a = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    a.add_argument("folder", type=pathlib.Path)
    a.add_argument("report", type=pathlib.Path, nargs="?", help="the report in JSON of the same diagnosis")
    a.add_argument("--format", choices=("png", "pdf"), default="png")
    arguments = a.parse_args()
    folder, report_file = arguments.folder, arguments.report
    if report_file is None and (folder / "report.json").exists():
        report_file = folder / "report.json"
    try:
        curves = by_joint(folder / "residual.csv")
        spectra = by_joint(folder / "spectrum.csv") if (folder / "spectrum.csv").exists() else {}
        report = json.loads(report_file.read_text(encoding="utf-8")) if report_file else {}
    except OSError as fault:
        sys.exit(f"{fault}; make it with `qerr diagnose SPEC LOG --plots {folder} -o {folder}/report.json`")
    except ValueError as fault:
        sys.exit(f"{report_file}: no JSON: {fault}")
    if report and report.get("command") != "diagnose":
        sys.exit(f"{report_file}: not a report of `qerr diagnose`")
    drawn = 0
    taken = set()
    for joint, curve in curves.items():
        if not moves(curve):
            print(f"{joint}: does not move: no picture")
            continue
        path = folder / f"{file_name(joint, taken)}.{arguments.format}"
        draw(joint, curve, spectra.get(joint), report, path)
        print(path)
        drawn += 1
    return 0 if drawn else 1


if __name__ == "__main__":
    sys.exit(main())
