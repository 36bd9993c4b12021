#!/usr/bin/env python3
"""Ten questions of a design review, answered by the words of the pages alone; the answers are known from the JSON of other runs.

    check_page_questions.py --qerr build/qerr [--robots FOLDER] [--verbose]

With --robots, also of public robots, with specs that are written here.
"""
import argparse
import json
import math
import pathlib
import re
import tempfile
import xml.etree.ElementTree as Xml

from pages import HTML, text_of
from tool import Tally, run

CONFIGS = pathlib.Path(__file__).resolve().parents[2] / "configs"
CONTINUOUS = {"kinova_gen3": [f"Actuator{k}" for k in (1, 3, 5, 7)], "fetch": ["upperarm_roll_joint", "forearm_roll_joint", "wrist_roll_joint"]}
FOREIGN = {"kinova_gen3": "", "kuka_iiwa14": ", tip: iiwa_link_ee", "ur5e": ", tip: tool0", "panda": ", base: panda_link0, tip: panda_hand", "fetch": ", base: torso_lift_link, tip: gripper_link"}
SPEC = """qerr: 1
robot: {{urdf: {urdf}{ends}}}
encoders: {{'*': {{counts_per_rev: 4096, gear_ratio: 100}}}}
configurations: {{count: 400{turns}}}
filters:
  velocity: {{derivative: 1, sample_rate: 1 kHz, lowpass: {{family: first_order, order: 2, cutoff: 50 Hz}}}}
requirements:
  - {{quantity: position.x.worst_case, statistic: max, at_most: {limit} m}}
  - {{quantity: velocity.y.sigma, statistic: p99, at_most: {rate} m/s}}
design: {{encoders: {{'*': {{bits: 14..20}}}}}}
sweep: [{{key: encoders.*.gear_ratio, values: [10, 50, 100]}}, {{key: filters.velocity.lowpass.cutoff, values: [20 Hz, 200 Hz]}}]
motion:
  sample_rate: 1 kHz
  duration: 6 s
  joints: {{{first}: {{sines: [{{amplitude: 20 deg, frequency: 0.7 Hz}}]}}{rest}}}
"""


def page(qerr, *arguments):
    """What a reader sees: the sentence below the title, and all words with those of the title block and each section."""
    made = run(qerr, *arguments, "--format", "html", "--quiet")
    assert made.code in (0, 1), made.err.decode()
    root = Xml.fromstring(made.out.decode())
    lead = next(p for p in root.iter(HTML + "p") if p.get("class") == "answer").text
    parts = {s.find(HTML + "h2").text: text_of(s) for s in root.iter(HTML + "section")}
    rows = [["".join(c.itertext()) for c in r] for d in root.iter(HTML + "div") if d.get("class") == "head" for r in d.iter(HTML + "tr")]
    return re.sub("[\u2066-\u2069]", "", lead), parts, rows, root


def report(qerr, *arguments):
    made = run(qerr, *arguments, "--format", "json", "--quiet")
    assert made.code in (0, 1), made.err.decode()
    return json.loads(made.out)


AMOUNT = re.compile(r"(-?\d+(?:\.\d+)?(?:e[-+]?\d+)?)(?: \+- ([\d.]+))? ?([numk]?)(1/s|m/s|rad/s|rad|m|s|Hz|%|deg)(?![\w/])")


def about(text, value):
    """Whether an amount of the text is the value, to three digits."""
    return any(abs(float(n) * {"n": 1e-9, "u": 1e-6, "m": 1e-3, "k": 1e3}.get(p, 1) - value) <= 6e-3 * abs(value)
               for n, _, p, _ in AMOUNT.findall(text))


def check_robot(t, qerr, name, spec, folder):
    coarse = ("--set", "encoders.*.gear_ratio=3")
    plain, worse = report(qerr, "analyze", spec), report(qerr, "analyze", spec, *coarse)
    judged, failing = report(qerr, "check", spec)["requirements"], report(qerr, "check", spec, *coarse)["requirements"]
    lead, parts, rows, _ = page(qerr, "analyze", spec, *coarse)
    first = max(worse["budget"], key=worse["budget"].get)
    t.check(f"{name}: 1 which encoder first", f"the first encoder to upgrade is that of {first}, " in lead, lead)
    fails = next(r for r in failing if not r["met"])
    over = 100 * (fails["value"] / fails["at_most"] - 1)
    said = re.search(r"is not met with .*?, beyond its limit by ([\d.e+]+) %", lead)
    t.check(f"{name}: 2 which requirement fails and by how much", fails["quantity"] in lead and said and abs(float(said[1]) / over - 1) < 1e-2, lead)
    file = folder / "points.csv"
    run(qerr, "analyze", spec, *coarse, "--quiet", "--per-configuration", file)
    lines = [line.split(",") for line in file.read_text().splitlines()]
    column = next(k for k, c in enumerate(lines[0]) if c.startswith(fails["quantity"] + " ["))
    worst = max(lines[1:], key=lambda line: float(line[column]))
    place = next(r[0] for r in rows if r[0].startswith("largest at"))
    angles = [(c.split(" [")[0], float(v) * (180 / math.pi if c.endswith("[rad]") else 1)) for c, v in zip(lines[0], worst)
              if c.endswith(("[rad]", "[m]")) and "." not in c]
    angles = [a for a in angles if f"\u2068{a[0]}\u2069" in place]
    t.check(f"{name}: 3 where is the worst configuration", len(angles) == place.count("\u2069")
            and all(abs(float(re.search(f"\u2068{re.escape(j)}\u2069 (-?[\\d.]+)", place)[1]) - a) <= 0.06 or about(place, a) for j, a in angles), place)
    text = " ".join(" ".join(r) for r in rows)
    t.check(f"{name}: 4 what did the override change", "before --set" in rows[0]
            and all(about(r[3], b["value"]) and about(r[2], a["value"]) for r, a, b in zip([r for r in rows[1:] if len(r) > 3], failing, judged)), text)
    t.check(f"{name}: 4 the sentence follows", plain["budget"] and any(about(page(qerr, "analyze", spec)[0], 100 * v) for v in plain["budget"].values()))


def check_diagnosis(t, qerr, name, spec, folder, joint):
    log = folder / "log.csv"
    run(qerr, "simulate", spec, "--log", log, "--quiet", "--set", f"effects=[{{type: backlash, joint: {joint}, gap: 1 mrad}}]")
    found = report(qerr, "diagnose", spec, log)
    _, parts, _, root = page(qerr, "diagnose", spec, log)
    cause = next(c for c in found["causes"] if c["effect"] == "backlash")
    gap = next(p for p in cause["parameters"] if p["name"] == "gap")
    row = next([text_of(c) for c in r] for r in root.iter(HTML + "tr") if len(r) == 4 and text_of(r).startswith(f"backlash of {joint}"))
    _, half, prefix, _ = AMOUNT.search(row[2]).groups()
    half = float(half) * {"u": 1e-6, "m": 1e-3}[prefix]
    t.check(f"{name}: 5 how sure is the cause", about(row[2], gap["value"]) and abs(half / ((gap["upper"] - gap["lower"]) / 2) - 1) < 0.1
            and (row[3] == "< 1e-15" if cause["p_value"] < 1e-15 else float(row[3]) == float(f"{cause['p_value']:.2g}")), str((row, gap)))
    wanted = {d["remedy"] for d in found["data"] if d.get("remedy")}
    t.check(f"{name}: 6 what to record next", all(r in parts["What to record next"] for r in wanted)
            and ("--plan" in parts["What to record next"] or not any(v["smallest"] is None for v in found["visible"])), parts.get("What to record next"))


def check_choices(t, qerr, name, spec):
    _, _, _, root = page(qerr, "filter", spec)
    row = next(["".join(c.itertext()) for c in r] for r in root.iter(HTML + "tr") if text_of(r).startswith("3.00 ms"))
    family, order, cutoff = re.fullmatch(r"(\w+), order (\d) at ([\d.]+ \w+)", row[1]).groups()
    design = f"filters.velocity.lowpass={{family: {family}, order: {order}, cutoff: {cutoff}{', ripple: 1 dB' if family == 'chebyshev1' else ''}" \
             f"{', attenuation: 40 dB' if family == 'chebyshev2' else ''}}}"
    built = run(qerr, "filter", spec, "--set", design, "--json", "-q")
    if built.code == 0:
        f = json.loads(built.out)["filters"][0]
        t.check(f"{name}: 7 which filter for 3 ms", about(row[2], f["group_delay_s"]) and f["group_delay_s"] <= 3e-3 and about(row[3], f["h2_norm"]), f"{row} {f['h2_norm']}")
    lead, _, _, _ = page(qerr, "design", spec)
    found = report(qerr, "design", spec)
    steps = [p["price"] for p in found["pareto"] if p["price"] > found["optimal"]["price"]]
    said = re.search(r"The next better step costs ([\d.]+)", lead)
    t.check(f"{name}: 8 what does the next better encoder cost", (said is None and not steps) or float(said[1]) == min(steps) - found["optimal"]["price"], lead)
    lead, parts, _, _ = page(qerr, "sweep", spec)
    used = {v["variant"]: max(r["value"] / r["at_most"] for r in v["requirements"]) for v in report(qerr, "sweep", spec)["variants"]}
    winner = min(used, key=used.get)
    t.check(f"{name}: 9 which variant wins", f"variant {winner} wins" in lead and about(lead, 100 * used[winner]) and "yes, wins" in parts["Variants"] or used[winner] > 1, lead)
    changed = (spec, spec, "--set", "encoders.*.gear_ratio=3")
    lead, _, _, _ = page(qerr, "compare", *changed)
    flipped = [r["quantity"] for r in report(qerr, "compare", *changed)["requirements"] if r["flipped"]]
    t.check(f"{name}: 10 what flipped", flipped and all(q in lead.split("Flipped: ")[1] for q in flipped[:4]), lead)


def check_all(t, qerr, name, urdf, ends=""):
    with tempfile.TemporaryDirectory() as made:
        folder = pathlib.Path(made)
        spec = folder / "arm.yaml"
        turns = ", ".join(f"{j}: [-180 deg, 180 deg]" for j in CONTINUOUS.get(name, []))
        ends = {"ends": ends, "rest": ", panda_joint4: {center: -90 deg}" if name == "panda" else "", "turns": turns and f", limits: {{{turns}}}"}
        spec.write_text(SPEC.format(urdf=urdf, **ends, limit=1, rate=1, first="'*'").split("motion:")[0])
        free = report(qerr, "analyze", spec)
        joint = next(iter(free["budget"]))
        limits = [1.3 * report(qerr, "check", spec)["requirements"][k]["value"] for k in (0, 1)]
        spec.write_text(SPEC.format(urdf=urdf, **ends, limit=limits[0], rate=limits[1], first=joint))
        check_robot(t, qerr, name, spec, folder)
        check_choices(t, qerr, name, spec)
        check_diagnosis(t, qerr, name, spec, folder, joint)


if __name__ == "__main__":
    given = argparse.ArgumentParser()
    given.add_argument("--qerr", required=True)
    given.add_argument("--robots")
    given.add_argument("--verbose", action="store_true")
    chosen = given.parse_args()
    tally = Tally(chosen.verbose)
    check_all(tally, chosen.qerr, "kuka_lwr", CONFIGS / "kuka_lwr/kuka_lwr.urdf")
    for robot, robot_ends in FOREIGN.items() if chosen.robots else ():
        check_all(tally, chosen.qerr, robot, pathlib.Path(chosen.robots).resolve() / f"{robot}.urdf", robot_ends)
    raise SystemExit(tally.close())
