#!/usr/bin/env python3
"""Pages of analyze and filter: well-formed, without requests, small, the same for any threads; what they draw is what JSON and CSV say.

    check_pages.py --qerr build/qerr [--verbose]
"""
import json
import pathlib
import re
import tempfile
import xml.etree.ElementTree as Xml

from tool import program_and_tally, run

CONFIGS = pathlib.Path(__file__).resolve().parents[2] / "configs"
LARGEST = 300_000
SVG, HTML = "{http://www.w3.org/2000/svg}", "{http://www.w3.org/1999/xhtml}"
NAMESPACES = ("http://www.w3.org/1999/xhtml", "http://www.w3.org/2000/svg")


def page(t, qerr, name, *arguments):
    made = [run(qerr, *arguments, "--format", "html", "--threads", n, "--quiet") for n in (1, 2)]
    t.check(f"{name}: ends with 0", made[0].code == 0, made[0].err.decode(errors="replace"))
    t.check(f"{name}: the same bytes for one and two threads", made[0].out == made[1].out)
    t.check(f"{name}: below 300 kB", 0 < len(made[0].out) < LARGEST, str(len(made[0].out)))
    text = made[0].out.decode()
    bare = text
    for namespace in NAMESPACES:
        bare = bare.replace(f'xmlns="{namespace}"', "")
    bare = re.sub(r"<pre>.*?</pre>", "", bare, flags=re.S)
    t.check(f"{name}: fetches nothing", not re.search(r"https?:|\bsrc=|\bhref=|url\(|@import|fetch\(|XMLHttp", bare))
    root = Xml.fromstring(text)
    pictures = [s for s in root.iter(SVG + "svg") if s.get("role") == "img"]
    t.check(f"{name}: has pictures with title and description",
            pictures and all(s.find(SVG + "title").text and s.find(SVG + "desc").text for s in pictures))
    return root


def figures(root):
    """By their captions."""
    return {f.find(HTML + "figcaption").text: f for f in root.iter(HTML + "figure")}


def marks(figure, series):
    group = next(g for g in figure.iter(SVG + "g") if g.get("data-series") == series)
    return [(float(c.get("data-x")), float(c.get("data-y"))) for c in group.iter(SVG + "circle")]


def check_analysis(t, qerr, spec, *more):
    name = spec.parent.name
    root = page(t, qerr, f"analyze {name}", "analyze", spec, *more)
    report = json.loads(run(qerr, "analyze", spec, *more, "--format", "json", "--quiet").out)
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
    for c in report["position"]:
        caption = f"Share of the variance of {c['coordinate']}"
        if "share" in c:
            bars = {g.get("data-name"): float(g.get("data-value"))
                    for g in drawn[caption].iter(SVG + "g") if g.get("data-name")}
            t.check(f"{name}: shares of {c['coordinate']} as in JSON", bars == c["share"], f"{bars} for {c['share']}")


def check_filters(t, qerr, spec):
    name = spec.parent.name
    root = page(t, qerr, f"filter {name}", "filter", spec)
    report = json.loads(run(qerr, "filter", spec, "--format", "json", "--quiet").out)
    drawn = figures(root)
    for f in report["filters"]:
        figure = drawn[f"Noise against delay, derivative {f['derivative']}"]
        t.check(f"{name}: {f['name']} at its delay and norm",
                marks(figure, f["name"]) == [(f["group_delay_s"], f["h2_norm"])])
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "impulse.csv"
            run(qerr, "filter", spec, "--impulse", file, "--quiet")
            rows = [line.rsplit(",", 2) for line in file.read_text().splitlines()[1:]]
        values = {f"{float(time):.6g}": float(value) for who, time, value in rows if who == f["name"]}
        line = next(p for p in drawn[f"Impulse response of {f['name']}"].iter(SVG + "path") if p.get("data-points"))
        points = [p.split(",") for p in line.get("data-points").split()]
        common = [(float(y), values[f"{float(x):.6g}"]) for x, y in points if f"{float(x):.6g}" in values]
        largest = max(abs(v) for v in values.values())
        # Six digits are written; values beyond the CSV's end have decayed.
        t.check(f"{name}: impulse response of {f['name']} as in CSV",
                len(common) >= 4 and all(abs(a - b) <= 1e-5 * max(abs(b), 1e-9 * largest) for a, b in common),
                str(common[:5]))


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
    check_refusal(tally, program)
    raise SystemExit(tally.close())
