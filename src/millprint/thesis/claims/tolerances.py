"""What a tolerance allows, the verdicts that follow from it, and the words for these and for what a claim is."""

from __future__ import annotations

import math
import re
from decimal import ROUND_DOWN, ROUND_HALF_UP, Decimal, InvalidOperation
from typing import TYPE_CHECKING

from millprint.estimate.estimates import FEWEST_REPEATS

if TYPE_CHECKING:
    from millprint.thesis.claims.evidence import Finding

# By the value itself.
REPRODUCED, DEVIATES, ERRATUM, NOT_RUN = "reproduced", "deviates", "erratum", "not run"
VERDICTS = (REPRODUCED, ERRATUM, DEVIATES, NOT_RUN)

# By the interval, of claims that have one; these two besides REPRODUCED and DEVIATES.
UNDECIDED, TOO_WIDE, TOO_FEW = "undecided", "wider than the tolerance", "too few repeats"
INTERVAL_VERDICTS = (REPRODUCED, DEVIATES, UNDECIDED, TOO_WIDE, TOO_FEW)
# Another run may fall on either side of the tolerance.
OPEN_VERDICTS = (UNDECIDED, TOO_WIDE, TOO_FEW)


# Values of the column `nature` of claims.tsv, ordered by how much a match proves, least first.
NATURES = {
    "read": "read from a table of the thesis and printed back",
    "arithmetic": "arithmetic on printed numbers",
    "put_in": "put in and read back",
    "fitted": "fitted to the printed value",
    "simulated": "simulated",
    "trained": "trained",
    "timed": "a run time",
}
# The same on every machine, because they do not depend on chance.
CERTAIN = ("read", "arithmetic")
TIMED = "timed"

# Values of the column `basis`.
STATED, DERIVED = "stated", "derived"
BASES = {
    STATED: "printed in the thesis, as a number or as a statement",
    DERIVED: "not printed: follows from two printed numbers (a mean from its standard deviation and variation)",
}


# Relative bounds for fitted pairs (tolerance `recover`) and for claims with the tolerance `report`.
RECOVER_BOUND = 0.05
REPORT_BOUND = 0.10

# A bound on the value itself, and a range that it must lie in.
BOUND = re.compile(r"(<=|>=|<|>)\s*([-+.\deE]+)%?")
RANGE = re.compile(r"([-+.\deE]+)\.\.([-+.\deE]+)")
_ORDERS = {"<=": lambda a, b: a <= b, ">=": lambda a, b: a >= b, "<": lambda a, b: a < b, ">": lambda a, b: a > b}


def agrees(published: str, tolerance: str, value: float | str) -> bool:
    """Whether `value` meets `published` within `tolerance`.

    Tolerances: `printed` (the published digits, rounded or truncated), `15%` (relative), `0.01` (absolute),
    `<=15%` and `>=3` (a bound on the value itself, for a percentage in per cent), `20..35` (a range), `recover` (5 %),
    `report` (10 %, or the same word), and any word, which must be equal. Of a pair, such as 0.30/0.045, each number.
    Raises ValueError for a number instead of a word, or the reverse.
    """
    parts = pairs(published, str(value))
    if len(parts) > 1:
        return all(agrees(theirs, tolerance, ours) for theirs, ours in parts)
    bound, within = BOUND.fullmatch(tolerance), RANGE.fullmatch(tolerance)
    if bound:
        return _ORDERS[bound[1]](float(value), float(bound[2]))
    if within:
        return float(within[1]) <= float(value) <= float(within[2])
    if not is_number(published):
        return str(value) == published
    value = float(value)
    if not math.isfinite(value):
        return False
    if tolerance == "printed":
        return _has_digits(published, value)
    return abs(value - float(published)) <= _reach(published, tolerance) * (1 + 1e-12)


def pairs(published: str, *others: str) -> list[tuple[str, ...]]:
    """The numbers of a pair such as 0.30/0.045 with those of the others; one tuple for a value that is not a pair."""
    split = published.split("/")
    if len(split) == 1 or not all(map(is_number, split)):
        return [(published, *others)]
    return list(zip(split, *(other.split("/") for other in others), strict=True))


def allowed_width(published: str, tolerance: str) -> float:
    """The width of what a tolerance allows about a printed number; infinite for a bound and for a word."""
    if within := RANGE.fullmatch(tolerance):
        return float(within[2]) - float(within[1])
    if BOUND.fullmatch(tolerance) or not is_number(published):
        return math.inf
    # Rounded: half a unit to either side; truncated: a whole one to one side.
    return 1.5 * float(_unit(published)) if tolerance == "printed" else 2 * _reach(published, tolerance)


def deviation(published: str, value: float | str | None) -> float | None:
    """Relative deviation from the published number, in per cent; None where one is not a number or the latter is 0."""
    if value is None or not is_number(published) or not is_number(value) or float(published) == 0:
        return None
    if not math.isfinite(float(value)):
        return None
    return 100 * (float(value) - float(published)) / abs(float(published))


def is_number(text: float | str) -> bool:
    """Whether a value or a text is a number, infinite ones included."""
    try:
        return not Decimal(str(text)).is_nan()
    except InvalidOperation:
        return False


def _reach(published: str, tolerance: str) -> float:
    """How far a value may be from a printed number to either side."""
    size = abs(float(published)) or 1.0
    if tolerance in ("recover", "report"):
        return (RECOVER_BOUND if tolerance == "recover" else REPORT_BOUND) * size
    return float(tolerance[:-1]) / 100 * size if tolerance.endswith("%") else float(tolerance)


def _unit(published: str) -> Decimal:
    """One unit of the last printed digit."""
    exponent = Decimal(published).as_tuple().exponent
    assert isinstance(exponent, int), "only infinity and what is not a number have a letter there"
    return Decimal(1).scaleb(exponent)


def _has_digits(published: str, value: float) -> bool:
    step = _unit(published)
    # repr carries the shortest digits that give the number back, so 0.145 is not read as 0.14499999.
    exact = Decimal(repr(round(value, 12)))
    return Decimal(published) in (exact.quantize(step, ROUND_HALF_UP), exact.quantize(step, ROUND_DOWN))


def verdict(published: str, tolerance: str, finding: Finding) -> str:
    """One of VERDICTS, by the value.

    A value within the tolerance is reproduced, whatever else the thesis prints. Else it is an erratum where two printed
    places cannot both hold, and deviates where they can.
    """
    if finding.value is None:
        return NOT_RUN
    if agrees(published, tolerance, finding.value):
        return REPRODUCED
    return ERRATUM if finding.contradiction else DEVIATES


def interval_verdict(published: str, tolerance: str, finding: Finding) -> str:
    """One of INTERVAL_VERDICTS; empty for a claim without an interval.

    Fewer than FEWEST_REPEATS decide nothing. `reproduced` if the interval lies inside the tolerance and no repeat
    failed, `deviates` if it lies outside, and else undecided, or too wide where it is wider than what is allowed.
    """
    interval = finding.interval
    if finding.value is None or interval is None:
        return ""
    if interval.repeats < FEWEST_REPEATS:
        return TOO_FEW
    if interval.failed == interval.repeats:
        return DEVIATES
    parts = pairs(published, str(interval.lower), str(interval.upper))
    found = [_of_ends(theirs, lower, upper, tolerance) for theirs, lower, upper in parts]
    worst = next((one for one in (DEVIATES, TOO_WIDE, UNDECIDED) if one in found), REPRODUCED)
    # A repeat that failed is a miss, so that the others cannot all be hits.
    return UNDECIDED if worst == REPRODUCED and interval.failed else worst


def _of_ends(published: str, lower: str, upper: str, tolerance: str) -> str:
    inside = [agrees(published, tolerance, end) for end in (lower, upper)]
    if all(inside):
        return REPRODUCED
    numbers = is_number(lower) and is_number(upper)
    # A tolerance allows one connected range. If it is about a printed number, the range contains that number.
    about = numbers and is_number(published) and not BOUND.fullmatch(tolerance) and not RANGE.fullmatch(tolerance)
    around = about and float(lower) <= float(published) <= float(upper)
    if not any(inside) and not around and not _holds_range(tolerance, lower, upper):
        return DEVIATES
    wide = numbers and float(upper) - float(lower) > allowed_width(published, tolerance)
    return TOO_WIDE if wide else UNDECIDED


def _holds_range(tolerance: str, lower: str, upper: str) -> bool:
    """Whether an interval holds the range that a tolerance names."""
    within = RANGE.fullmatch(tolerance)
    return within is not None and float(lower) <= float(within[1]) and float(within[2]) <= float(upper)
