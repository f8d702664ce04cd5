"""Evaluation of held-out predictions: metrics with intervals and their spread over repeats, and coverage."""

import numpy as np
import pandas as pd
from statsmodels.stats.proportion import proportion_confint

from millprint.config.yields import EvaluationConfig
from millprint.thesis.yields.metrics import METRICS, SPREAD, YieldWeights, bootstrap_metrics, metrics, spread
from millprint.thesis.yields.schemes import RANDOM

KEYS = ["model", "strategy", "scheme"]


def _over_splits(rows: pd.DataFrame, weigh: YieldWeights, level: float) -> pd.DataFrame:
    """Each metric over random splits: the median, the ends of the central range of a level, and SPREAD."""
    scores = pd.DataFrame(
        metrics(part["yield_percent"].to_numpy(float), part["predicted_percent"].to_numpy(float), weigh)
        for _, part in rows.groupby("repeat")
    )
    ends = scores.quantile([0.5, (1 - level) / 2, 1 - (1 - level) / 2]).set_axis(["value", "lower", "upper"])
    return pd.DataFrame({"metric": name, "error": np.nan, **ends[name], **spread(scores[name])} for name in METRICS)


def score_table(held_out: pd.DataFrame, weigh: YieldWeights, budget: EvaluationConfig) -> pd.DataFrame:
    """Metrics by model, strategy and scheme: columns KEYS, metric, value, error, lower, upper, SPREAD.

    held_out: KEYS, repeat, case, yield_percent, predicted_percent. For random splits the value is the median over the
    repeats and the interval their central range. For the others the error is a jackknife and the interval a bootstrap
    over cases; with several repeats of a cross-validation a metric is averaged over them, within each resample too.
    SPREAD is that of the metric over the repeats.
    """
    tables = []
    for keys, rows in held_out.groupby(KEYS, sort=False):
        about = dict(zip(KEYS, keys, strict=True))
        if about["scheme"] == RANDOM:
            table = _over_splits(rows, weigh, budget.level)
        else:
            wide = rows.pivot(index="repeat", columns="case", values=["yield_percent", "predicted_percent"])
            truth, predicted = wide["yield_percent"].to_numpy(), wide["predicted_percent"].to_numpy()
            table = bootstrap_metrics(truth, predicted, weigh, budget.resamples, budget.level, budget.seed)
        tables.append(table.assign(**about))
    return pd.concat(tables, ignore_index=True)[[*KEYS, "metric", "value", "error", "lower", "upper", *SPREAD]]


def coverage_table(intervals: pd.DataFrame, level: float) -> pd.DataFrame:
    """Coverage and mean width of predictive intervals by model, strategy, scheme, method and nominal level.

    intervals: KEYS, repeat, method, nominal, case, yield_percent, lower_percent, upper_percent. Columns: ..., nominal,
    covered [-] with its Clopper-Pearson interval of `level`, width_pp, cases, and SPREAD of the share over the repeats.
    Predictions of one case in several repeats are not independent, so the interval counts cases and not predictions.
    """
    found = []
    for keys, rows in intervals.groupby([*KEYS, "method", "nominal"], sort=False):
        inside = rows["yield_percent"].between(rows["lower_percent"], rows["upper_percent"])
        covered, repeats = float(inside.mean()), inside.groupby(rows["repeat"]).mean()
        cases = rows["case"].nunique()
        lower, upper = proportion_confint(covered * cases, cases, alpha=1 - level, method="beta")
        width = float((rows["upper_percent"] - rows["lower_percent"]).mean())
        found.append((*keys, covered, lower, upper, width, cases, *spread(repeats).values()))
    columns = [*KEYS, "method", "nominal", "covered", "lower", "upper", "width_pp", "cases", *SPREAD]
    return pd.DataFrame(found, columns=columns)


def time_variance(time_h: np.ndarray, yields: np.ndarray) -> pd.DataFrame:
    """Share of the yield's variance that time alone explains: columns measure, share [-].

    time_h, yields: (n,) [h] and [%]. `levels`: sum of squares between the times over the total sum of squares, the most
    that any function of time can explain; `line`: R2 of a straight line.
    """
    frame = pd.DataFrame({"time": time_h, "yield": yields})
    means = frame.groupby("time")["yield"].transform("mean")
    total = ((frame["yield"] - frame["yield"].mean()) ** 2).sum()
    between = ((means - frame["yield"].mean()) ** 2).sum()
    line = np.corrcoef(frame["time"], frame["yield"])[0, 1] ** 2
    return pd.DataFrame({"measure": ["levels", "line"], "share": [between / total, line]})
