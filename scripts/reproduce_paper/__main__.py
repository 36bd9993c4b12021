"""Reproduces the paper's tables and figures with qerr, and checks its claims. See scripts/reproduce_paper.sh.

    python3 scripts/reproduce_paper [OUT]          everything, into OUT (default: build/paper)
    python3 scripts/reproduce_paper --check        compare configs/paper/README.md with new results
    python3 scripts/reproduce_paper --write-page   write new results into that page
"""
import argparse
import importlib
import pathlib
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import page  # noqa: E402
from tool import ROOT, Output, Qerr, write_csv  # noqa: E402

# In the order of the paper; --quick omits the long simulations.
QUICK = [
    "tables",
    "velocity_ellipses",
    "linear_bound",
    "cutoffs",
    "sample_rates",
    "estimators",
    "quantized_sine",
    "whiteness",
]
SLOW = ["position_error", "derivative_error", "time_domain"]


def main():
    parser = argparse.ArgumentParser(
        description="Reproduces the paper's tables and figures, and checks its claims."
    )
    parser.add_argument(
        "out", nargs="?", default=str(ROOT / "build" / "paper"), help="folder for CSV and plots"
    )
    parser.add_argument("--qerr", default=str(ROOT / "build" / "qerr"), help="the program")
    parser.add_argument("--quick", action="store_true", help="without long simulations")
    action = parser.add_mutually_exclusive_group()
    action.add_argument(
        "--check", action="store_true", help="compare configs/paper/README.md with new results"
    )
    action.add_argument("--write-page", action="store_true", help="write new results into that page")
    arguments = parser.parse_args()
    if arguments.write_page and arguments.quick:
        parser.error("--write-page needs all claims; leave out --quick")

    with tempfile.TemporaryDirectory() as scratch:
        out = Output(scratch if arguments.check else arguments.out, draws=not arguments.check)
        claims = []
        for name in QUICK + ([] if arguments.quick else SLOW):
            start = time.monotonic()
            part = importlib.import_module(name)
            found = part.make(Qerr(arguments.qerr), out)
            claims += found
            print(f"{name}: {len(found)} claims, {time.monotonic() - start:.1f} s", file=sys.stderr)
        write_csv(out / "claims.csv", page.COLUMNS, [page.cells(claim) for claim in claims])
    if arguments.write_page:
        page.write(claims)
    if arguments.check:
        sys.exit(page.check(claims, complete=not arguments.quick))
    print(f"{len(claims)} claims, figures and tables in {arguments.out}", file=sys.stderr)


if __name__ == "__main__":
    main()
