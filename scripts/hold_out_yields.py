"""Predicts the screening runs of every outer fold with models that were tuned and fitted without them.

Settings: yields.training, yields.evaluation, yields.averaging.
Inputs: `train` and `test`.
Outputs: `predictions` and `intervals`.
"""

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.yields import AveragingConfig, HeldOutConfig, TrainingConfig
from millprint.run.files import write_table
from millprint.run.job import job, progress
from millprint.thesis.yields.experiments import read_rows
from millprint.thesis.yields.held_out import outer_folds, predict_held_out, procedure_of


def main(
    train: str,
    test: str,
    predictions_path: str,
    intervals_path: str,
    model: str,
    strategy: str,
    training: TrainingConfig,
    budget: HeldOutConfig,
    averaging: AveragingConfig,
) -> None:
    """Write held-out predictions and their intervals for every scheme."""
    parts = [read_rows(train).assign(role="train"), read_rows(test).assign(role="test")]
    rows = pd.concat(parts, ignore_index=True)
    procedure = procedure_of(model, strategy, training, budget, averaging)
    folds = outer_folds(rows, budget)
    with threadpool_limits(1), progress(len(folds), f"holding out {model} {strategy}", "fold") as bar:
        predictions, intervals = predict_held_out(procedure, rows, folds, budget.nominal, bar.update)
    write_table(predictions, predictions_path)
    write_table(intervals, intervals_path)


if "snakemake" in globals():
    given, output, own, names = snakemake.input, snakemake.output, snakemake.params, snakemake.wildcards
    with job(snakemake.log[0], f"hold out {names.model} {names.strategy}"):
        main(
            given.train,
            given.test,
            output.predictions,
            output.intervals,
            names.model,
            names.strategy,
            TrainingConfig(**own.training),
            HeldOutConfig(**own.evaluation),
            AveragingConfig(**own.averaging),
        )
