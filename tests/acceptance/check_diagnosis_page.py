#!/usr/bin/env python3
"""The page of diagnose: well-formed, without requests, small, the same for any threads; what it draws is what JSON and the files of
--plots say.

    check_diagnosis_page.py --qerr build/qerr [--verbose] [--million]
"""
import csv
import json
import pathlib
import random
import re
import sys
import tempfile
import xml.etree.ElementTree as Xml

from check_pages import CONFIGS, HTML, LARGEST, SVG, figures, page
from pages import embedded, opened
from tool import program_and_tally, run

AXIS = """<robot name="axis"><link name="base"/><link name="disc"/><joint name="{name}" type="revolute"><parent link="base"/>
<child link="disc"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""
GEARED = """qerr: 1
robot: {{urdf: axis.urdf}}
encoders: {{{name}: {{counts_per_rev: 2048, gear_ratio: 50}}}}
motion:
  sample_rate: 500 Hz
  duration: {duration}
  joints: {{{name}: {{sines: [{{amplitude: 30 deg, frequency: 0.2 Hz}}, {{amplitude: 4 deg, frequency: 1.1 Hz}}]}}}}
"""
FAULTS = ("effects=[{{type: backlash, joint: {name}, gap: 2 arcmin}}, "
          "{{type: transmission_error, joint: {name}, order: 2, amplitude: 0.3 mrad, phase: 20 deg}}]")


def axis(folder, name='"a & <b>"', duration="10 s"):
    """A spec and its log with two effects."""
    bare = name.strip('"')
    (folder / "axis.urdf").write_text(AXIS.format(name=bare.replace("&", "&amp;").replace("<", "&lt;")), encoding="utf-8")
    (folder / "geared.yaml").write_text(GEARED.format(name=name, duration=duration), encoding="utf-8")
    return folder / "geared.yaml", bare


def simulated(t, qerr, spec, log, *effects):
    made = run(qerr, "simulate", spec, "--log", log, "-o", log.with_suffix(".txt"), "--quiet",
               *(word for effect in effects for word in ("--set", effect)))
    t.check(f"simulate {log.stem}", made.code == 0, made.err.decode())
    return log


def rows(path):
    with open(path, encoding="utf-8", newline="") as f:
        return list(csv.DictReader(f))


def drawn_lines(figure):
    """{series: its points}, of lines and of marks."""
    lines = {}
    for g in figure.iter(SVG + "g"):
        if g.get("data-series") is None:
            continue
        points = [tuple(float(v) for v in p.split(",")) for path in g.iter(SVG + "path") if path.get("data-points")
                  for p in path.get("data-points").split()]
        points += [(float(m.get("data-x")), float(m.get("data-y"))) for m in g.iter() if m.get("data-x")]
        lines[g.get("data-series")] = points
    return lines


def six(x, y):
    return float(f"{x:.6g}"), float(f"{y:.6g}")


def check_curve(t, name, lines, curve, observed):
    wanted = {observed: "residual", **({"fit": "fit"} if curve["fit"] else {})}
    t.check(f"{name}: the series of a curve", set(lines) == set(wanted), str(set(lines)))
    for series, key in wanted.items():
        pairs = [(x, y) for x, y in zip(curve["at"], curve[key]) if y is not None]
        same = [six(*p) for p in lines[series]] == [six(*p) for p in pairs]
        t.check(f"{name}: {series} as in JSON", same, f"{lines[series][:3]} for {pairs[:3]}")


def check_causes(t, name, root, report):
    drawn = figures(root)
    titles = [h.text for h in root.iter(HTML + "h3")]
    t.check(f"{name}: the page has the report's JSON", embedded(root) == report)
    rows = [tuple("".join(c.itertext()) for c in r) for r in root.iter(HTML + "tr")]
    for cause in report["causes"]:
        title = next((text for text in titles if text.startswith(cause["effect"]) and text.endswith(cause["joint"])), None)
        if not t.check(f"{name}: {cause['effect']} has its part", title is not None, str(titles)):
            continue
        if cause["curve"]:
            check_curve(t, f"{name}: {title}", drawn_lines(drawn[f"Residual without {title}, and its fit"]), cause["curve"],
                        "residual without this")
        for p in cause["parameters"]:
            row = next((r for r in rows if r[:2] == (title, p["name"])), None)
            sure = "< 1e-15" if cause["p_value"] < 1e-15 else f"{cause['p_value']:.2g}"
            t.check(f"{name}: {title}, {p['name']} in the table, and how sure it is", row is not None and float(row[3].replace("< ", "")) == float(sure.replace("< ", "")), str(row))


def check_extremes(t, name, points, pairs):
    """Each point is a row, and the smallest and largest rows are drawn. Six digits are written."""
    known = {six(*p) for p in pairs}
    drawn = {six(*p) for p in points}
    t.check(f"{name}: only rows of the record", drawn and drawn <= known, str(list(drawn - known)[:3]))
    for choose in (min, max):
        t.check(f"{name}: {choose.__name__}", choose(p[1] for p in drawn) == choose(p[1] for p in known))


def check_residuals(t, name, root, plots, report):
    drawn = figures(root)
    residual, spectrum = rows(plots / "residual.csv"), rows(plots / "spectrum.csv")
    for joint in dict.fromkeys(r["joint"] for r in residual):
        mine = [r for r in residual if r["joint"] == joint]
        corrected = any(c["joint"] == joint for c in report["causes"])
        column = {k: [float(r[k]) for r in mine] for k in ("time [s]", "reference", "direction", "before", "after")}
        lines = drawn_lines(drawn[f"Residual of {joint} in time"])
        t.check(f"{name}: {joint} before and after", set(lines) == ({"before", "after"} if corrected else {"before"}))
        for when, points in lines.items():
            check_extremes(t, f"{name}: {joint} in time, {when}", points, zip(column["time [s]"], column[when]))
            t.check(f"{name}: {joint} in time, few points", len(points) <= 1000, str(len(points)))
        for way, sign in (("forward", 1), ("backward", -1)):
            title = f"Residual of {joint} by position, {way}"
            here = [k for k, d in enumerate(column["direction"]) if d == sign]
            t.check(f"{name}: {joint} {way} is drawn", bool(here) == (title in drawn))
            if not here:
                continue
            check_extremes(t, f"{name}: {joint} {way}", drawn_lines(drawn[title])["before"],
                           [(column["reference"][k], column["before"][k]) for k in here])
            if corrected:
                check_extremes(t, f"{name}: {joint} {way}, after", drawn_lines(drawn[f"Residual of {joint} by position, after"])[way],
                               [(column["reference"][k], column["after"][k]) for k in here])
        orders = [r for r in spectrum if r["joint"] == joint]
        for when, points in drawn_lines(drawn[f"Orders in the residual of {joint}"]).items():
            known = {six(float(r["order"]), float(r[when])) for r in orders}
            t.check(f"{name}: orders of {joint} {when} as in spectrum.csv", {six(*p) for p in points} <= known)
            largest = max(float(r[when]) for r in orders)
            t.check(f"{name}: the largest order of {joint} {when}", abs(max(p[1] for p in points) / largest - 1) < 1e-5)


def check_fit(t, name, root, plots, joint):
    """The mean fit of all rows is that of its intervals, weighted with their rows; it stays within the rows' values."""
    residual = [r for r in rows(plots / "residual.csv") if r["joint"] == joint]
    for way, sign in (("forward", 1), ("backward", -1)):
        mine = [(float(r["reference"]), float(r["before"]) - float(r["after"])) for r in residual if float(r["direction"]) == sign]
        fit = drawn_lines(figures(root)[f"Residual of {joint} by position, {way}"])["fit"]
        half = 0.5 * min(b[0] - a[0] for a, b in zip(fit, fit[1:])) * 1.001
        off = []
        for at, mean in fit[:: max(1, len(fit) // 20)]:
            near = [y for x, y in mine if abs(x - at) <= half]
            if near:
                off.append(not min(near) - 1e-9 <= mean <= max(near) + 1e-9)
        t.check(f"{name}: the fit {way} is a mean of its rows", len(off) > 5 and not any(off), str(sum(off)))


def check_counts(t, name, root, log, joint, resolution):
    cycle = 64
    sums = {}
    for r in rows(log):
        count = int(r[f"{joint}.counts"])
        sums.setdefault(count % cycle, []).append(count * resolution - float(r[f"{joint}.reference [rad]"]))
    points = drawn_lines(figures(root)[f"Residual of {joint} by count"])["before"]
    off = [abs(y - sum(sums[int(x)]) / len(sums[int(x)])) for x, y in points]
    t.check(f"{name}: means by count", len(points) == len(sums) and max(off) < 1e-5 * max(abs(p[1]) for p in points), str(off[:4]))


def check_two_effects(t, qerr, folder):
    spec, joint = axis(folder)
    log = simulated(t, qerr, spec, folder / "log.csv", FAULTS.format(name='"' + joint + '"'))
    root = page(t, qerr, "two effects", "diagnose", spec, log)
    report = json.loads(run(qerr, "diagnose", spec, log, "--format", "json", "--plots", folder / "plots", "--quiet").out)
    answer = next(p for p in root.iter(HTML + "p") if p.get("class") == "answer").text
    t.check("two effects: the answer names verdict and causes",
            all(word in answer for word in (report["verdict"].upper(), *(c["effect"] for c in report["causes"]), joint)), answer)
    t.check("two effects: both are found", {c["effect"] for c in report["causes"]} == {"backlash", "transmission_error"})
    check_causes(t, "two effects", root, report)
    check_residuals(t, "two effects", root, folder / "plots", report)
    check_fit(t, "two effects", root, folder / "plots", joint)
    check_counts(t, "two effects", root, log, joint, 2 * 3.141592653589793 / (2048 * 50))


def check_arm(t, qerr, folder):
    """Joints with and without causes, some of them at rest."""
    spec = CONFIGS / "kuka_lwr/spec.yaml"
    arm = folder / "arm.yaml"
    arm.write_text(f"""qerr: 1
robot: {{urdf: {spec.parent}/kuka_lwr.urdf}}
encoders: {{'*': {{counts_per_rev: 4096, gear_ratio: 100}}}}
motion:
  sample_rate: 100 Hz
  duration: 20 s
  joints: {{{', '.join(f'a{i}: {{sines: [{{amplitude: 30 deg, frequency: 0.{i}3 Hz}}]}}' for i in range(1, 7))}}}
""")
    log = simulated(t, qerr, arm, folder / "arm.csv", "effects=[{type: eccentricity, joint: a2, amplitude: 0.1 mrad, phase: 1 rad}, "
                    "{type: offset, joint: a7, offset: 1 mrad}]")
    root = page(t, qerr, "arm", "diagnose", arm, log, threads=(1, 2))
    report = json.loads(run(qerr, "diagnose", arm, log, "--format", "json", "--plots", folder / "plots", "--quiet").out)
    check_causes(t, "arm", root, report)
    drawn = figures(root)
    t.check("arm: a joint at rest has no spectrum", "Residual of a7 in time" in drawn and "Orders in the residual of a7" not in drawn)
    gain = [[c.find(HTML + "bdi").text for c in row.iter(HTML + "td")] for table in root.iter(HTML + "table")
            for row in table.iter(HTML + "tr") if "counts before" in "".join(h.text for h in table.iter(HTML + "th"))]
    wanted = f"{report['gain']['counts_before']:.3g}"
    t.check("arm: the gain", any(row and row[0] == "all joints" and row[3] == wanted for row in gain), f"{gain} for {wanted}")


def check_poses(t, qerr, folder):
    """A table of poses has no time and no directions; the joint's name is written from the right."""
    spec, joint = axis(folder, "\u05de\u05e4\u05e8\u05e7")
    log = simulated(t, qerr, spec, folder / "log.csv", FAULTS.format(name=joint).replace("type: backlash", "type: offset").replace("gap", "offset"))
    lines = log.read_text(encoding="utf-8").splitlines()
    poses = random.Random(3).sample(lines[1:], 800)
    log.write_text("\n".join(",".join(line.split(",")[1:3]) for line in [lines[0], *poses]) + "\n", encoding="utf-8")
    root = page(t, qerr, "poses", "diagnose", spec, log)
    run(qerr, "diagnose", spec, log, "--plots", folder / "plots", "-o", folder / "report.json", "--quiet")
    drawn = {re.sub("[\u200e\u2068\u2069]", "", caption): f for caption, f in figures(root).items()}
    residual = rows(folder / "plots/residual.csv")
    position = [(float(r["reference"]), float(r["before"])) for r in residual]
    check_extremes(t, "poses: by position", drawn_lines(drawn[f"Residual of {joint} by position"])["before"], position)
    check_extremes(t, "poses: by row", drawn_lines(drawn[f"Residual of {joint} by row"])["after"],
                   [(k, float(r["after"])) for k, r in enumerate(residual)])
    summary = next(p.text for p in root.iter(HTML + "p") if "rms as recorded" in (p.text or ""))
    t.check("poses: the name does not take the number behind it", summary.startswith(f"\u200e\u2068{joint}\u2069: "), repr(summary))


def check_many_causes(t, qerr, folder):
    """Three causes at each of seven joints: the page draws all of them, and as many joints as stay below its size."""
    spec = folder / "arm.yaml"
    joints = [f"a{i}" for i in range(1, 8)]
    spec.write_text(f"""qerr: 1
robot: {{urdf: {CONFIGS}/kuka_lwr/kuka_lwr.urdf}}
encoders: {{'*': {{counts_per_rev: 4096, gear_ratio: 100}}}}
motion:
  sample_rate: 100 Hz
  duration: 20 s
  joints: {{{', '.join(f'{j}: {{sines: [{{amplitude: 30 deg, frequency: 0.0{k}7 Hz}}]}}' for k, j in enumerate(joints, 2))}}}
""")
    effects = ", ".join(f"{{type: backlash, joint: {j}, gap: 1 arcmin}}, {{type: eccentricity, joint: {j}, amplitude: 0.1 mrad, "
                        f"phase: 20 deg}}, {{type: transmission_error, joint: {j}, order: 2, amplitude: 0.3 mrad, phase: 1 rad}}"
                        for j in joints)
    log = simulated(t, qerr, spec, folder / "arm.csv", f"effects=[{effects}]")
    root = page(t, qerr, "many causes", "diagnose", spec, log)
    report = embedded(root)
    t.check("many causes: found", len(report["causes"]) >= 18, str(len(report["causes"])))
    check_causes(t, "many causes", root, report)
    drawn = [caption for caption in figures(root) if caption.startswith("Residual of") and caption.endswith("in time")]
    told = [item.text for item in root.iter(HTML + "li") if "rms as recorded" in (item.text or "")]
    t.check("many causes: each joint is drawn or told", len(drawn) >= 1 and len(drawn) + len(told) == 7, f"{drawn}, {told}")


def check_remainder(t, qerr, folder):
    """A step that no effect has: its curve, its advice."""
    spec, joint = axis(folder, "axis")
    log = simulated(t, qerr, spec, folder / "step.csv", "effects=[]")
    lines = log.read_text().splitlines()
    at = lines[0].split(",").index("axis.reference [rad]")
    moved = [line.split(",") for line in lines[1:]]
    for k, row in enumerate(moved):
        if k > 3000:
            row[at] = repr(float(row[at]) + 2.3e-3)
    log.write_text("\n".join([lines[0], *map(",".join, moved)]) + "\n")
    root = page(t, qerr, "step", "diagnose", spec, log)
    report = json.loads(run(qerr, "diagnose", spec, log, "--format", "json", "--quiet").out)
    curves = [u for u in report["unexplained"] if u["curve"]]
    t.check("step: something is left", bool(curves), str(report["verdict"]))
    shown = [drawn_lines(f) for c, f in figures(root).items() if c.startswith("Unidentified: axis: ")]
    t.check("step: every curve is drawn", len(shown) == len(curves))
    for u, lines in zip(curves, shown):
        check_curve(t, "step", lines, u["curve"], "residual without this" if u["curve"]["fit"] else "residual")
    t.check("step: what to do next", any(h.text == "What to record next" for h in root.iter(HTML + "h2")))


def check_without_pictures(t, qerr, folder):
    """A tracked tip alone, too few rows, no reference: a page without residuals, with its reason."""
    spec, joint = axis(folder, "axis")
    log = simulated(t, qerr, spec, folder / "whole.csv", FAULTS.format(name="axis"))
    lines = [line.split(",") for line in log.read_text().splitlines()]
    for name, kept, count in (("tip", (0, 1, 3, 4, 5), None), ("counts", (0, 1), None), ("short", (0, 1, 2), 6), ("two", (0, 1, 2), 3)):
        file = folder / f"{name}.csv"
        file.write_text("\n".join(",".join(row[i] for i in kept) for row in lines[:count]) + "\n")
        made = run(qerr, "diagnose", spec, file, "--format", "html", "--quiet")
        t.check(f"{name}: ends with 0", made.code == 0, made.err.decode())
        text = made.out.decode()
        report = json.loads(run(qerr, "diagnose", spec, file, "--format", "json", "--quiet").out)
        root = Xml.fromstring(text)
        answer = next(p for p in root.iter(HTML + "p") if p.get("class") == "answer").text
        t.check(f"{name}: the verdict", answer.startswith(report["verdict"].upper().replace("_", " ")), answer)
        t.check(f"{name}: the reason", report["reason"] in answer, answer)
        t.check(f"{name}: no residual where there is no reference", name == "short" or name == "two" or "Residual of" not in text)


def check_speed(t, qerr, folder):
    """A page of a long record is small, and takes little longer than JSON."""
    spec, joint = axis(folder, "axis", "60 s")
    log = simulated(t, qerr, spec, folder / "long.csv", FAULTS.format(name="axis"))
    runs = {form: [run(qerr, "diagnose", spec, log, "--format", form, "--quiet") for _ in range(2)] for form in ("json", "html")}
    seconds = {form: min(ran.seconds for ran in both) for form, both in runs.items()}
    t.check("long: at most 0.3 s of CPU time beyond the diagnosis", seconds["html"] < seconds["json"] + 0.3, str(seconds))
    text = runs["html"][0].out
    t.check("long: below 300 kB", len(text) < LARGEST, str(len(text)))
    t.check("long: no date, no path but the inputs'", not re.search(rb"\b20\d\d-\d\d-\d\d\b", text))


def check_million(t, qerr, folder):
    """A page of a million rows opens in less than a second, and scrolls without a task above 50 ms."""
    spec, joint = axis(folder, "axis", "2000 s")  # at 500 Hz
    log = simulated(t, qerr, spec, folder / "million.csv", FAULTS.format(name="axis"))
    t.check("million: rows", sum(1 for _ in log.open()) == 1_000_001)
    told = opened(folder, run(qerr, "diagnose", spec, log, "--format", "html", "--quiet").out.decode())
    t.check("million: opens in less than a second", 0 < told["loaded"] < 1000, str(told))
    t.check("million: scrolls without a task above 50 ms", not told["scrolled"], str(told))
    print(f"million: {told}")


if __name__ == "__main__":
    million = "--million" in sys.argv  # real time: not beside other work
    sys.argv = [a for a in sys.argv if a != "--million"]
    program, tally = program_and_tally()
    for check in (check_million,) if million else (check_two_effects, check_arm, check_poses, check_many_causes, check_remainder, check_without_pictures, check_speed):
        with tempfile.TemporaryDirectory() as work:
            check(tally, program, pathlib.Path(work))
    raise SystemExit(tally.close())
