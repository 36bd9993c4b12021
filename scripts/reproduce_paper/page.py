"""The tables of configs/paper/README.md: written from new results, and compared with them, digit by digit."""
import difflib
import sys

from slips import SLIPS
from tool import ROOT

PAGE = ROOT / "configs" / "paper" / "README.md"
BEGIN, END = "<!-- tables: written by scripts/reproduce_paper.sh --write-page -->", "<!-- end of tables -->"
COLUMNS = ["where", "claim", "printed", "ours", "verdict", "why"]


def cells(claim):
    return [claim.where, claim.claim, claim.printed, claim.ours, claim.verdict, claim.why]


def _judged(claim):
    return f"**{claim.verdict}**" + (f": {claim.why}" if claim.why else "")


def text(number, claim):
    """One row for the terminal."""
    return (
        f"{number}. {claim.where}: {claim.claim}\n"
        f"  printed: {claim.printed}\n  ours:    {claim.ours}\n  verdict: {_judged(claim)}"
    )


def _table(header, rows):
    def line(words):
        return "| " + " | ".join(str(word).replace("|", "\\|") for word in words) + " |"

    return "\n".join([line(header), "|" + "---|" * len(header), *(line(row) for row in rows)])


def _tables(claims):
    rows = [
        [number, claim.where, claim.claim, claim.printed, claim.ours, _judged(claim)]
        for number, claim in enumerate(claims, start=1)
    ]
    return "\n".join(
        [
            _table(["row", "where", "claim", "printed", "ours", "verdict"], rows),
            "",
            "## Slips that need no figures",
            "",
            _table(["where", "printed", "meant"], SLIPS),
        ]
    )


def _renewed(text, claims):
    if BEGIN not in text or END not in text:
        sys.exit(f"reproduce_paper: the page lacks the marks '{BEGIN}' and '{END}'")
    before, after = text.split(BEGIN, 1)[0], text.split(END, 1)[1]
    return f"{before}{BEGIN}\n{_tables(claims)}\n{END}{after}"


def write(path, claims):
    path.write_text(_renewed(path.read_text(encoding="utf-8"), claims), encoding="utf-8")


def check(path, claims):
    """@returns 1 if the page and the new results differ in any character"""
    old = path.read_text(encoding="utf-8")
    new = _renewed(old, claims)
    lines = difflib.unified_diff(old.splitlines(), new.splitlines(), str(path), "new results", lineterm="", n=0)
    print("\n".join(lines), file=sys.stderr)
    print(f"{len(claims)} claims compared with the page", file=sys.stderr)
    return int(old != new)
