"""Runs of other groups and mills: their table, and how well models trained on the other sources predict each of them.

Each source is held out as a whole (scikit-learn's LeaveOneGroupOut), because runs of one group share their powder,
their gas line and their mill: a run that is left out alone is predicted with the help of its own group.
"""

from collections.abc import Callable, Collection, Mapping

import numpy as np
import pandas as pd
from scipy.stats import rankdata
from sklearn.model_selection import LeaveOneGroupOut
from statsmodels.stats.proportion import proportion_confint

from millprint.config.other_sources import OtherSourcesConfig
from millprint.config.proposals import PredictionConfig
from millprint.config.yields import EvaluationConfig
from millprint.doe.runs import PERCENT_YIELD, YIELD
from millprint.errors import ConfigError
from millprint.files import row_name
from millprint.fingerprint.model import Fingerprint
from millprint.predict.features import CHEMICAL, CONDITIONS, FREQUENCY, NORMAL, TANGENTIAL
from millprint.predict.held_out import OuterFold, predict_held_out
from millprint.predict.new_conditions import range_warnings, trained_ranges
from millprint.predict.procedures import Procedure
from millprint.tables import CASE, Number, Text, read_measured, refuse_rows

SOURCE, GIVEN = "source", "given"
ENERGIES = (NORMAL, TANGENTIAL, FREQUENCY)
LEFT_OUT_SOURCE = "leave_source_out"
# Bounds of the columns: a value outside has another unit. Collisions of ball mills have from some nanojoules (beads
# of a millimetre) to some joules (large balls in a planetary mill).
BOUNDS = {
    "bpr": (0, 1000),
    "molar_ratio": (0, 1000),
    "time_h": (0, 1000),
    NORMAL: (1e-3, 1e7),
    TANGENTIAL: (1e-3, 1e7),
    FREQUENCY: (0.1, 1e5),
}
# What a fingerprint needs, as columns: the variable of a condition, and the factor from the column to its unit.
MILL_COLUMNS = {
    "fill_ratio": ("fill_ratio", 1.0),
    "speed_rpm": ("speed_hz", 1 / 60),
    "ball_diameter_mm": ("ball_diameter_m", 1e-3),
}
# With fewer held-out runs a bootstrap says nothing; with fewer training runs a model of six conditions neither.
FEWEST_HELD, FEWEST_TRAINED = 5, 10
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


def read_other_runs(settings: OtherSourcesConfig, taken: Mapping[str, Collection[str]], config: str) -> pd.DataFrame:
    """The runs of others: case, source, the six conditions, yield_percent, and where the energies come from.

    taken: cases of other tables by the table's path; no run may have the name of one of them. config: the file with
    the settings, for messages. The table has case, source, bpr, molar_ratio, time_h and yield_percent, and either the
    three descriptors or, in rows where these are empty, fill_ratio, speed_rpm and ball_diameter_mm, from which the
    fingerprint of the source calculates them. Column `descriptors` is `given` or the counting rule of the fingerprint.
    Without a table there are no rows. Raises ConfigError, in one line, for the first fault.
    """
    if settings.runs is None:
        return pd.DataFrame(columns=[CASE, SOURCE, *CONDITIONS, YIELD, "descriptors"])
    path = settings.runs
    frame = read_measured(
        path,
        [
            Text(CASE, unique=True),
            Text(SOURCE),
            *(Number(name, *BOUNDS[name], above=True) for name in CHEMICAL),
            *(Number(name, *BOUNDS[name], may_be_blank=True) for name in ENERGIES),
            *(Number(name, 0, above=True, optional=True, may_be_blank=True) for name in MILL_COLUMNS),
            PERCENT_YIELD,
        ],
    )
    _check_names(frame, path, settings, taken, config)
    _check_units(frame, path)
    table = frame[[CASE, SOURCE, *CONDITIONS, YIELD]].assign(descriptors=GIVEN)
    for source in settings.sources:
        calculated = (frame[SOURCE] == source.name) & frame[NORMAL].isna()
        if not calculated.any():
            continue
        if source.fingerprint is None:
            why = (
                f"source {source.name} has no fingerprint: give the descriptors here, or its `fingerprint` in {config}"
            )
            refuse_rows(frame, path, NORMAL, calculated, why)
        else:
            found, rule = _calculated(frame[calculated], path, source.fingerprint)
            table.loc[calculated, list(ENERGIES)] = found
            table.loc[calculated, "descriptors"] = rule
    return table


def _check_names(
    frame: pd.DataFrame, path: str, settings: OtherSourcesConfig, taken: Mapping[str, Collection[str]], config: str
) -> None:
    frame[SOURCE] = frame[SOURCE].str.strip()
    known = [source.name for source in settings.sources]
    why = f"not in yields.other_sources.sources of {config}; known: {', '.join(known)}"
    refuse_rows(frame.fillna({SOURCE: ""}), path, SOURCE, ~frame[SOURCE].isin(known), why)
    for name in known:
        if name not in set(frame[SOURCE]):
            raise ConfigError(f"{config}: yields.other_sources.sources: {name!r}: {path} has no run of it")
    for table, cases in taken.items():
        why = f"{table} has a run of that name; must be another"
        refuse_rows(frame, path, CASE, frame[CASE].isin(list(cases)), why)


def _check_units(frame: pd.DataFrame, path: str) -> None:
    """Refuse rows with some of the three descriptors, and sources whose yields must be fractions."""
    blank = frame[list(ENERGIES)].isna()
    for name in ENERGIES:
        partly = blank[name] & ~blank.all(axis=1)
        refuse_rows(frame, path, name, partly, "must be a number, or all three descriptors of the row empty")
    largest = frame.groupby(SOURCE)[YIELD].transform("max")
    for row in map(int, np.flatnonzero((largest <= 1) & (largest > 0))):
        place = f"column {YIELD}, {row_name(frame, row, YIELD)} = {frame[YIELD].iloc[row]:g}"
        source = frame[SOURCE].iloc[row]
        raise ConfigError(f"{path}: {place}: no yield of source {source} is above 1; must be in %, 71 and not 0.71")


def _calculated(frame: pd.DataFrame, path: str, fingerprint_path: str) -> tuple[np.ndarray, str]:
    """The descriptors (rows, 3) of rows by a fingerprint, and its counting rule; refuses what it does not know."""
    for column in MILL_COLUMNS:
        if column not in frame:
            raise ConfigError(f"{path}: column {column} is missing: rows without descriptors need it")
        refuse_rows(frame, path, column, frame[column].isna(), "must be a number, since the row has no descriptors")
    fingerprint = Fingerprint.read(fingerprint_path)
    si = {name: frame[column].to_numpy(float) * unit for column, (name, unit) in MILL_COLUMNS.items()}
    rows = [fingerprint.condition(**dict(zip(si, values, strict=True))) for values in zip(*si.values(), strict=True)]
    beyond = [fingerprint.outside(row, fingerprint.about["volume_m3"]) for row in rows]
    for column, (name, unit) in MILL_COLUMNS.items():
        low, high = (end / unit for end in fingerprint.about["ranges"][name])
        why = f"outside what {fingerprint_path} was simulated for; must be from {low:.4g} to {high:.4g}"
        refuse_rows(frame, path, column, [name in names for names in beyond], why)
    found = fingerprint.descriptors(fingerprint.condition(**si))
    energies = [1e6 * found["normal_energy_J"], 1e6 * found["tangential_energy_J"], found["frequency_per_ball_hz"]]
    return np.column_stack(energies), str(fingerprint.about["counting_rule"])


def with_other_runs(own: pd.DataFrame, others: pd.DataFrame, name: str) -> pd.DataFrame:
    """The runs of all sources: case, source, the six conditions, yield_percent; `name` is the source of `own`."""
    columns = [CASE, SOURCE, *CONDITIONS, YIELD]
    ours = own.assign(source=name)[columns]
    return pd.concat([ours, others[columns]], ignore_index=True) if len(others) else ours


def check_folds(rows: pd.DataFrame, folds: int, config: str) -> None:
    """Refuse more inner folds than a source that is held out leaves runs. Raises ConfigError, in one line."""
    for name, fold in sources_out(rows).items():
        if FEWEST_TRAINED <= len(fold.kept) < folds:
            raise ConfigError(
                f"{config}: yields.honest.folds = {folds}: at most {len(fold.kept)}, the runs without source {name}"
            )


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
