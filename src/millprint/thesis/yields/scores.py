"""Scores of predictive distributions, and paired tests of whether two models can be told apart."""

import numpy as np
import pandas as pd
from statsmodels.stats.multitest import multipletests

from millprint.statistics.quantiles import student_above
from millprint.thesis.yields.distributions import SCORE_COLUMNS
from millprint.thesis.yields.evaluation import KEYS
from millprint.thesis.yields.metrics import SPREAD, jackknife_error, spread, without_each
from millprint.thesis.yields.regressors import CLIMATOLOGY
from millprint.thesis.yields.schemes import LEFT_OUT, NESTED

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

    Leave-one-out: errors are paired by run, the error is a jackknife over runs, and t = difference / error has n - 1
    degrees of freedom. Repeated k-fold: d_j is the difference in fold j of J = k r, and t = mean(d) / sqrt((1 / J +
    n_test / n_train) var(d)) with J - 1 degrees: the corrected resampled t-test of Nadeau and Bengio, Machine Learning
    52 (2003) 239, since the training rows of folds overlap and their differences are not independent draws. R2 is taken
    as 1 minus the squared error over the variance of all yields, so that folds add up. Neither test accounts for
    correlated errors of models trained on overlapping rows, nor for the choice of the 27 runs.
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
        left = without_each(len(gain))
        parts = gain[left].mean(axis=-1) / (truth[left].var(axis=-1) if metric == "r2" else 1.0)
        difference, error, degrees = gain.mean() / scale, float(jackknife_error(parts)), len(gain) - 1
        repeats = [difference]
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
    """Every model against `reference` (model and strategy), by both schemes, in R2 and CRPS.

    Columns: model, strategy, against, scheme, metric, difference (model minus reference), error, statistic, degrees, p,
    SPREAD (of the difference), p_holm (over the models of a scheme and metric), told_apart (yes where p_holm is below
    1 - level).
    """
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
