#!/usr/bin/env python3
"""Acceptance of error handling: bad specs, bad URDFs, exit codes, outputs that cannot be written.

    check_bad_input.py --qerr build/qerr [--verbose]
"""
import csv
import pathlib
import re
import sys
import tempfile

import exit_codes
from cases import CORPUS
from tool import program_and_tally, run

SHAPE = re.compile(r"^(?P<file>.+?):(?P<line>\d+):(?P<column>\d+): \S")
CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f\x80-\x9f]")


def faults(ran, line="-", text="-"):
    """What is wrong with qerr's answer to a bad input; empty if it satisfies the contract."""
    found = []
    message = ran.err.decode("utf-8", errors="surrogateescape")
    if ran.code == "timeout" or ran.seconds > 2:
        found.append(f"took {ran.seconds:.1f} s")
    if isinstance(ran.code, int) and ran.code < 0:
        found.append(f"killed by signal {-ran.code}")
    elif ran.code != 3:
        found.append(f"exit code {ran.code} instead of 3")
    if ran.out:
        found.append(f"{len(ran.out)} bytes on standard output")
    if len(message.splitlines()) > 20:
        found.append(f"{len(message.splitlines())} lines of message")
    if len(message) > 20000:
        found.append(f"{len(message)} characters of message")
    if CONTROL.search(message) or any(0xDC80 <= ord(c) <= 0xDCFF for c in message):
        found.append("control characters or bad UTF-8 in the message")
    shaped = [m for m in map(SHAPE.match, message.splitlines()) if m]
    if not shaped:
        found.append("no message of the shape FILE:LINE:COLUMN: ...")
    elif line != "-":
        low, _, high = line.partition("-")
        if not any(int(low) <= int(m["line"]) <= int(high or low) for m in shaped):
            found.append(f"names line {shaped[0]['line']} instead of {line}")
    if text != "-" and text not in message:
        found.append(f"does not contain '{text}'")
    return "; ".join(found) + (f"\n      {message.strip()[:400]}" if found else "")


def check_specs(t, qerr):
    specs = sorted((CORPUS / "bad_specs").glob("*.yaml"))
    t.check("at least 70 bad specs", len(specs) >= 70, str(len(specs)))
    for spec in specs:
        _, _, line, text = spec.read_text().splitlines()[0].split(" ", 3)
        problem = faults(run(qerr, "analyze", spec, limit=20), line, text)
        t.check(f"bad_specs/{spec.name}", not problem, problem)


def spec_around(folder, urdf, extra=""):
    spec = folder / "around.yaml"
    spec.write_text(f"qerr: 1\nrobot: {{urdf: {urdf}}}\nencoders:\n  '*': {{bits: 14}}\nconfigurations: {{count: 20}}\n{extra}")
    return spec


def grown(folder):
    """Bad URDFs too large to keep in the repository."""
    start, middle, end = '<?xml version="1.0"?>\n<robot name="r">\n', '<link name="a"/>\n', "</robot>\n"
    made = {
        "deep_40000": start + "<a>" * 40000 + "</a>" * 40000 + end,
        "deep_unclosed_1000000": start + "<a>" * 1000000,
        "attributes_50000": start + "<link name='a' " + " ".join(f"a{i}='1'" for i in range(50000)) + "/>\n" + end,
        "over_16_MB": start + middle + "<!--" + "x" * (17 << 20) + "-->\n" + end,
        "long_name": start + f'<link name="{"n" * 500000}"/>\n' + middle + end,
        "chain_without_end": start + "".join(f'<link name="l{i}"/>\n' for i in range(3000)) + end,
    }
    for name, text in made.items():
        path = folder / f"{name}.urdf"
        path.write_text(text)
        yield path


def check_urdfs(t, qerr, folder):
    sound = run(qerr, "analyze", spec_around(folder, CORPUS / "two_joints.urdf"))
    t.check("the valid robot of the corpus is accepted", sound.code == 0, sound.err.decode(errors="replace")[:300])
    with open(CORPUS / "bad_urdfs" / "expect.csv", newline="") as table:
        rows = list(csv.DictReader(table))
    present = {p.name for p in (CORPUS / "bad_urdfs").glob("*.urdf")}
    t.check("at least 70 bad URDFs, each in expect.csv", len(rows) >= 70 and present == {r["file"] for r in rows},
            f"{len(rows)}, not in both: {sorted(present ^ {r['file'] for r in rows})}")
    for row in rows:
        ran = run(qerr, "analyze", spec_around(folder, CORPUS / "bad_urdfs" / row["file"]), limit=20)
        problem = faults(ran, row["line"], row["substring"])
        t.check(f"bad_urdfs/{row['file']}", not problem, problem)
    for path in grown(folder):
        problem = faults(run(qerr, "analyze", spec_around(folder, path), limit=20))
        t.check(f"a generated URDF: {path.stem}", not problem, problem)


def check_flawed_urdfs(t, qerr, folder):
    """A flaw that the chain from base to tip does not use is a warning that names it."""
    with open(CORPUS / "flawed_urdfs" / "expect.csv", newline="") as table:
        rows = list(csv.DictReader(table))
    present = {p.name for p in (CORPUS / "flawed_urdfs").glob("*.urdf")}
    t.check("every flawed URDF is in expect.csv", present == {r["file"] for r in rows}, str(present))
    for row in rows:
        spec = folder / "flawed.yaml"
        urdf = CORPUS / "flawed_urdfs" / row["file"]
        spec.write_text(f"qerr: 1\nrobot: {{urdf: {urdf}, base: base_link, tip: tool0}}\n"
                        "encoders: {'*': {bits: 14}}\nconfigurations: {count: 20}\n")
        ran = run(qerr, "analyze", spec, limit=20)
        message = ran.err.decode(errors="replace")
        t.check(f"flawed_urdfs/{row['file']}", ran.code == 0 and row["substring"] in message and "warning: " in message,
                f"exit code {ran.code}: {message[:400]}")
        made = run(qerr, "robot", urdf, "--write-spec", spec, "--force", limit=20)
        ran = run(qerr, "analyze", spec, limit=20)
        t.check(f"flawed_urdfs/{row['file']}: the first spec is analyzed", made.code == 0 and ran.code == 0,
                (made.err + ran.err).decode(errors="replace")[:400])


def grown_specs(folder):
    start = f"qerr: 1\nrobot: {{urdf: {CORPUS / 'two_joints.urdf'}}}\nencoders: {{'*': {{bits: 14}}}}\n"
    made = {
        "invalid_utf8": start.encode() + b"coordinates: [x\xff]\n", "nul": start.encode() + b"\0coordinates: [x]\n",
        "utf16": start.encode("utf-16"), "empty": b"", "control": start.encode() + b"coordinates: ['x\x1b[31m']\n",
        "escaped_control": start.encode() + b'coordinates: ["x\\e[31m\\r\\0"]\n', "binary": bytes(range(256)) * 4,
        "deep_100000": (start + "coordinates: " + "[" * 100000).encode(), "deep_maps": (start + "filters: " + "{a: " * 100000).encode(),
        "over_16_MB": start.encode() + b"#" + b"x" * (17 << 20) + b"\n",
        "many_unknown_keys": (start + "".join(f"key{i}: 1\n" for i in range(5000))).encode(),
        "long_key": (start + "k" * 300000 + ": 1\n").encode(), "newline_in_key": start.encode() + b'"a\\nb\\nc": 1\n',
        "billion_grid": (start + "configurations: {method: grid, count: [4000000000, 4000000000]}\n").encode(),
    }
    for name, data in made.items():
        path = folder / f"{name}.yaml"
        path.write_bytes(data)
        yield path


def check_foreign_files(t, qerr, folder):
    """A file of another kind in each place that takes one: refused, without a word of what it holds."""
    spec = spec_around(folder, CORPUS / "two_joints.urdf", "requirements: [{quantity: position.x.sigma, statistic: max, at_most: 1 m}]\n")
    report = folder / "report.json"
    run(qerr, "analyze", spec, "-o", report)
    kinds = {"passwords": "root:$6$SECRET:19000:0:99999:7:::\ndaemon:*SECRET:19000::\n", "table": "SECRET1,SECRET2\n1,2\n",
             "words": "SECRET words\nand SECRET more\n", "json": '{"SECRET": SECRET}\n'}
    for kind, text in kinds.items():
        foreign = folder / kind
        foreign.write_text(text)
        for words in (["analyze", foreign], ["compare", foreign, spec], ["check", spec, "--baseline", foreign], ["merge", foreign],
                      ["diagnose", spec, foreign], ["robot", foreign], ["analyze", spec, "--set", f"robot.urdf={foreign}"],
                      ["analyze", spec, "--set", f"configurations={{method: file, file: {foreign}}}"],
                      ["simulate", spec, "--set", f"motion={{file: {foreign}}}"],
                      ["design", spec, "--set", f"design={{encoders: {{'*': {{catalogue: {foreign}}}}}}}"],
                      ["sweep", spec, "--set", f"sweep=[{{key: encoders.*, catalogue: {foreign}}}]"]):
            ran = run(qerr, *words)
            t.check(f"{words[0]} of {kind}: 3, without its content", ran.code == 3 and not ran.out and b"SECRET" not in ran.err,
                    f"exit {ran.code}: {ran.err.decode()[:300]}")
    ran = run(qerr, "analyze", report)
    t.check("a report as a spec: 3, by name", ran.code == 3 and b"report" in ran.err, ran.err.decode()[:300])


def main():
    qerr, t = program_and_tally()
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        check_specs(t, qerr)
        for path in grown_specs(folder):
            problem = faults(run(qerr, "analyze", path, limit=20))
            t.check(f"a generated spec: {path.stem}", not problem, problem)
        check_urdfs(t, qerr, folder)
        check_flawed_urdfs(t, qerr, folder)
        check_foreign_files(t, qerr, folder)
        exit_codes.check_good_specs(t, qerr, CORPUS)
        exit_codes.check_exit_codes(t, qerr, folder, spec_around(folder, CORPUS / "two_joints.urdf"))
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
