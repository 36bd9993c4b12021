#!/usr/bin/env python3
"""qerr sweep and qerr merge: the same bytes whatever kills, divides or parallelizes them, and the figures of analyze.

    check_sweep.py --qerr build/qerr [--verbose] [--rounds 4] [--rows 12]
"""
import argparse
import csv
import filecmp
import io
import json
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time

from exit_codes import expect
from tool import Tally, Worst, run

ROOT = pathlib.Path(__file__).resolve().parents[2]
CONFIGS = ROOT / "configs"

CATALOGUE = """name,price [EUR],counts_per_rev,gear_ratio,bits,backlash [arcmin]
coarse,100,1024,100,,
"fine, with play",250,4096,100,,0.5
direct,900,,,20,
"""
HEAD = f"""qerr: 1
robot: {{urdf: {CONFIGS}/kuka_lwr/kuka_lwr.urdf}}
encoders:
  '*': {{counts_per_rev: 4096, gear_ratio: 100}}
filters:
  velocity: {{derivative: 1, sample_rate: 1 kHz, lowpass: {{family: first_order, order: 2, cutoff: 50 Hz}}}}
requirements:
  - {{quantity: position.x.worst_case, statistic: max, at_most: 40 um}}
  - {{quantity: velocity.delay, at_most: 7 ms}}
"""
# 84 variants whose Jacobians are shared, of which some cannot be computed; and 48 that are analyzed one by one.
SHARED = HEAD + """configurations: {count: 1000}
sweep:
  - {key: encoders.a2, catalogue: encoders.csv}
  - {keys: [encoders.a1.counts_per_rev, encoders.a1.gear_ratio], values: [[1000, 80], [2000, 50]]}
  - {key: filters.velocity.lowpass.cutoff, from: 20 Hz, to: 700 Hz, count: 7, scale: log}
  - {key: encoders.a3.gear_ratio, values: [30, 80]}
"""
SINGLE = HEAD + """configurations: {count: 60}
sweep:
  - {key: encoders.*.counts_per_rev, values: [1000, 5000, 8000, 40000]}
  - {keys: [robot.tool, coordinates], values: [[{xyz: [0, 0, 0.1]}, [x, y, z]], [{xyz: [0.1, 0, 0]}, [x, rx]]]}
  - {key: filters.velocity.lowpass.order, values: [1, 2, 3]}
  - {key: configurations.seed, values: [1, 2]}
"""


def rows_of(path):
    with open(path, newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return header, rows


def check_figures(t, qerr, spec, table, few, rng):
    """Rows of some variants against analyze --set."""
    header, rows = rows_of(table)
    keys = header[1:header.index("signal")]
    t.check(f"{spec.name}: header", header == ["variant", *keys, *"signal,filter,coordinate,unit,bound,statistic,value".split(",")])
    by_variant = {}
    for row in rows:
        by_variant.setdefault(int(row[0]), []).append(row[1:])
    t.check(f"{spec.name}: variants are numbered from 0", sorted(by_variant) == list(range(len(by_variant))), str(len(by_variant)))
    worst, failed = Worst(1e-12), 0
    for variant in rng.sample(sorted(by_variant), few):
        own = by_variant[variant]
        changes = []
        for key, value in zip(keys, own[0]):
            if key == "encoders.a2":  # a row of the catalogue
                cells = next(r for r in csv.DictReader(io.StringIO(CATALOGUE)) if r["name"] == value)
                entry = ", ".join(f"{k}: {cells[k]}" for k in ("counts_per_rev", "gear_ratio", "bits") if cells[k])
                changes += ["--set", f"encoders.a2={{{entry}}}"]
                if cells["backlash [arcmin]"]:
                    changes += ["--set", f"effects=[{{type: backlash, joint: a2, gap: {cells['backlash [arcmin]']} arcmin}}]"]
            else:
                changes += ["--set", f"{key.partition(' [')[0]}={value}"]
        ran = run(qerr, "analyze", "-q", spec, "--format", "csv", "--set", "sweep=[]", *changes)
        if ran.code == 3:
            failed += 1
            message = own[0][len(keys) + 4]
            t.check(f"variant {variant}: its row says why it cannot be computed",
                    len(own) == 1 and own[0][len(keys)] == "error" and own[0][-1] == "" and message.split(":")[0] in ran.err.decode(), str(own))
            continue
        expected = list(csv.reader(io.StringIO(ran.out.decode())))[1:]
        largest = {}
        for row in expected:
            largest[row[3]] = max(largest.get(row[3], 0), float(row[-1] or 0))
        same = [row[len(keys):-1] for row in own] == [row[:-1] for row in expected]
        t.check(f"variant {variant}: the rows of analyze", same)
        for found, wanted in zip(own, expected) if same else ():
            worst.add(f"variant {variant}, {wanted[:-1]}", float(found[-1] or 0), float(wanted[-1] or 0), 1e-12 * largest[wanted[3]])
    t.check(f"{spec.name}: figures of analyze --set to 1e-12", worst.holds(), worst.detail())


def same(a, b):
    return filecmp.cmp(a, b, shallow=False)


def check_killed(t, qerr, spec, whole, folder, options, rounds, rng):
    """kill -9 at random times, then --resume, until it is complete."""
    target, started = folder / "killed.csv", time.monotonic()
    run(qerr, "sweep", "-q", spec, *options, "-o", folder / "timed.csv")
    duration = time.monotonic() - started
    for round_ in range(rounds):
        target.unlink(missing_ok=True)
        for kills in range(30):
            process = subprocess.Popen([str(qerr), "sweep", "-q", str(spec), *options, "-o", str(target), "--resume"], stdin=subprocess.DEVNULL)
            try:
                code = process.wait(timeout=rng.uniform(0, duration) if kills < 4 else 60)
                break
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        t.check(f"{spec.name} {' '.join(options)}: round {round_}, killed {kills} times", code == 0 and same(whole, target))


def check_torn(t, qerr, spec, whole, folder, options, rng):
    data = whole.read_bytes()
    for size in [0, 1, data.index(b"\r") - 3, data.index(b"\r"), data.index(b"\r") + 2, len(data) - 1, len(data),
                 *(rng.randrange(len(data)) for _ in range(4))]:
        target = folder / "torn.csv"
        target.write_bytes(data[:size])
        ran = run(qerr, "sweep", "-q", spec, *options, "-o", target, "--resume")
        t.check(f"{spec.name}: resumed from {size} bytes of {len(data)}", ran.code == 0 and same(whole, target), ran.err.decode()[:200])


def check_shards(t, qerr, spec, whole, folder, options, rng):
    for count in (1, 5, 13):
        shards = [folder / f"{k}of{count}.csv" for k in range(1, count + 1)]
        for k, shard in enumerate(shards, 1):
            run(qerr, "sweep", "-q", spec, *options, "--shard", f"{k}/{count}", "-o", shard, "--threads", rng.choice("12"))
        rng.shuffle(shards)
        merged = folder / "merged.csv"
        ran = run(qerr, "merge", *shards, "-o", merged)
        t.check(f"{spec.name} {' '.join(options)}: {count} shards", ran.code == 0 and same(whole, merged), ran.err.decode()[:200])
    t.check("merge to standard output", run(qerr, "merge", *shards).out == whole.read_bytes())


def check_shards_of_one_variant(t, qerr, folder):
    """As many shards as variants, or more: numbers alone do not tell how many there are."""
    spec = CONFIGS / "scara" / "spec.yaml"
    axis = ["--set", "sweep=[{key: configurations.seed, values: [1, 2, 3, 4]}]", "--set", "configurations.count=10", "--set", "motion.duration=0.2"]
    for options, counts in ((axis, (4, 6)), ([*axis, "--wide"], (6,))):
        whole = run(qerr, "sweep", "-q", spec, *options, "--format", "csv").out
        for count in counts:
            shards = [folder / f"one{k}of{count}.csv" for k in range(1, count + 1)]
            for k, shard in enumerate(shards, 1):
                run(qerr, "sweep", "-q", spec, *options, "--shard", f"{k}/{count}", "-o", shard)
            t.check(f"{count} shards of 4 variants", run(qerr, "merge", *shards[::-1]).out == whole)
            t.check(f"{count} shards of 4 variants, with --spec", run(qerr, "merge", *shards, "--spec", spec, *options).out == whole)
            for left in range(count):
                expect(t, f"{count} shards of 4 variants without {left + 1}", run(qerr, "merge", *shards[:left], *shards[left + 1:]), 3)
            expect(t, "one of them alone", run(qerr, "merge", shards[0]), 3, words=["shards"])
            expect(t, "one of them twice", run(qerr, "merge", *shards, shards[-1]), 3)
            again = run(qerr, "sweep", "-q", spec, *options, "--shard", f"2/{count}", "--resume", "-o", shards[1])
            t.check("one of them resumed", again.code == 0 and run(qerr, "merge", *shards).out == whole, again.err.decode()[:200])


def check_said_at_once(t, qerr, folder):
    """A sweep of hours says so before its first variant."""
    axes = ", ".join(f"{{key: configurations.{key}, from: 1, to: 9000, count: 9000}}" for key in ("seed", "count"))
    process = subprocess.Popen([str(qerr), "sweep", str(CONFIGS / "scara" / "spec.yaml"), "--set", f"sweep=[{axes}]", "-o", str(folder / "hours.csv")],
                               stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    timer = threading.Timer(20, process.kill)
    timer.start()
    said = next((line for line in process.stderr if b"8.10e+07 variants" in line or b"8.1e+07 variants" in line), b"")
    timer.cancel()
    process.kill()
    process.wait()
    t.check("a sweep of hours says so", re.search(rb"take \d+ h", said) is not None, said.decode())


def check_wide(t, qerr, spec, folder):
    wide, tidy = folder / "wide.csv", folder / "tidy.csv"
    run(qerr, "sweep", "-q", spec, "--wide", "-o", wide)
    run(qerr, "sweep", "-q", spec, "-o", tidy)
    header, rows = rows_of(wide)
    expected = {}
    for variant, *cells in rows_of(tidy)[1]:
        signal, filter_, coordinate, unit, bound, statistic, value = cells[-7:]
        if signal == "budget":
            expected[variant, f"budget.{coordinate}.share"] = value
        elif signal != "error":
            expected[variant, f"{filter_ or signal}.{coordinate}.{bound}.{statistic} [{unit}]"] = value
    found = {(row[0], name): cell for row in rows for name, cell in zip(header, row)}
    t.check(f"{spec.name}: --wide has every figure of the tidy form", all(found.get(key) == value for key, value in expected.items()))
    t.check("one row a variant", len(rows) == len({row[0] for row in rows}) > 0)
    met = [row for row in rows if not row[-1]]
    place = {name: i for i, name in enumerate(header)}
    verdicts = all((row[place["met"]] == "true") == (row[place["requirements[0].met"]] == row[place["requirements[1].met"]] == "true")
                   and (float(row[place["requirements[0].value [m]"]]) <= 4e-5) == (row[place["requirements[0].met"]] == "true")
                   and row[place["requirements[1].value [s]"]] == row[place["velocity.delay [s]"]] for row in met)
    t.check("--wide: requirements and their verdicts", verdicts and len({row[place["met"]] for row in met}) == 2)
    report = json.loads(run(qerr, "sweep", "-q", spec, "--format", "json", "--statistics", "max").out)
    values = {(str(v["variant"]), f'{f["quantity"]}.max [{f["unit"]}]'): f["max"] for v in report["variants"] for f in v.get("figures", [])}
    t.check("JSON has the same figures", values and all(float(found[key]) == value for key, value in values.items()))


def check_errors(t, qerr, spec, whole, folder):
    def with_sweep(text):
        file = folder / "wrong.yaml"
        file.write_text(HEAD + "configurations: {count: 50}\n" + text)
        return run(qerr, "sweep", "-q", file, "-o", folder / "none.csv")

    for text, words in (("", ["sweep", "nothing to vary"]),
                        ("sweep: [{key: encoders.a1.bitz, values: [1, 2]}]\n", ["bitz", "bits"]),
                        ("sweep: [{key: encoders.a1.bits, values: []}]\n", ["values", "empty"]),
                        ("sweep: [{keys: [encoders.a1.bits, encoders.a2.bits], values: [[13, 14], [15]]}]\n", ["values[1]", "2 keys"]),
                        ("sweep: [{keys: [encoders.a1.bits, encoders.a2.bits], values: [13, 14]}]\n", ["values[0]", "list"]),
                        ("sweep: [{keys: [], values: []}]\n", ["keys", "empty"]),
                        ("sweep: [{key: encoders.a1.bits, keys: [encoders.a2.bits], values: [1]}]\n", ["keys"]),
                        ("sweep: [{key: encoders.a1.bits, values: [12]}, {key: encoders.a1.bits, values: [13]}]\n", ["encoders.a1.bits", "twice"]),
                        ("sweep: [{key: encoders.a1.bits, values: [12]}, {key: encoders.a1, values: [{bits: 3}]}]\n", ["encoders.a1", "twice"]),
                        ("sweep: [{key: encoders.a1.bits, values: [12]}, {key: encoders.a1.counts_per_rev, values: [9]}]\n", ["counts_per_rev", "twice"]),
                        ("sweep: [{key: 'a[0].b', values: [12]}, {key: a.0.b, values: [9]}]\n", ["a.0.b and a[0].b", "twice"]),
                        ("sweep: [{key: filters.velocity, catalogue: encoders.csv}]\n", ["catalogue", "encoders"]),
                        ("sweep: [{key: encoders.a1, catalogue: nowhere.csv}]\n", ["nowhere.csv"]),
                        ("sweep: [{key: encoders.a1, catalogue: encoders.csv, values: [1]}]\n", ["values", "catalogue"])):
        ran = with_sweep(text)
        expect(t, f"refused: {text.strip() or 'a spec without sweep'}", ran, (3, 4), words=words)
    many = "sweep:\n" + "".join(f"  - {{key: encoders.a{i}.counts_per_rev, from: 100, to: 1e6, count: 1e5}}\n" for i in range(1, 4))
    expect(t, "1e15 variants need --allow-long", with_sweep(many), 3, words=["--allow-long", "1e10"])
    many += "".join(f"  - {{key: encoders.a{i}.counts_per_rev, from: 100, to: 1e6, count: 1e5}}\n" for i in range(4, 8))
    expect(t, "more than 2^53 variants", with_sweep(many), 3, words=["2^53"])
    t.check("nothing is written", not (folder / "none.csv").exists())

    for shard in ("0/3", "4/3", "1.5/3", "x/3", "3", "1/0", "-1/3"):
        expect(t, f"--shard {shard}", run(qerr, "sweep", "-q", spec, "--shard", shard, "-o", folder / "none.csv"), 2, words=["--shard", "K/N"])
    expect(t, "--statistics of an unknown one", run(qerr, "sweep", spec, "--statistics", "max,p98"), 2, words=["p98"])
    expect(t, "--resume without a file", run(qerr, "sweep", spec, "--resume"), 2, words=["--resume", "-o"])
    expect(t, "--wide in JSON", run(qerr, "sweep", spec, "--wide", "--format", "json"), 2, words=["--wide", "CSV"])

    target = folder / "resumed.csv"
    other = spec.with_name("other.yaml")
    other.write_text(spec.read_text().replace("values: [30, 80]", "values: [30, 81]"))
    run(qerr, "sweep", "-q", spec, "-o", target)
    t.check("the file has its record", "user.qerr" in os.listxattr(target), "the folder of temporary files keeps no extended attributes")
    for name, words in (("another seed", [spec, "--seed", "7"]), ("other statistics", [spec, "--statistics", "max"]), ("another shard", [spec, "--shard", "2/3"]),
                        ("other values", [other]), ("--wide", [spec, "--wide"]), ("another count", [spec, "--set", "configurations.count=999"])):
        ran = run(qerr, "sweep", "-q", *words, "-o", target, "--resume")
        expect(t, f"resume with {name}", ran, 3, words=["resumed.csv", "--resume"])
        t.check(f"resume with {name}: the file is as before", same(whole, target))
    copied = folder / "copied.csv"
    copied.write_bytes(whole.read_bytes()[: whole.stat().st_size // 2].replace(b"max", b"min"))
    target.unlink()
    shutil.copyfile(copied, target)  # bytes only, no note
    ran = run(qerr, "sweep", spec, "-o", target, "--resume")
    t.check("resume of a copy: all variants anew, and said", ran.code == 0 and same(whole, target) and b"computed anew" in ran.err, ran.err.decode())
    target.write_text("key,value\nx,3\n")
    expect(t, "resume of a file that is no sweep", run(qerr, "sweep", "-q", spec, "-o", target, "--resume"), 3, words=["resumed.csv"])
    expect(t, "an output that is the spec", run(qerr, "sweep", "-q", spec, "-o", spec), 2)

    a, b, c = (folder / f"{k}of5.csv" for k in (1, 2, 3))
    shards = [folder / f"{k}of5.csv" for k in range(1, 6)]
    expect(t, "merge without one shard", run(qerr, "merge", *shards[:1], *shards[2:]), 3, words=["shard 2/5 is missing"])
    expect(t, "merge with a shard twice", run(qerr, "merge", *shards, b), 3, words=[b.name])
    copy = folder / "copy.csv"
    copy.write_bytes(c.read_bytes())
    expect(t, "merge with a copy of a shard", run(qerr, "merge", *shards, copy), 3, words=[c.name, copy.name])
    copy.write_bytes(c.read_bytes()[:-3000])
    expect(t, "merge with a torn shard", run(qerr, "merge", a, b, copy, *shards[3:]), 3, words=[copy.name, "not complete"])
    expect(t, "merge with a shard of another division", run(qerr, "merge", a, b, folder / "3of13.csv", *shards[3:]), 3, words=["shard"])
    run(qerr, "sweep", "-q", CONFIGS / "scara" / "spec.yaml", "--set", "configurations.count=10", "--set", "motion.duration=0.2",
        "--shard", "3/5", "-o", copy)
    expect(t, "merge with a shard of another sweep", run(qerr, "merge", a, b, copy, *shards[3:]), 3, words=[copy.name, "another sweep"])
    t.check("merge --spec", run(qerr, "merge", *shards, "--spec", spec).out == whole.read_bytes())
    expect(t, "merge --spec without the last shard", run(qerr, "merge", *shards[:4], "--spec", spec), 3, words=["is missing"])
    for name, words in (("of another seed", [spec, "--seed", "7"]), ("of other values", [other])):
        run(qerr, "sweep", "-q", *words, "--shard", "5/5", "-o", copy)
        expect(t, f"merge --spec with a shard {name}", run(qerr, "merge", *shards[:4], copy, "--spec", spec), 3, words=[copy.name, "spec"])
    expect(t, "merge --spec with other options", run(qerr, "merge", *shards, "--spec", spec, "--statistics", "max"), 3, words=["--statistics"])
    expect(t, "merge --spec of another form", run(qerr, "merge", *shards, "--spec", spec, "--wide"), 3, words=["--wide"])
    expect(t, "merge --set without --spec", run(qerr, "merge", *shards, "--set", "a=3"), 2, words=["--spec"])
    expect(t, "merge of a spec", run(qerr, "merge", spec), 3, words=[spec.name])
    expect(t, "merge of nothing", run(qerr, "merge"), 2, words=["FILE"])
    expect(t, "merge into a shard", run(qerr, "merge", *shards, "-o", a), 2, words=[a.name])


EDITED = """qerr: 1
robot: {urdf: arm.urdf}
encoders: {'*': {counts_per_rev: 4096, gear_ratio: 100}}
configurations: {count: 40}
requirements: [{quantity: position.x.sigma, statistic: max, at_most: 5 um}]
filters: {v: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: first_order, order: 2, cutoff: 50 Hz}}}
sweep:
  - {key: encoders.a2, catalogue: cat.csv}
  - {key: robot.urdf, values: [arm.urdf, other.urdf]}
  - {key: filters.v.lowpass.cutoff, values: [20 Hz, 50 Hz, 600 Hz]}
"""


class Edited:
    """A sweep whose inputs and files are edited between two runs."""

    def __init__(self, qerr, folder, rng):
        self.qerr, self.folder, self.rng, self.options = qerr, folder, rng, []
        urdf = (CONFIGS / "kuka_lwr" / "kuka_lwr.urdf").read_text()
        self.texts = {"edited.yaml": EDITED, "cat.csv": CATALOGUE, "arm.urdf": urdf, "other.urdf": urdf.replace("0.4", "0.5")}
        for name, text in self.texts.items():
            (folder / name).write_text(text)
        self.wide = rng.choice([[], ["--wide"]])

    def run(self, *words):
        return run(self.qerr, *words, cwd=self.folder)

    def sweep(self, *words):
        return self.run("sweep", "-q", "edited.yaml", *self.wide, *self.options, *words)

    def kill(self, *words):
        process = subprocess.Popen([str(self.qerr), "sweep", "-q", "edited.yaml", *self.wide, *words], cwd=self.folder, stdin=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        try:
            process.wait(timeout=self.rng.uniform(0, 0.05))
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def edit_input(self):
        """Changes an input. @returns the name that a refusal must have"""
        name, old, new = self.rng.choice([("edited.yaml", "50 Hz", "51 Hz"), ("edited.yaml", "5 um", "6 um"), ("edited.yaml", "qerr: 1", "# a comment\nqerr: 1"),
                                          ("cat.csv", "1024", "1025"), ("cat.csv", "0.5", "0.6"), ("arm.urdf", "0.4", "0.41"), ("other.urdf", "0.5", "0.51"),
                                          ("--set", "", "requirements.0.at_most=7 um"), ("--set", "", "configurations.count=41"), ("--seed", "", "3"),
                                          ("--statistics", "", "max")])
        if not old:
            self.options = [name, new]
            return name
        (self.folder / name).write_text(self.texts[name].replace(old, new))
        return "the spec" if name == "edited.yaml" else name

    def edit_rows(self, file):
        """Changes digits of whole rows, removes, repeats or cuts some."""
        lines = file.read_bytes().split(b"\r\n")
        i = self.rng.randrange(1, max(2, len(lines) - 1))
        kind = self.rng.randrange(5)
        if kind == 0:
            lines[i:i + 3] = [line.translate(bytes.maketrans(b"37", b"48")) for line in lines[i:i + 3]]
        elif kind == 1:
            del lines[i]
        elif kind == 2:
            lines.insert(i, lines[i])
        elif kind == 3:
            lines[i:] = [lines[i][: len(lines[i]) // 2]] if i < len(lines) else []
        else:
            lines.append(b"99,more")
        if self.rng.random() < 0.5:
            file.unlink()  # as editors do, which write another file in its place
        file.write_bytes(b"\r\n".join(lines))


def check_edited(t, qerr, rounds, rng):
    """Killed, edited, and resumed or merged: the bytes of a fresh run, or a refusal that names what has changed."""
    for round_ in range(rounds):
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            e = Edited(qerr, folder, rng)
            sharded, whole = rng.random() < 0.5, rng.random() < 0.6
            files = [["--shard", f"{k}/3", "-o", f"{k}.csv"] for k in (1, 2, 3)] if sharded else [["-o", "one.csv"]]
            for words in files:
                (e.sweep if whole or rng.random() < 0.5 else e.kill)(*words)
            changed = [e.edit_input()] if rng.random() < 0.6 else []
            name = files[-1][-1]
            if (folder / name).exists() and rng.random() < (0.3 if changed else 0.8):
                e.edit_rows(folder / name)
                changed += [name]
            if sharded and rng.random() < 0.5:  # one of them is computed anew, for mixed shards
                e.sweep(*files[0])
            refused = None
            for words in files:
                if sharded and (folder / words[-1]).exists() and rng.random() < 0.3:
                    continue
                ran = e.sweep(*words, "--resume")
                refused = refused or (ran if ran.code else None)
            result = folder / "one.csv"
            if sharded:
                spec = ["--spec", "edited.yaml", *e.wide, *e.options] if rng.random() < 0.5 else []
                ran = e.run("merge", "3.csv", "1.csv", "2.csv", "-o", "all.csv", *spec)
                refused, result = (ran if ran.code else None), folder / "all.csv"
            fresh = folder / "fresh.csv"
            e.sweep("-o", fresh.name)
            message = refused.err.decode() if refused else ""
            if refused:
                good = refused.code == 3 and (any(word in message for word in changed) or "not complete" in message or "missing" in message)
            else:
                good = same(result, fresh) or (sharded and "--spec" not in spec and changed)  # all shards of the inputs before
            t.check(f"edited, round {round_}: {'shards' if sharded else 'one file'}, {', '.join(changed) or 'nothing'} changed", good, message[:300])


def check_varied_key(t, qerr, spec):
    """An override of a key that the sweep varies governs nothing in the sweep, and what it says elsewhere."""
    words = [spec, "--set", "sweep=[{key: filters.velocity.lowpass.cutoff, values: [50 Hz, 60 Hz]}]", "--set", "configurations.count=20"]
    change = ["--set", "filters.velocity.lowpass.cutoff=20 Hz"]
    expect(t, "--set of a key that the sweep varies", run(qerr, "sweep", "-q", *words, *change), 3, words=["the sweep varies it"])
    found = run(qerr, "analyze", "-q", "--format", "csv", *words, *change)
    t.check("analyze uses it", found.code == 0 and found.out != run(qerr, "analyze", "-q", "--format", "csv", *words).out, found.err.decode())


def check_check(t, qerr, spec, folder):
    """--check: 1 for requirements that are not met, 3 for variants that cannot be computed; these are counted, with -q, too."""
    at_most = "requirements=[{quantity: position.x.worst_case, statistic: max, at_most: %s}]"
    axis = "sweep=[{key: filters.velocity.lowpass.cutoff, values: [50 Hz, %s]}]"
    for limit, cutoff, code, words in (("1 m", "60 Hz", 0, []), ("1 nm", "60 Hz", 1, ["2 of 2 variants do not meet"]), ("1 m", "600 Hz", 3, ["1 of 2 variants"]),
                                       ("1 nm", "600 Hz", 3, ["1 of 2 variants cannot be computed", "1 of 2 variants do not meet"])):
        changes = ["--set", at_most % limit, "--set", axis % cutoff, "--set", "configurations.count=20"]
        for more in ([], ["--wide"], ["--format", "json"], ["--shard", "1/1"]):
            ran = run(qerr, "sweep", "-q", spec, *changes, *more, "--check")
            said = ran.err.decode()
            t.check(f"--check {' '.join(more)}: {code}", ran.code == code and all(word in said for word in words) and bool(said) == bool(words), f"{ran.code} {said}")
        ran = run(qerr, "sweep", "-q", spec, *changes)
        t.check("without --check: 0, and what was not computed is counted", ran.code == 0 and (b"1 of 2 variants" in ran.err) == (cutoff == "600 Hz"), ran.err.decode())
    target = folder / "checked.csv"
    run(qerr, "sweep", "-q", spec, *changes, "-o", target)
    ran = run(qerr, "sweep", "-q", spec, *changes, "-o", target, "--resume", "--check")
    t.check("--check of a file that was not judged", ran.code == 3 and b"1 of 2 variants do not meet" in ran.err, ran.err.decode())
    expect(t, "--check without requirements", run(qerr, "sweep", "-q", spec, "--set", "requirements=[]", *changes[2:], "--check"), 3, words=["requirements"])


def check_pipe(t, qerr, shards, whole):
    """Each file is read once: it may be a pipe."""
    words = " ".join(f"'{shard}'" for shard in shards[1:])
    done = subprocess.run(["bash", "-c", f"'{qerr}' merge {words} <(cat '{shards[0]}')"], capture_output=True, timeout=60)
    t.check("merge of a pipe to standard output", done.returncode == 0 and done.stdout == whole.read_bytes(), done.stderr.decode())


def check_output(t, qerr, spec, whole, folder):
    t.check("standard output has the bytes of a file", run(qerr, "sweep", "-q", spec).out == whole.read_bytes())
    for threads in ("1", "3"):
        run(qerr, "sweep", "-q", spec, "--threads", threads, "-o", folder / "threads.csv")
        t.check(f"{threads} threads: the same bytes", same(whole, folder / "threads.csv"))
    done = subprocess.run(["bash", "-c", f"'{qerr}' sweep -q '{spec}' | head -1"], capture_output=True, text=True)
    t.check("sweep | head ends quietly", done.stdout.startswith("variant,") and not done.stderr, done.stderr)
    t.check("a table on demand", b"variant" in run(qerr, "sweep", "-q", spec, "--format", "table").out)
    run(qerr, "sweep", "-q", spec, "--statistics", "p99,max", "-o", folder / "few.csv")
    header, rows = rows_of(folder / "few.csv")
    everything = [row for row in rows_of(whole)[1] if row[-2] in ("max", "p99", "")]
    t.check("--statistics narrows the rows", rows == everything)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--qerr", required=True)
    parser.add_argument("--verbose", action="store_true", help="print the checks that pass, too")
    parser.add_argument("--rounds", type=int, default=2, help="sweeps that are killed, of each kind")
    parser.add_argument("--rows", type=int, default=6, help="variants compared with analyze, of each kind")
    parser.add_argument("--edits", type=int, default=30, help="sweeps whose inputs or files are edited")
    arguments = parser.parse_args()
    qerr, t, rng = pathlib.Path(arguments.qerr).resolve(), Tally(arguments.verbose), random.Random(1)
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        (folder / "encoders.csv").write_text(CATALOGUE)
        for name, text in (("single.yaml", SINGLE), ("shared.yaml", SHARED)):
            spec, whole = folder / name, folder / "whole.csv"
            spec.write_text(text)
            ran = run(qerr, "sweep", spec, "-o", whole)
            t.check(f"{name}: 0, with a warning about variants that cannot be computed",
                    ran.code == 0 and (b"warning: variant" in ran.err) == (name == "shared.yaml"), ran.err.decode()[:300])
            check_figures(t, qerr, spec, whole, arguments.rows, rng)
            # Each form of the table with one way of computing it: neither knows the other.
            options = ["--wide", "--statistics", "max"] if name == "single.yaml" else []
            if options:
                whole = folder / "wide_whole.csv"
                run(qerr, "sweep", "-q", spec, *options, "-o", whole)
            for check in (check_torn, check_shards):
                check(t, qerr, spec, whole, folder, options, rng)
            check_killed(t, qerr, spec, whole, folder, options, arguments.rounds, rng)
        whole = folder / "whole.csv"
        check_wide(t, qerr, spec, folder)
        check_output(t, qerr, spec, whole, folder)
        for k in range(1, 6):
            run(qerr, "sweep", "-q", spec, "--shard", f"{k}/5", "-o", folder / f"{k}of5.csv")
        run(qerr, "sweep", "-q", spec, "--shard", "3/13", "-o", folder / "3of13.csv")
        check_errors(t, qerr, spec, whole, folder)
        check_pipe(t, qerr, [folder / f"{k}of5.csv" for k in range(1, 6)], whole)
        check_check(t, qerr, spec, folder)
        check_edited(t, qerr, arguments.edits, rng)
        check_varied_key(t, qerr, spec)
        check_shards_of_one_variant(t, qerr, folder)
        check_said_at_once(t, qerr, folder)
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
