"""Reproduces the paper's tables and figures with qerr, and checks its claims. See scripts/reproduce_paper.sh.

    python3 scripts/reproduce_paper [OUT]          everything, into OUT (default: build/paper)
    python3 scripts/reproduce_paper --row N        row N of configs/paper/README.md, and the qerr commands behind it
    python3 scripts/reproduce_paper --check        compare the tables of that page with new results, digit by digit
    python3 scripts/reproduce_paper --write-page   write new results into that page
"""
import argparse
import concurrent.futures
import importlib
import os
import pathlib
import shutil
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import page  # noqa: E402
from tool import ROOT, Output, Qerr, write_csv  # noqa: E402

# Module, function and the number of its claims, in the order of the page. New ones at the end: rows keep their numbers.
PARTS = [
    ("tables", "table_2", 2),
    ("tables", "table_3", 2),
    ("tables", "table_4", 3),
    ("velocity_ellipses", "make", 4),
    ("linear_bound", "vertices", 1),
    ("linear_bound", "intervals", 1),
    ("cutoffs", "figure_7", 1),
    ("cutoffs", "figure_8", 2),
    ("sample_rates", "figure_9", 1),
    ("sample_rates", "figure_10", 1),
    ("estimators", "make", 4),
    ("quantized_sine", "envelopes", 2),
    ("quantized_sine", "output_variance", 1),
    ("whiteness", "whiteness", 1),
    ("whiteness", "speed_of_the_experiment", 1),
    ("whiteness", "constant_speed", 1),
    ("position_error", "make", 3),
    ("derivative_error", "make", 4),
    ("time_domain", "record", 1),
    ("time_domain", "independence", 1),
    ("time_domain", "worst_over_sigma", 1),
    ("acceleration", "make", 3),
    ("discussion", "robots", 1),
    ("discussion", "low_rate", 1),
    ("discussion", "slow", 1),
    ("discussion", "nothing_to_say", 1),
    ("discussion", "structures", 1),
    ("discussion", "dither", 1),
    ("assumptions", "quantized_truth", 1),
    ("assumptions", "ripples", 1),
]
SHOWN = 3  # commands that --row prints, of many that differ in a value


def program():
    """The program that was built here, else that of PATH."""
    built = ROOT / "build" / "qerr"
    return str(built) if built.exists() else shutil.which("qerr") or sys.exit("reproduce_paper: no qerr; see --qerr")


def make(module, function, count, path, folder, draws):
    """The claims of one part, and the commands that it ran."""
    qerr = Qerr(path)
    found = getattr(importlib.import_module(module), function)(qerr, Output(folder, draws))
    claims = found if isinstance(found, list) else [found]
    if len(claims) != count:
        sys.exit(f"reproduce_paper: {module}.{function} has {len(claims)} claims; please correct PARTS")
    return claims, qerr.ran


def show_row(number, path):
    """Prints one row and what was run for it."""
    left = number
    for part in PARTS:
        if 1 <= left <= part[2]:
            break
        left -= part[2]
    else:
        sys.exit(f"reproduce_paper: the page has rows 1 to {sum(part[2] for part in PARTS)}")
    with tempfile.TemporaryDirectory() as scratch:
        claims, ran = make(*part, path, scratch, draws=False)
    print(page.text(number, claims[left - 1]))
    print(f"Computed by {part[1]}() of scripts/reproduce_paper/{part[0]}.py from, in the project's root:")
    print("\n".join(f"  {command}" for command in ran[:SHOWN]))
    if len(ran) > SHOWN:
        print(f"  and {len(ran) - SHOWN} more with other values")


def main():
    parser = argparse.ArgumentParser(
        description="Reproduces the paper's tables and figures, and checks its claims."
    )
    parser.add_argument(
        "out", nargs="?", default=str(ROOT / "build" / "paper"), help="folder for CSV and plots"
    )
    parser.add_argument("--qerr", help="the program (default: build/qerr, else that of PATH)")
    parser.add_argument("--page", default=str(page.PAGE), help="the page (default: configs/paper/README.md)")
    action = parser.add_mutually_exclusive_group()
    action.add_argument("--row", type=int, metavar="N", help="print row N of the page and its commands")
    action.add_argument("--check", action="store_true", help="compare the page with new results")
    action.add_argument("--write-page", action="store_true", help="write new results into the page")
    arguments = parser.parse_args()
    path = arguments.qerr or program()
    if arguments.row is not None:
        return show_row(arguments.row, path)

    draws = not (arguments.check or arguments.write_page)
    with tempfile.TemporaryDirectory() as scratch, concurrent.futures.ProcessPoolExecutor(os.cpu_count()) as pool:
        folder = arguments.out if draws else scratch
        parts = [pool.submit(make, *part, path, folder, draws) for part in PARTS]
        claims = [claim for part in parts for claim in part.result()[0]]
        write_csv(Output(folder, draws) / "claims.csv", page.COLUMNS, [page.cells(claim) for claim in claims])
    target = pathlib.Path(arguments.page)
    if arguments.write_page:
        page.write(target, claims)
    if arguments.check:
        sys.exit(page.check(target, claims))
    print(f"{len(claims)} claims" + (f", figures and tables in {arguments.out}" if draws else ""), file=sys.stderr)


if __name__ == "__main__":
    main()
