#!/usr/bin/env python3
"""Pages of analyze and filter: well-formed and valid, without requests, small, the same for any threads; what they draw is what JSON and CSV say.

    check_pages.py --qerr build/qerr [--verbose]

Debian's `tidy` validates the HTML, and `chromium` shows the pages; without one of them its checks are skipped, which is said.
"""
import csv
import io
import json
import math
import pathlib
import re
import shutil
import subprocess
import tempfile
import xml.etree.ElementTree as Xml

from pages import CHROMIUM, HTML, SVG, axe_core, axis_titles, bar_cells, close, decoded, embedded, figures, line, marks, printed_pages, shown, written
from tool import program_and_tally, run

CONFIGS = pathlib.Path(__file__).resolve().parents[2] / "configs"
LARGEST = 800_000
NAMESPACES = ("http://www.w3.org/1999/xhtml", "http://www.w3.org/2000/svg")
TIDY = shutil.which("tidy")
PICTURE = re.compile(r'href="data:image/png;base64,[A-Za-z0-9+/]+=*"')


def page(t, qerr, name, *arguments, drawn=True, threads=(2,)):
    """threads: numbers of them, whose pages must be the same."""
    made = [run(qerr, *arguments, "--format", "html", "--threads", n, "--quiet") for n in threads]
    t.check(f"{name}: ends with 0", made[0].code == 0, made[0].err.decode(errors="replace"))
    t.check(f"{name}: the same bytes for any threads", all(other.out == made[0].out for other in made))
    t.check(f"{name}: below 800 kB", 0 < len(made[0].out) < LARGEST, str(len(made[0].out)))
    text = made[0].out.decode()
    bare = text
    for namespace in NAMESPACES:
        bare = bare.replace(f'xmlns="{namespace}"', "")
    bare = PICTURE.sub("", re.sub(r"<pre>.*?</pre>", "", bare, flags=re.S))
    t.check(f"{name}: fetches nothing", not re.search(r"https?:|\bsrc=|\bhref=|url\((?!#)|@import|fetch\(|XMLHttp|data:", bare))
    if TIDY:
        found = subprocess.run([TIDY, "-q", "-e", "-utf8"], input=made[0].out, capture_output=True)
        t.check(f"{name}: valid HTML", found.returncode == 0, found.stderr.decode()[:500])
    root = Xml.fromstring(text)
    pictures = [s for s in root.iter(SVG + "svg") if s.get("role") == "img"]
    t.check(f"{name}: has pictures with title and description",
            bool(pictures) == drawn and all(s.find(SVG + "title").text and s.find(SVG + "desc").text for s in pictures))
    return root


def check_heat_map(t, name, figure, coordinate, rows):
    image = next(i for i in figure.iter(SVG + "image") if i.get("data-span"))
    width, height, pixels = decoded(image)
    x0, x1, y0, y1 = map(float, image.get("data-span").split())
    low, high = float(image.get("data-from")), float(image.get("data-to"))
    x, y = (f"tip.{title.split()[0]} [m]" for title in axis_titles(figure))
    column = next(c for c in rows[0] if c.startswith(f"position.{coordinate}.worst_case ["))
    largest = {}
    for row in rows:
        at = (min(int((float(row[x]) - x0) / (x1 - x0) * width), width - 1),
              min(int((float(row[y]) - y0) / (y1 - y0) * height), height - 1))
        largest[at] = max(largest.get(at, 0), float(row[column]))
    wrong = []
    for c in range(width):
        for r in range(height):
            index, value = pixels[height - 1 - r][c], largest.get((c, r))
            wanted = 0 if value is None else 1 + 254 * (value - low) / (high - low)
            if abs(index - wanted) > (0.5 + 1e-6 if value is not None else 0):
                wrong.append((c, r, index, wanted))
    t.check(f"{name}: heat map of {coordinate} as in CSV", not wrong and len(largest) > 3, f"{len(wrong)}: {wrong[:3]}")


def percentile(ordered, percentage):
    at = percentage / 100 * (len(ordered) - 1)
    k = min(int(at), len(ordered) - 2)
    return ordered[k] + (at - k) * (ordered[k + 1] - ordered[k])


def check_distribution(t, name, figure, bound, column, rows):
    ordered = sorted(float(row[column]) for row in rows)
    drawn = line(figure, bound)
    t.check(f"{name}: distribution of {column} as in CSV",
            len(drawn) > 20 and all(close(x, percentile(ordered, y)) for x, y in drawn), str(drawn[:3]))


def check_robot(t, name, drawn, report, rows):
    """The outline at the tip of the least certain configuration against covariance and worst case of JSON and CSV."""
    at, joints = report["covariance"]["largest_at"], list(report["covariance"]["largest_at"])
    row = next(r for r in rows if all(
        close(float(next(v for k, v in r.items() if k.startswith(j + " ["))), at[j], 1e-12) for j in joints))
    names = report["covariance"]["coordinates"]
    covariance = report["covariance"]["at_largest"]
    for view in ("xy", "xz", "yz"):
        figure = drawn[f"View {view}, largest variance"]
        groups = [g.get("data-series") for g in figure.iter(SVG + "g") if g.get("data-series")]
        factor = float(next(re.search(r"one sigma, (\S+) times", g)[1] for g in groups if "one sigma" in g))
        tip = marks(figure, "robot")[-1]
        ellipse, box = (line(figure, next(g for g in groups if g.startswith(s))) for s in ("one sigma", "worst case"))
        for k, axis in enumerate(view):
            t.check(f"{name}: tip {axis} in view {view}", close(tip[k], float(row[f"tip.{axis} [m]"]), 1e-9))
            sigma = math.sqrt(covariance[names.index(axis)][names.index(axis)])
            worst = float(row[f"position.{axis}.worst_case [m]"])
            tolerance = 2e-5 * abs(tip[k])
            reached = max(p[k] for p in ellipse) - tip[k]
            # 36 points: the farthest is at least cos(5 deg) of the outline's reach.
            t.check(f"{name}: sigma of {axis} in view {view}",
                    0.996 * factor * sigma - tolerance <= reached <= factor * sigma + tolerance, f"{reached}, {factor * sigma}")
            t.check(f"{name}: worst case of {axis} in view {view}",
                    abs(max(p[k] for p in box) - tip[k] - factor * worst) <= tolerance)


def check_analysis(t, qerr, spec, *more):
    name = spec.parent.name
    root = page(t, qerr, f"analyze {name}", "analyze", spec, *more, threads=(1, 2))
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "points.csv"
        report = json.loads(run(qerr, "analyze", spec, *more, "--format", "json", "--quiet", "--per-configuration", file).out)
        rows = list(csv.DictReader(io.StringIO(file.read_text())))
    t.check(f"{name}: the page has the report's JSON", embedded(root) == report)
    drawn = figures(root)
    blocks = [("position", report["position"])] + [(f["filter"], f["coordinates"]) for f in report["derivatives"]]
    for block, coordinates in blocks:
        for c in coordinates:
            figure = drawn[f"Error of {block} {c['coordinate']}"]
            for bound in ("worst_case", "sigma"):
                if c.get(bound) is None:
                    continue
                wanted = [(c[bound][k], y) for k, y in (("min", 0), ("p50", 50), ("p95", 95), ("p99", 99), ("max", 100))]
                t.check(f"{name}: {block} {c['coordinate']} {bound} as in JSON", marks(figure, bound) == wanted,
                        f"{marks(figure, bound)} for {wanted}")
                before = "position." + c["coordinate"] if block == "position" else f"{block}.{c['coordinate']}"
                column = next(k for k in rows[0] if k.startswith(f"{before}.{bound} ["))
                check_distribution(t, name, figure, bound, column, rows)
    for c in report["position"]:
        maps = {caption: f for caption, f in drawn.items() if caption.startswith(f"Worst case of {c['coordinate']} over the workspace, ")}
        t.check(f"{name}: heat maps of {c['coordinate']} in one plane or in three", len(maps) in (1, 3), str(list(maps)))
        for caption, figure in maps.items():
            check_heat_map(t, f"{name}, {caption[-2:]}", figure, c["coordinate"], rows)
        caption = f"Share of the variance of {c['coordinate']}"
        if "share" in c:
            bars = {g.get("data-name"): float(g.get("data-value"))
                    for g in drawn[caption].iter(SVG + "g") if g.get("data-name")}
            t.check(f"{name}: shares of {c['coordinate']} as in JSON", bars == c["share"], f"{bars} for {c['share']}")


    if {"x", "y", "z"} <= {c["coordinate"] for c in report["position"]}:
        check_robot(t, name, drawn, report, rows)


def value_of_middle(root):
    """Of the cell in the middle of the first heat map, as its colour says."""
    image = next(i for i in root.iter(SVG + "image") if i.get("data-span"))
    width, height, pixels = decoded(image)
    index = pixels[int(0.503 * height)][int(0.503 * width)]
    low, high = float(image.get("data-from")), float(image.get("data-to"))
    return low + (index - 1) / 254 * (high - low)


def check_keys(t, keys, text):
    """Turned, zoomed, read and switched by keys alone."""
    t.check("keys: the next and the previous configuration", keys["largest"] == keys["back"] != keys["previous"], str(keys))
    yaw, pitch, scale = map(float, keys["reset"].split())
    t.check("keys: the robot turns", close(float(keys["turned"].split()[0]), yaw + 0.1, 1e-2), str(keys))
    t.check("keys: the robot comes closer", close(float(keys["closer"].split()[2]), 1.25 * scale, 1e-3), str(keys))
    data = json.loads(re.search(r'<script type="application/json">(.*?)</script>', text, re.S)[1])  # of the scene
    sigmas = [math.sqrt(data["poses"][0][-6 + k]) for k in (0, 3, 5)]
    said = re.search(r"sigma([\d.]+) um([\d.]+) um([\d.]+) um", keys["largest"])
    t.check("keys: sigma beside the robot is the scene's", said and all(close(1e-6 * float(a), b, 1e-3) for a, b in zip(said.groups(), sigmas)),
            f"{keys['largest']} {sigmas}")
    tip = [marks(figures(Xml.fromstring(text))[f"View {view}, largest variance"], "robot")[-1] for view in ("xy", "xz")]
    said = re.search(r"tip(-?[\d.]+) mm(-?[\d.]+) mm(-?[\d.]+) mm", keys["largest"])
    t.check("keys: the tip of the scene is that of the projections",
            said and all(close(1e-3 * float(a), b, 1e-3) for a, b in zip(said.groups(), (*tip[0], tip[1][1]))), f"{keys['largest']} {tip}")
    x, y = map(float, keys["point"].split(","))
    said = re.search(r": ([\d.]+) um, ([\d.]+) %", keys["value"])
    t.check("keys: the second value of the first line", said and close(1e-6 * float(said[1]), x, 1e-3) and close(float(said[2]), y, 1e-3), str(keys["value"]))
    t.check("keys: zoom changes line and ticks", keys["zoomed"][0] != keys["whole"][0] and keys["zoomed"][1] != keys["whole"][1], str(keys["zoomed"]))
    numbers = [[float(v) for v in re.findall(r"-?[\d.]+", keys[k][0])] for k in ("whole", "again")]
    t.check("keys: 0 shows all again", len(numbers[0]) == len(numbers[1]) and all(abs(a - b) < 0.02 for a, b in zip(*numbers)), str(keys["again"]))
    t.check("keys: a series is switched off and on", keys["off"] == "none" and keys["on"] == "", str((keys["off"], keys["on"])))


def check_in_browser(t, qerr):
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        page_file = pathlib.Path(folder) / "report.html"
        run(qerr, "analyze", CONFIGS / "kuka_lwr/spec.yaml", "-o", page_file, "--quiet")
        text = page_file.read_text()
        checker = axe_core()
        messages, sent, pointer, dom = shown(folder, text, 400, checker)
        t.check("browser: no message on the console", not messages, str(messages[:3]))
        t.check("browser: no request", sent == [], str(sent))
        t.check("browser: the script has run", "<output>" in dom and 'class="option" hidden' in dom)
        said = re.fullmatch(r"-?[\d.]+ [nmu]?m, -?[\d.]+ [nmu]?m: ([\d.]+) um", pointer or "")
        t.check("browser: position and value at the pointer, with prefix and unit",
                said and close(float(said[1]) * 1e-6, value_of_middle(Xml.fromstring(text)), 1e-3), pointer)
        check_keys(t, json.loads(written(dom, "keys")), text)
        t.check("browser: 400 pixels without overflow", int(written(dom, "width")) <= 0, written(dom, "width"))
        if checker:
            faults = [f for f in json.loads(written(dom, "axe")) if f[0] in ("serious", "critical")]
            t.check("browser: axe-core finds no serious fault", not faults, str(faults[:3]))
        else:
            print("skip  axe-core, which is not installed: npm install -g axe-core, or AXE_CORE=.../axe.min.js")
        for size in ("A4", "letter"):
            count = printed_pages(folder, text, size)
            t.check(f"browser: an arm of 7 joints, 6 coordinates and 2 filters on at most four pages, {size}", 1 <= count <= 4, str(count))
        wrong = '<img alt="" src="http://127.0.0.1:9/x"/><script>undefined_name()</script></body>'
        messages, sent, _, _ = shown(folder, text.replace("</body>", wrong))
        t.check("browser: a request and an error would be seen", sent == ["http://127.0.0.1:9/x"] and len(messages) >= 1,
                f"{sent}, {messages}")


def check_filters(t, qerr, spec):
    name = spec.parent.name
    root = page(t, qerr, f"filter {name}", "filter", spec)
    report = json.loads(run(qerr, "filter", spec, "--format", "json", "--quiet").out)
    t.check(f"filter {name}: the page has the report's JSON", embedded(root) == report)
    drawn = figures(root)
    for f in report["filters"]:
        figure = drawn[f"Noise against delay, derivative {f['derivative']}"]
        t.check(f"{name}: {f['name']} at its delay and norm",
                marks(figure, f["name"]) == [(f["group_delay_s"], f["h2_norm"])])
        slow = [p for p in line(drawn[f"Phase of {f['name']}"], "filter") if p[0] < 0.01 * f["bandwidth_hz"] * 2]
        t.check(f"{name}: the phase of {f['name']} is that of its delay at low frequencies",
                slow and all(close(y, -360 * x * f["group_delay_s"], 0.02) for x, y in slow), str(slow[:3]))
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "impulse.csv"
            run(qerr, "filter", spec, "--impulse", file, "--quiet")
            rows = [text.rsplit(",", 2) for text in file.read_text().splitlines()[1:]]
        values = {f"{float(time):.6g}": float(value) for who, time, value in rows if who == f["name"]}
        points = line(drawn[f"Impulse response of {f['name']}"], "impulse response")
        common = [(y, values[f"{x:.6g}"]) for x, y in points if f"{x:.6g}" in values]
        largest = max(abs(v) for v in values.values())
        # Six digits are written; values beyond the CSV's end have decayed.
        t.check(f"{name}: impulse response of {f['name']} as in CSV",
                len(common) >= 4 and all(abs(a - b) <= 1e-5 * max(abs(b), 1e-9 * largest) for a, b in common),
                str(common[:5]))


def check_sample(t, qerr):
    """Of more configurations the page draws a part, which it says; its ends and marks are those of all."""
    spec, more = CONFIGS / "scara/spec.yaml", ("--set", "configurations.count=40000")
    root = page(t, qerr, "analyze of 40000 configurations", "analyze", spec, *more)
    text = " ".join("".join(p.itertext()) for p in root.iter(HTML + "p"))
    t.check("a part of the configurations is said to be one", text.count("drawn from 32768 of them") == 2)
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "points.csv"
        run(qerr, "analyze", spec, *more, "--quiet", "--per-configuration", file)
        rows = [float(row["position.x.worst_case [m]"]) for row in csv.DictReader(io.StringIO(file.read_text()))]
    drawn, some = line(figures(root)["Error of position x"], "worst_case"), sorted(rows[:32768])
    wanted = [(min(rows) if y == 0 else max(rows) if y == 100 else percentile(some, y), y) for _, y in drawn]
    t.check("distribution of a part as in CSV", all(close(a[0], b[0]) for a, b in zip(drawn, wanted)), str(drawn[:3]))
    page(t, qerr, "analyze, grid", "analyze", spec, "--set", "configurations.method=grid", "--set", "configurations.count=8")


def drawn_limits(root, caption):
    return {float(p.get("data-limit")) for p in figures(root)[caption].iter(SVG + "path") if p.get("data-limit")}


def check_limits(t, qerr):
    some = ("--set", "configurations.count=500")
    root = page(t, qerr, "analyze with requirements", "analyze", CONFIGS / "kuka_lwr/spec.yaml", *some)
    drawn = drawn_limits(root, "Error of position z")
    t.check("the required limit is drawn", drawn == {0.00015}, str(drawn))
    arguments = ("analyze", CONFIGS / "scara/spec.yaml", *some, "--prove")
    root = page(t, qerr, "analyze --prove", *arguments)
    x = json.loads(run(qerr, *arguments, "--format", "json", "--quiet").out)["position"][0]
    drawn, proven = drawn_limits(root, "Error of position x"), {x[b]["proven"]["upper"] for b in ("worst_case", "sigma")}
    t.check("proven limits are drawn", proven <= drawn, f"{drawn} for {proven}")


def check_head(t, root, judged, override):
    """What the page is about: spec, override, hash, encoders, and each verdict with its margin."""
    head = next(d for d in root.iter(HTML + "div") if d.get("class") == "head")
    text = " ".join("".join(head.itertext()).split())
    wanted = [judged["spec"]["sha256"][:12], override, "counts a revolution", "qerr " + judged["qerr"]]
    t.check("head: spec, override, encoders, version", all(w in text for w in wanted), f"{wanted} in {text}")
    rows = [[" ".join("".join(c.itertext()).split()) for c in r.iter(HTML + "td")] for r in head.iter(HTML + "tr") if r.find(f"{HTML}td[@class='where']") is None][1:]
    for row, r in zip(rows, judged["requirements"], strict=True):
        margin = 1 - r["value"] / r["at_most"]
        t.check(f"head: {row[1]}", row[0].endswith(" met" if r["met"] else "not met") and close(float(row[-1].split()[0]), 100 * margin, 1e-2), str(row))


def check_verdicts(t, qerr):
    specs = [CONFIGS / arm / "spec.yaml" for arm in ("kuka_lwr", "scara")]
    few = ("--set", "configurations.count=500")
    for given in (specs[:1], specs):
        root = page(t, qerr, f"check of {len(given)}", "check", *given, *few, drawn=False)
        drawn = sorted(value for value, _ in bar_cells(root, "verdicts"))
        judged = json.loads(run(qerr, "check", *given, *few, "--format", "json", "--quiet").out)
        t.check(f"check of {len(given)}: the page has the report's JSON", embedded(root) == judged)
        all_specs = judged.get("reports", [judged])
        parts = sorted((r["value"] / r["at_most"] if "at_most" in r else r["at_least"] / r["value"]) for s in all_specs for r in s["requirements"])
        if len(given) == 1:
            check_head(t, root, all_specs[0], few[1])
        t.check("parts of the limits as in JSON", len(drawn) == len(parts) and all(close(a, b) for a, b in zip(drawn, parts)), f"{drawn} {parts}")


def check_refusal(t, qerr):
    made = run(qerr, "robot", CONFIGS / "kuka_lwr/kuka_lwr.urdf", "--format", "html")
    t.check("a report without a page is refused", made.code == 2 and not made.out, made.err.decode())
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "report.html"
        run(qerr, "filter", CONFIGS / "kuka_lwr/spec.yaml", "-o", file, "--quiet")
        t.check("the ending chooses the page", file.exists() and file.read_text().startswith("<!DOCTYPE html>"))


if __name__ == "__main__":
    program, tally = program_and_tally()
    for arm in ("kuka_lwr", "scara", "barrett_wam"):
        check_analysis(tally, program, CONFIGS / arm / "spec.yaml", "--set", "configurations.count=500")
        check_filters(tally, program, CONFIGS / arm / "spec.yaml")
    check_sample(tally, program)
    check_limits(tally, program)
    check_verdicts(tally, program)
    check_refusal(tally, program)
    if CHROMIUM:
        check_in_browser(tally, program)
    for name, found in (("tidy", TIDY), ("chromium", CHROMIUM)):
        if not found:
            print(f"skip  checks with {name}, which is not installed")
    raise SystemExit(tally.close())
