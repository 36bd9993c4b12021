#!/usr/bin/env python3
"""Faults of the system, injected one by one, and signals: every output is then the old one or a whole new one.

    check_faults.py --qerr build/qerr --preload build/tests/libqerr_faults.so [--calls 60] [--memory 40] [--kills 60] [--verbose]
"""
import argparse
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from cases import CORPUS
from tool import Tally

SPEC = f"""qerr: 1
robot: {{urdf: {CORPUS / 'two_joints.urdf'}}}
encoders: {{'*': {{counts_per_rev: 4096, gear_ratio: 50}}}}
configurations: {{count: 3000}}
filters: {{v: {{derivative: 1, sample_rate: 1 kHz, lowpass: {{family: first_order, order: 2, cutoff: 50 Hz}}}}}}
requirements: [{{quantity: position.x.sigma, statistic: max, at_most: 1 m}}]
motion: {{sample_rate: 1 kHz, duration: 0.5 s, joints: {{JOINT: {{sines: [{{amplitude: 0.3, frequency: 2 Hz}}]}}}}}}
sweep: [{{key: 'encoders.*.counts_per_rev', values: [1000, 2000, 3000]}}]
design: {{encoders: {{'*': {{bits: 12..14}}}}}}
"""
OLD = b"old\n"
CALLS = ("write", "read", "open", "close", "fsync", "rename", "link", "ftruncate", "lseek", "mmap")
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGXCPU, signal.SIGUSR1, signal.SIGALRM)


def commands():
    """Words of a command, and its outputs."""
    yield ["analyze", "s.yaml", "--threads", "2"], {"-o": "o.json", "--per-configuration": "p.csv"}
    yield ["filter", "s.yaml"], {"-o": "o.json", "--response": "r.csv", "--impulse": "i.csv", "--transient": "t.csv"}
    yield ["check", "s.yaml"], {"-o": "o.json", "--junit": "j.xml"}
    yield ["simulate", "s.yaml", "--threads", "2"], {"-o": "o.json", "--log": "l.csv"}
    yield ["diagnose", "s.yaml", "log.csv", "--force", "--threads", "2"], {"-o": "o.json", "--write-model": "m.yaml"}
    yield ["sweep", "s.yaml", "--threads", "2"], {"-o": "o.csv"}
    yield ["merge", "k1.csv", "k2.csv"], {"-o": "o.csv"}
    yield ["design", "s.yaml", "--force"], {"-o": "o.json", "--write-spec": "w.yaml"}
    yield ["threshold", "s.yaml"], {"-o": "o.csv"}
    yield ["compare", "s.yaml", "other.yaml"], {"-o": "o.json"}
    yield ["robot", "arm.urdf", "--force"], {"-o": "o.json", "--write-spec": "w.yaml"}
    yield ["schema"], {"-o": "o.json"}


class Bench:
    """A folder with inputs, in which commands run with and without a fault."""

    def __init__(self, qerr, preload, folder):
        self.qerr, self.preload, self.folder = qerr, preload, folder
        joint = "joint"
        for line in (CORPUS / "two_joints.urdf").read_text().split("<joint name=")[1:2]:
            joint = line[1:].split(line[0])[0]
        (folder / "s.yaml").write_text(SPEC.replace("JOINT", joint))
        (folder / "other.yaml").write_text(SPEC.replace("JOINT", joint).replace("4096", "2000"))
        (folder / "arm.urdf").write_bytes((CORPUS / "two_joints.urdf").read_bytes())
        for words in (["simulate", "s.yaml", "--log", "log.csv", "-o", "sim.json"], ["sweep", "s.yaml", "--shard", "1/2", "-o", "k1.csv"],
                      ["sweep", "s.yaml", "--shard", "2/2", "-o", "k2.csv"]):
            subprocess.run([str(qerr), *words, "-q"], cwd=folder, check=True)
        self.inputs = {path.name for path in folder.iterdir()}

    def words(self, command, outputs):
        return [str(self.qerr), *command, "-q", *(word for pair in outputs.items() for word in pair)]

    def fill(self, outputs):
        for name in outputs.values():
            (self.folder / name).write_bytes(OLD)

    def run(self, command, outputs, quiet=True, **variables):
        self.fill(outputs)
        words = [w for w in self.words(command, outputs) if quiet or w != "-q"]
        return subprocess.run(words, cwd=self.folder, env=dict(os.environ, LD_PRELOAD=str(self.preload), **variables),
                              stdin=subprocess.DEVNULL, capture_output=True, timeout=60)

    def read(self, outputs):
        """The contents of the outputs, without times of day."""
        contents = {}
        for name in outputs.values():
            path = self.folder / name
            contents[name] = re.sub(rb'time(stamp)?="[^"]*"', b"", path.read_bytes()) if path.exists() else None
        return contents

    def clear(self, outputs):
        for name in outputs.values():
            (self.folder / name).unlink(missing_ok=True)

    def left(self, outputs):
        return {path.name for path in self.folder.iterdir()} - self.inputs - set(outputs.values())

    def problem(self, command, outputs, whole):
        """What is wrong with the files after a run that did not end well."""
        torn = [name for name, data in self.read(outputs).items() if data not in (OLD, whole[name])
                # The table of a sweep grows under its own name, so that it can be continued.
                and not (command[0] == "sweep" and data is not None and whole[name].startswith(data))]
        left = self.left(outputs)
        for name in left:
            (self.folder / name).unlink()
        return (f"torn: {torn} " if torn else "") + (f"left: {left}" if left else "")


def check_calls(t, bench, command, outputs, whole, counts, every):
    for call in CALLS:
        last = counts[call]
        # The first calls read inputs, the last ones write outputs.
        at = range(1, last + 1) if last < every else sorted({1, 2, last // 2, last - 1, last})
        faults = [f"{call}:{n}" for n in at]
        for fault in [*faults, f"{call}:1+", f"{call}:2+:28"]:
            ran = bench.run(command, outputs, FAULT=fault)
            problem = bench.problem(command, outputs, whole)
            if ran.returncode not in (0, 4):
                problem += f" exit code {ran.returncode}"
            if ran.returncode == 4 and not ran.stderr.strip():
                problem += " no message"
            if ran.returncode == 0 and bench.read(outputs) != whole:
                problem += " exit code 0 without the results"
            t.check(f"{command[0]}, fault {fault}: 4 with a message, or done", not problem, f"{problem} {ran.stderr.decode()[:200]}")


def check_memory(t, bench, command, outputs, whole, count, samples, draw):
    at = sorted({1, 2, 3, count, *(draw.randint(1, count) for _ in range(samples))})
    for fault in [f"malloc:{n}" for n in at] + [f"malloc:{n}+" for n in at[::2]]:
        ran = bench.run(command, outputs, FAULT=fault)
        problem = bench.problem(command, outputs, whole)
        if ran.returncode not in (0, 4, 5):
            problem += f" exit code {ran.returncode}"
        if ran.returncode != 0 and not ran.stderr.strip():
            problem += " no message"
        if ran.returncode == 0 and bench.read(outputs) != whole:
            problem += " exit code 0 without the results"
        t.check(f"{command[0]}, fault {fault}: 4 or 5 with a message, or done", not problem, f"{problem} {ran.stderr.decode()[:200]}")


def check_threads(t, bench, command, outputs, whole):
    ran = bench.run([*command[:-1], "4"], outputs, quiet=False, FAULT="thread:1+")
    done = ran.returncode == 0 and bench.read(outputs) == whole
    t.check(f"{command[0]} without a second thread: the same result", done, f"exit {ran.returncode} {ran.stderr.decode()[:200]}")
    return b"fewer threads" in ran.stderr


def check_signals(t, bench, command, outputs, whole, number, delay):
    """A signal after a while: the old files or whole ones, the code of the signal at once, and nothing left."""
    bench.fill(outputs)
    process = subprocess.Popen(bench.words(command, outputs), cwd=bench.folder, stdin=subprocess.DEVNULL,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(delay)
    start = time.monotonic()
    process.send_signal(number)
    code = process.wait(timeout=10)
    seconds = time.monotonic() - start
    killed = number == signal.SIGKILL
    left = bench.left(outputs)
    if killed:  # between two system calls a whole file may have its random name only; it hinders no one
        for name in [n for n in left if n.startswith(".qerr.")]:
            (bench.folder / name).unlink()
    problem = bench.problem(command, outputs, whole)
    # Before main the system's action holds: the process ends by the signal itself.
    if code not in (0, -number) if killed else code not in (0, 128 + number, -number):
        problem += f" exit code {code}"
    if seconds > 0.2 and not killed:
        problem += f" {seconds:.2f} s"
    t.check(f"{command[0]}, {number.name} after {delay * 1000:.1f} ms", not problem, problem)


def check_full_disk(t, bench):
    """A file system of 64 KB, where a process may mount one: containers mostly forbid it. Only `unshare` and `mount` can make
    the script fail."""
    script = (f"mount -t tmpfs -o size=64k none {bench.folder}/small || exit 1; cd {bench.folder}; {bench.qerr} analyze s.yaml -q "
              "--per-configuration small/p.csv -o small/o.json; echo $? $(ls -A small)")
    (bench.folder / "small").mkdir()
    ran = subprocess.run(["unshare", "-rm", "sh", "-c", script], capture_output=True, text=True, timeout=60) \
        if shutil.which("unshare") else None
    (bench.folder / "small").rmdir()
    if ran is None or ran.returncode != 0:
        print("skip  a full disk: this machine forbids mounting one" + (f" ({ran.stderr.strip()})" if ran else ": no unshare"))
        return
    t.check("a full disk: 4, nothing left", ran.stdout.split() == ["4"], ran.stdout + ran.stderr)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--qerr", required=True)
    parser.add_argument("--preload", required=True, help="the library of tests/faults/preload.c")
    parser.add_argument("--calls", type=int, default=60, help="a system call that a command makes less often fails at each of its places")
    parser.add_argument("--memory", type=int, default=12, help="allocations that fail, for each command")
    parser.add_argument("--kills", type=int, default=6, help="kill -9 at random moments, for each command")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--verbose", action="store_true")
    arguments = parser.parse_args()
    t, draw = Tally(arguments.verbose), random.Random(arguments.seed)
    with tempfile.TemporaryDirectory() as temporary:
        bench = Bench(pathlib.Path(arguments.qerr).resolve(), pathlib.Path(arguments.preload).resolve(), pathlib.Path(temporary))
        warned = 0
        for command, outputs in commands():
            counted = bench.folder / "counts"
            bench.inputs.add("counts")
            start = time.monotonic()
            ran = bench.run(command, outputs, FAULT_COUNTS=str(counted))
            seconds = time.monotonic() - start
            whole = bench.read(outputs)
            written = ran.returncode == 0 and all(data not in (OLD, None) for data in whole.values())
            if not t.check(f"{command[0]} without a fault", written, ran.stderr.decode()[:300]):
                continue
            counts = {name: int(count) for name, count in (line.split() for line in counted.read_text().splitlines())}
            check_calls(t, bench, command, outputs, whole, counts, arguments.calls)
            check_memory(t, bench, command, outputs, whole, counts["malloc"], arguments.memory, draw)
            if "--threads" in command:
                warned += check_threads(t, bench, command, outputs, whole)
            for number in SIGNALS:
                check_signals(t, bench, command, outputs, whole, number, draw.uniform(0.2, 1) * seconds)
            for _ in range(arguments.kills):
                check_signals(t, bench, command, outputs, whole, signal.SIGKILL, draw.uniform(0.2, 1) * seconds)
            ran = bench.run(command, outputs)
            t.check(f"{command[0]} after all that", ran.returncode == 0 and bench.read(outputs) == whole, ran.stderr.decode()[:200])
            bench.clear(outputs)
        t.check("fewer threads than asked for are a warning", warned > 0)
        check_full_disk(t, bench)
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
