"""The verdict on a claim: the computed value, or its interval, against the published one and the claim's tolerance."""

import math
import re
from decimal import ROUND_DOWN, ROUND_HALF_UP, Decimal, InvalidOperation

from millprint.claims.evidence import Finding, Interval
from millprint.claims.verdicts import DEVIATES, ERRATUM, NOT_RUN, REPRODUCED, UNDECIDED

# Relative bounds for fitted pairs (tolerance `recover`) and for claims with the tolerance `report`.
RECOVER_BOUND = 0.05
REPORT_BOUND = 0.10

# A bound on the value itself.
BOUND = re.compile(r"(<=|>=|<|>)\s*([-+.\deE]+)%?")
_ORDERS = {"<=": lambda a, b: a <= b, ">=": lambda a, b: a >= b, "<": lambda a, b: a < b, ">": lambda a, b: a > b}


def verdict(published: str, tolerance: str, finding: Finding) -> str:
    """One of VERDICTS.

    With an interval: `reproduced` if it lies inside the tolerance, `deviates` if wholly outside, else undecided.
    """
    if finding.erratum:
        return ERRATUM
    if finding.value is None:
        return NOT_RUN
    if finding.interval is None:
        return REPRODUCED if agrees(published, tolerance, finding.value) else DEVIATES
    return _of_interval(published, tolerance, finding.interval)


def _of_interval(published: str, tolerance: str, interval: Interval) -> str:
    ends = str(interval.lower), str(interval.upper)
    if tolerance == "recover":
        # A pair is inside if both of its numbers are, and outside if either is.
        parts = [
            _of_interval(theirs, f"{100 * RECOVER_BOUND:g}%", Interval(lower, upper, interval.origin))
            for theirs, lower, upper in zip(published.split("/"), *(end.split("/") for end in ends), strict=True)
        ]
        return DEVIATES if DEVIATES in parts else UNDECIDED if UNDECIDED in parts else REPRODUCED
    inside = [agrees(published, tolerance, end) for end in ends]
    if all(inside):
        return REPRODUCED
    # What a tolerance allows is in one piece. Where it is about a printed number, it holds that number.
    spans = is_number(published) and not BOUND.fullmatch(tolerance) and all(map(is_number, ends))
    crossed = any(inside) or (spans and float(ends[0]) <= float(published) <= float(ends[1]))
    return UNDECIDED if crossed else DEVIATES


def agrees(published: str, tolerance: str, value: float | str) -> bool:
    """Whether `value` meets `published` within `tolerance`.

    Tolerances: `printed` (the published digits, rounded or truncated), `15%` (relative), `0.01` (absolute),
    `<=15%` and `>=3` (a bound on the value itself, for a percentage in per cent), `recover` (each number of a pair
    within 5 %), `report` (10 %, or the same word), and any word, which must be equal.
    Raises ValueError for a number instead of a word, or the reverse.
    """
    bound = BOUND.fullmatch(tolerance)
    if bound:
        return _ORDERS[bound[1]](float(value), float(bound[2]))
    if tolerance == "recover":
        pairs = zip(published.split("/"), str(value).split("/"), strict=True)
        return all(_relative(float(ours), float(theirs)) <= RECOVER_BOUND for theirs, ours in pairs)
    if not is_number(published):
        return str(value) == published
    value = float(value)
    if not math.isfinite(value):
        return False
    if tolerance == "printed":
        return _has_digits(published, value)
    if tolerance == "report":
        return _relative(value, float(published)) <= REPORT_BOUND
    if tolerance.endswith("%"):
        return _relative(value, float(published)) <= float(tolerance[:-1]) / 100
    return abs(value - float(published)) <= float(tolerance)


def deviation(published: str, value: float | str | None) -> float | None:
    """Relative deviation from the published number, in per cent; None where either is no number or the latter is 0."""
    if value is None or not is_number(published) or not is_number(value) or float(published) == 0:
        return None
    if not math.isfinite(float(value)):
        return None
    return 100 * (float(value) - float(published)) / abs(float(published))


def _has_digits(published: str, value: float) -> bool:
    exponent = Decimal(published).as_tuple().exponent
    assert isinstance(exponent, int), "only infinity and what is no number have a letter there"
    step = Decimal(1).scaleb(exponent)
    # repr carries the shortest digits that give the number back, so 0.145 is not read as 0.14499999.
    exact = Decimal(repr(round(value, 12)))
    return Decimal(published) in (exact.quantize(step, ROUND_HALF_UP), exact.quantize(step, ROUND_DOWN))


def _relative(value: float, published: float) -> float:
    return abs(value - published) / abs(published) if published else abs(value)


def is_number(text: float | str) -> bool:
    """Whether a value or a text is a number, infinite ones included."""
    try:
        return not Decimal(str(text)).is_nan()
    except InvalidOperation:
        return False
