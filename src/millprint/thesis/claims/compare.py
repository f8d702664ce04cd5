"""The two verdicts on a claim: by its value, and by the interval of a value that chance has a part in."""

from millprint.statistics.student import FEWEST_REPEATS
from millprint.thesis.claims.claim_verdicts import (
    DEVIATES,
    ERRATUM,
    NOT_RUN,
    REPRODUCED,
    TOO_FEW,
    TOO_WIDE,
    UNDECIDED,
)
from millprint.thesis.claims.evidence import Finding
from millprint.thesis.claims.tolerances import BOUND, RANGE, agrees, allowed_width, is_number, pairs


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
