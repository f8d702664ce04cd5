"""Permutation test of the averaged process: could it score as well if the yields had nothing to do with the runs?"""

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.averaging import AveragingConfig
from millprint.config.yields import LibraryTrialConfig
from millprint.files import write_table
from millprint.job import job
from millprint.predict.library_trials import permutation_p, permute
from millprint.predict.tables import read_rows
from millprint.progress import progress


def main(parts: list[str], output, averaging: AveragingConfig, trial: LibraryTrialConfig) -> None:
    """Write the score of every shuffle, and the p-value."""
    rows = pd.concat([read_rows(path) for path in parts], ignore_index=True)
    with threadpool_limits(1), progress(trial.permutations + 1, "permuting yields", "shuffle") as bar:
        table = permute(rows, averaging, trial, bar.update)
    write_table(table, output.permutations)
    write_table(permutation_p(table), output.test)


if "snakemake" in globals():
    with job(snakemake.log[0], "permute yields"):
        main(
            list(snakemake.input),
            snakemake.output,
            AveragingConfig(**snakemake.params.averaging),
            LibraryTrialConfig(**snakemake.params.trial),
        )
