"""The table of claims in configs/paper/README.md: written from fresh figures, and held against them."""
import re
import sys

from tool import ROOT

PAGE = ROOT / "configs" / "paper" / "README.md"
BEGIN, END = "<!-- claims: written by scripts/reproduce_paper.sh --write-page -->", "<!-- end of claims -->"
COLUMNS = ["where", "claim", "printed", "ours", "verdict", "why", "command"]
TOLERANCE = 0.02  # of a figure between machines: compilers round differently, and counts then fall differently

_FIGURE = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?(?![\w])")


def cells(claim):
    return [claim.where, claim.claim, claim.printed, claim.ours, claim.verdict, claim.why, claim.command]


def _row(claim):
    *words, command = cells(claim)
    return "| " + " | ".join(words) + f" | `{command}` |"


def _table(claims):
    head = "| " + " | ".join(COLUMNS) + " |\n|" + "---|" * len(COLUMNS)
    return "\n".join([head, *map(_row, claims)])


def _parts():
    text = PAGE.read_text(encoding="utf-8")
    if BEGIN not in text or END not in text:
        sys.exit(f"reproduce_paper: {PAGE} has lost its marks '{BEGIN}' and '{END}'")
    before, rest = text.split(BEGIN, 1)
    table, after = rest.split(END, 1)
    return before, table.strip("\n"), after


def write(claims):
    before, _, after = _parts()
    PAGE.write_text(f"{before}{BEGIN}\n{_table(claims)}\n{END}{after}", encoding="utf-8")


def same(old, new):
    """The same words, and figures within the tolerance (rounding errors, such as 3e-16, within a factor)."""
    if _FIGURE.sub("#", old) != _FIGURE.sub("#", new):
        return False
    for a, b in zip(map(float, _FIGURE.findall(old)), map(float, _FIGURE.findall(new))):
        tiny = max(abs(a), abs(b)) < 1e-8
        if not tiny and abs(a - b) > TOLERANCE * max(abs(a), abs(b)):
            return False
    return True


def check(claims, complete):
    """Every fresh row must stand in the page. @returns the number of rows that do not"""
    page_rows = _parts()[1].splitlines()[2:]
    faults = 0
    for claim in claims:
        if not any(same(row, _row(claim)) for row in page_rows):
            faults += 1
            print(f"not in {PAGE.relative_to(ROOT)} (or otherwise):\n  {_row(claim)}", file=sys.stderr)
    if complete and len(page_rows) != len(claims):
        faults += 1
        print(f"{len(page_rows)} rows in the page, {len(claims)} claims", file=sys.stderr)
    print(f"{len(claims)} claims compared with the page, {faults} differ", file=sys.stderr)
    return 1 if faults else 0
