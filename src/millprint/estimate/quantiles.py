"""Quantiles, tails and densities of the normal, Student's t, F and chi-squared distributions; none has a unit.

The numbers equal scipy.stats to the last bit, which calls the same functions of scipy.special. Importing scipy.stats
would take about a second in every job of the workflow.
Arguments may be numbers or arrays, which are broadcast. A share outside 0 to 1 gives NaN, and so do degrees of freedom
that are not positive; Student's quantiles need a share between 0 and 1, both excluded.

`<law>_quantile(share)` is the value below which a share lies, `<law>_exceeded(chance)` the value that is exceeded with
a chance, `<law>_below(value)` and `<law>_above(value)` the chance of less and of more than a value.
"""

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
