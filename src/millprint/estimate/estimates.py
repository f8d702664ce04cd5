"""A number with its intervals, each named by what it holds: sums, parts and ratios, and repeats."""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from pydantic import Field
from pydantic.json_schema import SkipJsonSchema

from millprint.estimate.quantiles import student_quantile

LEVEL = 0.95
# With fewer repeats the spread is hardly known: an interval of their mean may have any size, and decides nothing.
FEWEST_REPEATS = 5
# An interval whose ends are farther apart than this factor says nothing: they count as not known.
WIDEST = 10.0
ENDS = ("lower", "upper")
# The intervals of an Estimate, which are fields of it.
INTERVALS = ("scatter", "mean", "contact", "shape", "repeats")
# A field that no file has: pydantic leaves it out.
NOT_WRITTEN = Field(exclude=True)


@dataclass(frozen=True)
class Interval:
    """The two ends of an interval."""

    lower: float
    """lower end, in the unit of the value"""
    upper: float
    """upper end, in the unit of the value"""

    def holds(self, value: float) -> bool:
        """Whether a value lies between the ends."""
        return bool(self.lower <= value <= self.upper)

    def meets(self, other: "Interval") -> bool:
        """Whether two intervals have a value in common."""
        return bool(self.lower <= other.upper and other.lower <= self.upper)


@dataclass(frozen=True)
class Estimate:
    """A number with its unit and its intervals, which are given separately and not added up."""

    value: float
    """the value, in `unit`"""
    unit: str
    """unit; "-" for a plain number"""
    scatter: Interval | None = None
    """band of a new simulation: contains one more, of the recorded time, with `fingerprint.probability`"""
    mean: Interval | None = None
    """band of the mean: contains the mean of very many simulations with `fingerprint.probability`"""
    contact: Interval | None = None
    """interval by contact parameters: restitution, frictions and stiffness that nobody has measured"""
    shape: Interval | None = None
    """interval by the shape of the jar, where it was fitted"""
    motions: tuple[float, ...] | None = None
    """the value of each of the motions that last, that of most simulations first, where `value` is a mean over several
    of them, which no simulation has
    """
    repeats: Annotated[SkipJsonSchema[Interval | None], NOT_WRITTEN] = None
    """interval by repeats of a measurement, a training or a simulation"""
    how: Annotated[SkipJsonSchema[str | None], NOT_WRITTEN] = None
    """how it was made, such as measured or predicted"""
    of: Annotated[SkipJsonSchema[int | None], NOT_WRITTEN] = None
    """number of repeats that it was made of"""
    failed: Annotated[SkipJsonSchema[int | None], NOT_WRITTEN] = None
    """number of these that failed, and are not in the interval"""

    @property
    def intervals(self) -> dict[str, Interval]:
        """The known intervals by name."""
        return {name: known for name in INTERVALS if (known := getattr(self, name)) is not None}

    @property
    def values(self) -> tuple[float, ...]:
        """The values that one simulation may have: that of each motion that lasts, or else the only one."""
        return self.motions or (self.value,)

    def having(self, known: Mapping[str, Interval]) -> "Estimate":
        """The estimate with these of INTERVALS, by name, in place of its own."""
        fields: dict[str, Any] = dict(known)
        return replace(self, **fields)

    def ends(self, name: str) -> tuple[float, float]:
        """The ends of one of INTERVALS; NaN where it is not known. Raises KeyError for another name."""
        if name not in INTERVALS:
            raise KeyError(name)
        known = self.intervals.get(name)
        return (known.lower, known.upper) if known else (math.nan, math.nan)

    @property
    def lower(self) -> float:
        """Lower end of the band of a new simulation; NaN if it is not known."""
        return self.ends("scatter")[0]

    @property
    def upper(self) -> float:
        """Upper end of the band of a new simulation; NaN if it is not known."""
        return self.ends("scatter")[1]

    def hull(self, names: Sequence[str] = INTERVALS) -> Interval:
        """The smallest interval that holds those of the names that are known; without any, only the value."""
        known = [interval for name, interval in self.intervals.items() if name in names]
        known = known or [Interval(self.value, self.value)]
        return Interval(min(each.lower for each in known), max(each.upper for each in known))

    def together(self, least: float = -math.inf) -> Interval:
        """The known intervals as one, if they are independent: their distances from the value, added in squares.

        least: the smallest possible value of the quantity, where the interval is cut off.
        """
        known = self.intervals.values()
        low = math.hypot(*(self.value - each.lower for each in known))
        high = math.hypot(*(each.upper - self.value for each in known))
        return Interval(_not_below(self.value - low, self.value, least), self.value + high)

    def through(self, rising: Callable[[float], float], unit: str | None = None) -> "Estimate":
        """The estimate of a rising function of the value, from the function at the ends; unit: of its values."""
        ends = {name: Interval(rising(own.lower), rising(own.upper)) for name, own in self.intervals.items()}
        motions = self.motions and tuple(map(rising, self.motions))
        return replace(self, value=rising(self.value), unit=unit or self.unit, motions=motions).having(ends)

    def __mul__(self, factor: float) -> "Estimate":
        """The estimate times a positive number."""
        return self.through(lambda end: end * factor)

    def columns(self, name: str, of: str = "scatter") -> dict[str, float]:
        """The columns of a table for the value, as NAME, and for one of its intervals."""
        return {name: self.value, **dict(zip(columns_of(name, of), self.ends(of), strict=True))}

    def __str__(self) -> str:
        """Three digits of what one simulation may have, with the ends of the hull, if one is known, and the unit."""
        hull, values = self.hull(), " or ".join(f"{value:.3g}" for value in self.values)
        return (
            f"{values} ({hull.lower:.3g} to {hull.upper:.3g}) {self.unit}"
            if self.intervals
            else f"{values} {self.unit}"
        )


def columns_of(name: str, interval: str) -> list[str]:
    """The columns of a table for the two ends of one of INTERVALS of a quantity."""
    between = {"scatter": "", "mean": "_mean"}.get(interval, f"_by_{interval}")
    return [f"{name}{between}_{end}" for end in ENDS]


def total(parts: Sequence[Estimate]) -> Estimate:
    """The sum of parts of one unit. The ends add up too: so the interval holds however the parts depend on each other.

    An interval that one of the parts lacks is not known of the sum.
    """
    shared = set.intersection(*(set(part.intervals) for part in parts))
    ends = {
        name: Interval(*(sum(part.ends(name)[end] for part in parts) for end in (0, 1)))
        for name in INTERVALS
        if name in shared
    }
    return Estimate(sum(part.value for part in parts), parts[0].unit).having(ends)


def parts_of(whole: Estimate, parts: Mapping[str, Estimate]) -> dict[str, Estimate]:
    """Parts that add up to a whole and are never negative, with intervals that say no more than the whole allows.

    A part is at most the upper end of the whole less the lower ends of the other parts (0 if not known), and at least
    the lower end of the whole less their upper ends. Its value stays inside. Raises ValueError for values that do not
    add up to the whole.
    """
    if not math.isclose(total(list(parts.values())).value, whole.value, rel_tol=1e-6):
        raise ValueError(f"{', '.join(parts)} do not add up to the whole")
    found = {}
    for name, part in parts.items():
        others = [other for key, other in parts.items() if key != name]
        ends = {}
        for interval, own in part.intervals.items():
            if interval not in whole.intervals:
                continue
            lower, upper = whole.ends(interval)
            rest = [other.intervals.get(interval, Interval(0.0, math.inf)) for other in others]
            highest, lowest = upper - sum(each.lower for each in rest), lower - sum(each.upper for each in rest)
            ends[interval] = Interval(min(max(own.lower, lowest), part.value), max(min(own.upper, highest), part.value))
        found[name] = part.having(ends)
    return found


def ratio_of(one: Estimate, other: Estimate) -> Estimate:
    """one / other of two independent quantities with normal logarithms and intervals of the same probability.

    Variances of logarithms add up, and so do the squares of the distances from the value to an end:
    log(r_upper / r)^2 = log(one_upper / one)^2 + log(other / other_lower)^2, and the other way round for the lower end.
    An interval that one of the two lacks is not known.
    """
    value = one.value / other.value
    found = {}
    for name in one.intervals.keys() & other.intervals.keys():
        (low, high), (other_low, other_high) = one.ends(name), other.ends(name)
        below = np.hypot(np.log(one.value / low), np.log(other_high / other.value))
        above = np.hypot(np.log(high / one.value), np.log(other.value / other_low))
        found[name] = Interval(float(value * np.exp(-below)), float(value * np.exp(above)))
    return Estimate(value, "-").having(found)


def share_of(ratio: Estimate) -> Estimate:
    """The share of one part in two, r / (1 + r) [-]; it rises with the ratio r of that part to the other."""
    return ratio.through(lambda end: end / (1.0 + end))


def odds_of(share: Estimate) -> Estimate:
    """The ratio of a part to the other one, s / (1 - s) [-], of its share s in both: the inverse of `share_of`."""
    return share.through(lambda end: end / (1.0 - end) if end < 1 else math.inf)


def known_ends(logs: np.ndarray) -> np.ndarray:
    """Logarithms (2, ...) of the lower and the upper end over the value, NaN where the interval says nothing."""
    return np.where(logs[1] - logs[0] <= np.log(WIDEST), logs, np.nan)


def factor_of(half: np.ndarray | float) -> np.ndarray:
    """The factor from a value to the ends of its interval, from half the width in logarithms; NaN if not known."""
    half = np.asarray(half, dtype=float)
    return np.exp(known_ends(np.stack([-half, half]))[1])


def half_width(values: np.ndarray, level: float = LEVEL) -> Any:
    """Half of Student's interval of the mean of repeats, such as blocks of one run: t(n - 1) s / sqrt(n).

    values: (n, ...); NaN where one of them has no value, and for one repeat.
    """
    if len(values) < 2:
        return np.full(np.shape(values)[1:], np.nan)
    return student_quantile((1 + level) / 2, len(values) - 1) * np.std(values, axis=0, ddof=1) / np.sqrt(len(values))


def mean_of(
    values: Sequence[float] | np.ndarray, unit: str, level: float = LEVEL, least: float = -math.inf
) -> Estimate:
    """The mean of repeats (n,) with Student's interval, which one value does not have.

    least: the smallest possible value of the quantity, where the interval is cut off.
    """
    mean, half = float(np.mean(values)), float(half_width(np.asarray(values, dtype=float), level))
    known = {} if math.isnan(half) else {"repeats": Interval(_not_below(mean - half, mean, least), mean + half)}
    return Estimate(mean, unit, of=len(values)).having(known)


def _not_below(lower: float, value: float, least: float) -> float:
    """The lower end of an interval about a value, or `least` if that is higher; the value itself stays inside."""
    return max(lower, min(value, least))


def difference_of(one: np.ndarray, other: np.ndarray, unit: str) -> Estimate:
    """The difference of the means of two sets of blocks with Welch's interval (Biometrika 34 (1947) 28)."""
    squares = np.array([own.var(ddof=1) / len(own) for own in (one, other)])
    difference, half = float(one.mean() - other.mean()), 0.0
    if squares.sum():
        freedom = squares.sum() ** 2 / (squares**2 / [len(one) - 1, len(other) - 1]).sum()
        half = float(student_quantile((1 + LEVEL) / 2, freedom) * np.sqrt(squares.sum()))
    return Estimate(difference, unit, repeats=Interval(difference - half, difference + half), of=len(one) + len(other))


def spread_of(values: Sequence[float], level: float = LEVEL, one_more: bool = False) -> tuple[float, float]:
    """The interval of the mean of repeats: Student's, mean +- t(n - 1) s / sqrt(n), widened to include all repeats.

    one_more: the interval of another repeat instead, mean +- t(n - 1) s sqrt(1 + 1 / n): a printed number of one
    training or seed is to be compared with it. With fewer than FEWEST_REPEATS, only the lowest and the highest. Repeats
    that are not finite, as of a roll-out that diverges, make the upper end infinite. Raises ValueError for fewer than
    two.
    """
    found = _at_least_two(values)
    known = found[np.isfinite(found)]
    if len(known) < len(found):
        return (float(known.min()) if len(known) else np.inf), np.inf
    low, high = float(known.min()), float(known.max())
    if len(known) < FEWEST_REPEATS:
        return low, high
    mean, reach = known.mean(), half_width(known, level) * (np.sqrt(len(known) + 1) if one_more else 1.0)
    return min(low, float(mean - reach)), max(high, float(mean + reach))


def range_of_single(value: float, values: Sequence[float]) -> tuple[float, float]:
    """The range of a value that was found once, if it scatters like these repeats of something similar.

    It reaches as far to both sides as the largest difference between two repeats. The range of a value
    that is not negative ends at 0. Raises ValueError for fewer than two repeats.
    """
    found, reach = _at_least_two(values), largest_difference(values)
    lowest = 0.0 if value >= 0 and (found >= 0).all() else -np.inf
    return (max(lowest, value - reach) if np.isfinite(value) else lowest), value + reach


def largest_difference(values: Sequence[float]) -> float:
    """The largest difference between two of the values; infinite if some are infinite and others not."""
    found = np.asarray(values, dtype=float)
    with np.errstate(invalid="ignore"):
        return float(np.nanmax(found) - np.nanmin(found)) if np.isfinite(found).any() else 0.0


def _at_least_two(values: Sequence[float]) -> np.ndarray:
    if len(values) < 2:
        raise ValueError("an interval needs two repeats or more")
    return np.asarray(values, dtype=float)


def latin_hypercube(
    ranges: Mapping[str, tuple[float, float]], count: int, logarithmic: Collection[str] = ()
) -> dict[str, np.ndarray]:
    """Samples that fill ranges evenly (McKay, Beckman and Conover, Technometrics 21 (1979) 239): `count` of each name.

    Those of `logarithmic` are even in the logarithm. The same ranges always give the same samples.
    """
    # Slow to import, and who checks input imports this module.
    from scipy.stats import qmc

    cube = qmc.LatinHypercube(len(ranges), rng=np.random.default_rng(0)).random(count)
    return {
        name: low * (high / low) ** share if name in logarithmic else low + (high - low) * share
        for share, (name, (low, high)) in zip(cube.T, ranges.items(), strict=True)
    }
