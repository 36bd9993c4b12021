#!/usr/bin/env python3
"""The help, its examples, the man pages and the completions; how wrong command lines are answered.

    check_help.py --qerr build/qerr [--verbose]

Shells and groff that are not installed are reported as skipped.
"""
import html.parser
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

import zsh_terminal
from tool import program_and_tally, run

ROOT = pathlib.Path(__file__).resolve().parents[2]
DIAGNOSIS = ROOT / "configs" / "diagnosis"


def text_of(ran):
    return ran.out.decode()


def names_under(title, page):
    """Terms of a section of a page."""
    section = re.search(rf"^{title}\n((?:  .*\n)+)", page, re.M)
    return re.findall(r"^  ([a-z]\S*)", section[1], re.M) if section else []


def check_pages(t, qerr):
    overview = text_of(run(qerr, "help"))
    commands, topics = names_under("Commands", overview), names_under("Topics", overview)
    t.check("commands and topics are listed", len(commands) >= 10 and len(topics) >= 6, overview[:200])
    t.check("--help and -h are the same page", overview == text_of(run(qerr, "--help")) == text_of(run(qerr, "-h")))
    for name in ["", *commands, *topics]:
        for columns in ("80", "120", "50"):
            ran = run(qerr, *(["help", name] if name else ["help"]), env=dict(os.environ, COLUMNS=columns))
            lines = text_of(ran).splitlines()
            code = [line for line in lines if line.startswith("  ")]
            wide = [line for line in lines if len(line) > int(columns) and (columns == "80" or line not in code)]
            t.check(f"help {name} fits {columns} columns", ran.code == 0 and lines and not wide, str(wide[:2]))
    for name in commands:
        page = text_of(run(qerr, "help", name))
        t.check(f"{name} --help is its page, with examples", page == text_of(run(qerr, name, "--help")) and "\nExamples\n" in page)
        for topic in re.findall(r"`qerr help (\S+)`", page):
            t.check(f"{name} refers to a topic: {topic}", topic in topics)
    return commands, topics


KEYWORDS = {  # words that people search for; a page that must be among those found, and a word of its excerpt
    "dh table": ("glossary", "DH"), "csv": ("output", "CSV"), "pandas": ("output", "pandas"), "noise": ("filters", "noise"),
    "repeatability": ("glossary", "ISO 9283"), "TCP": ("glossary", "tool centre point"), "ENCODER": ("encoders", "encoder"),
    "ros": ("urdf", "ROS_PACKAGE_PATH"), "iso 9283": ("glossary", "RP"), "pre-commit": ("ci", "pre-commit"),
}


def check_search(t, qerr, pages):
    for words, (page, shown) in KEYWORDS.items():
        ran = run(qerr, "help", *words.split())
        found = re.findall(r"^qerr help (\S+)$", text_of(ran), re.M)
        also = re.search(r"^Also in\n([^\n]+(?:\n[^\n]+)*)", text_of(ran), re.M)
        also = re.findall(r"[\w-]+", also[1]) if also else []
        t.check(f"help {words} finds {page}", ran.code == 0 and page in found + also and shown in text_of(ran), text_of(ran)[:300])
        t.check(f"help {words} names pages once", len(set(found + also)) == len(found + also) and set(found + also) <= pages)
        wide = [line for line in text_of(ran).splitlines() if len(line) > 80]
        t.check(f"help {words} fits 80 columns", not wide, str(wide[:2]))
    t.check("the middle of a word is not found", run(qerr, "help", "ncoder").code == 2)


def check_lists(t, qerr):
    """Every quantity of the list can be required, every unit be written."""
    rows = {kind: [row["name"] for row in json.loads(run(qerr, "list", kind, "--format", "json").out)] for kind in ("quantities", "units")}
    spec = ROOT / "configs" / "kuka_lwr" / "spec.yaml"
    examples = {"JOINT": "a1", "COORDINATE": "x", "FILTER": "velocity", "BOUND": "sigma", "FIGURE": "gain_margin", "NAME": "table"}
    names = [re.sub("|".join(examples), lambda word: examples[word[0]], name) for name in rows["quantities"]]
    controlled = {"torque", "closed_torque", "closed_position", "loop", "wall", "control"}
    groups = {n.split(".")[0] for n in names}
    t.check("quantities of positions, filters, encoders and controllers", len(names) >= 18 and groups == {"position", "velocity", "encoder"} | controlled)
    control = ["--set", "control={sample_rate: 1 kHz, joints: {JOINTS: {kp: 100 N m/rad, kd: 2 N m s/rad, velocity: velocity, "
               "inertia: 1 kg m^2, damping: 0.2 N m s/rad, friction: 0.5 N m}}}", "--set", "walls={table: {normal: [0, 0, 1]}}"]
    for name in names:
        group = name.split(".")[0]
        of = [word.replace("JOINTS", "'a*'" if group == "wall" else "a1") for word in control]  # a wall needs all joints
        more = ", statistic: max" if name.count(".") == 2 and group not in ("encoder", "loop", "wall", "control") else ""
        beside = "{quantity: torque.a1.worst_case, statistic: max, at_most: 1e9}, " if group == "control" else ""
        moving = ["--set", "motion={sample_rate: 1 kHz, duration: 1 s, joints: {a1: {velocity: 0.1 rad/s}}}"]
        ran = run(qerr, "check", "-q", spec, "--set", f"requirements=[{beside}{{quantity: {name}{more}, at_most: 1e99}}]",
                  "--set", "configurations.count=3", *moving, *(of if group in controlled else []))
        met = b"2 requirements met" if beside else b"1 requirement met"
        t.check(f"{name} can be required", ran.code == 0 and met in ran.out, (ran.out + ran.err).decode()[:300])
    t.check("units of lengths, angles and times", {"m", "deg", "arcsec", "Hz", "rpm"} <= set(rows["units"]))


class Links(html.parser.HTMLParser):
    """Targets of links, and whether every element is closed in its turn."""

    def __init__(self, text):
        super().__init__()
        self.targets, self.open, self.fault = set(), [], None
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.open.append(tag)
        self.targets |= {value for name, value in attributes if name in ("href", "src")}

    def handle_startendtag(self, tag, attributes):
        self.targets |= {value for name, value in attributes if name in ("href", "src")}

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.fault = self.fault or tag


def check_site(t, qerr, pages):
    with tempfile.TemporaryDirectory() as folder:
        ran = run(qerr, "help", "--html", pathlib.Path(folder) / "site")
        written = {path.name: path.read_text() for path in (pathlib.Path(folder) / "site").iterdir()}
        t.check("a page of the site for every page of the help", ran.code == 0 and set(written) == {f"{p}.html" for p in pages | {"index"}})
        for name, text in written.items():
            links = Links(text)
            t.check(f"{name} is well formed", not links.fault and not links.open, f"{links.fault} {links.open}")
            t.check(f"{name} refers to pages of the site only", links.targets <= set(written), str(links.targets - set(written)))
        t.check("the index leads to every page", Links(written["index.html"]).targets >= {f"{p}.html" for p in pages})
        if shutil.which("tidy"):
            for name in ("index.html", "glossary.html", "ci.html"):
                done = subprocess.run(["tidy", "-q", "-e", "-utf8"], input=written[name], capture_output=True, text=True)
                t.check(f"tidy finds nothing in {name}", done.returncode == 0, done.stderr[:300])


def examples(qerr, command):
    section = re.search(r"^Examples\n((?:  .*\n|\n)+)", text_of(run(qerr, "help", command)), re.M)
    return [line.strip() for line in section[1].splitlines() if line.strip() and not line.strip().startswith("#")]


def split_log(folder):
    """encoders.csv has the columns of encoders and references, tracker.csv those of the tip, at every second stamp."""
    rows = [line.split(",") for line in (folder / "log.csv").read_text().splitlines() if not line.startswith("#")]
    tip = [i for i, name in enumerate(rows[0]) if name.startswith("tip.")]
    joints = [i for i, name in enumerate(rows[0]) if i > 0 and i not in tip]
    for name, columns, chosen in (("encoders.csv", joints, rows), ("tracker.csv", tip, [rows[0], *rows[1::2]])):
        (folder / name).write_text("".join(",".join(row[i] for i in [0, *columns]) + "\n" for row in chosen))


def check_examples(t, qerr, commands):
    """Every example runs where arm.yaml, wrist.yaml and log.csv exist."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        (folder / "bin").mkdir()
        (folder / "bin" / "qerr").symlink_to(qerr)
        for path in DIAGNOSIS.iterdir():
            shutil.copy(path, folder)
        shutil.copy(ROOT / "configs" / "puma560" / "puma560.urdf", folder / "arm.urdf")
        spec = (folder / "spec.yaml").read_text().replace("../", f"{ROOT}/configs/")
        spec = spec if "requirements:" in spec else spec + "requirements: [{quantity: position.x.worst_case, statistic: max, at_most: 1 m}]\n"
        spec += "sweep: [{key: configurations.seed, values: [1, 2, 3, 4, 5]}]\n"
        spec += "design: {encoders: {'*': {bits: 12..16}}}\n"
        for name in ("arm.yaml", "wrist.yaml"):
            (folder / name).write_text(spec)
        environment = dict(os.environ, PATH=f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}")
        (folder / "spec.yaml").unlink()  # its robot is elsewhere
        made = run(qerr, "simulate", "arm.yaml", "--log", "log.csv", "-o", "simulated.txt", cwd=folder)
        t.check("the log of the examples", made.code == 0, made.err.decode()[:200])
        split_log(folder)
        (folder / "shards").mkdir()
        for k in range(1, 6):
            for shard in (f"{k}.csv", f"shards/{k}.csv"):
                run(qerr, "sweep", "-q", "arm.yaml", "--shard", f"{k}/5", "-o", shard, cwd=folder)
        for command in commands:
            for line in examples(qerr, command):
                if "| source" in line:
                    continue  # of fish
                # A proof within 1 % takes seconds.
                line = re.sub(r"--prove$", "--prove 5%", line)
                done = subprocess.run(["bash", "-c", line], cwd=folder, env=environment, capture_output=True, text=True, timeout=120)
                t.check(f"example: {line}", done.returncode == 0, done.stderr[:300])


def check_man_pages(t, qerr, commands, topics):
    with tempfile.TemporaryDirectory() as folder:
        ran = run(qerr, "help", "--man", folder)
        pages = {path.name: path for path in pathlib.Path(folder).glob('man[17]/*')}
        wanted = {"qerr.1", *(f"qerr-{name}.1" for name in commands), *(f"qerr-{name}.7" for name in topics)}
        t.check("a man page for every command and topic", ran.code == 0 and set(pages) == wanted, str(set(pages) ^ wanted))
        if not shutil.which("groff"):
            return print("skip  man pages: no groff", file=sys.stderr)
        done = subprocess.run(["groff", "-t", "-man", "-ww", "-Tutf8", "-P-c", *(pages[page] for page in sorted(pages))],
                              capture_output=True, text=True, env=dict(os.environ, LC_ALL="C.UTF-8"))  # a warning names its page
        t.check("man pages without a warning of groff", done.returncode == 0 and not done.stderr, done.stderr[:300])
        shown = re.split(r"^(?=\S+\([17]\) )", done.stdout, flags=re.M)[1:]  # from header to header
        t.check("each man page has text", len(shown) == len(pages) and min(map(len, shown)) > 300, f"{len(shown)} of {len(pages)}")


COMPLETIONS = [  # words, the last one to be completed; some that must be offered; some that must not
    (["qerr", "an"], {"analyze"}, {"check"}),
    (["qerr", "list", "f"], {"filters", "formats"}, {"effects"}),
    (["qerr", "list", "filters", "k"], {"kalman"}, {"backlash"}),
    (["qerr", "list", "effects", "b"], {"backlash"}, {"butterworth"}),
    (["qerr", "help", "enc"], {"encoders"}, {"analyze"}),
    (["qerr", "analyze", "--per"], {"--per-configuration"}, {"--log"}),
    (["qerr", "simulate", "arm.yaml", "--format", "j"], {"json"}, {"csv"}),
    (["qerr", "check", "--color", "n"], {"never"}, {"always"}),
    (["qerr", "sweep", "arm.yaml", "--statistics", "p"], {"p99"}, {"max"}),
    (["qerr", "analyze", "ar"], {"arm.yaml"}, {"analyze"}),
]


def completed_in_bash(script, words, folder):
    asked = "COMP_WORDS=(" + " ".join(map(shlex.quote, words)) + f"); COMP_CWORD={len(words) - 1}; _qerr; printf '%s\\n' \"${{COMPREPLY[@]}}\""
    return subprocess.run(["bash", "-c", f"source {script}; {asked}"], cwd=folder, capture_output=True, text=True)


def completed_in_fish(script, words, folder):
    return subprocess.run(["fish", "--no-config", "-c", f"source {script}; complete -C {shlex.quote(' '.join(words))}"],
                          cwd=folder, capture_output=True, text=True)


def offered_by(shell, script, words, folder):
    """The words that the shell offers; of zsh, all that its terminal shows."""
    if shell == "zsh":
        return set(re.findall(r"[\w.-]+", zsh_terminal.completed(script, " ".join(words), folder).replace(" ".join(words[:-1]), "")))
    done = (completed_in_bash if shell == "bash" else completed_in_fish)(script, words, folder)
    return {row.split("\t")[0] for row in done.stdout.splitlines()}


def check_completions(t, qerr):
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        (folder / "arm.yaml").touch()
        for shell in ("bash", "fish", "zsh"):
            if not shutil.which(shell):
                print(f"skip  completion of {shell}: not installed", file=sys.stderr)
                continue
            script = folder / f"complete.{shell}"
            script.write_bytes(run(qerr, "completion", shell).out)
            for words, wanted, unwanted in COMPLETIONS:
                offered = offered_by(shell, script, words, folder)
                t.check(f"{shell} completes {' '.join(words)}", wanted <= offered and not unwanted & offered, str(offered)[:300])


MISTAKES = [  # words; what the message must name
    ([], ["command", "qerr help"]),
    (["analyse", "arm.yaml"], ["analyse", "qerr analyze"]),
    (["arm.yaml"], ["arm.yaml", "qerr analyze arm.yaml"]),
    (["analyze"], ["SPEC", "e.g. qerr analyze"]),
    (["analyze", "a.yaml", "b.yaml"], ["b.yaml", "qerr analyze [OPTION...] SPEC"]),
    (["analyze", "a.yaml", "encoders.a2.bits=19"], ["--set 'encoders.a2.bits=19'"]),
    (["analyze", "a.yaml", "--sed", "3"], ["--sed", "did you mean '--set'"]),
    (["analyze", "a.yaml", "-x"], ["-x", "qerr help analyze"]),
    (["analyze", "a.yaml", "--seed"], ["--seed", "--seed N"]),
    (["analyze", "a.yaml", "--seed", "--quiet"], ["--seed", "'--quiet'", "--seed N"]),
    (["analyze", "a.yaml", "--seed", "1", "--seed", "2"], ["--seed", "once", "'1'"]),
    (["analyze", "a.yaml", "--threads", "two"], ["--threads", "whole number from 1 to 1024", "'two'"]),
    (["analyze", "a.yaml", "--quiet=yes"], ["--quiet", "'yes'"]),
    (["analyze", "a.yaml", "--format", "jsn"], ["--format", "'jsn'", "did you mean 'json'"]),
    (["analyze", "a.yaml", "--color", "no"], ["--color", "'no'", "never"]),
    (["filter", "a.yaml", "--motion-band", "3Hz"], ["--motion-band", "FROM TO"]),
    (["filter", "a.yaml", "--clock", "1MHz"], ["--clock", "--estimators"]),
    (["compare", "a.yaml"], ["B", "the other report or spec", "e.g. qerr compare"]),
    (["compare", "-", "-"], ["standard input"]),
    (["sweep"], ["SPEC", "e.g. qerr sweep"]),
    (["sweep", "a.yaml", "--shard", "0/3"], ["--shard", "K/N", "'0/3'", "2/5"]),
    (["sweep", "a.yaml", "--statistics", "max,p98"], ["--statistics", "'p98'", "did you mean"]),
    (["sweep", "a.yaml", "--resume"], ["--resume", "-o FILE.csv"]),
    (["sweep", "a.yaml", "--wide", "--format", "json"], ["--wide", "CSV"]),
    (["merge"], ["FILE", "e.g. qerr merge"]),
    (["merge", "-", "-"], ["standard input"]),
    (["check", "a.yaml", "--tolerance", "2%"], ["--tolerance", "--baseline"]),
    (["check", "a.yaml", "--baseline", "b.json", "--tolerance", "2 mm"], ["--tolerance", "'2 mm'", "2%"]),
    (["analyze", "a.yaml", "--prove", "2 mm"], ["--prove", "'2 mm'", "0.5%"]),
    (["analyze", "--prove=0", "a.yaml"], ["--prove", "'0'", "0.001%"]),
    (["check", "a.yaml", "--prove", "1%", "--prove"], ["--prove", "once", "'1%'"]),
    (["list"], ["KIND", "e.g. qerr list"]),
    (["list", "filtrs"], ["'filtrs'", "did you mean 'filters'"]),
    (["list", "filters", "kalmn"], ["'kalmn'", "did you mean 'kalman'"]),
    (["help", "encoderz"], ["'encoderz'", "did you mean 'encoders'"]),
    (["help", "nonsuch"], ["'nonsuch'", "analyze", "choice", "variants"]),  # the list is not cut
    (["schema", "--output-of", "analyse"], ["--output-of", "did you mean 'analyze'"]),
    (["--seed", "3", "analyze", "a.yaml"], ["--seed", "behind a command"]),
    # What CLI11 alone would take for a value, or for none.
    (["analyze", "--seed=", "a.yaml"], ["--seed: the value is missing"]),
    (["analyze", "a.yaml", "-o", ""], ["--output: the value is missing", "''"]),
    (["analyze", "a.yaml", "-qo", "--", "b.yaml"], ["--output: the value is missing", "'--'"]),
    (["analyze", "a.yaml", "--quiet=true"], ["--quiet: takes no value", "'true'"]),
    (["filter", "a.yaml", "--motion-band", "3Hz", "-q"], ["--motion-band: the second value is missing", "'-q'"]),
    (["analyze", "a.yaml", "-5"], ["-5: unknown option"]),
    (["analyze", "a.yaml", "-qx"], ["-x: unknown option"]),
    (["analyze", "a.yaml", "--fromat=json"], ["--fromat: unknown option", "did you mean '--format'"]),
    (["list", "filters", "[kalman,bessel]"], ["'[kalman,bessel]'"]),
]


def check_words(t, qerr):
    """Words that an option takes as its value, and files named like options and commands."""
    spec = "qerr: 1\nrobot: {urdf: %s}\nencoders: {'*': {bits: 12}}\nconfigurations: {count: 5}\n" % (
        ROOT / "configs" / "kuka_lwr" / "kuka_lwr.urdf")
    with tempfile.TemporaryDirectory() as folder:
        for name in ("analyze", "-x", "--seed", "[a,b].yaml", "--"):
            (pathlib.Path(folder) / name).write_text(spec)
        for words in (["analyze"], ["--", "-x"], ["--", "--seed"], ["--", "--"], ["[a,b].yaml"], ["-", "--set", "encoders.*.bits=13"],
                      ["-qo-", "analyze"], ["--output=-", "analyze"], ["analyze", "-qo", "-", "--seed=3"]):
            ran = subprocess.run([qerr, "analyze", *words], cwd=folder, input=spec.encode(), capture_output=True)
            t.check(f"qerr analyze {' '.join(words)} runs", ran.returncode == 0 and b"kuka_lwr" in ran.stdout, ran.stderr.decode())



def check_mistakes(t, qerr):
    for words, named in MISTAKES:
        ran = run(qerr, *words)
        message = ran.err.decode()
        missing = [name for name in named if name not in message]
        t.check(f"qerr {' '.join(words)}: 2, one line that helps", ran.code == 2 and not ran.out and message.count("\n") == 1 and not missing,
                f"exit {ran.code}, lacks {missing}: {message}")


def check_globals(t, qerr):
    for words in (["-V"], ["--version"], ["analyze", "-V"]):
        t.check(f"qerr {' '.join(words)}", re.fullmatch(r"qerr \d+\.\d+\.\d+\n", text_of(run(qerr, *words))))
    spec = ROOT / "configs" / "phantom_premium" / "spec.yaml"
    for words, coloured in ((["--color", "always", "analyze", spec], True), (["analyze", spec, "--color=always"], True),
                            (["analyze", spec], False), (["--color", "never", "analyze", spec], False),
                            (["analyze", spec, "--color=always", "--no-color"], False), (["help", "--color", "always"], True)):
        ran = run(qerr, *words, *(["-q"] if "help" not in words else []), env={**os.environ, "NO_COLOR": "1"})
        t.check(f"colours of {' '.join(map(str, words[:3]))}", ran.code == 0 and (b"\x1b[" in ran.out) == coloured)
    for words in (["--prove", spec], [spec, "--prove"], ["--prove", "5%", spec], ["--prove=0.05", spec], [spec, "--prove", "-q"]):
        ran = run(qerr, "analyze", *words, "-q", "--format", "json", "--set", "configurations.count=100")
        gap = json.loads(ran.out)["position"][0]["sigma"]["proven"]["gap"] if ran.code == 0 else 1
        t.check(f"qerr analyze {' '.join(str(w) for w in words if w != spec)}: a value may follow --prove", gap <= 0.05, ran.err.decode()[:200])
    one = json.loads(run(qerr, "list", "filters", "kalman", "--format", "json").out)
    t.check("list filters kalman: one row", [row["name"] for row in one] == ["kalman"])
    for words in (["help"], ["list", "filters"], ["completion", "bash"], ["schema"]):
        done = subprocess.run(["bash", "-c", f"{shlex.quote(str(qerr))} {' '.join(words)} | head -1"], capture_output=True, text=True)
        t.check(f"{' '.join(words)} | head -1 ends quietly", done.stdout and not done.stderr, done.stderr)


def main():
    qerr, t = program_and_tally()
    commands, topics = check_pages(t, qerr)
    check_search(t, qerr, {*commands, *topics})
    check_lists(t, qerr)
    check_site(t, qerr, {*commands, *topics})
    check_examples(t, qerr, commands)
    check_man_pages(t, qerr, commands, topics)
    check_completions(t, qerr)
    check_mistakes(t, qerr)
    check_words(t, qerr)
    check_globals(t, qerr)
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
