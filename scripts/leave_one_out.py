"""Predicts every screening run by a model that was tuned and fitted without it."""

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.yields import HonestConfig, TrainingConfig
from millprint.files import write_table
from millprint.job import job, progress
from millprint.predict.honest import leave_one_out
from millprint.predict.tables import read_rows


def main(
    parts: list[str],
    predictions: str,
    model: str,
    strategy: str,
    settings: TrainingConfig,
    budget: HonestConfig,
    threads: int = 1,
) -> None:
    """Write a held-out prediction for each row of `parts`."""
    rows = pd.concat([read_rows(path) for path in parts], ignore_index=True)
    with threadpool_limits(threads), progress(len(rows), f"leave-one-out {model} {strategy}", "run") as bar:
        write_table(leave_one_out(model, strategy, rows, settings, budget, threads, bar.update), predictions)


if "snakemake" in globals():
    with job(snakemake.log[0], f"leave one out {snakemake.wildcards.model} {snakemake.wildcards.strategy}"):
        main(
            [snakemake.input.train, snakemake.input.test],
            snakemake.output.predictions,
            snakemake.wildcards.model,
            snakemake.wildcards.strategy,
            TrainingConfig(**snakemake.params.training),
            HonestConfig(**snakemake.params.honest),
            threads=snakemake.threads,
        )
