"""What held-out predictions are worth: metrics with intervals, coverage, and the luck of a split."""

import numpy as np
import pandas as pd
from statsmodels.stats.proportion import proportion_confint

from millprint.config.yields import HonestConfig
from millprint.predict.evaluation import bootstrap_metrics
from millprint.predict.honest import LOCKED_AGAIN, NESTED, PERMUTED, RANDOM
from millprint.predict.metrics import METRICS, YieldWeights, metrics

KEYS = ["model", "strategy", "scheme"]
# What a larger value of a metric means; every other metric is an error.
GAINS = ("r2",)


def _by_repeat(rows: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
    """Truth and prediction, each (repeats, cases), cases in one order."""
    wide = rows.pivot(index="repeat", columns="case", values=["yield_percent", "predicted_percent"])
    return wide["yield_percent"].to_numpy(), wide["predicted_percent"].to_numpy()


def _spread_over_repeats(rows: pd.DataFrame, weigh: YieldWeights, level: float) -> list[dict]:
    """Median over repeats with the central range of `level`: the repeats are the population."""
    scores = [
        metrics(part["yield_percent"].to_numpy(float), part["predicted_percent"].to_numpy(float), weigh)
        for _, part in rows.groupby("repeat")
    ]
    tail = (1 - level) / 2
    found = []
    for name in METRICS:
        lower, middle, upper = np.nanquantile([score[name] for score in scores], [tail, 0.5, 1 - tail])
        found.append({"metric": name, "value": middle, "lower": lower, "upper": upper})
    return found


def judge(held_out: pd.DataFrame, weigh: YieldWeights, budget: HonestConfig) -> pd.DataFrame:
    """Metrics by model, strategy and scheme: columns KEYS, metric, value, lower, upper.

    held_out: KEYS, repeat, case, yield_percent, predicted_percent. For random splits and permutations the value is
    the median over the repeats and the interval their central range. For the others the interval is a bootstrap over
    cases; with several repeats of a cross-validation a metric is averaged over them, within each resample too.
    """
    tables = []
    for keys, rows in held_out.groupby(KEYS, sort=False):
        about = dict(zip(KEYS, keys, strict=True))
        if about["scheme"] in (RANDOM, PERMUTED):
            table = pd.DataFrame(_spread_over_repeats(rows, weigh, budget.level))
        else:
            truth, predicted = _by_repeat(rows)
            table = bootstrap_metrics(truth, predicted, weigh, budget.resamples, budget.level, budget.seed)
        tables.append(table.assign(**about))
    return pd.concat(tables, ignore_index=True)[[*KEYS, "metric", "value", "lower", "upper"]]


def judge_intervals(enclosed: pd.DataFrame, level: float) -> pd.DataFrame:
    """Coverage and mean width of predictive intervals by model, strategy, scheme, method and nominal level.

    enclosed: KEYS, method, nominal, case, yield_percent, lower_percent, upper_percent. Columns: ..., nominal,
    covered [-] with its Clopper-Pearson interval of `level`, width_pp, cases. Predictions of one case in several
    repeats are not independent, so the interval counts cases and not predictions.
    """
    found = []
    for keys, rows in enclosed.groupby([*KEYS, "method", "nominal"], sort=False):
        inside = rows["yield_percent"].between(rows["lower_percent"], rows["upper_percent"])
        cases, share = rows["case"].nunique(), float(inside.mean())
        lower, upper = proportion_confint(share * cases, cases, alpha=1 - level, method="beta")
        found.append(
            dict(zip([*KEYS, "method", "nominal"], keys, strict=True))
            | {
                "covered": share,
                "lower": float(lower),
                "upper": float(upper),
                "width_pp": float((rows["upper_percent"] - rows["lower_percent"]).mean()),
                "cases": cases,
            }
        )
    return pd.DataFrame(found)


def split_luck(held_out: pd.DataFrame, weigh: YieldWeights, level: float) -> pd.DataFrame:
    """How much the locked split flatters each model, at one search budget: a row a model and metric.

    Columns: model, strategy, metric, locked, random_median, random_lower, random_upper, nested, worse_splits. The last
    is the share of random splits on which the model does worse than on the locked one: 1 is flattered, 0 is hurt.
    """
    found = []
    for (model, strategy), rows in held_out.groupby(["model", "strategy"], sort=False):
        scores = {}
        for scheme in (LOCKED_AGAIN, RANDOM, NESTED):
            parts = rows[rows["scheme"] == scheme].groupby("repeat")
            scores[scheme] = [
                metrics(part["yield_percent"].to_numpy(float), part["predicted_percent"].to_numpy(float), weigh)
                for _, part in parts
            ]
        tail = (1 - level) / 2
        for name in METRICS:
            locked = scores[LOCKED_AGAIN][0][name]
            drawn = np.array([score[name] for score in scores[RANDOM]])
            lower, middle, upper = np.nanquantile(drawn, [tail, 0.5, 1 - tail])
            worse = drawn < locked if name in GAINS else drawn > locked
            found.append(
                {
                    "model": model,
                    "strategy": strategy,
                    "metric": name,
                    "locked": locked,
                    "random_median": middle,
                    "random_lower": lower,
                    "random_upper": upper,
                    "nested": np.mean([score[name] for score in scores[NESTED]]),
                    "worse_splits": float(worse.mean()),
                }
            )
    return pd.DataFrame(found)
