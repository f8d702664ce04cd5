"""What a tolerance allows, the verdicts on a claim by its value and by its repeats, and words for what a claim is."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from decimal import Decimal, InvalidOperation
from typing import TYPE_CHECKING

from millprint.estimate.estimates import Estimate, Interval
from millprint.estimate.judge import DIFFERS, OPEN, Allowed, Verdict, judge, judge_all

if TYPE_CHECKING:
    from millprint.thesis.claims.evidence import Finding

# The reason of a value that differs where two printed places cannot both hold.
ERRATUM = "erratum"

# Values of the column `nature` of claims.tsv, ordered by how much a match proves, least first.
NATURES = {
    "arithmetic": "arithmetic on printed numbers, or read from a table of the thesis and printed back",
    "put_in": "put in and read back",
    "fitted": "fitted to the printed value, or with settings that were read off it",
    "simulated": "simulated",
    "trained": "trained",
    "timed": "run times",
}
# The same on every machine, because they do not depend on chance.
CERTAIN = ("arithmetic",)
# A match of these shows nothing of the thesis.
ASSUMED = ("put_in", "fitted")
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


def agrees(published: str, tolerance: str, value: float | str) -> bool:
    """Whether `value` meets `published` within `tolerance` (`allowed`); of a pair, such as 0.30/0.045, each number.

    Raises ValueError for a number instead of a word, or the reverse.
    """
    parts = pairs(published, str(value))
    return all(allowed(one, tolerance).holds(reading(one, tolerance, ours)) for one, ours in parts)


def allowed(published: str, tolerance: str) -> Allowed:
    """The values that meet a printed number or word, as `reading` gives them, within a tolerance.

    Tolerances: `printed` (the published digits, rounded or truncated), `15%` (relative), `0.01` (absolute),
    `<=15%` and `>=3` (a bound on the value itself, for a percentage in per cent), `20..35` (a range), `recover` (5 %),
    `report` (10 %, or the same word), and any word, which must be equal.
    """
    if bound := BOUND.fullmatch(tolerance):
        end, is_open = float(bound[2]), len(bound[1]) == 1
        return Allowed(upper=end, open_upper=is_open) if bound[1][0] == "<" else Allowed(end, open_lower=is_open)
    if within := RANGE.fullmatch(tolerance):
        return Allowed(float(within[1]), float(within[2]))
    if not is_number(published):
        return Allowed(lower=1.0)
    if tolerance != "printed":
        reach = _reach(published, tolerance) * (1 + 1e-12)
        return Allowed(float(published) - reach, float(published) + reach)
    # Rounded: half a unit to either side; truncated: a whole one, away from 0.
    number, unit = Decimal(published), _unit(published)
    if not number:
        return Allowed(-float(unit), float(unit), open_lower=True, open_upper=True)
    near, far = float(abs(number) - unit / 2), float(abs(number) + unit)
    return Allowed(near, far, open_upper=True) if number > 0 else Allowed(-far, -near, open_lower=True)


def reading(published: str, tolerance: str, value: float | str) -> float:
    """A value as a number: of a word 1 if it is the published one, else 0."""
    if not (BOUND.fullmatch(tolerance) or RANGE.fullmatch(tolerance) or is_number(published)):
        return float(str(value) == published)
    # So 0.145 is not read as 0.14499999.
    return round(float(value), 12) if tolerance == "printed" and math.isfinite(float(value)) else float(value)


def pairs(published: str, *others: str) -> list[tuple[str, ...]]:
    """The numbers of a pair such as 0.30/0.045 with those of the others; one tuple for a value that is not a pair."""
    split = published.split("/")
    if len(split) == 1 or not all(map(is_number, split)):
        return [(published, *others)]
    return list(zip(split, *(other.split("/") for other in others), strict=True))


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


def judge_value(published: str, tolerance: str, finding: Finding) -> Verdict:
    """The verdict on a claim by only its value: it says whether our number agrees, not whether it holds.

    A value within the tolerance agrees, whatever else the thesis prints. One that differs is an erratum where two
    printed places cannot both hold.
    """
    if finding.value is None:
        return judge(None, Allowed())
    found = judge_all(
        judge(Estimate(reading(one, tolerance, ours), ""), allowed(one, tolerance))
        for one, ours in pairs(published, str(finding.value))
    )
    return Verdict(DIFFERS, ERRATUM) if found.word == DIFFERS and finding.contradiction else found


def judge_repeats(published: str, tolerance: str, finding: Finding) -> Verdict | None:
    """The verdict on a claim by its interval and by the jars that fit as well, which says whether the claim holds.

    A claim that some of these jars meet and others do not is open. None without an interval and without jars.
    """
    alone, jars = _judge_interval(published, tolerance, finding), finding.jars
    if finding.value is None or not jars:
        return alone
    found, met = _judge_interval(published, tolerance, finding, jars), jars_that_meet(published, tolerance, jars)
    if found and found.word == OPEN and (met < len(jars) or alone is None or alone.word != OPEN):
        return Verdict(OPEN, f"{met} of {len(jars)} jars and counting rules that fit equally well meet it")
    return found


def jars_that_meet(published: str, tolerance: str, jars: Sequence[float | str]) -> int:
    """How many of the values of a claim by jar meet it."""
    return sum(agrees(published, tolerance, value) for value in jars)


def _judge_interval(
    published: str, tolerance: str, finding: Finding, jars: Sequence[float | str] = ()
) -> Verdict | None:
    own = finding.repeats
    if finding.value is None or (own is None and not jars):
        return None
    of, failed = (own.of, own.failed) if own else (None, 0)
    if of is not None and failed == of:
        return judge(Estimate(math.inf, "", of=of, failed=failed), Allowed())
    found = []
    ends = [own.lower, own.upper] if own else []
    for one, *texts in pairs(published, *map(str, [finding.value, *ends, *jars])):
        value, *values = (reading(one, tolerance, text) for text in texts)
        known = {"repeats": Interval(*sorted(values[:2]))} if own else {}
        if jars:
            by_jar = [value, *values[len(ends) :]]
            known["shape"] = Interval(min(by_jar), max(by_jar))
        estimate = Estimate(value, "", of=of, failed=failed).having(known)
        found.append(judge(estimate, allowed(one, tolerance)))
    return judge_all(found)


def reason_of(value: Verdict, repeats: Verdict | None) -> str:
    """The reason of both verdicts, once where the interval says the same as the value."""
    return "; ".join(dict.fromkeys(each.reason for each in (value, repeats) if each))
