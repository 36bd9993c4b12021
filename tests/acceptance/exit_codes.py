"""Exit codes, outputs that cannot be written, and specs that must be accepted."""
import json
import os
import pathlib
import shlex
import signal
import subprocess
import time
import xml.etree.ElementTree

from cases import CORPUS
from tool import run


def check_good_specs(t, qerr, corpus):
    specs = sorted((corpus / "good_specs").glob("*.yaml"))
    t.check("at least 15 good specs", len(specs) >= 15, str(len(specs)))
    for spec in specs:
        ran = run(qerr, "analyze", spec, "--format", "json")
        t.check(f"good_specs/{spec.name} is accepted", ran.code == 0, f"exit {ran.code}: {ran.err.decode(errors='replace')[:300]}")
        if ran.code == 0:
            try:
                json.loads(ran.out, parse_constant=lambda word: 1 / 0)
                problem = ""
            except (ValueError, ZeroDivisionError) as trouble:
                problem = repr(trouble)
            t.check(f"good_specs/{spec.name}: strict JSON", not problem, problem)


def expect(t, name, ran, code, quiet_stdout=True, words=()):
    codes = code if isinstance(code, tuple) else (code,)
    text = ran.err.decode(errors="replace")
    problems = [] if ran.code in codes else [f"exit code {ran.code} instead of {code}"]
    if quiet_stdout and ran.out:
        problems.append(f"{len(ran.out)} bytes on standard output")
    if ran.code not in (0,) and not text.strip():
        problems.append("no message")
    if len(text.splitlines()) > 20:
        problems.append(f"{len(text.splitlines())} lines of message")
    problems += [f"does not contain '{w}'" for w in words if w not in text]
    t.check(name, not problems, "; ".join(problems) + "\n      " + text.strip()[:300])


def check_exit_codes(t, qerr, folder, spec):
    expect(t, "an unknown option: 2", run(qerr, "analyze", spec, "--colour"), 2, words=["--colour"])
    expect(t, "an unknown command: 2", run(qerr, "analyse", spec), 2)
    expect(t, "no command: 2", run(qerr), 2)
    expect(t, "no spec: 2", run(qerr, "analyze"), 2)
    expect(t, "an unknown format: 2", run(qerr, "analyze", spec, "--format", "xml"), 2)
    for option in (["--threads", "-1"], ["--threads", "1.5"], ["--seed", "-1"], ["--seed", "nan"],
                   ["--seed", "1e400"], ["--seed", ""], ["--seed", "99999999999999999999999"], ["--threads", "two"]):
        expect(t, f"{' '.join(option) or 'nothing'}: 2", run(qerr, "analyze", spec, *option), 2)
    expect(t, "--set with an unknown key", run(qerr, "analyze", spec, "--set", "encoders.elbow.colour=3"), (2, 3), words=["colour"])
    expect(t, "--set without '='", run(qerr, "analyze", spec, "--set", "seed"), (2, 3))
    expect(t, "--set with a bad value", run(qerr, "analyze", spec, "--set", "configurations.count=-3"), (2, 3), words=["count"])
    expect(t, "--set with a good value: 0", run(qerr, "analyze", spec, "--set", "configurations.count=30"), 0, False)
    for arguments in (["--help"], ["--version"], ["analyze", "--help"]):
        ran = run(qerr, *arguments)
        t.check(f"{' '.join(arguments)}: 0, on standard output", ran.code == 0 and ran.out and not ran.err, f"exit {ran.code}")
    expect(t, "a missing spec: 4", run(qerr, "analyze", folder / "nowhere.yaml"), 4, words=["nowhere.yaml"])
    expect(t, "a directory as spec: 3 or 4", run(qerr, "analyze", folder), (3, 4))
    missing = folder / "missing_urdf.yaml"
    missing.write_text("qerr: 1\nrobot: {urdf: nowhere.urdf}\nencoders: {'*': {bits: 14}}\n")
    expect(t, "a missing URDF: 3 or 4", run(qerr, "analyze", missing), (3, 4), words=["nowhere.urdf"])
    missing.write_text("qerr: 1\nrobot: {urdf: .}\nencoders: {'*': {bits: 14}}\n")
    expect(t, "a directory as URDF: 3 or 4", run(qerr, "analyze", missing), (3, 4))
    check_outputs(t, qerr, folder, spec)


def shell(command):
    done = subprocess.run(["bash", "-c", command], stdin=subprocess.DEVNULL, capture_output=True, timeout=60)
    return done.returncode, done.stdout, done.stderr


def check_outputs(t, qerr, folder, spec):
    expect(t, "-o into a missing folder: 4", run(qerr, "analyze", spec, "-o", folder / "no" / "out.json"), 4)
    expect(t, "-o onto a folder: 4", run(qerr, "analyze", spec, "--format", "json", "-o", folder), 4)
    expect(t, "--per-configuration into a missing folder: 4",
           run(qerr, "analyze", spec, "--per-configuration", folder / "no" / "out.csv"), 4, False)
    expect(t, "-o /dev/full: 4", run(qerr, "analyze", spec, "--format", "json", "-o", "/dev/full"), 4)
    command = f"{shlex.quote(str(qerr))} analyze {shlex.quote(str(spec))} --format "
    for form in ("table", "json", "csv"):
        code, _, err = shell(f"{command}{form} > /dev/full")
        t.check(f"{form} > /dev/full: 4", code == 4 and err, f"exit {code}: {err.decode()[:200]}")
        code, out, err = shell(f"{command}{form} --quiet | head -1")
        t.check(f"{form} | head -1: no error message", out.count(b"\n") <= 1 and b"error" not in err.lower() and b"pipe" not in err.lower(), err.decode()[:200])
    code, _, err = shell(f"{command}json >&-")
    t.check("standard output closed: 4", code == 4, f"exit {code}: {err.decode()[:200]}")
    t.check("/dev/full is still a device", not os.path.isfile("/dev/full"))
    target = folder / "kept.json"
    target.write_text("old")
    before = set(os.listdir(folder))
    bad = folder / "bad_after.yaml"
    bad.write_text(spec.read_text() + "nonsense: 1\n")
    run(qerr, "analyze", bad, "-o", target)
    t.check("a failed run keeps the old output and leaves no temporary file",
            target.read_text() == "old" and set(os.listdir(folder)) == before | {"bad_after.yaml"})
    run(qerr, "analyze", spec, "-o", target)
    t.check("a successful run replaces it and leaves no temporary file",
            target.read_text().startswith("{") and set(os.listdir(folder)) == before | {"bad_after.yaml"})
    code, out, err = shell(f"cat {shlex.quote(str(spec))} | {shlex.quote(str(qerr))} analyze - --format json -o -")
    t.check("the spec from standard input, the report to standard output", code == 0 and out.startswith(b"{"), err.decode()[:200])
    code, out, err = shell(f"{command}json -o >(cat)")
    t.check("a pipe as output is written directly", code == 0, err.decode()[:200])
    plain = {name: subprocess.run([str(qerr), "analyze", str(spec), "--format", "json"], capture_output=True,
                                  env=dict(os.environ, **extra)).stdout
             for name, extra in (("C", {"LC_ALL": "C"}), ("de", {"LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8"}))}
    t.check("the output is independent of the locale", plain["C"] == plain["de"] and plain["C"])
    ran = run(qerr, "analyze", spec, "--no-color")
    t.check("no colour codes unless on a terminal", b"\x1b" not in ran.out)
    check_forms(t, qerr, folder, spec)
    check_files_of_a_run(t, qerr, folder, spec)
    check_comparison(t, qerr, folder)
    check_closed_streams(t, qerr, folder, spec)
    check_long_work(t, qerr, folder)
    check_interrupt(t, qerr, folder, spec)


def check_forms(t, qerr, folder, spec):
    """Endings that are no format of an output, and the options about the form of what is written."""
    for words in (["merge", "none.csv", "-o", folder / "all.xlsx"], ["schema", "-o", folder / "schema.yaml"],
                  ["completion", "bash", "-o", folder / "qerr.py"], ["simulate", spec, "--log", folder / "log.json"],
                  ["analyze", spec, "--per-configuration", folder / "each.html"], ["analyze", spec, "-o", folder / "report.md"]):
        expect(t, f"{words[0]} into {words[-1].name}: 2", run(qerr, *words), 2, words=[words[-1].suffix])
        t.check(f"{words[-1].name} is not written", not words[-1].exists())
    expect(t, "schema -o schema.json: 0", run(qerr, "schema", "-o", folder / "schema.json"), 0)
    quiet = run(qerr, "analyze", spec, "-q", "--json")
    t.check("--json is --format json", quiet.out == run(qerr, "analyze", spec, "-q", "--format", "json").out and quiet.out.startswith(b"{"))
    expect(t, "--json beside another --format: 2", run(qerr, "analyze", spec, "--json", "--format", "csv"), 2)
    ran = run(qerr, "threshold", spec, "-q", "--set", "threshold.length=300 mm",
              "--set", "filters={v: {derivative: 1, sample_rate: 1 kHz}}")
    t.check("threshold shows what --set changed", ran.out.startswith(b"with --set threshold.length=300"), ran.out.decode()[:200])
    long = ["analyze", CORPUS.parents[1] / "configs/kuka_lwr/spec.yaml", "--set", "configurations.count=50000000", "--threads", "1"]
    for when, lines in (("always", True), ("never", False), ("auto", False)):
        ran = run(qerr, *long, "-q", "--progress", when)
        t.check(f"--progress {when} where no terminal is", (b"% of 50.0 M configurations" in ran.err) == lines and b"\x1b" not in ran.err,
                ran.err.decode()[:200])


def check_files_of_a_run(t, qerr, folder, spec):
    """No output may be an input or another output; nothing is written then."""
    own, urdf = folder / "own.yaml", folder / "own.urdf"
    urdf.write_bytes((CORPUS / "two_joints.urdf").read_bytes())
    filters = "filters: {velocity: {derivative: 1, sample_rate: 1 kHz, lowpass: {family: first_order, order: 2, cutoff: 50 Hz}}}\n"
    motion = "motion: {sample_rate: 1 kHz, duration: 1 s, joints: {}}\n"
    needs = "requirements: [{quantity: position.x.worst_case, statistic: max, at_most: 1 m}]\n"
    own.write_text(spec.read_text().replace(str(CORPUS / "two_joints.urdf"), "own.urdf") + filters + motion + needs)
    (folder / "alias.yaml").symlink_to(own)
    os.link(urdf, folder / "hard.urdf")
    log = folder / "own.csv"
    run(qerr, "simulate", own, "--log", log, "-o", folder / "simulated.txt")
    old = folder / "old.json"
    run(qerr, "check", own, "-q", "-o", old)
    new, other = folder / "same.csv", f"{folder}/./same.csv"
    before = {path: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    for words in (["analyze", own, "-o", own], ["analyze", own, "-o", folder / "alias.yaml"], ["analyze", own, "-o", urdf],
                  ["analyze", own, "-o", folder / "hard.urdf"], ["analyze", own, "--per-configuration", own],
                  ["analyze", own, "-o", new, "--per-configuration", other], ["filter", own, "-o", new, "--impulse", other],
                  ["filter", own, "--response", new, "--transient", other], ["filter", own, "--impulse", urdf],
                  ["simulate", own, "--log", new, "-o", other], ["simulate", own, "--log", urdf, "-o", new],
                  ["check", own, "--junit", new, "-o", other], ["check", own, "--junit", own], ["threshold", own, "-o", own],
                  ["compare", own, own, "-o", own], ["check", own, "--baseline", old, "-o", old],
                  ["diagnose", own, log, "-o", log], ["diagnose", own, log, "--write-model", own, "-o", new],
                  ["diagnose", own, log, "--write-table", new, "--write-model", other],
                  ["check", own, "--junit", "-", "-o", "-"], ["check", own, "--junit", "-", "--format", "json"],
                  ["simulate", own, "--log", "-"], ["filter", own, "--impulse", "-"]):
        expect(t, f"{' '.join(pathlib.Path(str(w)).name for w in words)}: 2", run(qerr, *words), 2)
    kept = {path: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    t.check("a refused command line has written nothing", kept == before, str(set(kept) ^ set(before)))
    code, _, err = shell(f"cd {shlex.quote(str(folder))} && {shlex.quote(str(qerr))} analyze own.yaml -q >> own.yaml")
    t.check("standard output appended to the spec: 2", code == 2 and own.read_bytes() == before[own], err.decode()[:200])
    code, _, err = shell(f"{shlex.quote(str(qerr))} analyze {shlex.quote(str(own))} -q -o /dev/null --per-configuration /dev/null")
    t.check("devices may be given twice", code == 0, err.decode()[:200])
    ran = run(qerr, "check", own, "-q", "--junit", "-")
    t.check("--junit - leaves standard output to the XML alone",
            ran.code == 0 and ran.out.startswith(b"<?xml") and xml.etree.ElementTree.fromstring(ran.out) is not None,
            ran.out.decode()[:200])
    # No table of qerr is taken for a catalogue or a spec that a person may have edited.
    kinds = ("coordinates", "effects", "encoders", "filters", "formats", "statistics")
    for words in (["analyze", own], ["check", own], ["compare", own, own], ["filter", own], ["robot", urdf], ["simulate", own], ["threshold", own],
                  ["diagnose", own, log], *(["list", kind] for kind in kinds)):
        for ending in (".csv", ".json", ".txt"):
            again = folder / f"again{ending}"
            again.unlink(missing_ok=True)
            codes = [run(qerr, *words, "-o", again).code for _ in range(2)]
            t.check(f"{words[0]} {pathlib.Path(str(words[1])).name} replaces its {ending}", codes == [0, 0], str(codes))


def check_comparison(t, qerr, folder):
    """Differences are no failure of compare; a figure that is worse than in the baseline is one of check."""
    own, old = folder / "own.yaml", folder / "old.json"
    coarser = ["-q", "--set", "encoders.*.counts_per_rev=1000"]
    expect(t, "compare with differences: 0", run(qerr, "compare", old, own, *coarser), 0, quiet_stdout=False)
    expect(t, "check of the same spec as the baseline: 0", run(qerr, "check", own, "-q", "--baseline", old), 0, quiet_stdout=False)
    ran = run(qerr, "check", own, *coarser, "--baseline", old, "--tolerance", "2%", "--format", "json")
    worse = json.loads(ran.out)["regressions"] if ran.out else []
    t.check("check of a coarser encoder against the baseline: 1", ran.code == 1 and worse and all(r["change"] > 0.02 for r in worse), str(worse))
    coarse = folder / "coarse.json"
    run(qerr, "check", own, *coarser, "--format", "json", "-o", coarse)
    for tolerance, said in (("2", True), ("2%", False)):
        ran = run(qerr, "check", own, "--baseline", old, "--tolerance", tolerance)
        t.check(f"a tolerance of {tolerance}: {'asked about' if said else 'taken'}", ran.code == 0 and (b"2 % is 0.02" in ran.err) == said, ran.err.decode()[:300])
    ran = run(qerr, "check", own, "--baseline", coarse)
    t.check("a baseline of another --set: said", ran.code == 0 and b"--set 'encoders.*.counts_per_rev=1000'" in ran.err and
            b"different specs" in ran.err, ran.err.decode()[:300])
    bare = ["--set", "requirements=[]"]
    expect(t, "check without requirements: 3", run(qerr, "check", own, "-q", *bare), 3)
    expect(t, "check without requirements, with a baseline: 0", run(qerr, "check", own, "-q", *bare, "--baseline", old), 0, quiet_stdout=False)
    twin, both = folder / "twin.yaml", folder / "both.json"
    twin.write_text(own.read_text())
    expect(t, "check of two specs into a baseline: 0", run(qerr, "check", own, twin, "-q", "--format", "json", "-o", both), 0)
    ran = run(qerr, "check", own, twin, "--baseline", both)
    said = ran.err.decode().splitlines()
    t.check("each of two specs is compared with its own baseline", ran.code == 0 and ran.out.count(b"Baseline: none of") == 2, ran.out.decode()[-500:])
    t.check("a warning of two specs stands once, with both names", said and len(said) == len(set(said)) and
            all(f"{own}, {twin}: " in line for line in said if line.startswith("warning")), ran.err.decode()[:500])
    expect(t, "a baseline without a report of the spec: 3", run(qerr, "check", own, twin, "--baseline", old), 3)
    for text in ("", "{}", '{"qerr": "0", "command": "simulate"}', "[" * 100000, "quantity,statistic\n", '{"qerr": "0", "command": "check"}'):
        wrong = folder / "wrong.json"
        wrong.write_text(text)
        for words in (["compare", wrong, own], ["compare", old, wrong], ["check", own, "--baseline", wrong]):
            ran = run(qerr, *words)
            t.check(f"{words[0]} with {text[:30]!r} as a report: 3, one line, nothing on standard output",
                    ran.code == 3 and not ran.out and ran.err.count(b"\n") == 1, f"exit {ran.code}: {ran.err.decode()[:200]}")


def check_closed_streams(t, qerr, folder, spec):
    program, out = shlex.quote(str(qerr)), folder / "closed.json"
    for closed in (">&-", "<&-", "2>&-", "<&- >&- 2>&-"):
        out.unlink(missing_ok=True)
        code, _, err = shell(f"{program} analyze {shlex.quote(str(spec))} -o {shlex.quote(str(out))} {closed}")
        whole = out.exists() and bool(json.loads(out.read_text())["position"])
        t.check(f"-o with {closed}: 0 and a whole file", code == 0 and whole, f"exit {code}, whole: {whole}: {err.decode()[:200]}")
    code, _, err = shell(f"{program} analyze - <&-")
    t.check("a closed standard input: 4", code == 4, f"exit {code}: {err.decode()[:200]}")
    code, _, err = shell(f"ulimit -f 1; {program} analyze {shlex.quote(str(spec))} --set configurations.count=2000 "
                         f"--per-configuration {shlex.quote(str(folder / 'big.csv'))} -o /dev/null")
    left = [path.name for path in folder.iterdir() if path.name.startswith("big.csv")]
    t.check("a file beyond the limit of its size: 4, nothing left", code == 4 and not left, f"exit {code}: {left} {err.decode()[:200]}")


def check_long_work(t, qerr, folder):
    spec = folder / "own.yaml"  # of check_files_of_a_run
    for words, named in ((["analyze", spec, "--set", "configurations.count=30000000000"], "configurations.count"),
                         (["check", spec, "--set", "configurations={method: grid, count: 1000000}"], "configurations.count"),
                         (["sweep", spec, "--set", "sweep=[{key: threshold.length, from: 1, to: 2, count: 100000}, "
                           "{key: motion.sample_rate, from: 1, to: 2, count: 100000}, {key: motion.duration, values: [1, 2]}]"], "sweep"),
                         (["simulate", spec, "--set", "motion.duration=1e12"], "motion.duration"),
                         (["diagnose", spec, "--plan", "--set", "motion.duration=1e12"], "motion.duration"),
                         (["simulate", spec, "--runs", "1e8", "--set", "motion.duration=1000"], "motion.duration")):
        expect(t, f"{' '.join(map(str, words[2:]))} without --allow-long: 3", run(qerr, *words), 3, words=["--allow-long", named, "take about"])


def check_interrupt(t, qerr, folder, spec):
    long_run = folder / "long.yaml"
    long_run.write_text(spec.read_text().replace("count: 20", "count: 50000000000"))
    for number, wanted in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
        process = subprocess.Popen([str(qerr), "analyze", str(long_run), "--allow-long", "--format", "json", "-o", str(folder / "long.json")],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=os.setsid)
        time.sleep(0.5)
        early = process.poll()
        start = time.monotonic()
        process.send_signal(number)
        try:
            process.communicate(timeout=10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
        seconds = time.monotonic() - start
        code = process.returncode if process.returncode >= 0 else 128 - process.returncode
        t.check(f"{number.name}: exit code {wanted} within a second, no file left",
                early is None and code == wanted and seconds < 1 and not (folder / "long.json").exists(),
                f"ended before: {early}, exit {process.returncode}, {seconds:.2f} s")
