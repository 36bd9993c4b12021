#!/usr/bin/env python3
"""The page of simulate: well-formed, without requests, small, the same for any threads; what it draws is what JSON says, and the errors
that the log of the same run has.

    check_simulation_page.py --qerr build/qerr [--verbose]
"""
import cmath
import json
import math
import pathlib
import tempfile

from check_diagnosis_page import drawn_lines, rows, six
from check_pages import CONFIGS, HTML, SVG, figures, page
from pages import bar_cells, embedded
from tool import program_and_tally, run

TABLE = """qerr: 1
robot: {{joint: {{name: table, type: revolute, radius: 100 mm}}}}
coordinates: [x, y]
encoders: {{table: {{counts_per_rev: 3600}}}}
filters:
  velocity: {{derivative: 1, sample_rate: {rate}, lowpass: {{family: butterworth, order: 2, cutoff: 20 Hz}}}}
motion:
  sample_rate: 1 kHz
  duration: 2 s
  joints: {{table: {{center: 30 deg, sines: [{{amplitude: 20 deg, frequency: 1 Hz}}]}}}}
"""


def bars(figure):
    return {g.get("data-name"): g for g in figure.iter(SVG + "g") if g.get("data-name")}


def check_prediction(t, name, root, report):
    t.check(f"{name}: the page has the report's JSON", embedded(root) == report)
    sigma = bars(figures(root)["Simulated sigma over IPQN along the path"])
    t.check(f"{name}: the peaks as in JSON", [v for v, _ in bar_cells(root, "peaks")] == [r["peak_simulated"] for r in report["results"]])
    for r in report["results"]:
        label = f"{r['filter']} {r['coordinate']}"
        found = float(sigma[label].get("data-value"))
        t.check(f"{name}: sigma of {label}", found == r["sigma_simulated"] / r["sigma_ipqn_path"], str(found))
        error = next(sigma[label].iter(SVG + "path"))
        ends = [float(error.get(k)) for k in ("data-from", "data-to")]
        t.check(f"{name}: its interval", ends == [r[k] / r["sigma_ipqn_path"] for k in ("sigma_lower", "sigma_upper")], str(ends))


def check_ladder(t, name, root, r):
    label = f"{name}: ladder of {r['filter']} {r['coordinate']}"
    row = next(["".join(c.itertext()) for c in x] for x in root.iter(HTML + "tr") if len(x) == 7 and "".join(x[0].itertext()).endswith(f"{r['filter']} {r['coordinate']}"))
    found, wanted = [float(v) for v in row[3:] if v], [v for v in r["ladder"].values() if v is not None]
    t.check(f"{label}: the factors", len(found) == len(wanted) and all(math.isclose(a, b, rel_tol=1e-3) for a, b in zip(found, wanted)), f"{row} for {r['ladder']}")


def check_time(t, name, root, r):
    """The largest drawn error is the peak, inside the bounds, which are those of the report."""
    label = f"{r['filter']} {r['coordinate']}"
    lines = drawn_lines(figures(root)[f"Error of {label} in time"])
    largest = max(abs(y) for _, y in lines["error"])
    t.check(f"{name}: the peak of {label}", math.isclose(largest, r["peak_simulated"], rel_tol=1e-5), f"{largest} for {r['peak_simulated']}")
    for series, key in (("worst case along the path", "worst_case_path"), ("sigma, IPQN along the path", "sigma_ipqn_path")):
        drawn = {y for _, y in lines[series]}
        t.check(f"{name}: {series} of {label}", drawn == {float(f"{s * r[key]:.6g}") for s in (1, -1)}, str(drawn))


def errors_of_log(path, coordinate, settling):
    function = math.cos if coordinate == "x" else math.sin
    all_ = []
    for row in rows(path)[settling:]:
        read = 2 * math.pi / 3600 * int(row["table.counts"])
        all_.append((float(row["time [s]"]), 0.1 * (function(read) - function(float(row["table.reference [rad]"])))))
    return all_


def density(values, rate):
    """Welch's estimate by its definition: {frequency: density}."""
    n = 1 << int(math.log2(len(values) / 4))
    mean = sum(values) / len(values)
    window = [0.5 - 0.5 * math.cos(2 * math.pi * k / n) for k in range(n)]
    turns = [cmath.exp(-2j * math.pi * k / n) for k in range(n)]
    power, sections = [0.0] * (n // 2 + 1), 0
    for start in range(0, len(values) - n + 1, n // 2):
        part = [w * (v - mean) for w, v in zip(window, values[start:])]
        for f in range(n // 2 + 1):
            power[f] += abs(sum(p * turns[f * k % n] for k, p in enumerate(part))) ** 2
        sections += 1
    scale = 1 / (sections * rate * sum(w * w for w in window))
    return {f * rate / n: math.sqrt((1 if f == n // 2 else 2) * power[f] * scale) for f in range(1, n // 2 + 1)}


def check_log(t, qerr, root, spec, folder, report):
    log = folder / "log.csv"
    run(qerr, "simulate", spec, "--log", log, "-o", folder / "report.txt", "--quiet")
    for coordinate in ("x", "y"):
        wanted = errors_of_log(log, coordinate, report["settling_samples"])
        lines = drawn_lines(figures(root)[f"Error of position {coordinate} in time"])
        scale = max(abs(y) for _, y in wanted)
        known = {float(f"{x:.6g}"): y for x, y in wanted}
        off = [abs(y - known[x]) for x, y in lines["error"]]
        t.check(f"log: errors of {coordinate}", len(off) > 100 and max(off) < 1e-5 * scale, str(max(off) / scale))
        lines = drawn_lines(figures(root)[f"Spectrum of position {coordinate}"])
        exact = density([y for _, y in wanted], 1000)
        # Intervals hold one frequency each at the low end.
        compared = [(y, exact[min(exact, key=lambda f: abs(f - x))]) for x, y in lines["simulated"][:5]]
        t.check(f"log: spectrum of {coordinate}", all(math.isclose(a, b, rel_tol=1e-4) for a, b in compared), str(compared))
        square, drawn = sum(y * y for y in exact.values()), lines["simulated"]
        # Root mean squares of intervals whose ends are half way between the mean frequencies, about.
        ends = [0.0, *((a[0] + b[0]) / 2 for a, b in zip(drawn, drawn[1:])), 500.0]
        part = sum(y * y * (b - a) for (_, y), a, b in zip(drawn, ends, ends[1:])) / (square * min(exact))
        t.check(f"log: the power of {coordinate}", abs(part - 1) < 0.2, str(part))
        sigma = next(r["sigma_ipqn_path"] for r in report["results"] if (r["filter"], r["coordinate"]) == ("position", coordinate))
        white = {y for _, y in lines["white (IPQN)"]}
        t.check(f"log: white errors of {coordinate}", white == {float(f"{sigma * math.sqrt(2 / 1000):.6g}")}, str(white))


def check_table(t, qerr, rate):
    with tempfile.TemporaryDirectory() as work:
        folder = pathlib.Path(work)
        spec = folder / "table.yaml"
        spec.write_text(TABLE.format(rate=rate))
        root = page(t, qerr, f"table, {rate}", "simulate", spec)
        report = json.loads(run(qerr, "simulate", spec, "--format", "json", "--quiet").out)
        check_prediction(t, "table", root, report)
        for r in report["results"]:
            check_ladder(t, f"table, {rate}", root, r)
            check_time(t, f"table, {rate}", root, r)
        check_log(t, qerr, root, spec, folder, report)
        check_cutoffs(t, qerr, spec)


def check_cutoffs(t, qerr, spec):
    more = ("--cutoffs", "velocity=5Hz..100Hz")
    root = page(t, qerr, "cut-offs", "simulate", spec, *more)
    report = json.loads(run(qerr, "simulate", spec, *more, "--format", "json", "--quiet").out)["cutoffs"]
    lines = drawn_lines(figures(root)["Error over the cut-off"])
    for series, key in (("encoder error", "encoder_rms"), ("tracking error", "tracking_rms"), ("total", "total_rms")):
        wanted = [six(c["cutoff"], c[key]) for c in report["choices"]]
        t.check(f"cut-offs: {series}", [six(*p) for p in lines[series]][:len(wanted)] == wanted, str(lines[series][:3]))
    answer = next(p for p in root.iter(HTML + "p") if p.get("class") == "answer").text
    t.check("cut-offs: the best one in the answer", f"{report['best']:.3g}".rstrip("0").rstrip(".") in answer, answer)


def check_arm(t, qerr):
    """24 signals of seven joints, and a second run with other phases."""
    with tempfile.TemporaryDirectory() as work:
        spec = pathlib.Path(work) / "arm.yaml"
        filters = "\n".join(f"  f{d}: {{derivative: {d}, sample_rate: 1 kHz, lowpass: {{family: butterworth, order: 3, cutoff: 30 Hz}}}}"
                            for d in (0, 1, 2))
        joints = ", ".join(f"a{i}: {{sines: [{{amplitude: 30 deg, frequency: 0.{i}3 Hz}}]}}" for i in range(1, 8))
        spec.write_text(f"""qerr: 1
robot: {{urdf: {CONFIGS}/kuka_lwr/kuka_lwr.urdf}}
coordinates: [x, y, z, rx, ry, rz]
encoders: {{'*': {{counts_per_rev: 4096, gear_ratio: 100}}}}
filters:
{filters}
motion: {{sample_rate: 1 kHz, duration: 5 s, joints: {{{joints}}}}}
""")
        effects = "effects=[{type: backlash, joint: a2, gap: 0.2 mrad}]"
        for runs in ("1", "3"):
            root = page(t, qerr, f"arm, {runs} runs", "simulate", spec, "--runs", runs, "--set", effects, threads=(1, 2) if runs == "3" else (2,))
            report = json.loads(run(qerr, "simulate", spec, "--runs", runs, "--set", effects, "--format", "json", "--quiet").out)
            check_prediction(t, f"arm, {runs} runs", root, report)
            for r in report["results"]:
                check_ladder(t, f"arm, {runs} runs", root, r)
                if runs == "1":
                    check_time(t, "arm", root, r)


if __name__ == "__main__":
    program, tally = program_and_tally()
    check_table(tally, program, "1 kHz")
    check_table(tally, program, "250 Hz")
    check_arm(tally, program)
    raise SystemExit(tally.close())
