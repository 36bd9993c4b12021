#!/usr/bin/env python3
"""Commands that compute, under valgrind: no read or write outside what is allocated, none of what was never set.

    check_memory.py --qerr build/qerr [--verbose]

Skipped (exit code 77) without valgrind. scripts/sanitize.sh runs all tests, with more kinds of errors; this is the part of it
that needs no build of its own.
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile

from check_faults import Bench, commands
from tool import program_and_tally

FOUND = 99  # exit code of a run with errors
OF_OTHERS = ("check", "compare", "threshold", "schema")  # compute what analyze and filter compute, or nothing


def main():
    qerr, t = program_and_tally()
    valgrind = shutil.which("valgrind")
    if not valgrind:
        print("skipped: no valgrind")
        return 77
    with tempfile.TemporaryDirectory() as temporary:
        bench = Bench(qerr, None, pathlib.Path(temporary))
        log, spec = bench.folder / "log.csv", bench.folder / "s.yaml"  # less of both: valgrind is some forty times slower
        log.write_text("".join(log.read_text().splitlines(keepends=True)[:150]))
        spec.write_text(spec.read_text().replace("count: 3000", "count: 20").replace("duration: 0.5 s", "duration: 0.1 s"))
        for command, outputs in commands():
            if command[0] in OF_OTHERS:
                continue
            words = bench.words(command, outputs)
            ran = subprocess.run([valgrind, "--quiet", f"--error-exitcode={FOUND}", *words], cwd=bench.folder, capture_output=True, timeout=300)
            t.check(f"valgrind {' '.join(command)}", ran.returncode == 0, f"exit {ran.returncode}: {ran.stderr.decode()[:2000]}")
        (bench.folder / "s.yaml").write_text("qerr: 1\nrobot: {urdf: arm.urdf, tip: [}\n")
        ran = subprocess.run([valgrind, "--quiet", f"--error-exitcode={FOUND}", str(qerr), "analyze", "s.yaml"], cwd=bench.folder,
                             capture_output=True, timeout=300)
        t.check("valgrind, a spec that is refused", ran.returncode == 3, f"exit {ran.returncode}: {ran.stderr.decode()[:2000]}")
    return t.close()


if __name__ == "__main__":
    sys.exit(main())
