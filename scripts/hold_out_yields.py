"""Predicts runs by models that were tuned and fitted without them: of every outer fold, or of whole groups.

Groups are fill ratios of other regimes, and the runs of other laboratories and mills, which no training row covers.

Settings: yields.training, yields.evaluation, yields.averaging; of groups yields.prediction, yields.other_sources,
doe.factors and the mill too.
Inputs: `train` and `test`; of groups `screening`, `split`, `regimes`, `others` and their `fingerprints` too.
Outputs: `predictions` and `intervals`; or `regimes`, `regimes_summary`, `sources`, `sources_predictions` and
`sources_runs`.
"""

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.doe import Factor
from millprint.config.mill import MillConfig
from millprint.config.yields import (
    PRIMARY,
    TWO_STEP,
    AveragingConfig,
    EvaluationConfig,
    HeldOutConfig,
    OtherSourcesConfig,
    PredictionConfig,
    TrainingConfig,
)
from millprint.observables.condition import Condition
from millprint.run.files import write_table
from millprint.run.job import job, progress
from millprint.thesis.regimes import read_regimes
from millprint.thesis.yields.experiments import GIVEN, read_other_runs, read_parts, read_rows, with_other_runs
from millprint.thesis.yields.groups import (
    leave_regimes_out,
    leave_sources_out,
    reference_of_mill,
    regime_rows,
    score_sources,
    sources_out,
    summarise_regimes,
)
from millprint.thesis.yields.held_out import Procedure, outer_folds, predict_held_out, procedure_of
from millprint.thesis.yields.regressors import AVERAGED

# For regimes, the averaged Gaussian process with and without the tangential share, and the two models of Table 5.8, the
# process with the start of the largest marginal likelihood.
REGIME_PROCEDURES = {
    (AVERAGED, "power and share"): (AVERAGED, PRIMARY, False),
    (AVERAGED, "power alone"): (AVERAGED, PRIMARY, True),
    ("gpr_starts two_step", "energies and frequency"): ("gpr_starts", TWO_STEP, False),
    ("xgb two_step", "energies and frequency"): ("xgb", TWO_STEP, False),
}
# For sources, the averaged Gaussian process, the best model of Table 5.6, and its baseline.
SOURCE_MODELS = [(AVERAGED, PRIMARY), ("gpr_starts", TWO_STEP), ("linear", PRIMARY)]


def leave_regimes(
    parts: list[str], cases: pd.DataFrame, output, reference: Condition[float], models: tuple, level: float
) -> None:
    """Write predictions for every regime left out, without and with one or two cases of it in the training rows.

    models: settings of training, evaluation and averaging.
    """
    screening = pd.concat([read_rows(path) for path in parts], ignore_index=True)
    rows = regime_rows(cases, reference)
    procedures = {
        name: (procedure_of(model, strategy, *models), hidden)
        for name, (model, strategy, hidden) in REGIME_PROCEDURES.items()
    }
    with threadpool_limits(1), progress(len(procedures) * 12, "leaving regimes out", "fit") as bar:
        table = leave_regimes_out(screening, rows, procedures, level, bar.update)
    write_table(table, output.regimes)
    write_table(summarise_regimes(table), output.regimes_summary)


def leave_sources(given, output, own, models: tuple) -> None:
    """Write the runs of all sources, their predictions by models of the other sources, and the scores of every one."""
    factors = [Factor(**factor) for factor in own.factors]
    screening = pd.concat(read_parts(given.screening, given.split, factors), ignore_index=True)
    told = OtherSourcesConfig(**own.other_sources)
    others = read_other_runs(told, {given.screening: screening["case"]}, "the configuration")
    rows = with_other_runs(screening, others, told.own)
    procedures = {key: procedure_of(*key, *models) for key in SOURCE_MODELS}
    limits, level, (_, budget, _) = PredictionConfig(**own.prediction), own.interval_level, models
    fits = len(sources_out(rows)) * len(SOURCE_MODELS)
    with threadpool_limits(1), progress(fits, "leaving sources out", "fit") as bar:
        predictions = leave_sources_out(rows, procedures, limits, level, bar.update)
    # Ours are the descriptors of the screening table.
    origins = [*[GIVEN] * len(screening), *others["descriptors"]]
    write_table(rows.assign(descriptors=origins), output.sources_runs)
    write_table(predictions, output.sources_predictions)
    write_table(score_sources(predictions, rows, budget, level), output.sources)


def hold_out(given, output, name: str, procedure: Procedure, budget: HeldOutConfig) -> None:
    """Write held-out predictions of a model and their intervals for every scheme."""
    parts = [read_rows(given.train).assign(role="train"), read_rows(given.test).assign(role="test")]
    rows = pd.concat(parts, ignore_index=True)
    folds = outer_folds(rows, budget)
    with threadpool_limits(1), progress(len(folds), f"holding out {name}", "fold") as bar:
        predictions, intervals = predict_held_out(procedure, rows, folds, budget.nominal, bar.update)
    write_table(predictions, output.predictions)
    write_table(intervals, output.intervals)


if "snakemake" in globals():
    given, made, own, names = snakemake.input, snakemake.output, snakemake.params, snakemake.wildcards
    training, averaging = TrainingConfig(**own.training), AveragingConfig(**own.averaging)
    with job(snakemake.log[0], "hold out yields"):
        if made.get("predictions"):
            budget = HeldOutConfig(**own.evaluation)
            procedure = procedure_of(names.model, names.strategy, training, budget, averaging)
            hold_out(given, made, f"{names.model} {names.strategy}", procedure, budget)
        else:
            models = training, EvaluationConfig(**own.evaluation), averaging
            leave_sources(given, made, own, models)
            cases = read_regimes(given.regimes)
            reference = reference_of_mill(cases, MillConfig(**own.mill), **own.machine)
            leave_regimes([given.train, given.test], cases, made, reference, models, own.interval_level)
