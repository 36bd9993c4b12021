#!/usr/bin/env python3
"""What qerr shows on a terminal: lines that fit 80 columns, and the progress of long work.

    check_terminal.py --qerr build/qerr [--verbose]
"""
import fcntl
import os
import pathlib
import pty
import re
import struct
import sys
import tempfile
import termios

from tool import program_and_tally, run

ROOT = pathlib.Path(__file__).resolve().parents[2]
CONFIGS = ROOT / "configs"
CODES = re.compile(r"\x1b\[[0-9;]*[mK]")


def on_terminal(qerr, words, columns, stop_at=None):
    """Everything that is written to a terminal of so many columns, standard error included; and the exit code.

    stop_at: a text at which Ctrl-C is typed.
    """
    process, terminal = pty.fork()
    if process == 0:
        fcntl.ioctl(1, termios.TIOCSWINSZ, struct.pack("HHHH", 50, columns, 0, 0))
        os.environ.pop("COLUMNS", None)
        os.environ["TERM"] = "xterm"
        os.execv(str(qerr), ["qerr", *map(str, words)])
    read = b""
    while True:
        try:
            part = os.read(terminal, 65536)
        except OSError:
            break
        if not part:
            break
        read += part
        if stop_at and stop_at in read:
            os.write(terminal, b"\x03")
            stop_at = None
    os.close(terminal)
    return read.decode(), os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])


def shown_lines(text):
    """Lines as they stand on the screen at some time: a carriage return starts one anew."""
    return [CODES.sub("", line) for line in re.split(r"[\r\n]+", text)]


def commands():
    specs = sorted(CONFIGS.glob("*/*.yaml"))
    for kind in ("effects", "filters", "encoders", "formats", "coordinates", "statistics"):
        yield ["list", kind]
    yield ["threshold", *sorted((CONFIGS / "table_iv").glob("*.yaml"))]
    for urdf in sorted(CONFIGS.glob("*/*.urdf")):
        yield ["robot", urdf]
    reports = [spec for spec in specs if "filters:" in spec.read_text()]
    for one, other in list(zip(reports, reports[1:]))[::2]:
        yield ["compare", one, other]
        yield ["compare", one, other, "--details"]
    for spec in specs:
        yield ["analyze", spec]
        yield ["analyze", spec, "--details"]
        if "sweep:" in spec.read_text():
            yield ["sweep", spec, *(["--set", "motion.duration=0.4"] if "motion:" in spec.read_text() else [])]
        for key, words in (("requirements:", ["check"]), ("motion:", ["simulate"]), ("motion:", ["diagnose", "--plan"])):
            if re.search(rf"^{key}", spec.read_text(), re.M):
                yield [*words, spec]
        if "filters:" in spec.read_text():
            yield ["filter", spec]
            yield ["filter", spec, "--at", "1", "--motion-band", "0.1Hz", "1Hz", "--coefficients", "--noise", "--speed", "0.3", "--estimators"]


def check_widths(t, qerr):
    for columns, every in ((80, 1), (120, 6)):
        for words in list(commands())[::every]:
            text, code = on_terminal(qerr, words, columns)
            wide = [line for line in shown_lines(text) if len(line) > columns]
            title = " ".join(pathlib.Path(str(w)).name for w in words)[:70]
            t.check(f"{title} fits {columns} columns", code == 0 and not wide, f"exit {code}, {len(wide)} wide: {wide[:2]}")


def check_progress(t, qerr):
    with tempfile.TemporaryDirectory() as folder:
        log, spec = pathlib.Path(folder) / "log.csv", CONFIGS / "diagnosis" / "spec.yaml"
        few = ["--set", "filters={}", "--set", "motion.duration=450"]
        made = run(qerr, "simulate", spec, *few, "--log", log, "-o", "/dev/null")
        t.check("the log of the progress", made.code == 0, made.err.decode()[:200])
        with open(log, "a", encoding="utf-8") as file:  # what ends after reading, as that is what has a progress
            file.write("nothing\n")
        arm = CONFIGS / "kuka_lwr" / "spec.yaml"
        # One thread: the time until there is something to show does not depend on the number of cores.
        one = ["--threads", "1"]
        for noun, words, wanted in (("configurations", ["analyze", arm, *one, "--set", "configurations.count=12000000"], 0),
                            ("variants", ["sweep", arm, *one, "--set", "sweep=[{key: configurations.seed, from: 1, to: 400, count: 400}]"], 0),
                            ("samples", ["simulate", spec, *one, "--runs", "1500"], 0), ("bytes", ["diagnose", spec, log], 3)):
            text, code = on_terminal(qerr, words, 80)
            steps = re.findall(rf"\r(\d+) % of [\d.]+ [kMG]? ?{noun}, [\d.]+ [kMG]?/s, [\dhdaysmin ]+ left\x1b\[K", text)
            quick = "left" not in text  # a machine that is done within the first moment
            t.check(f"{words[0]} shows how much of its {noun} is done", code == wanted and (steps or (quick and noun == "bytes")), text[:300])
            t.check(f"{words[0]}: the progress rises, and is removed", steps == sorted(steps, key=int) and (quick or "\r\x1b[K" in text), str(steps))
            if noun == "configurations":
                quiet, _ = on_terminal(qerr, [*words, "--quiet"], 80)
                t.check(f"{words[0]} --quiet shows none", "left" not in quiet)


def check_interrupt(t, qerr):
    """Ctrl-C says in a line of its own how to go on, and the prompt that follows begins a line."""
    spec = CONFIGS / "scara" / "spec.yaml"
    with tempfile.TemporaryDirectory() as folder:
        slow = "configurations.count=2000000000"
        rows, choice = pathlib.Path(folder, "rows.csv"), pathlib.Path(folder, "choice.yaml")
        choice.write_text(f"qerr: 1\nrobot: {{urdf: {CONFIGS}/kuka_lwr/kuka_lwr.urdf}}\nencoders: {{'*': {{bits: 17}}}}\n"
                          "configurations: {count: 50000}\nrequirements:\n"
                          "  - {quantity: position.xyz.worst_case, statistic: max, at_most: 0.05 mm}\n"
                          "  - {quantity: position.rxyz.sigma, statistic: p95, at_most: 0.02 mrad}\n"
                          "design: {encoders: {'*': {bits: 8..25}}}\n")
        for words, wanted in ((["design", choice], "--only-optimum"),
                              (["analyze", spec, "--set", slow, "--allow-long"], "unfinished files are removed"),
                              (["sweep", spec, "-o", rows, "--set", "sweep=[{key: configurations.seed, from: 1, to: 90000, count: 90000}]"],
                               "--resume goes on")):
            text, code = on_terminal(qerr, [*words, "--threads", "1"], 80, stop_at=b" % of ")  # of the configurations, of a search's work
            last = shown_lines(text.replace("^C", ""))[-2:]
            t.check(f"{words[0]}: Ctrl-C", code == 130 and text.endswith("\n") and wanted in "".join(last), text[-300:])


def main():
    qerr, t = program_and_tally()
    check_widths(t, qerr)
    check_progress(t, qerr)
    check_interrupt(t, qerr)
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
