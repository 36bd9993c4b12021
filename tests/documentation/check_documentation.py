#!/usr/bin/env python3
"""Checks README.md, .github/CONTRIBUTING.md, the topics of the help and configs/paper/README.md against what the program does now.

    check_documentation.py [--qerr PATH]                  compare; one line per difference, exit code 1 if there is any
    check_documentation.py --update                       renew outputs and figures in all files
    check_documentation.py --mutations N [--seed SEED]    compare, then change one digit of the text or of an output at a time,
                                                          N times in each file, and verify that each change is found (N = 0: all)

The blocks are run as session.py says, those of each file in a copy of their own; figures in the text are compared with the values of
statements.py, and every other number must be a name or a formula that statements.py lists. The tables of configs/paper/README.md are
computed anew by scripts/reproduce_paper. Excepted: the section "Speed" of .github/CONTRIBUTING.md, commands that install or build, workflows
of GitHub and GitLab. Standard library only (scripts/reproduce_paper needs numpy).
"""
import argparse
import difflib
import math
import pathlib
import random
import re
import subprocess
import sys
import tempfile

import document
import statements
from session import Fault, Session, checked_by_running, excepted, outputs

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXCEPTED_SECTION = "Speed"
MOST_LINES = {"README.md": 250}  # what is more belongs into the help
DIGITS = re.compile(r"[^\s|]*\d[^\s|]*")
TABLES = re.compile(r"(?<=<!-- tables: ).*(?=<!-- end of tables -->)", re.S)


def builds(block):
    return block.language == "sh" and excepted(block)


class Page:
    """One file and the ways to renew it."""

    def __init__(self, name, qerr, keep_states):
        self.name, self.text = name, (ROOT / name).read_text(encoding="utf-8")
        self.session = Session(ROOT, qerr, keep_states) if name != statements.PAPER else None
        self.values = statements.Values(ROOT, qerr)
        self.tables = None if self.session else self._new_tables(qerr)

    def _new_tables(self, qerr):
        with tempfile.TemporaryDirectory() as scratch:
            copy = pathlib.Path(scratch) / "page.md"
            copy.write_text(self.text, encoding="utf-8")
            script = [sys.executable, ROOT / "scripts" / "reproduce_paper", "--qerr", qerr, "--page", copy]
            subprocess.run([*script, "--write-page"], check=True, stderr=subprocess.PIPE)
            return TABLES.search(copy.read_text(encoding="utf-8"))[0]

    def renewed(self, text, first_only=False):
        """The text with new outputs and figures; may raise Fault."""
        changes = []
        if self.session:
            for block, body in outputs(document.blocks(text), self.session):
                changes.append((block.begin, block.end, body))
                if first_only and body != block.body:
                    break
        if self.tables is not None:
            changes.append((*TABLES.search(text).span(), self.tables))
        for begin, end, value in statements.changes(self.name, text, self.values):
            changes.append((begin, end, value))
        for begin, end, value in sorted(changes, reverse=True):
            text = text[:begin] + value + text[end:]
        return text

    def faults(self, text, first_only=False):
        """Differences between this text and what comes out now."""
        try:
            new = self.renewed(text, first_only)
        except (Fault, statements.Missing) as fault:
            return [f"{self.name}: {fault}"]
        lines = difflib.unified_diff(text.splitlines(), new.splitlines(), self.name, "comes out", lineterm="", n=0)
        if text.count("\n") > MOST_LINES.get(self.name, math.inf):
            return [f"{self.name}: more than {MOST_LINES[self.name]} lines"]
        return [*lines, *(f"{self.name}:{line}: no test of '{word}'" for line, word in self.untested(text))]

    def covered(self, text):
        """Ranges of the text that are run, computed anew or excepted."""
        ranges = [document.section(text, EXCEPTED_SECTION)] if self.session else []
        ranges += [(b.begin, b.end) for b in document.blocks(text) if checked_by_running(b) or builds(b)]
        if self.tables is not None:
            ranges.append(TABLES.search(text).span())
        return ranges + statements.covered(self.name, text, ROOT)

    def untested(self, text):
        bare = list(text)
        for begin, end in self.covered(text):
            bare[begin:end] = [c if c == "\n" else " " for c in bare[begin:end]]
        bare = "".join(bare)
        for match in DIGITS.finditer(bare):
            yield document.line_of(text, match.start()), match[0]

    def mutable(self):
        """Places of the digits that state something: of the text and of outputs. Another digit in an input is another example."""
        skip = [document.section(self.text, EXCEPTED_SECTION)] if self.session else []
        skip += [(b.begin, b.end) for b in document.blocks(self.text) if builds(b) or (b.language and checked_by_running(b))]
        digits = (m.start() for m in re.finditer(r"\d", self.text))
        return [place for place in digits if not any(begin <= place < end for begin, end in skip)]


def mutate(page, count, generator):
    """Changes single digits. @returns a line for each change that is not found"""
    places = page.mutable()
    chosen = places if count == 0 else generator.sample(places, min(count, len(places)))
    missed = []
    for place in sorted(chosen):
        digit = generator.choice([d for d in "0123456789" if d != page.text[place]])
        text = page.text[:place] + digit + page.text[place + 1 :]
        if not page.faults(text, first_only=True):
            line = document.line_of(text, place)
            missed.append(f"{page.name}:{line}: {page.text[place]} -> {digit} is not found: {text.splitlines()[line - 1]}")
    print(f"{page.name}: {len(chosen)} of {len(places)} digits changed, {len(chosen) - len(missed)} found", file=sys.stderr)
    return missed


def main():
    parser = argparse.ArgumentParser(description="Checks the documentation.")
    parser.add_argument("--qerr", default=str(ROOT / "build" / "qerr"), help="the program (default: build/qerr)")
    parser.add_argument("--update", action="store_true", help="renew outputs and figures")
    parser.add_argument("--mutations", type=int, metavar="N", help="digits to change in each file; 0: all")
    parser.add_argument("--seed", type=int, default=1, help="of the choice of digits")
    parser.add_argument("--only", choices=statements.DOCUMENTS, metavar="FILE", help="check one file")
    parser.add_argument("--skip", choices=statements.DOCUMENTS, action="append", default=[], metavar="FILE", help="leave one out")
    arguments = parser.parse_args()
    faults = []
    names = [arguments.only] if arguments.only else statements.DOCUMENTS
    for name in (name for name in names if name not in arguments.skip):
        page = Page(name, str(pathlib.Path(arguments.qerr).resolve()), arguments.mutations is not None)
        if arguments.update:
            page.text = page.renewed(page.text)
            (ROOT / name).write_text(page.text, encoding="utf-8")
        found = page.faults(page.text)
        if not found and arguments.mutations is not None:
            found = mutate(page, arguments.mutations, random.Random(arguments.seed))
        faults += found
    print("\n".join(faults), end="\n" if faults else "")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    try:
        main()
    except (Fault, statements.Missing) as fault:
        sys.exit(str(fault))
