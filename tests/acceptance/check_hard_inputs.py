#!/usr/bin/env python3
"""Inputs that no machine produces: values beyond physics, names that nobody can read, tables of many columns.

    check_hard_inputs.py --qerr build/qerr [--verbose]
"""
import json
import pathlib
import re
import sys
import tempfile
import xml.sax.saxutils

from cases import CORPUS
from tool import program_and_tally, run

SPEC = """qerr: 1
robot: {{urdf: {urdf}}}
encoders: {{{name}: {{bits: 17}}, '*': {{counts_per_rev: 4096, gear_ratio: 50}}}}
configurations: {{count: 20}}
coordinates: [x, y]
filters: {{{name}: {{derivative: 1, sample_rate: 1 kHz, lowpass: {{family: first_order, order: 2, cutoff: 50 Hz}}}}}}
requirements: [{{quantity: position.x.sigma, statistic: max, at_most: 1 m}}]
effects: [{{type: backlash, joint: {name}, gap: 1 mrad}}]
motion: {{sample_rate: 1 kHz, duration: 0.3 s, joints: {{{name}: {{sines: [{{amplitude: 0.3, frequency: 10 Hz}}]}}}}}}
"""
HIDDEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff]")


def spec_with(folder, name):
    """A spec of a robot whose first joint has this name, and a filter of the same name."""
    text = (CORPUS / "two_joints.urdf").read_text()
    first = re.search(r"""<joint name=["']([^"']*)["']""", text)
    urdf = folder / "named.urdf"
    urdf.write_text(text.replace(first[0], "<joint name=" + xml.sax.saxutils.quoteattr(name), 1))
    spec = folder / "named.yaml"
    spec.write_text(SPEC.format(urdf=urdf.name, name=json.dumps(name)))
    return spec


def check_absurd_values(t, qerr, folder):
    spec = spec_with(folder, "j")
    for change in ("effects=[{type: backlash, joint: j, gap: 1e300}]", "effects=[{type: latency, joint: j, delay: 1e300}]",
                   "effects=[{type: latency, joint: j, delay: -1e5}]", "effects=[{type: decoding, joint: j, factor: 0}]",
                   "effects=[{type: noise, joint: j, sigma: 1e200}]", "effects=[{type: offset, joint: j, offset: 1e18}]",
                   "effects=[{type: eccentricity, joint: j, amplitude: 1e300}]", "effects=[{type: timing_jitter, joint: j, sigma: 1e9}]",
                   "effects=[{type: missed_counts, joint: j, counts: 1, time: 1e300}]", "coupling=[[1e308, 0], [0, 1]]",
                   "encoders.j={resolution: 1e-320}", "encoders.j={resolution: 1e-300}", "encoders.j={counts_per_rev: 4096, gear_ratio: 1e40}",
                   "encoders.j={counts_per_rev: 4096, gear_ratio: 0}", "filters.j.sample_rate=1e300", "filters.j.sample_rate=1e-300",
                   "configurations.seed=1e17", "configurations.seed=9007199254740993", "motion.joints.j.center=1e300",
                   "motion.joints.j.sines=[{amplitude: 1e300, frequency: 1}]", "motion.joints.j.velocity=1e200",
                   "robot.tool={xyz: [1e300, 0, 0]}", "robot.tool={xyz: [0, 0, 0], rpy: [1e300, 0, 0]}",
                   "filters.j={derivative: 0, sample_rate: 1000, numerator: [1e308], denominator: [1, -0.5]}",
                   "filters.j={derivative: 0, sample_rate: 1000, numerator: [0], denominator: [1, -0.5]}"):
        for command in ("analyze", "simulate"):
            ran = run(qerr, command, spec, "--set", change, limit=20)
            t.check(f"{command} --set {change}: 3 at once, with the key", ran.code == 3 and not ran.out and ran.seconds < 2
                    and change.split("=")[0].split(".")[0].encode() in ran.err, f"exit {ran.code}, {ran.seconds:.1f} s: {ran.err.decode()[:200]}")
    urdf = folder / "named.urdf"
    good = urdf.read_text()
    for numbers in ("1e300 0 0", "0 0 -1e20"):
        urdf.write_text(re.sub(r"""xyz=(["'])[^"']*["']""", f'xyz="{numbers}"', good))
        ran = run(qerr, "analyze", spec)
        t.check(f"xyz of {numbers} in a URDF: 3", ran.code == 3, f"exit {ran.code}: {ran.err.decode()[:200]}")


def check_log_cells(t, qerr, folder):
    spec, log = spec_with(folder, "j"), folder / "cells.csv"
    ran = run(qerr, "simulate", spec, "--log", log)
    rows = log.read_bytes().decode().split("\r\n")
    header = rows[0].split(",")
    for column in ("j.reference [rad]", "tip.x [m]", "j.counts", "time [s]"):
        for value in ("1e12", "1e13", "-1e15", "1e18", "1e300", "-1e308"):
            if column == "time [s]" and value.startswith("-"):
                continue
            cells = rows[-2].split(",")
            cells[header.index(column)] = value
            bad = folder / "bad.csv"
            bad.write_bytes("\r\n".join([*rows[:-2], ",".join(cells), ""]).encode())
            ran = run(qerr, "diagnose", spec, bad, limit=20)
            # A date in attoseconds or a count in the exact range of doubles can be what was meant.
            allowed = (0, 3) if column in ("time [s]", "j.counts") and abs(float(value)) < 1e300 else (3,)
            t.check(f"{value} as {column}: 3, in this column", ran.code in allowed and ran.seconds < 5 and
                    (ran.code == 0 or column.encode() in ran.err), f"exit {ran.code}, {ran.seconds:.1f} s: {ran.err.decode()[:200]}")


def simulated_rows(qerr, folder):
    """The spec, and its simulated log as rows of cells."""
    spec, log = spec_with(folder, "j"), folder / "simulated.csv"
    run(qerr, "simulate", spec, "--log", log)
    return spec, [row.split(",") for row in log.read_text().splitlines()]


def check_far_tips(t, qerr, folder):
    """A tracker that shows the same far point all the time, or one of no size: an answer, whatever it is."""
    (spec, rows), far = simulated_rows(qerr, folder), folder / "far.csv"
    kept = [i for i, name in enumerate(rows[0]) if not name.endswith(".reference [rad]")]
    for column in ("tip.x [m]", "tip.y [m]"):
        for value in ("1e8", "-1e8", "3e6", "1e-310", "-9.5e-200", "0", "-2.5e-96", "7e7"):
            for length in (9, 61, len(rows)):
                table = [list(row) for row in rows[:length]]
                for row in table[1:]:
                    row[rows[0].index(column)] = value
                far.write_text("".join(",".join(row[i] for i in kept) + "\n" for row in table))
                ran = run(qerr, "diagnose", spec, far, "--format", "json", limit=20)
                t.check(f"{value} as {column} of {length} rows: an answer", ran.code == 0 and ran.seconds < 5,
                        f"exit {ran.code}, {ran.seconds:.1f} s: {ran.err.decode()[:200]}")


def check_far_columns(t, qerr, folder):
    """A column of another origin, however far: its differences drown in the rounding of doubles. No search may be endless."""
    (spec, rows), far = simulated_rows(qerr, folder), folder / "shifted.csv"
    for column in ("j.counts", "j.reference [rad]", "time [s]", "tip.x [m]"):
        at = rows[0].index(column)
        for shift in (3e5, 1e9, -2e11, 1e13, 1e15, 9e15):
            shifted = [[*row[:at], repr(float(row[at]) + shift).removesuffix(".0"), *row[at + 1:]] for row in rows[1:]]
            far.write_text("".join(",".join(row) + "\n" for row in [rows[0], *shifted]))
            ran = run(qerr, "diagnose", spec, far, "--format", "json", limit=20)
            t.check(f"{column} + {shift:g}: an answer", ran.code in (0, 3) and ran.seconds < 2,
                    f"exit {ran.code}, {ran.seconds:.1f} s: {ran.err.decode()[:200]}")


def check_bits(t, qerr, folder):
    """A counter of which only the lowest bits are logged, as by a wire for a counter: an answer, and no signal."""
    (spec, rows), bits = simulated_rows(qerr, folder), folder / "bits.csv"
    at = rows[0].index("j.counts")
    for what, reading in {"alternating": lambda i, count: i % 2, "slowly alternating": lambda i, count: i // 3 % 2,
                          "lowest bit": lambda i, count: count % 2, "two bits": lambda i, count: count % 4,
                          "always 0": lambda i, count: 0}.items():
        made = [[*row[:at], str(reading(i, int(row[at]))), *row[at + 1:]] for i, row in enumerate(rows[1:])]
        for kept in (len(rows[0]), 3):
            bits.write_text("".join(",".join(row[:kept]) + "\n" for row in [rows[0], *made]))
            ran = run(qerr, "diagnose", spec, bits, "--format", "json", limit=20)
            t.check(f"counts {what}, {kept} columns: an answer", ran.code in (0, 3) and ran.seconds < 2,
                    f"exit {ran.code}, {ran.seconds:.1f} s: {ran.err.decode()[:200]}")


def check_names(t, qerr, folder):
    log, table = folder / "log.csv", folder / "table.csv"
    for name in (" x ", " x", "x ", "#x", "=cmd|'/C calc'!A0", "+x", "-x", "@x", "'x", "''x", "'=x", "x,y", 'x"y', "x [rad]", "x[1]", "time", "ä", "x.counts"):
        spec = spec_with(folder, name)
        made = run(qerr, "simulate", spec, "--log", log)
        read = run(qerr, "diagnose", spec, log, "--format", "json")
        named = read.code == 0 and name in {c["joint"] for c in json.loads(read.out)["visible"]}
        t.check(f"a joint named {name!r}: its log is read", made.code == 0 and named, f"{made.code}, {read.code}: {read.err.decode()[:200]}")
        for words in (["analyze", spec, "--format", "csv"], ["filter", spec, "--format", "csv"], ["analyze", spec, "-o", folder / "n", "--per-configuration", table],
                      ["robot", folder / "named.urdf", "--format", "csv"]):
            ran = run(qerr, *words)
            text = ran.out.decode() + (table.read_text() if words[-1] == table else "")
            formulas = [cell for cell in re.split(r"[,\r\n]", text) if re.match(r'"?[=@]|"?[-+][^0-9.]', cell)]
            t.check(f"{words[0]} with {name!r} writes no formula", ran.code == 0 and not formulas, f"{ran.code} {formulas[:3]}")
    for name in ("a\u009b31m", "\u202ex", "x\u200b", "\ufeffx", "a\u2028b", "x\u2066y"):
        spec = spec_with(folder, name)
        for words in (["analyze", spec], ["robot", folder / "named.urdf"], ["robot", folder / "named.urdf", "--format", "json"]):
            ran = run(qerr, *words)
            shown = HIDDEN.findall(ran.out.decode() + ran.err.decode())
            # `robot` shows a flawed robot, and what is wrong with it.
            codes = (0, 3) if words[0] == "robot" else (3,)
            t.check(f"{words[0]} with a joint named {name!r}: refused, escaped", ran.code in codes and not shown, f"{ran.code} {shown} {ran.err[:200]}")


def check_many_columns(t, qerr, folder):
    spec, log, wide = spec_with(folder, "j"), folder / "log.csv", folder / "wide.csv"
    run(qerr, "simulate", spec, "--log", log)
    names = ",".join(f"c{i}" for i in range(50000))
    rows = log.read_text().split("\n")[:31]
    wide.write_text("\n".join(row.rstrip("\r") + "," + (names if i == 0 else "1," * 49999 + "1") for i, row in enumerate(rows)) + "\n")
    ran = run(qerr, "diagnose", spec, wide)
    t.check("a log of 50,000 columns: within 3 s", ran.code == 0 and ran.seconds < 3, f"exit {ran.code}, {ran.seconds:.1f} s {ran.err[:200]}")


RESTING = """<robot name="spindle"><link name="a"/><link name="b"/><link name="c"/><link name="tip"/>
<joint name="mount" type="fixed"><parent link="a"/><child link="b"/><origin xyz="0 0 {height}" rpy="{roll} 0 0"/></joint>
<joint name="j" type="continuous"><parent link="b"/><child link="c"/><origin xyz="0 0 0.2" rpy="-2.7 0 0"/><axis xyz="0 0 1"/></joint>
<joint name="end" type="fixed"><parent link="c"/><child link="tip"/><origin xyz="0 0 0.16" rpy="0.4 0 0"/></joint></robot>
"""


def check_resting_tips(t, qerr, folder):
    """On the only joint's axis the tip moves by rounding errors: a page with an extent of 1e-17 m had no cell, and crashed."""
    urdf, spec = folder / "spindle.urdf", folder / "spindle.yaml"
    for height, roll in ((0.79, 1.84), (0.3, 0.7), (12, 2.9), (0, 0)):
        urdf.write_text(RESTING.format(height=height, roll=roll))
        ran = run(qerr, "robot", urdf, "--write-spec", spec, "--force")
        page = folder / "spindle.html"
        ran = run(qerr, "analyze", "-q", spec, "-o", page)
        t.check(f"a page of a tip at rest, {height} m up", ran.code == 0 and b"</html>" in page.read_bytes(), f"{ran.code} {ran.err[:200]}")
        spec.unlink()


def check_questions(t, qerr, folder):
    """What was answered, and should not have been, or with a wrong figure."""
    spec, report = spec_with(folder, "j"), folder / "report.json"
    for options, word in ((["--sine", "-1", "1"], b"above 0"), (["--sine=-1deg", "1Hz"], b"above 0"), (["--speed", "1m/s"], b"--speed"),
                          (["--sine", "1m", "1Hz"], b"--sine")):
        ran = run(qerr, "filter", spec, *options)
        t.check(f"filter {' '.join(options)}: 2", ran.code == 2 and word in ran.err, f"{ran.code} {ran.err[:200]}")
    ran = run(qerr, "analyze", spec, "--seed", "9007199254740993")
    t.check("--seed 2^53 + 1, which a double cannot hold: 2", ran.code == 2 and b"--seed" in ran.err, f"{ran.code} {ran.err[:200]}")
    ran = run(qerr, "simulate", spec, "--cutoffs", "j=5mm..50Hz")
    t.check("--cutoffs in millimetres: the rule", ran.code == 2 and b"must be a frequency" in ran.err, f"{ran.code} {ran.err[:200]}")
    for words, code, word in ((["analyze", spec, "--above", "foo=1"], 2, b"qerr: --above: "), (["analyze", ""], 4, b"name of a file is empty")):
        ran = run(qerr, *words)
        t.check(f"{words[0]} {words[-1]!r}: {code}", ran.code == code and word in ran.err, f"{ran.code} {ran.err[:200]}")
    run(qerr, "analyze", "-q", spec, "--set", "coordinates=[rx]", "--set", "requirements=[]", "--set", "filters={}", "-o", report)
    ran = run(qerr, "check", "-q", spec, "--baseline", report)
    t.check("a baseline without any of the figures: 3", ran.code == 3 and b"none of the figures" in ran.err, f"{ran.code} {ran.err[:200]}")
    report.write_text('{"a": "1e400",\n "b": 1e400}')
    ran = run(qerr, "compare", report, report)
    t.check("a number that is too large: its own place", ran.code == 3 and b"report.json:2:7" in ran.err, f"{ran.code} {ran.err[:200]}")


def check_damaged_shards(t, qerr, folder):
    spec, whole = spec_with(folder, "j"), folder / "whole.csv"
    shards = [folder / f"shard{k}.csv" for k in (1, 2)]
    for k, shard in enumerate(shards, 1):
        run(qerr, "sweep", spec, "--set", "sweep=[{key: encoders.j.bits, values: [12, 13, 14, 15]}]", "--shard", f"{k}/2", "-o", shard)
    ran = run(qerr, "merge", *shards, "-o", whole)
    t.check("merge of two shards", ran.code == 0, f"{ran.code} {ran.err[:200]}")
    good = shards[1].read_bytes()
    rows = good.split(b"\r\n")
    for what, row in (("a cell less", rows[3].rsplit(b",", 1)[0]), ("a C1 character", rows[3] + "\x9b31m".encode()),
                      ("no UTF-8", rows[3] + b"\xff"), ("an escape", rows[3] + b"\x1b[31m")):
        shards[1].write_bytes(b"\r\n".join(rows[:3] + [row] + rows[4:]))
        ran = run(qerr, "merge", *shards, "-o", folder / "damaged.csv")
        t.check(f"merge of a line with {what}: 3, with its place", ran.code == 3 and b"shard2.csv:4" in ran.err
                and not HIDDEN.search(ran.err.decode()) and not (folder / "damaged.csv").exists(), f"{ran.code} {ran.err[:200]}")


def main():
    qerr, t = program_and_tally()
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        check_absurd_values(t, qerr, folder)
        check_log_cells(t, qerr, folder)
        check_far_tips(t, qerr, folder)
        check_far_columns(t, qerr, folder)
        check_bits(t, qerr, folder)
        check_names(t, qerr, folder)
        check_many_columns(t, qerr, folder)
        check_resting_tips(t, qerr, folder)
        check_questions(t, qerr, folder)
        check_damaged_shards(t, qerr, folder)
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
