"""The verdict on a claim: the computed value against the published one, within the claim's tolerance."""

import math
import re
from decimal import ROUND_DOWN, ROUND_HALF_UP, Decimal, InvalidOperation

from millprint.claims.evidence import Finding

REPRODUCED, DEVIATES, ERRATUM, NOT_RUN = "reproduced", "deviates", "erratum", "not run"
VERDICTS = (REPRODUCED, ERRATUM, DEVIATES, NOT_RUN)

# Relative bounds for fitted pairs (tolerance `recover`) and for claims with the tolerance `report`.
RECOVER_BOUND = 0.05
REPORT_BOUND = 0.10

_ORDERS = {"<=": lambda a, b: a <= b, ">=": lambda a, b: a >= b, "<": lambda a, b: a < b, ">": lambda a, b: a > b}


def verdict(published: str, tolerance: str, finding: Finding) -> str:
    """One of `reproduced`, `deviates`, `erratum`, `not run`."""
    if finding.erratum:
        return ERRATUM
    if finding.value is None:
        return NOT_RUN
    return REPRODUCED if agrees(published, tolerance, finding.value) else DEVIATES


def agrees(published: str, tolerance: str, value: float | str) -> bool:
    """Whether `value` meets `published` within `tolerance`.

    Tolerances: `printed` (the published digits, rounded or truncated), `15%` (relative), `0.01` (absolute),
    `<=15%` and `>=3` (a bound on the value itself, for a percentage in per cent), `recover` (each number of a pair
    within 5 %), `report` (10 %, or the same word), and any word, which must be equal.
    Raises ValueError for a number instead of a word, or the reverse.
    """
    bound = re.fullmatch(r"(<=|>=|<|>)\s*([-+.\deE]+)%?", tolerance)
    if bound:
        return _ORDERS[bound[1]](float(value), float(bound[2]))
    if tolerance == "recover":
        pairs = zip(published.split("/"), str(value).split("/"), strict=True)
        return all(_relative(float(ours), float(theirs)) <= RECOVER_BOUND for theirs, ours in pairs)
    if not _is_number(published):
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
    if value is None or not _is_number(published) or not _is_number(str(value)) or float(published) == 0:
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


def _is_number(text: str) -> bool:
    try:
        return Decimal(text).is_finite()
    except InvalidOperation:
        return False
