"""Judging predictions: metrics with bootstrap intervals, and what time alone explains."""

import numpy as np
import pandas as pd
from scipy.stats import norm

from millprint.predict.metrics import METRICS, YieldWeights, metrics


def bootstrap_metrics(
    truth: np.ndarray, predicted: np.ndarray, weigh: YieldWeights, resamples: int, level: float, seed: int
) -> pd.DataFrame:
    """Each metric with its percentile interval over resampled cases: columns metric, value, lower, upper.

    truth, predicted: (cases,) yields [%], or (repeats, cases), over whose repeats a metric is averaged, each resample
    taking the same cases in all. The models are not fitted again, so the interval tells how far the figure hangs on
    which cases it was taken over. Resamples in which a metric is not defined (all yields equal) are left out.
    """
    truth, predicted = np.atleast_2d(truth), np.atleast_2d(predicted)
    cases = truth.shape[1]
    drawn = np.random.default_rng(seed).integers(cases, size=(resamples, cases))
    values = metrics(truth, predicted, weigh)
    # A repeat at a time: all at once would take gigabytes.
    spread = [metrics(one[drawn], other[drawn], weigh) for one, other in zip(truth, predicted, strict=True)]
    tail = (1 - level) / 2
    rows = []
    for name in METRICS:
        lower, upper = np.nanquantile(np.mean(np.stack([part[name] for part in spread]), axis=0), [tail, 1 - tail])
        rows.append({"metric": name, "value": float(np.mean(values[name])), "lower": lower, "upper": upper})
    return pd.DataFrame(rows)


def half_width(deviation: np.ndarray, level: float) -> np.ndarray:
    """Half width of the central normal interval of a level, for standard deviations (n,)."""
    return norm.ppf(0.5 + level / 2) * deviation


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
