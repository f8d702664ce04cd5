"""What a few repeats, such as trainings or seeds, say of their mean, and of a value that was found once."""

from collections.abc import Callable, Sequence

import numpy as np

from millprint.quantiles import student_quantile

LEVEL = 0.95


def student(values: Sequence[float], level: float = LEVEL) -> tuple[float, float]:
    """Student's interval of the mean of a few repeats; on logarithms where every value is positive.

    mean +- t(n - 1) s / sqrt(n). Repeats that are not finite, as of a roll-out that runs away, open the upper end.
    Raises ValueError for fewer than two.
    """
    found = _several(values)
    known = found[np.isfinite(found)]
    if len(known) < len(found):
        return (float(known.min()) if len(known) else np.inf), np.inf
    scaled, back = _scaled(known)
    reach = student_quantile((1 + level) / 2, len(known) - 1) * scaled.std(ddof=1) / np.sqrt(len(known))
    # A logarithm is rounded: repeats that agree to the last bit are inside all the same.
    low, high = (float(back(scaled.mean() + sign * reach)) for sign in (-1, 1))
    return min(low, float(known.min())), max(high, float(known.max()))


def once(value: float, values: Sequence[float], level: float = LEVEL) -> tuple[float, float]:
    """The interval of a value that was found once, if it scatters as these repeats of something alike.

    value +- t(n - 1) s, as a factor where all are positive. Raises ValueError for fewer than two repeats.
    """
    found = _several(values)
    if not (np.isfinite(found).all() and np.isfinite(value)):
        return (0.0 if value > 0 and (found > 0).all() else -np.inf), np.inf
    scaled, back = _scaled(np.append(found, value))
    reach = student_quantile((1 + level) / 2, len(found) - 1) * scaled[:-1].std(ddof=1)
    low, high = (float(back(scaled[-1] + sign * reach)) for sign in (-1, 1))
    return min(low, value), max(high, value)


def apart(values: Sequence[float]) -> float:
    """The largest difference between two of the values; infinite if some are infinite and others not."""
    found = np.asarray(values, dtype=float)
    with np.errstate(invalid="ignore"):
        return float(np.nanmax(found) - np.nanmin(found)) if np.isfinite(found).any() else 0.0


def _several(values: Sequence[float]) -> np.ndarray:
    if len(values) < 2:
        raise ValueError("an interval needs two repeats or more")
    return np.asarray(values, dtype=float)


def _scaled(values: np.ndarray) -> tuple[np.ndarray, Callable[[float], float]]:
    """The values on the scale on which they scatter evenly, and the way back."""
    return (np.log(values), np.exp) if (values > 0).all() else (values, float)
