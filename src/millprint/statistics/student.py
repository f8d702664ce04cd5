"""The uncertainty of the mean of a few repeats, such as trainings or seeds, and of a value that was found once."""

from collections.abc import Sequence

import numpy as np

from millprint.statistics.quantiles import student_quantile

LEVEL = 0.95
# With fewer repeats the spread is hardly known: an interval of their mean may have any size, and decides nothing.
FEWEST_REPEATS = 5


def spread_of(values: Sequence[float], level: float = LEVEL) -> tuple[float, float]:
    """The interval of the mean of repeats: Student's, mean +- t(n - 1) s / sqrt(n), widened to include all repeats.

    With fewer than FEWEST_REPEATS, only the lowest and the highest. Repeats that are not finite, as of a roll-out that
    diverges, make the upper end infinite. Raises ValueError for fewer than two.
    """
    found = _several(values)
    known = found[np.isfinite(found)]
    if len(known) < len(found):
        return (float(known.min()) if len(known) else np.inf), np.inf
    low, high = float(known.min()), float(known.max())
    if len(known) < FEWEST_REPEATS:
        return low, high
    reach = student_quantile((1 + level) / 2, len(known) - 1) * known.std(ddof=1) / np.sqrt(len(known))
    return min(low, float(known.mean() - reach)), max(high, float(known.mean() + reach))


def once(value: float, values: Sequence[float]) -> tuple[float, float]:
    """The range of a value that was found once, if it scatters like these repeats of something similar: +- `apart`.

    The range of a value that is not negative ends at 0. Raises ValueError for fewer than two repeats.
    """
    found, reach = _several(values), apart(values)
    lowest = 0.0 if value >= 0 and (found >= 0).all() else -np.inf
    return (max(lowest, value - reach) if np.isfinite(value) else lowest), value + reach


def apart(values: Sequence[float]) -> float:
    """The largest difference between two of the values; infinite if some are infinite and others not."""
    found = np.asarray(values, dtype=float)
    with np.errstate(invalid="ignore"):
        return float(np.nanmax(found) - np.nanmin(found)) if np.isfinite(found).any() else 0.0


def _several(values: Sequence[float]) -> np.ndarray:
    if len(values) < 2:
        raise ValueError("an interval needs two repeats or more")
    return np.asarray(values, dtype=float)
