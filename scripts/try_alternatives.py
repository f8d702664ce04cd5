"""What the averaged process is compared with: other libraries, and yields that were shuffled.

Settings: yields.training, yields.evaluation, yields.averaging, yields.library_trial.
Inputs: `train` and `test`.
Outputs: `libraries`; or `permutations` and `permutation_test`.
"""

from collections.abc import Sequence

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.averaged_process import AveragingConfig
from millprint.config.yields import HeldOutConfig, LibraryTrialConfig, TrainingConfig
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.run.progress import progress
from millprint.thesis.yields.evaluation import WHOLE
from millprint.thesis.yields.held_out import outer_folds
from millprint.thesis.yields.library_trials import compare_libraries, permutation_p, permute
from millprint.thesis.yields.metrics import YieldWeights
from millprint.thesis.yields.run_tables import read_rows


def try_libraries(
    train: str,
    test: str,
    libraries_path: str,
    training: TrainingConfig,
    budget: HeldOutConfig,
    averaging: AveragingConfig,
    trial: LibraryTrialConfig,
) -> None:
    """Write scores of the library, of the one before it and of random halves of both."""
    parts = [read_rows(train).assign(role="train"), read_rows(test).assign(role="test")]
    rows = pd.concat(parts, ignore_index=True)
    folds = [fold for fold in outer_folds(rows, budget) if fold.scheme in WHOLE]
    with threadpool_limits(1), progress(len(folds), "comparing libraries", "fold") as bar:
        table = compare_libraries(rows, folds, averaging, trial, YieldWeights.of(training), bar.update)
    write_table(table, libraries_path)


def try_shuffles(parts: Sequence[str], output, averaging: AveragingConfig, trial: LibraryTrialConfig) -> None:
    """Write the score of every shuffle of the yields, and the p-value: could chance score as well?"""
    rows = pd.concat([read_rows(path) for path in parts], ignore_index=True)
    with threadpool_limits(1), progress(trial.permutations + 1, "permuting yields", "shuffle") as bar:
        table = permute(rows, averaging, trial, bar.update)
    write_table(table, output.permutations)
    write_table(permutation_p(table), output.permutation_test)


if "snakemake" in globals():
    made, own = snakemake.output, snakemake.params
    parts = snakemake.input.train, snakemake.input.test
    averaging, trial = AveragingConfig(**own.averaging), LibraryTrialConfig(**own.trial)
    with job(snakemake.log[0], "try alternatives") as log:
        if made.get("libraries"):
            training = TrainingConfig(**own.training)
            try_libraries(*parts, made.libraries, training, HeldOutConfig(**own.evaluation), averaging, trial)
            log.info("tried: libraries")
        if made.get("permutations"):
            try_shuffles(parts, made, averaging, trial)
            log.info("tried: shuffled yields")
