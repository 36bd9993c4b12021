#!/usr/bin/env python3
"""Pages of filter, compare, sweep and design: what they draw is what JSON says, or what other runs compute.

    check_choice_pages.py --qerr build/qerr [--verbose]
"""
import json
import math
import pathlib
import re
import tempfile
import xml.etree.ElementTree as Xml

from check_pages import CONFIGS, HTML, LARGEST, SVG, close, figures, marks, page
from pages import bar_cells, embedded, text_of
from tool import program_and_tally, run

HARD_NAME = 'a<b> & "c" \u05d0\u05d1\u05d2 ' + "n" * 48


def report(qerr, *arguments, code=0):
    made = run(qerr, *arguments, "--format", "json", "--quiet")
    assert made.code == code, made.err.decode()
    return json.loads(made.out)


def bars(figure):
    return {g.get("data-name"): float(g.get("data-value")) for g in figure.iter(SVG + "g") if g.get("data-name")}


def line(figure, series):
    """Points of a line, six digits each, and those of its marks, all digits."""
    group = next(g for g in figure.iter(SVG + "g") if g.get("data-series") == series)
    paths = [p.get("data-points") for p in group.iter(SVG + "path") if p.get("data-points")]
    return [tuple(map(float, p.split(","))) for p in " ".join(paths).split()]


def check_filter(t, qerr, folder):
    spec = CONFIGS / "kuka_lwr/spec.yaml"
    root = page(t, qerr, "filter", "filter", spec)
    drawn = figures(root)
    for f in report(qerr, "filter", spec)["filters"]:
        caption = f"Norms of {f['name']} over the cut-off"
        if caption not in drawn:
            t.check(f"{f['name']}: said to have no cut-off", "there are no norms over a cut-off" in text_of(root))
            continue
        own = marks(drawn[caption], "this filter")
        cutoff = own[0][0]
        t.check(f"{f['name']}: marked at its norms", own == [(cutoff, f["h2_norm"]), (cutoff, f["l1_norm"]["upper"])])
        sigma, worst = (line(drawn[caption], s) for s in ("sigma, H2 norm", "worst case, l1 norm"))
        t.check(f"{f['name']}: over at least a decade", len(sigma) == len(worst) >= 9 and sigma[-1][0] > 2 * sigma[0][0])
        for i in (0, len(sigma) // 3, len(sigma) - 1):
            key = f"filters.{f['name']}.lowpass.cutoff={sigma[i][0]} Hz"
            other = next(g for g in report(qerr, "filter", spec, "--set", key)["filters"] if g["name"] == f["name"])
            # The cut-off has six digits, and the norms grow with up to its third power.
            for what, found, wanted in (("H2", sigma[i][1], other["h2_norm"]), ("l1", worst[i][1], other["l1_norm"]["upper"])):
                t.check(f"{f['name']}: {what} at {sigma[i][0]} Hz", abs(found - wanted) <= 3e-5 * wanted, f"{found} for {wanted}")
        front = line(drawn[f"Noise against delay, derivative {f['derivative']}"], "undominated low-passes")
        t.check(f"{f['name']}: no filter of the front equals another in noise and delay",
                len(front) > 5 and all(a[0] <= b[0] and a[1] >= b[1] for a, b in zip(front, front[1:])), str(front[:4]))
        t.check(f"{f['name']}: a step of the front is at most its noise at its delay",
                min(h2 for delay, h2 in front if delay <= f["group_delay_s"] * (1 + 1e-5)) <= f["h2_norm"] * (1 + 1e-5))
    page(t, qerr, "many filters", "filter", CONFIGS / "filters/filters.yaml")
    check_coefficients(t, qerr, folder)


def check_coefficients(t, qerr, folder):
    """Coefficients have no cut-off; names that markup must not read."""
    spec = folder / "coefficients.yaml"
    spec.write_text(json.dumps({"qerr": 1, "robot": {"urdf": str(CONFIGS / "kuka_lwr/kuka_lwr.urdf")}, "encoders": {"*": {"bits": 14}},
                                "filters": {HARD_NAME: {"derivative": 1, "sample_rate": 1000, "numerator": [1000, -1000],
                                                        "denominator": [1]}}}))
    root = page(t, qerr, "filter by coefficients", "filter", spec)
    t.check("coefficients: said to have no cut-off", "is given by its coefficients" in text_of(root))
    t.check("coefficients: the name as it is", HARD_NAME in text_of(root))


def check_compare(t, qerr):
    spec = CONFIGS / "scara/spec.yaml"
    arguments = ("compare", spec, spec, "--set", "encoders.elbow.counts_per_rev=1024", "--set", "configurations.count=300")
    root = page(t, qerr, "compare", *arguments, drawn=False)
    found, drawn = report(qerr, *arguments), figures(root)
    t.check("compare: the page has the report's JSON", embedded(root) == found)
    changed = {f"{f['figure']} {f['statistic']}".strip(): f for f in found["figures"]}
    changes = next(x for x in root.iter(HTML + "table") if x.get("class") == "changes")
    pairs = [(r.find(f"{HTML}td/{HTML}bdi").text, [float(c.get("data-value")) for c in r if c.get("data-value")]) for r in changes.find(HTML + "tbody")]
    t.check("compare: figures are drawn", len(pairs) >= 3)
    for name, pair in pairs:
        t.check(f"compare: {name} as in JSON", pair == [changed[name]["a"], changed[name]["b"]], str(pair))
    shares = [s[side] for s in found["shares"] for side in "ab"]
    t.check("compare: shares as in JSON", [v for v, _ in bar_cells(root, "shares")] == shares)
    flipped = [r for r in found["requirements"] if r["flipped"]]
    t.check("compare: a requirement flips", flipped)
    t.check("compare: when requirements flip as in JSON", sorted(v for v, _ in bar_cells(root, "flips")) == sorted(r["flips_after"] for r in flipped))
    t.check("compare: the hash of both", text_of(root).count(json.loads(run(qerr, "check", spec, "--json", "-q").out)["spec"]["sha256"][:12]) == 2)
    first = f"{flipped[0]['quantity']} {flipped[0]['statistic'] or ''}".strip()
    t.check("compare: the first one to flip is named",
            re.search("First to flip on the way from A to B[^:]*: .?" + re.escape(first), text_of(root)))
    same = page_without_pictures(t, qerr, "compare with itself", "compare", spec, spec)
    t.check("compare with itself: said", "all unchanged" in same and "No requirement flips" in same)


def page_without_pictures(t, qerr, name, *arguments, code=0):
    made = [run(qerr, *arguments, "--format", "html", "--threads", n, "--quiet") for n in (1, 2)]
    t.check(f"{name}: ends with {code}", made[0].code == code, made[0].err.decode(errors="replace"))
    t.check(f"{name}: the same bytes for one and two threads", made[0].out == made[1].out)
    t.check(f"{name}: below 300 kB", 0 < len(made[0].out) < LARGEST, str(len(made[0].out)))
    return text_of(Xml.fromstring(made[0].out.decode()))


def worded(value, unit):
    """A value as the spec writes it; numbers of more than eight characters have six digits."""
    if isinstance(value, str):
        return value
    digits = repr(value).removesuffix(".0")
    return (f"{value:.6g}" if len(digits) > 8 else digits) + (f" {unit}" if unit else "")


def swept(found, figure):
    """Values of a figure by the values of all keys."""
    values = {}
    for v in found["variants"]:
        named = {f"{f['quantity']} max": f["max"] for f in v.get("figures", [])}
        named.update({f"{r['quantity']} {r.get('statistic', '')}".strip(): r["value"] for r in v.get("requirements", [])})
        if named.get(figure) is not None:
            values[tuple(v["values"].items())] = named[figure]
    return values


def check_sweep_lines(t, qerr, name, spec, key, *more):
    """Every line of every picture over a key."""
    root = page(t, qerr, name, "sweep", spec, *more, threads=(1, 2))
    found, drawn = report(qerr, "sweep", spec, *more), figures(root)
    units, compared = found.get("units", {}), 0
    first = key
    for caption, figure in drawn.items():
        over = caption.split(" over ")  # the first key's pictures do not name it
        key, values = (over + [first])[1], swept(found, over[0])
        t.check(f"{name}: {caption} is a figure", values)
        groups = [g.get("data-series") for g in figure.iter(SVG + "g") if g.get("data-series")]
        for series in groups:
            if series.startswith("required: "):
                continue
            wanted = []
            for keys, value in values.items():
                others = ", ".join(f"{k} = {worded(v, units.get(k))}" for k, v in keys if k != key) or "all variants"
                if others in series.split("; "):
                    wanted.append((dict(keys)[key], value))
            points = line(figure, series)
            every = set((float(f"{x:.6g}"), float(f"{y:.6g}")) for x, y in wanted)
            t.check(f"{name}: {caption}, {series} as in JSON", points and set(points) <= every and points == sorted(points),
                    f"{points[:3]} for {sorted(every)[:3]}")
            t.check(f"{name}: {caption}, {series}: marks have all digits", set(marks(figure, series)) <= set(wanted))
            compared += len(points)
    t.check(f"{name}: points are compared", compared >= 8, str(compared))
    return root, found


def check_sweeps(t, qerr, folder):
    few = ("--set", "configurations.count=100", "--set", "motion.duration=0.4")
    root, _ = check_sweep_lines(t, qerr, "sweep scara", CONFIGS / "scara/spec.yaml", "encoders.wrist.bits", *few)
    t.check("sweep scara: the rest of the lines is said", re.search(r"\d of 9 combinations of the other keys", text_of(root)))
    cutoff = "filters.velocity.lowpass.cutoff"
    one_axis = (*few, "--set", f"sweep=[{{key: {cutoff}, from: 10 Hz, to: 1 kHz, count: 7, scale: log}}]")
    root, found = check_sweep_lines(t, qerr, "sweep over log", CONFIGS / "scara/spec.yaml", cutoff, *one_axis)
    t.check("sweep over log: the axis is logarithmic", f"Over {cutoff}, logarithmic." in text_of(root))
    met = sum(v.get("met", False) for v in found["variants"])
    if any("met" in v for v in found["variants"]):
        t.check("sweep over log: how many meet the requirements", f"{met} of 7 variants meet" in text_of(root))
    # A variant that cannot be computed leaves a gap, and is said.
    faulty = (*few, "--set", f"sweep=[{{key: {cutoff}, values: [10 Hz, 100 Hz, 1 MHz]}}]")
    root, _ = check_sweep_lines(t, qerr, "sweep with an error", CONFIGS / "scara/spec.yaml", cutoff, *faulty)
    t.check("sweep with an error: said", "1 variant cannot be computed or judged" in text_of(root))
    check_matrix(t, qerr, few)
    check_bars(t, qerr, few)
    check_long_sweep(t, qerr)


def check_bars(t, qerr, few):
    """Keys without numbers, and a sweep of one variant."""
    family = "filters.velocity.lowpass.family"
    for name, axis in (("families", f"{{key: {family}, values: [butterworth, bessel, chebyshev1]}}"),
                       ("one variant", "{key: encoders.wrist.bits, values: [14]}")):
        arguments = (CONFIGS / "scara/spec.yaml", *few, "--set", f"sweep=[{axis}]")
        root = page(t, qerr, f"sweep of {name}", "sweep", *arguments)
        found = report(qerr, "sweep", *arguments)
        for caption, figure in figures(root).items():
            wanted = {", ".join(f"{k} = {worded(v, None)}" for k, v in keys): value for keys, value in swept(found, caption).items()}
            t.check(f"sweep of {name}: {caption} as in JSON", bars(figure) == wanted, f"{bars(figure)} for {wanted}")


def check_matrix(t, qerr, few):
    """Two keys: a cell for each pair, crossed where the requirement is missed."""
    cutoff = "filters.velocity.lowpass.cutoff"
    arguments = (CONFIGS / "scara/spec.yaml", *few, "--set",
                 f"sweep=[{{key: encoders.*.bits, values: [12, 16]}}, {{key: {cutoff}, values: [10 Hz, 80 Hz]}}]")
    root, found = page(t, qerr, "sweep of two keys", "sweep", *arguments), report(qerr, "sweep", *arguments)
    tables = [x for x in root.iter(HTML + "table") if x.get("class") == "matrix"]
    t.check("sweep of two keys: a matrix of each figure", len(tables) == len(figures(root)), str(len(tables)))
    for table, caption in zip(tables, figures(root)):
        cells = [" ".join("".join(c.itertext()).split()) for c in table.iter(HTML + "td")]
        caption, over, _ = [*caption.split(" over "), "encoders.*.bits", ""][:3]
        values = swept(found, caption)
        other = next(k for k in (cutoff, "encoders.*.bits") if k != over)
        ordered = [values[keys] for keys in sorted(values, key=lambda k: (dict(k)[other], dict(k)[over]))]
        digits = [re.search(r"[\d.]+", c)[0].replace(".", "").lstrip("0")[:3].ljust(3, "0") for c in cells]
        t.check(f"sweep of two keys: {caption} as in JSON", digits == [f"{v:.2e}"[:4].replace(".", "") for v in ordered], f"{cells} {ordered}")
        limits = [r for r in found["variants"][0].get("requirements", []) if f"{r['quantity']} {r.get('statistic', '')}".strip() == caption]
        for r in limits:
            t.check(f"sweep of two keys: {caption} crossed", [c.startswith("\u2717") for c in cells] == [v > r["at_most"] for v in ordered], str(cells))


def check_long_sweep(t, qerr):
    """Hundreds of variants: a page of the size of others, and the ends of the lines are drawn."""
    gears = "sweep=[{key: encoders.*.gear_ratio, from: 10, to: 200, count: 60}, " \
            "{key: filters.velocity.sample_rate, from: 1 kHz, to: 4 kHz, count: 8}]"
    root = page(t, qerr, "long sweep", "sweep", CONFIGS / "kuka_lwr/spec.yaml", "--set", "configurations.count=2", "--set", gears)
    t.check("long sweep: lines that are left out are said", "4 of 8 combinations" in text_of(root))
    for caption, figure in figures(root).items():
        for group in figure.iter(SVG + "g"):
            if group.get("data-series", "required").startswith("required"):
                continue
            points = line(figure, group.get("data-series"))
            ends = (1000, 4000) if " over " in caption else (10, 200)
            t.check(f"long sweep: {caption} from end to end", (points[0][0], points[-1][0]) == ends)


CATALOGUE = "name,price [EUR],bits\n\"low & \"\"cheap\"\"\",10,13\n<middle>,25,16\nfine,70,19\n"
DESIGN = """qerr: 1
robot: {{urdf: {urdf}}}
encoders: {{"*": {{bits: 12}}}}
configurations: {{method: sobol, count: 500, seed: 3}}
requirements: [{{quantity: position.x.sigma, statistic: p99, at_most: {limit} um}}]
design: {{encoders: {{"*": {{catalogue: encoders.csv}}}}}}
"""


def check_design(t, qerr, folder):
    urdf = CONFIGS / "kuka_lwr/kuka_lwr.urdf"
    (folder / "encoders.csv").write_text(CATALOGUE)
    spec = folder / "design.yaml"
    spec.write_text(DESIGN.format(urdf=urdf, limit=60))
    root = page(t, qerr, "design", "design", spec, threads=(1, 2))
    found, drawn = report(qerr, "design", spec), figures(root)
    optimum, figure = found["optimal"], drawn["Price against position.x.sigma p99"]
    t.check("design: the front as in JSON", marks(figure, "front") == [(p["price"], p["value"]) for p in found["pareto"]])
    rows = [(p["price"], p["value"]) for p in found["uniform"] if p["value"] <= found["pareto"][0]["value"]]
    t.check("design: a row of the catalogue at all joints, as in JSON", len(rows) > 1 and marks(figure, "one encoder at all joints") == rows)
    t.check("design: it is one row each", all(len(set(p["encoders"].values())) == 1 for p in found["uniform"]), str(found["uniform"]))
    for name, key in (("optimum", "optimal"), ("runner-up", "runner_up")):
        wanted = [(found[key]["price"], found[key]["requirements"][0]["value"])]
        t.check(f"design: the {name} as in JSON", marks(figure, name) == wanted, f"{marks(figure, name)} for {wanted}")
    prices = list(bars(drawn["Price with one requirement relaxed"]).values())
    t.check("design: prices of requirements as in JSON",
            prices == [optimum["price"]] + [p["price"] for p in found["price_of_requirements"]])
    t.check("design: the page has the report's JSON", embedded(root) == found)
    paid = [value for value, _ in bar_cells(root, "pays")]
    t.check("design: what each joint pays adds up to the price", len(paid) == len(optimum["encoders"]) and close(sum(paid), optimum["price"]), str(paid))
    used = [value for value, _ in bar_cells(root, "verdicts")]
    t.check("design: use of the limits as in JSON", used == [r["value"] / r["at_most"] for r in optimum["requirements"]], str(used))
    cells = [c.text if c.find(HTML + "bdi") is None else c.find(HTML + "bdi").text for c in root.iter(HTML + "td")]
    t.check("design: the table names each encoder", all(joint in cells and name in cells for joint, name in optimum["encoders"].items()))
    spec.write_text(DESIGN.format(urdf=urdf, limit=1e-4))
    text = page_without_pictures(t, qerr, "infeasible design", "design", spec, code=1)
    t.check("infeasible design: what hinders", "No design meets the requirements" in text and "What hinders" in text
            and all(" ".join(o.split()) in text for o in report(qerr, "design", spec, code=1)["obstacles"]))


if __name__ == "__main__":
    program, tally = program_and_tally()
    with tempfile.TemporaryDirectory() as made:
        check_filter(tally, program, pathlib.Path(made))
        check_compare(tally, program)
        check_sweeps(tally, program, pathlib.Path(made))
        check_design(tally, program, pathlib.Path(made))
    raise SystemExit(tally.close())
