"""Scores of the averaged process's library, of the one before it, and of random halves of both."""

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.averaging import AveragingConfig
from millprint.config.yields import HeldOutConfig, LibraryTrialConfig, TrainingConfig
from millprint.files import write_table
from millprint.job import job
from millprint.predict.held_out import outer_folds
from millprint.predict.library_trials import compare_libraries
from millprint.predict.metrics import YieldWeights
from millprint.predict.scores import WHOLE
from millprint.predict.tables import read_rows
from millprint.progress import progress


def main(
    train: str,
    test: str,
    output,
    training: TrainingConfig,
    budget: HeldOutConfig,
    averaging: AveragingConfig,
    trial: LibraryTrialConfig,
) -> None:
    """Write the table of libraries and that of their members."""
    parts = [read_rows(train).assign(role="train"), read_rows(test).assign(role="test")]
    rows = pd.concat(parts, ignore_index=True)
    folds = [fold for fold in outer_folds(rows, budget) if fold.scheme in WHOLE]
    with threadpool_limits(1), progress(len(folds), "comparing libraries", "fold") as bar:
        table, members = compare_libraries(rows, folds, averaging, trial, YieldWeights.of(training), bar.update)
    write_table(table, output.libraries)
    write_table(members, output.members)


if "snakemake" in globals():
    with job(snakemake.log[0], "compare libraries"):
        main(
            snakemake.input.train,
            snakemake.input.test,
            snakemake.output,
            TrainingConfig(**snakemake.params.training),
            HeldOutConfig(**snakemake.params.honest),
            AveragingConfig(**snakemake.params.averaging),
            LibraryTrialConfig(**snakemake.params.trial),
        )
