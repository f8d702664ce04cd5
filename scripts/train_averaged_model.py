"""Fits the averaged Gaussian process on some rows and stores it."""

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.averaging import AveragingConfig
from millprint.doe.runs import YIELD
from millprint.files import write_table
from millprint.job import job
from millprint.predict.averaging import describe_members, fit_averaged
from millprint.predict.model_files import save_averaged
from millprint.predict.tables import read_rows


def main(parts: list[str], model_path: str, members_path: str, settings: AveragingConfig) -> None:
    """Train only on the rows of `parts`."""
    rows = pd.concat([read_rows(path) for path in parts], ignore_index=True)
    with threadpool_limits(1):
        model = fit_averaged(rows, rows[YIELD].to_numpy(float), settings)
        save_averaged(model, rows, settings.margin, model_path)
    write_table(describe_members(model), members_path)


if "snakemake" in globals():
    with job(snakemake.log[0], f"train averaged model {snakemake.wildcards.rows}"):
        main(
            list(snakemake.input),
            snakemake.output.model,
            snakemake.output.members,
            AveragingConfig(**snakemake.params.settings),
        )
