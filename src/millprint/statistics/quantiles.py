"""Quantiles, tails and densities of the normal, Student's t, F and chi-squared distributions; none has a unit.

The numbers equal scipy.stats to the last bit, which calls the same functions of scipy.special. Importing scipy.stats
would take about a second in every job of the workflow.
Arguments may be numbers or arrays, which are broadcast. A share outside 0 to 1 gives NaN, and so do degrees of freedom
that are not positive; Student's quantiles need a share between 0 and 1, both excluded.

`<law>_quantile(share)` is the value below which a share lies, `<law>_exceeded(chance)` the value that is exceeded with
a chance, `<law>_below(value)` and `<law>_above(value)` the chance of less and of more than a value. With them, the
uncertainty of the mean of a few repeats, such as trainings or seeds, and of a value that was found once.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import chdtrc, chdtri, fdtrc, fdtri, gammaincinv, ndtr, ndtri, stdtr, stdtrit

ROOT_TWO_PI = np.sqrt(2 * np.pi)


def normal_quantile(share: ArrayLike) -> Any:
    """The standard normal value below which a share [0 to 1] lies."""
    return ndtri(np.asarray(share))


def normal_exceeded(chance: ArrayLike) -> Any:
    """The standard normal value that is exceeded with a chance."""
    return 0.0 - ndtri(np.asarray(chance))


def normal_below(value: ArrayLike) -> Any:
    """The chance of less than a value of the standard normal distribution."""
    return ndtr(np.asarray(value))


def normal_density(value: ArrayLike, mean: ArrayLike = 0.0, deviation: ArrayLike = 1.0) -> Any:
    """The density at a value of a normal distribution, in one over the value's unit."""
    scaled = (np.asarray(value) - np.asarray(mean)) / np.asarray(deviation)
    return np.exp(-(scaled**2) / 2.0) / ROOT_TWO_PI / np.asarray(deviation)


def normal_log_density(value: ArrayLike, mean: ArrayLike = 0.0, deviation: ArrayLike = 1.0) -> Any:
    """The natural logarithm of `normal_density`."""
    scaled = (np.asarray(value) - np.asarray(mean)) / np.asarray(deviation)
    return -(scaled**2) / 2.0 - np.log(ROOT_TWO_PI) - np.log(deviation)


def student_quantile(share: ArrayLike, freedom: ArrayLike) -> Any:
    """The value of Student's t with `freedom` degrees of freedom below which a share lies."""
    return stdtrit(np.asarray(freedom), np.asarray(share))


def student_exceeded(chance: ArrayLike, freedom: ArrayLike) -> Any:
    """The value of Student's t that is exceeded with a chance."""
    return 0.0 - stdtrit(np.asarray(freedom), np.asarray(chance))


def student_above(value: ArrayLike, freedom: ArrayLike) -> Any:
    """The chance of more than a value of Student's t."""
    return stdtr(np.asarray(freedom), -np.asarray(value))


def f_quantile(share: ArrayLike, own: ArrayLike, residual: ArrayLike) -> Any:
    """The value of F below which a share lies; own, residual: degrees of freedom of its numerator and denominator."""
    return fdtri(np.asarray(own), np.asarray(residual), np.asarray(share))


def f_exceeded(chance: ArrayLike, own: ArrayLike, residual: ArrayLike) -> Any:
    """The value of F that is exceeded with a chance."""
    return f_quantile(1.0 - np.asarray(chance), own, residual)


def f_above(value: ArrayLike, own: ArrayLike, residual: ArrayLike) -> Any:
    """The chance of more than a value of F."""
    return fdtrc(np.asarray(own), np.asarray(residual), _in_support(value))


def chi_squared_quantile(share: ArrayLike, freedom: ArrayLike) -> Any:
    """The value of chi squared with `freedom` degrees of freedom below which a share lies."""
    return 2 * gammaincinv(_positive(freedom) / 2, np.asarray(share))


def chi_squared_exceeded(chance: ArrayLike, freedom: ArrayLike) -> Any:
    """The value of chi squared that is exceeded with a chance."""
    return chdtri(_positive(freedom), np.asarray(chance))


def chi_squared_above(value: ArrayLike, freedom: ArrayLike) -> Any:
    """The chance of more than a value of chi squared."""
    return chdtrc(_positive(freedom), _in_support(value))


def _positive(freedom: ArrayLike) -> np.ndarray:
    """Degrees of freedom, NaN where not positive: scipy.special treats 0 as a distribution that is always 0."""
    known = np.asarray(freedom)
    return np.where(known > 0, known, np.nan)


def _in_support(value: ArrayLike) -> np.ndarray:
    """The value of a distribution that is never negative: rounding may bring it below 0, where scipy.special fails."""
    return np.maximum(value, 0.0)


LEVEL = 0.95
# With fewer repeats the spread is hardly known: an interval of their mean may have any size, and decides nothing.
FEWEST_REPEATS = 5


def spread_of(values: Sequence[float], level: float = LEVEL) -> tuple[float, float]:
    """The interval of the mean of repeats: Student's, mean +- t(n - 1) s / sqrt(n), widened to include all repeats.

    With fewer than FEWEST_REPEATS, only the lowest and the highest. Repeats that are not finite, as of a roll-out that
    diverges, make the upper end infinite. Raises ValueError for fewer than two.
    """
    found = _at_least_two(values)
    known = found[np.isfinite(found)]
    if len(known) < len(found):
        return (float(known.min()) if len(known) else np.inf), np.inf
    low, high = float(known.min()), float(known.max())
    if len(known) < FEWEST_REPEATS:
        return low, high
    reach = student_quantile((1 + level) / 2, len(known) - 1) * known.std(ddof=1) / np.sqrt(len(known))
    return min(low, float(known.mean() - reach)), max(high, float(known.mean() + reach))


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
