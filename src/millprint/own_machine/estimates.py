"""A number with its interval, the mean of a series in which neighbours resemble each other, and verdicts."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from millprint.statistics.quantiles import LEVEL, student_quantile

# Blocks of a series, each long against the time in which its values forget each other; 10 to 30 are usual (Schmeiser,
# Operations Research 30 (1982) 556).
BLOCKS = 10
# An interval that spans more than this factor decides nothing.
WIDEST = 10.0
AGREES, AGREES_HALF = "agrees within both intervals", "agrees within the measured interval only"
CANNOT = "cannot be told"


class Estimate(NamedTuple):
    """A value and the ends of its interval, in one unit."""

    value: float
    lower: float
    upper: float

    @property
    def too_wide(self) -> bool:
        """Whether the interval spans more than WIDEST, or holds 0."""
        return self.lower <= 0 or self.upper > WIDEST * self.lower

    def times(self, factor: float) -> "Estimate":
        """The estimate times a positive factor."""
        return Estimate(self.value * factor, self.lower * factor, self.upper * factor)

    def __str__(self) -> str:
        """Three digits, with the ends."""
        return f"{self.value:.3g} ({self.lower:.3g} to {self.upper:.3g})"


def block_means(time_s: np.ndarray, values: np.ndarray, blocks: int = BLOCKS) -> np.ndarray:
    """Means (blocks,) of a series over parts of equal time; a part without a reading raises ValueError."""
    edges = np.linspace(time_s[0], time_s[-1], blocks + 1)
    place = np.searchsorted(edges[1:-1], time_s, side="right")
    counts = np.bincount(place, minlength=blocks)
    if not counts.all():
        raise ValueError(f"a tenth of the time without a reading, from {edges[counts.argmin()]:g} s on")
    return np.bincount(place, weights=values, minlength=blocks) / counts


def difference_of(one: np.ndarray, other: np.ndarray, level: float = LEVEL) -> Estimate:
    """The difference of the means of two sets of blocks with Welch's interval (Biometrika 34 (1947) 28)."""
    squares = np.array([own.var(ddof=1) / len(own) for own in (one, other)])
    difference = float(one.mean() - other.mean())
    if not squares.sum():
        return Estimate(difference, difference, difference)
    freedom = squares.sum() ** 2 / (squares**2 / [len(one) - 1, len(other) - 1]).sum()
    half = float(student_quantile((1 + level) / 2, freedom) * np.sqrt(squares.sum()))
    return Estimate(difference, difference - half, difference + half)


def weighted_quantiles(values: np.ndarray, weights: np.ndarray, shares: Sequence[float]) -> np.ndarray:
    """Quantiles of weighted values (n,): the smallest value below which at least the share of the weight lies."""
    order = np.argsort(values)
    below = np.cumsum(weights[order]) / weights.sum()
    return values[order][np.searchsorted(below, np.asarray(shares) * (1 - 1e-12)).clip(0, len(values) - 1)]


def verdict_on(measured: Estimate, predicted: Estimate) -> str:
    """The verdict on a predicted number by a measured one.

    They agree if each value lies within the other's interval; within the measured interval only, if the predicted one
    lies only in that, as where the predicted interval lacks contact parameters; and differ if the intervals are apart.
    """
    for name, own in (("measured", measured), ("predicted", predicted)):
        if own.too_wide:
            return f"{CANNOT}: the {name} interval spans more than a factor of {WIDEST:g}"
    if measured.lower <= predicted.value <= measured.upper and predicted.lower <= measured.value <= predicted.upper:
        return AGREES
    if measured.lower <= predicted.value <= measured.upper:
        return AGREES_HALF
    if predicted.lower <= measured.upper and measured.lower <= predicted.upper:
        return f"{CANNOT}: the intervals overlap, but do not hold both values"
    ratio = Estimate(
        predicted.value / measured.value, predicted.lower / measured.upper, predicted.upper / measured.lower
    )
    if ratio.value > 1:
        return f"predicted {ratio.value:.2g} times more ({ratio.lower:.2g} to {ratio.upper:.2g})"
    return f"predicted {1 / ratio.value:.2g} times less ({1 / ratio.upper:.2g} to {1 / ratio.lower:.2g})"
