"""The verdicts of the product: whether an estimate agrees with a claim, differs from it, or leaves it open, and why."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from millprint.estimate.estimates import FEWEST_REPEATS, INTERVALS, Estimate, Interval

AGREES, DIFFERS, OPEN = "agrees", "differs", "open"
VERDICTS = (AGREES, DIFFERS, OPEN)
# Reasons, besides those that name a number.
NOT_RUN, TOO_FEW, UNDECIDED, TOO_WIDE = "not run", "too few repeats", "undecided", "wider than the tolerance"
WITHIN, BEYOND, BOTH = "within the tolerance", "beyond the tolerance", "within both intervals"
NO_INTERVAL, CROSSING = "no interval is known", "the intervals overlap, but do not hold both values"
APART = "the intervals are apart"


class Verdict(NamedTuple):
    """One of VERDICTS, and the reason for it."""

    word: str
    reason: str

    @property
    def agrees(self) -> bool:
        """Whether the estimate agrees with the claim."""
        return self.word == AGREES

    def __str__(self) -> str:
        return f"{self.word}: {self.reason}"


@dataclass(frozen=True)
class Allowed:
    """The values that a claim allows: those from one end to the other. open_lower, open_upper: without this end."""

    lower: float = -math.inf
    upper: float = math.inf
    open_lower: bool = False
    open_upper: bool = False

    def holds(self, value: float) -> bool:
        """Whether the claim allows a value."""
        above = value > self.lower if self.open_lower else value >= self.lower
        return above and (value < self.upper if self.open_upper else value <= self.upper)

    def meets(self, own: Interval) -> bool:
        """Whether the claim allows a value of an interval."""
        above = own.upper > self.lower if self.open_lower else own.upper >= self.lower
        return above and (own.lower < self.upper if self.open_upper else own.lower <= self.upper)


def judge(
    estimate: Estimate | None,
    claim: Allowed | Estimate,
    by: Sequence[str] = INTERVALS,
    widest: float = math.inf,
) -> Verdict:
    """The verdict on a claim by an estimate; None: there is none.

    by: the intervals of INTERVALS that decide; widest: the largest factor between the ends of one that says anything.

    The claim that a value lies in a range holds if the whole interval does, and not if none of it does; without an
    interval the value decides. Fewer than FEWEST_REPEATS decide nothing, nor does what is NaN. A repeat that failed is
    a miss.
    The claim of another value, with its own interval, agrees if each value lies within the interval of the other, or
    the estimate within that of the claim, as where the interval of the estimate lacks a part; it differs if the
    intervals are apart. Where only one has an interval, this decides; not with `widest`, by which an interval that is
    not known is too wide. Of several motions that last, all values must be within the interval of the claim.
    """
    if estimate is None:
        return Verdict(OPEN, NOT_RUN)
    if estimate.of is not None and estimate.of < FEWEST_REPEATS:
        return Verdict(OPEN, TOO_FEW)
    failed = f"{estimate.failed} of {estimate.of} repeats failed"
    if estimate.failed and estimate.failed == estimate.of:
        return Verdict(DIFFERS, failed)
    found = _of_range(estimate, claim, by) if isinstance(claim, Allowed) else _of_value(estimate, claim, by, widest)
    return Verdict(OPEN, failed) if found.agrees and estimate.failed else found


def _of_range(estimate: Estimate, claim: Allowed, by: Sequence[str]) -> Verdict:
    own = estimate.hull(by)
    if any(map(math.isnan, (own.lower, own.upper, claim.lower, claim.upper))):
        return Verdict(OPEN, NO_INTERVAL)
    if claim.holds(own.lower) and claim.holds(own.upper):
        return Verdict(AGREES, WITHIN)
    if not claim.meets(own):
        return Verdict(DIFFERS, BEYOND)
    return Verdict(OPEN, TOO_WIDE if own.upper - own.lower > claim.upper - claim.lower else UNDECIDED)


def _of_value(estimate: Estimate, claim: Estimate, by: Sequence[str], widest: float) -> Verdict:
    names = (estimate.how or "estimated", claim.how or "claimed")
    known = [any(name in by for name in each.intervals) for each in (estimate, claim)]
    own, other = estimate.hull(by), claim.hull(by)
    numbers = (estimate.value, own.lower, own.upper, claim.value, other.lower, other.upper)
    needed = all if math.isfinite(widest) or estimate.motions else any
    if not needed(known) or any(map(math.isnan, numbers)):
        return Verdict(OPEN, _several(estimate) if estimate.motions else NO_INTERVAL)
    if estimate.motions:
        # The interval about their mean need not hold them.
        own = Interval(min(own.lower, *estimate.motions), max(own.upper, *estimate.motions))
    if not own.meets(other):
        told = APART if estimate.motions else _ratio(names[0], estimate.value, own, claim.value, other)
        return Verdict(DIFFERS, told)
    for name, each in zip(names, (own, other), strict=True):
        if math.isfinite(widest) and not 0 < each.upper <= widest * each.lower:
            spans = "reaches to zero" if each.lower <= 0 else f"spans more than a factor of {widest:g}"
            return Verdict(OPEN, f"the {name} interval {spans}")
    inside = [own.holds(claim.value), all(map(other.holds, estimate.values))]
    if estimate.motions and not inside[1]:
        return Verdict(OPEN, _several(estimate))
    if all(known) and all(inside):
        return Verdict(AGREES, BOTH)
    if inside[1] and known[1]:
        return Verdict(AGREES, f"within the {names[1]} interval only")
    if not known[1] and inside[0]:
        return Verdict(AGREES, f"within the {names[0]} interval")
    return Verdict(OPEN, CROSSING)


def _several(estimate: Estimate) -> str:
    return f"several motions last: {' or '.join(f'{value:.3g} {estimate.unit}' for value in estimate.values)}"


def _ratio(name: str, value: float, own: Interval, claimed: float, other: Interval) -> str:
    """How far two values are apart, in words: by a factor, or beyond the interval where one is not in (0, inf)."""
    if min(own.lower, other.lower, value, claimed) <= 0 or math.inf in (own.upper, other.upper, value, claimed):
        return APART
    factor, low, high = value / claimed, own.lower / other.upper, own.upper / other.lower
    if factor > 1:
        return f"{name} {factor:.2g} times more ({low:.2g} to {high:.2g})"
    return f"{name} {1 / factor:.2g} times less ({1 / high:.2g} to {1 / low:.2g})"


def judge_all(verdicts: Iterable[Verdict]) -> Verdict:
    """The verdict on what rests on several claims: that of the first that differs, or else is open, or else agrees.

    So it is only as sure as the least sure of them; without any, it is open.
    """
    order = (DIFFERS, OPEN, AGREES)
    return min(verdicts, key=lambda verdict: order.index(verdict.word), default=Verdict(OPEN, NOT_RUN))
