"""How well models trained on the other sources predict the runs of a group and mill.

Each source is held out as a whole (scikit-learn's LeaveOneGroupOut), because runs of one group share their powder,
their gas line and their mill: a run that is left out alone is predicted with the help of its own group.
"""

from collections.abc import Callable, Mapping

import numpy as np
import pandas as pd
from scipy.stats import rankdata
from sklearn.model_selection import LeaveOneGroupOut
from statsmodels.stats.proportion import proportion_confint

from millprint.config.next_experiments import PredictionConfig
from millprint.config.yields import EvaluationConfig
from millprint.run.tables import CASE
from millprint.thesis.doe.runs import YIELD
from millprint.thesis.yields.held_out import OuterFold, predict_held_out
from millprint.thesis.yields.new_conditions import range_warnings, trained_ranges
from millprint.thesis.yields.other_runs import FEWEST_TRAINED, SOURCE
from millprint.thesis.yields.procedures import Procedure

LEFT_OUT_SOURCE = "leave_source_out"
# With fewer held-out runs a bootstrap says nothing.
FEWEST_HELD = 5
ONE_SOURCE = "one source: nothing can be said on transfer"
TOO_FEW_HELD = f"fewer than {FEWEST_HELD} runs: too few to tell"
TOO_FEW_TRAINED = f"fewer than {FEWEST_TRAINED} runs of other sources: too few to train on"
TRANSFERS, ORDER_ONLY = "transfers", "only the order transfers"
FAILS, UNDECIDED = "does not transfer", "undecided: the interval of R2 holds 0"
SCORES = ("rmse_pp", "climatology_rmse_pp", "skill", "r2", "mean_error_pp", "rank_correlation")
SCORE_COLUMNS = [
    *(SOURCE, "runs", "trained_on", "training_runs", "outside_domain", "model", "strategy"),
    *(f"{name}{end}" for name in SCORES for end in ("", "_lower", "_upper")),
    *("nominal", "covered", "covered_lower", "covered_upper", "verdict"),
]
PREDICTION_COLUMNS = [
    *(SOURCE, CASE, "model", "strategy", YIELD, "predicted_percent", "climatology_percent"),
    *("method", "lower_percent", "upper_percent", "outside"),
]


def sources_out(rows: pd.DataFrame) -> dict[str, OuterFold]:
    """For every source the fold that holds it out; empty for one source. rows: source, yield_percent."""
    if rows[SOURCE].nunique() < 2:
        return {}
    yields = rows[YIELD].to_numpy(float)
    parts = LeaveOneGroupOut().split(rows, groups=rows[SOURCE])
    folds = [OuterFold(LEFT_OUT_SOURCE, number, kept, held, yields) for number, (kept, held) in enumerate(parts)]
    named = {rows[SOURCE].iloc[fold.held[0]]: fold for fold in folds}
    return {name: named[name] for name in rows[SOURCE].unique()}


def leave_sources_out(
    rows: pd.DataFrame,
    procedures: Mapping[tuple[str, str], Procedure],
    limits: PredictionConfig,
    level: float,
    tick: Callable[[], None] = lambda: None,
) -> pd.DataFrame:
    """Predictions of every source by models trained on all others, with PREDICTION_COLUMNS.

    rows: case, source, the six conditions, yield_percent; procedures: by model and strategy; limits: of the trained
    ranges; level: of the predictive intervals [-]; tick: called after each fit. climatology_percent is the mean yield
    of the training runs; outside says which conditions lie outside their ranges. No row for a source with fewer than
    FEWEST_TRAINED runs of others.
    """
    tables = []
    for source, fold in sources_out(rows).items():
        if len(fold.kept) < FEWEST_TRAINED:
            continue
        trained, held = rows.iloc[fold.kept], rows.iloc[fold.held]
        outside = range_warnings(held, trained_ranges(trained, limits))
        for (model, strategy), procedure in procedures.items():
            predicted, intervals = predict_held_out(procedure, rows, [fold], [level])
            # Of a model with two kinds of interval the first, as for the regimes.
            ends = intervals[intervals["method"] == intervals["method"].iloc[0]].reset_index(drop=True)
            table = predicted.assign(
                **{name: ends[name] for name in ("method", "lower_percent", "upper_percent")},
                source=source,
                model=model,
                strategy=strategy,
                climatology_percent=float(trained[YIELD].mean()),
                outside=outside,
            )
            tables.append(table[PREDICTION_COLUMNS])
            tick()
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=PREDICTION_COLUMNS)


def _scores(truth: np.ndarray, predicted: np.ndarray, climatology: float) -> dict[str, np.ndarray]:
    """Every one of SCORES over the last axis; truth, predicted: (..., n) [%]. NaN where a score is not defined."""
    error = predicted - truth
    square = (error**2).mean(axis=-1)
    reference = ((climatology - truth) ** 2).mean(axis=-1)
    ranks = [rankdata(values, axis=-1) for values in (truth, predicted)]
    order, guess = (rank - rank.mean(axis=-1, keepdims=True) for rank in ranks)
    with np.errstate(divide="ignore", invalid="ignore"):
        values = {
            "rmse_pp": np.sqrt(square),
            "climatology_rmse_pp": np.sqrt(reference),
            "skill": 1 - square / reference,
            "r2": 1 - square / truth.var(axis=-1),
            "mean_error_pp": error.mean(axis=-1),
            "rank_correlation": (order * guess).sum(axis=-1)
            / np.sqrt((order**2).sum(axis=-1) * (guess**2).sum(axis=-1)),
        }
    return {name: np.where(np.isfinite(value), value, np.nan) for name, value in values.items()}


def verdict(scores: Mapping[str, float]) -> str:
    """What transfers to a source, from the intervals of R2 and of the rank correlation.

    R2 compares with the mean yield of the source itself. The skill against the climatology of the training runs cannot
    decide: if a source yields 30 points less everywhere, the climatology is off by as much as the model.
    """
    if scores["r2_lower"] > 0:
        return TRANSFERS
    if scores["r2_upper"] <= 0:
        return ORDER_ONLY if scores["rank_correlation_lower"] > 0 else FAILS
    return UNDECIDED


def score_sources(
    predictions: pd.DataFrame, rows: pd.DataFrame, budget: EvaluationConfig, level: float
) -> pd.DataFrame:
    """Scores of every held-out source and model with bootstrap intervals over its runs, in SCORE_COLUMNS.

    predictions: of `leave_sources_out`; rows: as given to it; budget: resamples, level and seed of the bootstrap;
    level: of the predictive intervals. skill = 1 - MSE / MSE of the climatology, r2 = 1 - MSE / variance of the
    source's yields, covered with its Clopper-Pearson interval. An interval holds for further runs of the same source,
    not for yet another one. Where nothing can be said, one row of the source says why.
    """
    counts, tail = rows[SOURCE].value_counts(sort=False), (1 - budget.level) / 2
    if len(counts) < 2:
        alone = {SOURCE: counts.index[0], "runs": len(rows), "verdict": ONE_SOURCE}
        return pd.DataFrame([alone]).reindex(columns=SCORE_COLUMNS)
    found = []
    for source, runs in counts.items():
        others = [name for name in counts.index if name != source]
        trained = int(counts[others].sum())
        about = {SOURCE: source, "runs": runs, "trained_on": ", ".join(others), "training_runs": trained}
        if trained < FEWEST_TRAINED:
            found.append({**about, "verdict": TOO_FEW_TRAINED})
            continue
        held = predictions[predictions[SOURCE] == source]
        drawn = np.random.default_rng(budget.seed).integers(runs, size=(budget.resamples, runs))
        for (model, strategy), part in held.groupby(["model", "strategy"], sort=False):
            truth, predicted = part[YIELD].to_numpy(float), part["predicted_percent"].to_numpy(float)
            climatology = float(part["climatology_percent"].iloc[0])
            row = {name: float(value) for name, value in _scores(truth, predicted, climatology).items()}
            inside = part[YIELD].between(part["lower_percent"], part["upper_percent"]).sum()
            row |= {"nominal": level, "covered": inside / runs}
            ends = proportion_confint(inside, runs, alpha=1 - budget.level, method="beta")
            row |= dict(zip(("covered_lower", "covered_upper"), ends, strict=True))
            if runs >= FEWEST_HELD:
                for name, values in _scores(truth[drawn], predicted[drawn], climatology).items():
                    known = values[np.isfinite(values)]
                    lower, upper = np.quantile(known, [tail, 1 - tail]) if known.size else (np.nan, np.nan)
                    row |= {f"{name}_lower": lower, f"{name}_upper": upper}
            found.append(
                {
                    **about,
                    "outside_domain": int((part["outside"] != "").sum()),
                    "model": model,
                    "strategy": strategy,
                    **row,
                    "verdict": verdict(row) if runs >= FEWEST_HELD else TOO_FEW_HELD,
                }
            )
    return pd.DataFrame(found).reindex(columns=SCORE_COLUMNS)
