"""Runs qerr, and counts checks."""
import argparse
import pathlib
import resource
import subprocess


class Ran:
    """seconds: of CPU, which other work on the machine does not lengthen."""

    def __init__(self, code, out, err, seconds):
        self.code, self.out, self.err, self.seconds = code, out, err, seconds


def cpu_of_children():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run(qerr, *arguments, limit=60, **more):
    start = cpu_of_children()
    try:
        done = subprocess.run([str(qerr), *map(str, arguments)], stdin=subprocess.DEVNULL, capture_output=True,
                              timeout=limit, **more)
        return Ran(done.returncode, done.stdout, done.stderr, cpu_of_children() - start)
    except subprocess.TimeoutExpired as stopped:
        return Ran("timeout", stopped.stdout or b"", stopped.stderr or b"", limit)


def program_and_tally():
    """The program of --qerr, and a tally that prints passed checks with --verbose."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--qerr", required=True)
    parser.add_argument("--verbose", action="store_true", help="print the checks that pass, too")
    arguments = parser.parse_args()
    return pathlib.Path(arguments.qerr).resolve(), Tally(arguments.verbose)


def study_and_tally(rounds):
    """The arguments of a study with random cases (--rounds, --seed), the program of --qerr, and a tally."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--qerr", required=True)
    parser.add_argument("--rounds", type=int, default=rounds)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--verbose", action="store_true", help="print the checks that pass, too")
    arguments = parser.parse_args()
    return arguments, pathlib.Path(arguments.qerr).resolve(), Tally(arguments.verbose)


class Tally:
    def __init__(self, show_passed=True):
        self.passed = self.failed = 0
        self.show_passed = show_passed

    def check(self, name, holds, detail=""):
        if holds:
            self.passed += 1
            if self.show_passed:
                print(f"ok    {name}")
        else:
            self.failed += 1
            print(f"FAIL  {name}" + (f": {detail}" if detail else ""))
        return bool(holds)

    def close(self):
        print(f"{self.passed} passed, {self.failed} failed")
        return 1 if self.failed or not self.passed else 0


class Worst:
    """The largest deviation of many values from their expectations, as a multiple of the tolerance."""

    def __init__(self, relative=1e-9):
        self.relative, self.ratio, self.where, self.count = relative, 0.0, "", 0

    def add(self, where, found, wanted, floor=0.0):
        self.count += 1
        if isinstance(found, bool) or not isinstance(found, (int, float)):
            ratio = float("inf")
        else:
            allowed = self.relative * abs(wanted) + floor
            ratio = abs(found - wanted) / allowed if allowed > 0 else (0.0 if found == wanted else float("inf"))
        if not ratio <= self.ratio:
            self.ratio, self.where = ratio, f"{where}: found {found!r}, expected {wanted!r}"

    def holds(self):
        return self.count > 0 and self.ratio <= 1

    def detail(self):
        return f"{self.ratio:.3g} x the tolerance at {self.where}" if self.count else "nothing to compare"
