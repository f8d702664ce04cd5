"""Measures of the difference between a roll-out and a simulation, or between two simulations."""

import numpy as np

# A mean square speed over that of the simulation, above which a roll-out runs away.
RUNAWAY = 2.0
# What sums of equal numbers differ by, over these numbers.
ROUNDING = 1e-9


def position_error(position: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Mean over balls of the squared distance, Eq. 6.33: (frames, batch, balls, 3) twice to (frames, batch) [m2].

    The thesis prints a mean of squared norms, so axes are summed and not averaged.
    """
    return ((position - truth) ** 2).sum(axis=-1).mean(axis=-1)


def centroid_error(truth: np.ndarray) -> np.ndarray:
    """Error of a roll-out that puts every ball at the centre of mass, (frames, batch) [m2]: a mark for blurring."""
    return position_error(truth.mean(axis=2, keepdims=True), truth)


def plateau(error: np.ndarray) -> float:
    """Mean of the second half of the frames, over the batch; infinite where the roll-out is not finite."""
    value = error[len(error) // 2 :].mean()
    return float(value) if np.isfinite(value) else np.inf


def horizon(time_s: np.ndarray, error: np.ndarray, bound: float) -> float:
    """First time at which the error, averaged over the batch, exceeds `bound` [s]; the last time if it never does."""
    over = ~(error.mean(axis=1) <= bound)
    return float(time_s[np.argmax(over)] if over.any() else time_s[-1])


def growth_time(time_s: np.ndarray, error: np.ndarray, low: float, high: float) -> float:
    """Time in which the error, averaged over the batch, grows from `low` to `high` [s]; nan where it never does."""
    mean = error.mean(axis=1)
    if not (mean > high).any():
        return np.nan
    return horizon(time_s, error, high) - horizon(time_s, error, low)


def relative_error_percent(cumulative: np.ndarray, truth: np.ndarray) -> float:
    """Relative error of the cumulative dissipation at the end, summed over the batch, (frames, batch) twice [%]."""
    value = 100 * abs(cumulative[-1].sum() / truth[-1].sum() - 1)
    return float(value) if np.isfinite(value) else np.inf


def correlation(first: np.ndarray, second: np.ndarray) -> float:
    """Pearson's r of two arrays of one shape; not a number where either is constant to rounding or not finite."""
    first, second = first.ravel(), second.ravel()
    if len(first) < 3 or not (np.isfinite(first).all() and np.isfinite(second).all()):
        return np.nan
    if any(np.ptp(values) <= ROUNDING * np.abs(values).max() for values in (first, second)):
        return np.nan
    return float(np.corrcoef(first, second)[0, 1])


def increments(cumulative: np.ndarray, frames: int) -> np.ndarray:
    """Differences of a cumulative curve over every `frames` frames, (n, batch)."""
    return np.diff(cumulative[::frames], axis=0)


def distribution_distance(first: np.ndarray, second: np.ndarray) -> float:
    """Wasserstein distance of two samples, in their unit; infinite if the first holds anything not finite."""
    if not np.isfinite(first).all():
        return np.inf
    # Slow to import, and claims and figures import this module.
    from scipy.stats import wasserstein_distance

    return float(wasserstein_distance(first.ravel(), second.ravel()))


def highest_lift(position_m: np.ndarray) -> float:
    """How far any ball rises over where it started, (frames, batch, balls, 3) to [m]; infinite if not finite."""
    rise = (position_m[..., 2] - position_m[0, ..., 2]).max()
    return float(rise) if np.isfinite(rise) else np.inf


def explained_share(predicted: np.ndarray, truth: np.ndarray) -> float:
    """1 - residual over total sum of squares (R2) of all components together."""
    spread = ((truth - truth.mean()) ** 2).sum()
    return float(1 - ((predicted - truth) ** 2).sum() / spread) if spread > 0 else np.nan
