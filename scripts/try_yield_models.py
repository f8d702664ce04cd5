"""Leave-one-out cross-validation of alternative yield models."""

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.averaging import AveragingConfig
from millprint.config.yields import TrainingConfig
from millprint.doe.runs import YIELD
from millprint.files import write_table
from millprint.job import job
from millprint.predict.metrics import YieldWeights
from millprint.predict.tables import read_rows
from millprint.predict.trials import run_trials, trial_table
from millprint.progress import progress


def main(parts: list[str], tried_path: str, training: TrainingConfig, averaging: AveragingConfig) -> None:
    """Write one row for each model."""
    rows = pd.concat([read_rows(path) for path in parts], ignore_index=True)
    with threadpool_limits(1), progress(len(rows), "trying yield models", "run") as bar:
        trials = run_trials(rows, averaging, training.seed, bar.update)
    write_table(trial_table(trials, rows[YIELD].to_numpy(float), YieldWeights.of(training)), tried_path)


if "snakemake" in globals():
    with job(snakemake.log[0], "try yield models"):
        main(
            list(snakemake.input),
            snakemake.output.tried,
            TrainingConfig(**snakemake.params.training),
            AveragingConfig(**snakemake.params.averaging),
        )
