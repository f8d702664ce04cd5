"""Judging predictions: metrics with bootstrap intervals, and how often predictive intervals hold."""

import numpy as np
import pandas as pd
from scipy.stats import norm

from millprint.predict.metrics import METRICS, YieldWeights, metrics


def bootstrap_metrics(
    truth: np.ndarray, predicted: np.ndarray, weigh: YieldWeights, resamples: int, level: float, seed: int
) -> pd.DataFrame:
    """Each metric with its percentile interval over resampled rows: columns metric, value, lower, upper.

    truth, predicted: (n,) yields [%]. The models are not fitted again, so the interval tells how far the figure hangs
    on which rows it was taken over. Resamples in which a metric is not defined (all yields equal) are left out.
    """
    generator = np.random.default_rng(seed)
    drawn = generator.integers(len(truth), size=(resamples, len(truth)))
    values = metrics(truth, predicted, weigh)
    spread = metrics(truth[drawn], predicted[drawn], weigh)
    tail = (1 - level) / 2
    rows = []
    for name in METRICS:
        lower, upper = np.nanquantile(spread[name], [tail, 1 - tail])
        rows.append({"metric": name, "value": float(values[name]), "lower": lower, "upper": upper})
    return pd.DataFrame(rows)


def half_width(deviation: np.ndarray, level: float) -> np.ndarray:
    """Half width of the central normal interval of a level, for standard deviations (n,)."""
    return norm.ppf(0.5 + level / 2) * deviation


def coverage(truth: np.ndarray, predicted: np.ndarray, deviation: np.ndarray, nominal: list[float]) -> pd.DataFrame:
    """How many measurements their predictive intervals hold: columns nominal, covered [-], width_pp (mean)."""
    rows = []
    for level in nominal:
        half = half_width(deviation, level)
        rows.append(
            {
                "nominal": level,
                "covered": float(np.mean(np.abs(truth - predicted) <= half)),
                "width_pp": float(np.mean(2 * half)),
            }
        )
    return pd.DataFrame(rows)


def time_variance(time_h: np.ndarray, yields: np.ndarray) -> pd.DataFrame:
    """Share of the yield's variance that time alone explains: columns measure, share [-].

    `levels`: sum of squares between the times over the total, the most that any function of time can explain;
    `line`: R2 of a straight line.
    """
    frame = pd.DataFrame({"time": time_h, "yield": yields})
    means = frame.groupby("time")["yield"].transform("mean")
    total = ((frame["yield"] - frame["yield"].mean()) ** 2).sum()
    between = ((means - frame["yield"].mean()) ** 2).sum()
    line = np.corrcoef(frame["time"], frame["yield"])[0, 1] ** 2
    return pd.DataFrame({"measure": ["levels", "line"], "share": [between / total, line]})
