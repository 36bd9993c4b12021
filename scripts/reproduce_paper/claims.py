"""A claim of the paper, the computed result, and the verdict."""
import dataclasses
import math

CONFIRMED, LOOSE, WRONG = "confirmed", "loosely worded", "wrong"


@dataclasses.dataclass
class Claim:
    """One row of the page.

    `ours` is a text with the new figures; `why` explains a verdict other than "confirmed", else "".
    """

    where: str
    claim: str
    printed: str
    ours: str
    verdict: str
    why: str = ""


def rounds_to(value, printed):
    """Whether `value`, rounded to the decimals of the text `printed`, equals it: .08 has two decimals."""
    decimals = len(printed.split(".")[1]) if "." in printed else 0
    return math.isclose(round(value, decimals), float(printed), abs_tol=0.5 * 10.0 ** -(decimals + 6))


def confirmed_if(condition, otherwise=WRONG):
    return CONFIRMED if condition else otherwise


def number(value, digits=3):
    """Short decimal notation: 0.0802, 17.6, 1330, 1.2e-05."""
    if value == 0:
        return "0"
    text = f"{value:.{digits}g}"
    if "e" in text and 1e-4 <= abs(value) < 1e7:
        return f"{float(text):.0f}"
    return text


def within(gap, limit):
    """A difference from an independent computation, as the text "within 1e-09"; above the limit the row fails."""
    if not gap <= limit:
        raise ArithmeticError(f"a difference of {gap:.2g} from an independent computation, above {limit:.0e}")
    return f"within {limit:.0e}"


def numbers(values, digits=3):
    return ", ".join(number(value, digits) for value in values)
