"""The table of claims in configs/paper/README.md: written from new results, and compared with them."""
import re
import sys

from tool import ROOT

PAGE = ROOT / "configs" / "paper" / "README.md"
BEGIN, END = "<!-- claims: written by scripts/reproduce_paper.sh --write-page -->", "<!-- end of claims -->"
COLUMNS = ["where", "claim", "printed", "ours", "verdict", "why", "command"]
TOLERANCE = (
    0.02  # relative, between machines: different rounding can change individual counts
)

_FIGURE = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?(?![\w])")


def cells(claim):
    return [claim.where, claim.claim, claim.printed, claim.ours, claim.verdict, claim.why, claim.command]


def _row(index, claim):
    judged = f"**{claim.verdict}**" + (f": {claim.why}" if claim.why else "")
    words = [claim.where, claim.claim, claim.printed, claim.ours, judged]
    return f"| {index} | " + " | ".join(word.replace("|", "\\|") for word in words) + " |"


def _command(index, claim):
    return f"{index}. `{claim.command}`"


def _table(claims):
    numbered = list(enumerate(claims, start=1))
    return "\n".join(
        [
            "| | where | claim | printed | ours | verdict |",
            "|---|---|---|---|---|---|",
            *(_row(i, claim) for i, claim in numbered),
            "",
            "What to run for each, from the project's root:",
            "",
            *(_command(i, claim) for i, claim in numbered),
        ]
    )


def _parts():
    text = PAGE.read_text(encoding="utf-8")
    if BEGIN not in text or END not in text:
        sys.exit(f"reproduce_paper: {PAGE} lacks the marks '{BEGIN}' and '{END}'")
    before, rest = text.split(BEGIN, 1)
    table, after = rest.split(END, 1)
    return before, table.strip("\n"), after


def write(claims):
    before, _, after = _parts()
    PAGE.write_text(f"{before}{BEGIN}\n{_table(claims)}\n{END}{after}", encoding="utf-8")


def same(old, new):
    """Equal words, and figures within the tolerance; figures below 1e-6 are rounding errors and not compared."""
    if _FIGURE.sub("#", old) != _FIGURE.sub("#", new):
        return False
    for a, b in zip(map(float, _FIGURE.findall(old)), map(float, _FIGURE.findall(new))):
        tiny = max(abs(a), abs(b)) < 1e-6
        if not tiny and abs(a - b) > TOLERANCE * max(abs(a), abs(b)):
            return False
    return True


def check(claims, complete):
    """Every new row and command must be in the page, independent of its number. @returns 1 if not"""
    lines = {re.sub(r"^(\| \d+ \||\d+\.) ", "", line) for line in _parts()[1].splitlines()}
    faults = 0
    for claim in claims:
        for fresh in (_row(0, claim), _command(0, claim)):
            bare = re.sub(r"^(\| \d+ \||\d+\.) ", "", fresh)
            if not any(same(line, bare) for line in lines):
                faults += 1
                print(
                    f"{PAGE.relative_to(ROOT)}: differs from the new result:\n  {bare}", file=sys.stderr
                )
    rows = sum(line.count("**") >= 2 for line in lines)
    if complete and rows != len(claims):
        faults += 1
        print(f"{PAGE.relative_to(ROOT)}: {rows} claims, but {len(claims)} are checked now", file=sys.stderr)
    print(f"{len(claims)} claims compared with the page, {faults} differences", file=sys.stderr)
    return 1 if faults else 0
