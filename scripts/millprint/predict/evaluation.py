"""Evaluation of held-out predictions: metrics with intervals, coverage, and the effect of the split."""

import numpy as np
import pandas as pd
from statsmodels.stats.proportion import proportion_confint

from millprint.config.yields import EvaluationConfig
from millprint.predict.metrics import GAINS, METRICS, YieldWeights, bootstrap_metrics, metrics
from millprint.predict.schemes import LOCKED_AGAIN, NESTED, RANDOM

KEYS = ["model", "strategy", "scheme"]


def _scores(rows: pd.DataFrame, weigh: YieldWeights) -> pd.DataFrame:
    """The metrics of the repeats, one row for each."""
    return pd.DataFrame(
        metrics(part["yield_percent"].to_numpy(float), part["predicted_percent"].to_numpy(float), weigh)
        for _, part in rows.groupby("repeat")
    )


def _central(scores: pd.Series, level: float) -> dict[str, float]:
    """Median of the repeats and the ends of their central range of a level."""
    lower, middle, upper = np.nanquantile(scores, [(1 - level) / 2, 0.5, 1 - (1 - level) / 2])
    return {"value": middle, "lower": lower, "upper": upper}


def score_table(held_out: pd.DataFrame, weigh: YieldWeights, budget: EvaluationConfig) -> pd.DataFrame:
    """Metrics by model, strategy and scheme: columns KEYS, metric, value, error, lower, upper.

    held_out: KEYS, repeat, case, yield_percent, predicted_percent. For random splits the value is the median over the
    repeats and the interval their central range. For the others the error is a jackknife and the interval a bootstrap
    over cases; with several repeats of a cross-validation a metric is averaged over them, within each resample too.
    """
    tables = []
    for keys, rows in held_out.groupby(KEYS, sort=False):
        about = dict(zip(KEYS, keys, strict=True))
        if about["scheme"] == RANDOM:
            scores = _scores(rows, weigh)
            table = pd.DataFrame(
                {"metric": name, "error": np.nan, **_central(scores[name], budget.level)} for name in METRICS
            )
        else:
            wide = rows.pivot(index="repeat", columns="case", values=["yield_percent", "predicted_percent"])
            truth, predicted = wide["yield_percent"].to_numpy(), wide["predicted_percent"].to_numpy()
            table = bootstrap_metrics(truth, predicted, weigh, budget.resamples, budget.level, budget.seed)
        tables.append(table.assign(**about))
    return pd.concat(tables, ignore_index=True)[[*KEYS, "metric", "value", "error", "lower", "upper"]]


def coverage_table(intervals: pd.DataFrame, level: float) -> pd.DataFrame:
    """Coverage and mean width of predictive intervals by model, strategy, scheme, method and nominal level.

    intervals: KEYS, method, nominal, case, yield_percent, lower_percent, upper_percent. Columns: ..., nominal,
    covered [-] with its Clopper-Pearson interval of `level`, width_pp, cases. Predictions of one case in several
    repeats are not independent, so the interval counts cases and not predictions.
    """
    found = []
    for keys, rows in intervals.groupby([*KEYS, "method", "nominal"], sort=False):
        covered = float(rows["yield_percent"].between(rows["lower_percent"], rows["upper_percent"]).mean())
        cases = rows["case"].nunique()
        lower, upper = proportion_confint(covered * cases, cases, alpha=1 - level, method="beta")
        width = float((rows["upper_percent"] - rows["lower_percent"]).mean())
        found.append((*keys, covered, lower, upper, width, cases))
    columns = [*KEYS, "method", "nominal", "covered", "lower", "upper", "width_pp", "cases"]
    return pd.DataFrame(found, columns=columns)


def split_luck(held_out: pd.DataFrame, weigh: YieldWeights, level: float) -> pd.DataFrame:
    """How favourable the locked split is for each model and metric, all at the same search budget.

    held_out: KEYS, repeat, yield_percent, predicted_percent. Columns: model, strategy, metric, locked, random_median,
    random_lower, random_upper, nested, worse_splits. worse_splits is the share of random splits with a worse metric
    than the locked one: 1 if the locked split is the most favourable, 0 if it is the least.
    """
    found = []
    for (model, strategy), rows in held_out.groupby(["model", "strategy"], sort=False):
        locked, random, nested = (
            _scores(rows[rows["scheme"] == scheme], weigh) for scheme in (LOCKED_AGAIN, RANDOM, NESTED)
        )
        for name in METRICS:
            on_locked = locked[name].iloc[0]
            central = _central(random[name], level)
            worse = random[name] < on_locked if name in GAINS else random[name] > on_locked
            found.append(
                {
                    "model": model,
                    "strategy": strategy,
                    "metric": name,
                    "locked": on_locked,
                    "random_median": central["value"],
                    "random_lower": central["lower"],
                    "random_upper": central["upper"],
                    "nested": nested[name].mean(skipna=False),
                    "worse_splits": float(worse.mean()),
                }
            )
    return pd.DataFrame(found)


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
