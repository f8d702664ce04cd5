"""Evaluation of yield models: metrics, proper scores, coverage, paired tests, SHAP values, other seeds."""

import numpy as np
import pandas as pd

from millprint.config.yields import EvaluationConfig, TrainingConfig
from millprint.estimate.quantiles import student_above
from millprint.thesis.doe.factorial_designs import YIELD
from millprint.thesis.yields.averaging import AveragedModel
from millprint.thesis.yields.features import (
    FEATURES,
    LEFT_OUT,
    METRICS,
    NESTED,
    RANDOM,
    SPREAD,
    YieldWeights,
    bootstrap_metrics,
    engineer,
    jackknife_error,
    metrics,
    spread,
    without_each,
)
from millprint.thesis.yields.held_out import SCORE_COLUMNS
from millprint.thesis.yields.regressors import CLIMATOLOGY, other_seed, regressor
from millprint.thesis.yields.yield_model import YieldModel, fit_model

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
    from statsmodels.stats.proportion import proportion_confint

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
    """Share of the yield's variance that only the time explains: columns measure, share [-].

    time_h, yields: (n,) [h] and [%]. `levels`: sum of squares between the times over the total sum of squares, the most
    that any function of time can explain; `line`: R2 of a straight line.
    """
    frame = pd.DataFrame({"time": time_h, "yield": yields})
    means = frame.groupby("time")["yield"].transform("mean")
    total = ((frame["yield"] - frame["yield"].mean()) ** 2).sum()
    between = ((means - frame["yield"].mean()) ** 2).sum()
    line = np.corrcoef(frame["time"], frame["yield"])[0, 1] ** 2
    return pd.DataFrame({"measure": ["levels", "line"], "share": [between / total, line]})


CRPS, LOG_SCORE, PIT = SCORE_COLUMNS
# The schemes in which every run is predicted equally often.
WHOLE = (LEFT_OUT, NESTED)
COMPARED = ("r2", CRPS)
PIT_BINS = 5


def _by_case(rows: pd.DataFrame, column: str) -> np.ndarray:
    """A column of predictions, (repeats, cases), in the order of the cases' names."""
    return rows.pivot(index="repeat", columns="case", values=column).to_numpy()


def score_distributions(held_out: pd.DataFrame) -> pd.DataFrame:
    """Mean CRPS and logarithmic score, with the skill over climatology and jackknife errors over cases.

    held_out: KEYS, repeat, case, distribution, SCORE_COLUMNS, with the rows of climatology. Columns: KEYS,
    distribution, score, value, error, skill, SPREAD. skill is 1 - CRPS / CRPS of climatology [-], and for the
    logarithmic score the difference in nats, climatology minus model: above 0 if the model knows more. Scores of
    repeats are averaged for each case, and SPREAD is that of their means.
    """
    found, reference = [], {}
    for keys, rows in held_out[held_out["scheme"].isin(WHOLE)].groupby(KEYS, sort=False):
        for score in (CRPS, LOG_SCORE):
            repeats = _by_case(rows, score)
            means = repeats.mean(axis=0)
            about = dict(zip(KEYS, keys, strict=True)) | {"distribution": rows["distribution"].iloc[0]}
            error = float(jackknife_error(means[without_each(len(means))].mean(axis=-1)))
            own = {"score": score, "value": float(means.mean()), "error": error}
            found.append(about | own | spread(repeats.mean(axis=1)))
            if about["model"] == CLIMATOLOGY:
                reference[about["scheme"], score] = float(means.mean())
    table = pd.DataFrame(found)
    known = np.array([reference[key] for key in zip(table["scheme"], table["score"], strict=True)])
    skill = np.where(table["score"] == CRPS, 1 - table["value"] / known, known - table["value"])
    table.insert(table.columns.get_loc("error") + 1, "skill", skill)
    return table


def pit_histogram(held_out: pd.DataFrame) -> pd.DataFrame:
    """Histogram of the probability integral: columns KEYS, from, to, share [-], expected [-], SPREAD of the share.

    A share counts runs; that of repeats is the mean of theirs. Where predictive distributions are right,
    every share is the expected one. Too many in the outer bins: distributions are too narrow; in the middle: too wide.
    """
    edges, found = np.linspace(0, 1, PIT_BINS + 1), []
    for keys, rows in held_out[held_out["scheme"].isin(WHOLE)].groupby(KEYS, sort=False):
        repeats = [np.histogram(part, bins=edges)[0] / len(part) for part in _by_case(rows, PIT)]
        for low, high, shares in zip(edges[:-1], edges[1:], np.transpose(repeats), strict=True):
            found.append((*keys, low, high, shares.mean(), 1 / PIT_BINS, *spread(shares).values()))
    return pd.DataFrame(found, columns=[*KEYS, "from", "to", "share", "expected", *SPREAD])


def paired_test(one: pd.DataFrame, other: pd.DataFrame, scheme: str, metric: str) -> dict[str, float]:
    """The difference of a metric, one model minus another, with its error and a two-sided test that it is zero.

    one, other: the same runs in the same folds: repeat, fold, case, yield_percent, predicted_percent, CRPS. Keys:
    difference, error, statistic, degrees, p, and SPREAD of the difference over the repeats.

    Leave-one-out: errors are paired by run, averaged over the orders of the rows, the error is a jackknife over runs,
    and t = difference / error has n - 1 degrees of freedom. Repeated k-fold: d_j is the difference in fold j of J =
    k r, and t = mean(d) / sqrt((1 / J + n_test / n_train) var(d)) with J - 1 degrees: the corrected resampled t-test of
    Nadeau and Bengio, Machine Learning 52 (2003) 239, since the training rows of folds overlap and their differences
    are not independent draws. R2 is taken as 1 minus the squared error over the variance of all yields, so that folds
    add up. Neither test accounts for correlated errors of models trained on overlapping rows, nor for the choice of the
    27 runs.
    """
    keys = ["repeat", "fold", "case"]
    pair = one.merge(other, on=keys, suffixes=("", "_other"), validate="one_to_one")
    truth = pair["yield_percent"].to_numpy(float)
    if metric == "r2":
        errors = ((truth - pair[name]) ** 2 for name in ("predicted_percent_other", "predicted_percent"))
        first, second = (np.asarray(each, dtype=float) for each in errors)
        gain = first - second
    else:
        gain = (pair[metric] - pair[f"{metric}_other"]).to_numpy(float)
    cases = pair.drop_duplicates("case")["yield_percent"].to_numpy(float)
    scale = float(cases.var()) if metric == "r2" else 1.0
    if scheme == LEFT_OUT:
        by_order = pair.assign(gain=gain).pivot(index="repeat", columns="case", values="gain")
        truth = pair.pivot(index="repeat", columns="case", values="yield_percent").to_numpy(float)[0]
        repeats, gain = by_order.mean(axis=1).to_numpy() / scale, by_order.mean(axis=0).to_numpy()
        left = without_each(len(gain))
        parts = gain[left].mean(axis=-1) / (truth[left].var(axis=-1) if metric == "r2" else 1.0)
        difference, error, degrees = gain.mean() / scale, float(jackknife_error(parts)), len(gain) - 1
    else:
        folds = pair.assign(gain=gain / scale).groupby(["repeat", "fold"])["gain"].agg(["mean", "size"])
        held = float(folds["size"].mean())
        share = 1 / len(folds) + held / (len(cases) - held)
        difference, error = folds["mean"].mean(), float(np.sqrt(share * folds["mean"].var(ddof=1)))
        degrees, repeats = len(folds) - 1, folds["mean"].groupby("repeat").mean()
    statistic = difference / error if error > 0 else 0.0
    return {
        "difference": float(difference),
        "error": error,
        "statistic": float(statistic),
        "degrees": degrees,
        "p": float(2 * student_above(abs(statistic), degrees)),
        **spread(repeats),
    }


def paired_differences(held_out: pd.DataFrame, reference: tuple[str, str], level: float) -> pd.DataFrame:
    """Every other model against `reference` (model and strategy), by both schemes, in R2 and CRPS.

    Columns: model, strategy, against, scheme, metric, difference (model minus reference), error, statistic, degrees, p,
    SPREAD (of the difference), p_holm (over the models of a scheme and metric), told_apart (yes where p_holm is below
    1 - level).
    """
    from statsmodels.stats.multitest import multipletests

    found = []
    for scheme in WHOLE:
        models = dict(list(held_out[held_out["scheme"] == scheme].groupby(["model", "strategy"], sort=False)))
        for metric in COMPARED:
            rows = [
                {"model": model, "strategy": strategy, "against": " ".join(reference), "scheme": scheme}
                | {"metric": metric, **paired_test(table, models[reference], scheme, metric)}
                for (model, strategy), table in models.items()
                if (model, strategy) != reference
            ]
            adjusted = multipletests([row["p"] for row in rows], method="holm")[1]
            apart = np.where(adjusted < 1 - level, "yes", "no")
            found.append(pd.DataFrame(rows).assign(p_holm=adjusted, told_apart=apart))
    return pd.concat(found, ignore_index=True)


MODEL_KEYS = ["model", "strategy"]


def labelled(table: pd.DataFrame, model: YieldModel | AveragedModel) -> pd.DataFrame:
    """A table with the model's name and strategy as its first columns."""
    return table.assign(model=model.name, strategy=model.strategy)[[*MODEL_KEYS, *table]]


def locked_metrics(models: list[YieldModel | AveragedModel], test: pd.DataFrame, weigh: YieldWeights) -> pd.DataFrame:
    """Table 5.6: for each model rmse, mae [pp], mape [%], r2 [-], wmse [pp2], and the number of test rows."""
    truth = test[YIELD].to_numpy(float)
    tables = [
        labelled(pd.DataFrame([{**metrics(truth, model.predict(test), weigh), "test_rows": len(test)}]), model)
        for model in models
    ]
    return pd.concat(tables, ignore_index=True)


def predictions(models: list[YieldModel | AveragedModel], rows: pd.DataFrame, level: float) -> pd.DataFrame:
    """Every model's prediction for every row, with a predictive interval if the model has one.

    rows: case, the six conditions, yield_percent, and role where there is one. Columns: model, strategy, case, (role,)
    yield_percent, predicted_percent, error_pp, deviation_pp, lower_percent, upper_percent.
    """
    tables = []
    for model in models:
        predicted, (lower, upper) = model.predict(rows), model.intervals(rows, [level])[:, 0].T
        table = rows[[name for name in ("case", "role", YIELD) if name in rows]].assign(
            predicted_percent=predicted,
            error_pp=predicted - rows[YIELD],
            deviation_pp=model.deviation(rows),
            lower_percent=lower,
            upper_percent=upper,
        )
        tables.append(labelled(table, model))
    return pd.concat(tables, ignore_index=True)


def shap_values(model: YieldModel, rows: pd.DataFrame) -> pd.DataFrame:
    """SHAP values of a model: columns case, feature, feature_value, shap_pp, base_percent.

    rows: case and the six conditions. The model is the sum of its steps, so its SHAP values are those of its steps
    added up; in a two-step model the value of time is that of the time model. For each row the values and the base add
    up to the prediction. Raises ValueError for a regressor that cannot be explained.
    """
    features = engineer(rows)
    total = pd.DataFrame(0.0, index=features.index, columns=list(FEATURES))
    base = 0.0
    for step in model.steps:
        explain = regressor(step.plan.regressor).explain
        if explain is None:
            raise ValueError(f"{step.plan.regressor}: a regressor without SHAP values")
        values, offset = explain(step.estimator, step.inputs(features))
        total[list(step.plan.features)] += values
        base += offset
    long = total.assign(case=rows["case"]).melt("case", var_name="feature", value_name="shap_pp")
    long.insert(2, "feature_value", features.melt()["value"].to_numpy())
    return long.assign(base_percent=base)


def rank_features(values: pd.DataFrame) -> pd.DataFrame:
    """Mean |SHAP| of each feature of each model, largest first: columns model, strategy, feature, mean_abs_shap_pp."""
    keys = ["model", "strategy", "feature"]
    mean = values.assign(mean_abs_shap_pp=values["shap_pp"].abs()).groupby(keys, sort=False)["mean_abs_shap_pp"].mean()
    return mean.reset_index().sort_values(["model", "mean_abs_shap_pp"], ascending=[True, False], ignore_index=True)


TAKEN, TREE_SEED, SEARCH_SEED = "as taken", "seed", "search_seed"
TREE_SEEDS = (1, 2, 3)


def _row(
    model: YieldModel, choice: str, value: str, test: pd.DataFrame, outside: pd.DataFrame, training: TrainingConfig
) -> dict:
    """Metrics on the test rows, and the predicted yield of each run outside the domain [%]."""
    beyond = zip(outside["case"], model.predict(outside), strict=True)
    return {
        "model": model.name,
        "strategy": model.strategy,
        "choice": choice,
        "value": value,
        **metrics(test[YIELD].to_numpy(float), model.predict(test), YieldWeights.of(training)),
        **{f"case_{case}_percent": float(predicted) for case, predicted in beyond},
    }


def compare_seeds(
    model: YieldModel,
    again: YieldModel | None,
    train: pd.DataFrame,
    test: pd.DataFrame,
    outside: pd.DataFrame,
    training: TrainingConfig,
) -> pd.DataFrame:
    """Metrics on the test rows for a model, with other seeds of its trees, and after a search with another seed.

    again: the model of that search, or None; train, test, outside: case, the six conditions and yield_percent. Columns:
    model, strategy, choice (as taken, seed, search_seed), value, rmse [pp], mae [pp], mape [%], r2 [-], wmse [pp2], and
    case_CASE_percent for each row of `outside`.
    """
    places = test, outside, training
    rows = [_row(model, TAKEN, "", *places)]
    fit = (model.name, model.strategy, [step.parameters for step in model.steps], train, train[YIELD].to_numpy(float))
    for shift in TREE_SEEDS if regressor(model.name).seeded else ():
        changed = training.model_copy(update={"seed": training.seed + shift})
        rows.append(_row(fit_model(*fit, changed), TREE_SEED, f"seed + {shift}", *places))
    if again is not None:
        rows.append(_row(again, SEARCH_SEED, f"seed {other_seed(training).seed} for folds, search and fit", *places))
    return pd.DataFrame(rows)
