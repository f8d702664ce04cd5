"""Groups of runs that are left out as a whole: other sources of yields, and other mechanical regimes (Sec. 5.3.3).

Runs of one group share their powder, their gas line and their mill: a single run that is left out is predicted with the
help of its own group.
"""

from collections.abc import Callable, Mapping
from itertools import combinations

import numpy as np
import pandas as pd
from scipy.stats import rankdata
from sklearn.model_selection import LeaveOneGroupOut

from millprint.config.mill import MillConfig
from millprint.config.yields import EvaluationConfig, PredictionConfig
from millprint.estimate.estimates import Estimate, Interval
from millprint.estimate.judge import AGREES, DIFFERS, NO_INTERVAL, OPEN, Allowed, Verdict, judge
from millprint.mill.bodies import build_bodies, travel_m
from millprint.observables.condition import Condition
from millprint.run.tables import CASE
from millprint.thesis.doe.factorial_designs import YIELD
from millprint.thesis.regimes import design_cases, reference_condition
from millprint.thesis.yields.experiments import FEWEST_TRAINED, SOURCE
from millprint.thesis.yields.features import CONDITIONS
from millprint.thesis.yields.held_out import OuterFold, Procedure, predict_held_out
from millprint.thesis.yields.new_conditions import range_warnings, trained_ranges

LEFT_OUT_SOURCE = "leave_source_out"
# With fewer held-out runs a bootstrap says nothing.
FEWEST_HELD = 5
ONE_SOURCE = "one source: nothing can be said on transfer"
TOO_FEW_HELD = f"fewer than {FEWEST_HELD} runs: too few to tell"
TOO_FEW_TRAINED = f"fewer than {FEWEST_TRAINED} runs of other sources: too few to train on"
TRANSFERS, ORDER_ONLY = "transfers", "only the order transfers"
FAILS, UNDECIDED = "does not transfer", "the interval of R2 holds 0"
NO_SCORE = "R2 is not known: the yields do not vary"
SCORES = ("rmse_pp", "climatology_rmse_pp", "skill", "r2", "mean_error_pp", "rank_correlation")
SCORE_COLUMNS = [
    *(SOURCE, "runs", "trained_on", "training_runs", "outside_domain", "model", "strategy"),
    *(f"{name}{end}" for name in SCORES for end in ("", "_lower", "_upper")),
    *("nominal", "covered", "covered_lower", "covered_upper", "verdict", "reason"),
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


def judge_transfer(scores: Mapping[str, float]) -> Verdict:
    """Whether yields transfer to a source: R2 above 0, by its interval; the rank correlation tells if the order does.

    R2 compares with the mean yield of the source itself. The skill against the climatology of the training runs cannot
    decide: if a source yields 30 points less everywhere, the climatology is off by as much as the model.
    """
    own = Interval(scores["r2_lower"], scores["r2_upper"])
    found = judge(Estimate(scores["r2"], "-", repeats=own), Allowed(0.0, open_lower=True))
    missed = ORDER_ONLY if scores["rank_correlation_lower"] > 0 else FAILS
    unsure = NO_SCORE if found.reason == NO_INTERVAL else UNDECIDED
    return found._replace(reason={AGREES: TRANSFERS, DIFFERS: missed, OPEN: unsure}[found.word])


def score_sources(
    predictions: pd.DataFrame, rows: pd.DataFrame, budget: EvaluationConfig, level: float
) -> pd.DataFrame:
    """Scores of every held-out source and model with bootstrap intervals over its runs, in SCORE_COLUMNS.

    predictions: of `leave_sources_out`; rows: as given to it; budget: resamples, level and seed of the bootstrap;
    level: of the predictive intervals. skill = 1 - MSE / MSE of the climatology, r2 = 1 - MSE / variance of the
    source's yields, covered with its Clopper-Pearson interval. An interval holds for further runs of the same source,
    not for yet another one. Where nothing can be said, one row of the source says why.
    """
    from statsmodels.stats.proportion import proportion_confint

    counts, tail = rows[SOURCE].value_counts(sort=False), (1 - budget.level) / 2
    if len(counts) < 2:
        alone = {SOURCE: counts.index[0], "runs": len(rows), "verdict": OPEN, "reason": ONE_SOURCE}
        return pd.DataFrame([alone]).reindex(columns=SCORE_COLUMNS)
    found = []
    for source, runs in counts.items():
        others = [name for name in counts.index if name != source]
        trained = int(counts[others].sum())
        about = {SOURCE: source, "runs": runs, "trained_on": ", ".join(others), "training_runs": trained}
        if trained < FEWEST_TRAINED:
            found.append({**about, "verdict": OPEN, "reason": TOO_FEW_TRAINED})
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
            judged = judge_transfer(row) if runs >= FEWEST_HELD else Verdict(OPEN, TOO_FEW_HELD)
            found.append(
                {
                    **about,
                    "outside_domain": int((part["outside"] != "").sum()),
                    "model": model,
                    "strategy": strategy,
                    **row,
                    "verdict": judged.word,
                    "reason": judged.reason,
                }
            )
    return pd.DataFrame(found).reindex(columns=SCORE_COLUMNS)


SCREENING, REFERENCE = "screening", "reference"


def reference_of_mill(
    cases: pd.DataFrame, mill: MillConfig, reference_speed: float, density: float, diameter: float
) -> Condition[float]:
    """The condition of the reference case in a mill, at a speed [Hz], for a ball density [kg/m3] and diameter [m].

    The amplitude is half the longest travel of a wall, as in every run's summary. Raises ConfigError for a mill with an
    impossible shape.
    """
    return reference_condition(
        cases,
        speed_hz=reference_speed,
        ball_diameter_m=diameter,
        density_kg_m3=density,
        amplitude_m=travel_m(build_bodies(mill)),
    )


def regime_rows(cases: pd.DataFrame, reference: Condition[float]) -> pd.DataFrame:
    """The cases of chapter 4 as rows of a yield model: case, regime (the fill ratio), the six conditions, yield.

    cases: as read_regimes gives them; reference: the condition of the reference case. That case is left out, since it
    is a run of the screening (case 14).
    """
    designed = design_cases(cases, reference)
    rows = cases[["case", "mode", "bpr", "molar_ratio", "time_h", YIELD]].assign(
        regime=[f"fill {fill:.2f}" for fill in cases["fill_ratio"]],
        normal_energy_uJ=1e6 * designed["normal_energy_J"],
        tangential_energy_uJ=1e6 * designed["tangential_energy_J"],
        specific_frequency_hz=designed["specific_frequency_hz"],
    )
    kept = rows[rows["mode"] != REFERENCE]
    return kept[["case", "regime", *CONDITIONS, YIELD]].reset_index(drop=True)


def without_regime(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows with the tangential share of the first row in all of them; the sum of both energies is not changed.

    A model then knows how strongly the powder was stressed, but not in which way. Its predictions for another regime
    show how well it does without the share.
    """
    energy = rows["normal_energy_uJ"] + rows["tangential_energy_uJ"]
    first = rows.iloc[0]
    share = first["tangential_energy_uJ"] / (first["normal_energy_uJ"] + first["tangential_energy_uJ"])
    return rows.assign(normal_energy_uJ=(1 - share) * energy, tangential_energy_uJ=share * energy)


def _training_sets(others: list[str], own: list[str]) -> list[tuple[str, list[str], list[str]]]:
    """Name of what is added, cases added, cases to predict: with and without the other regime and cases of the same."""
    sets = [("nothing", [], own), ("other regime", others, own)]
    for count in range(1, len(own)):
        for added in combinations(own, count):
            left = [case for case in own if case not in added]
            sets.append((f"{count} of the regime", list(added), left))
            sets.append((f"other regime, {count} of the regime", [*others, *added], left))
    return sets


def leave_regimes_out(
    screening: pd.DataFrame,
    regimes: pd.DataFrame,
    procedures: dict[tuple[str, str], tuple[Procedure, bool]],
    level: float,
    tick: Callable[[], None] = lambda: None,
) -> pd.DataFrame:
    """Predictions for every regime by models trained on the screening runs and on different added cases.

    screening, regimes: case, (regime,) the six conditions, yield_percent. procedures: by model and descriptors, with
    whether the tangential share is hidden from it; tick: called after each fit. Columns: model, descriptors, regime,
    added, added_cases, case, yield_percent, predicted_percent, error_pp, method, lower_percent, upper_percent.
    """
    everything = pd.concat([screening.assign(regime=SCREENING), regimes], ignore_index=True).set_index("case")
    tables = []
    for (model, descriptors), (procedure, hidden) in procedures.items():
        seen = without_regime(everything) if hidden else everything
        for regime, group in regimes.groupby("regime", sort=False):
            others = regimes.loc[regimes["regime"] != regime, "case"].tolist()
            for added, cases, unseen in _training_sets(others, group["case"].tolist()):
                train = seen.loc[[*screening["case"], *cases]].reset_index()
                truth = everything.loc[unseen, YIELD].to_numpy(float)
                answer = procedure(train, train[YIELD].to_numpy(float), seen.loc[unseen].reset_index(), [level])
                method, ends = next(iter(answer.intervals.items()))
                columns = {
                    "model": model,
                    "descriptors": descriptors,
                    "regime": regime,
                    "added": added,
                    "added_cases": ", ".join(cases),
                    "case": unseen,
                    "yield_percent": truth,
                    "predicted_percent": answer.predicted,
                    "error_pp": answer.predicted - truth,
                    "method": method,
                    "lower_percent": ends[:, 0, 0],
                    "upper_percent": ends[:, 0, 1],
                }
                tables.append(pd.DataFrame(columns))
                tick()
    return pd.concat(tables, ignore_index=True)


def summarise_regimes(table: pd.DataFrame) -> pd.DataFrame:
    """RMSE and mean error [pp] and the share of runs within their intervals, by model, descriptors and what was added.

    The mean is over the runs of both regimes, each predicted once for every set of cases that could have been added.
    """
    inside = table["yield_percent"].between(table["lower_percent"], table["upper_percent"])
    scored = table.assign(square=table["error_pp"] ** 2, inside=inside.astype(float))
    groups = scored.groupby(["model", "descriptors", "added"], sort=False)
    summary = groups.agg(
        rmse_pp=("square", "mean"),
        mean_error_pp=("error_pp", "mean"),
        covered=("inside", "mean"),
        predictions=("case", "size"),
    )
    return summary.assign(rmse_pp=np.sqrt(summary["rmse_pp"])).reset_index()
