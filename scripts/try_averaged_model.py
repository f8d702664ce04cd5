"""Could chance score as well as the averaged process?

Settings: yields.averaging, yields.library_trial.
Inputs: `train` and `test`.
Outputs: `permutations` and `permutation_test`, of shuffled yields.
"""

from collections.abc import Sequence

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.yields import AveragingConfig, LibraryTrialConfig
from millprint.run.files import write_table
from millprint.run.job import job, progress
from millprint.thesis.yields.averaging import permutation_p, permute
from millprint.thesis.yields.experiments import read_rows


def main(parts: Sequence[str], output, averaging: AveragingConfig, trial: LibraryTrialConfig) -> None:
    """Write the score of every shuffle of the yields, and the p-value."""
    rows = pd.concat([read_rows(path) for path in parts], ignore_index=True)
    with threadpool_limits(1), progress(trial.permutations + 1, "permuting yields", "shuffle") as bar:
        table = permute(rows, averaging, trial, bar.update)
    write_table(table, output.permutations)
    write_table(permutation_p(table), output.permutation_test)


if "snakemake" in globals():
    given, own = snakemake.input, snakemake.params
    with job(snakemake.log[0], "try the averaged model"):
        settings = AveragingConfig(**own.averaging), LibraryTrialConfig(**own.trial)
        main([given.train, given.test], snakemake.output, *settings)
