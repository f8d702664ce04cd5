"""Predicts the screening runs of every outer fold with models that were tuned and fitted without them."""

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.averaging import AveragingConfig
from millprint.config.yields import HeldOutConfig, TrainingConfig
from millprint.files import write_table
from millprint.job import job, progress
from millprint.predict.honest import outer_folds, predict_held_out
from millprint.predict.learners import make_learner
from millprint.predict.tables import read_rows


def main(
    train: str,
    test: str,
    output,
    model: str,
    strategy: str,
    training: TrainingConfig,
    honest: HeldOutConfig,
    averaging: AveragingConfig,
) -> None:
    """Write held-out predictions and their intervals for every scheme."""
    parts = [read_rows(train).assign(role="train"), read_rows(test).assign(role="test")]
    rows = pd.concat(parts, ignore_index=True)
    learn = make_learner(model, strategy, training, honest, averaging)
    folds = outer_folds(rows, honest)
    with threadpool_limits(1), progress(len(folds), f"holding out {model} {strategy}", "fold") as bar:
        predicted, enclosed = predict_held_out(learn, rows, folds, honest.nominal, bar.update)
    write_table(predicted, output.predictions)
    write_table(enclosed, output.intervals)


if "snakemake" in globals():
    with job(snakemake.log[0], f"hold out {snakemake.wildcards.model} {snakemake.wildcards.strategy}"):
        main(
            snakemake.input.train,
            snakemake.input.test,
            snakemake.output,
            snakemake.wildcards.model,
            snakemake.wildcards.strategy,
            TrainingConfig(**snakemake.params.training),
            HeldOutConfig(**snakemake.params.honest),
            AveragingConfig(**snakemake.params.averaging),
        )
