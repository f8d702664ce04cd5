"""Splits the screening runs into training and test rows, so that training jobs cannot see a test row.

Runs of others join the training rows only if the configuration says so; the test rows are always those of the split.

Settings: doe.factors, yields.other_sources.
Inputs: `screening` and `split`.
Outputs: `train` and `test`.
"""

import logging

import pandas as pd

from millprint.config.doe import Factor
from millprint.config.yields import OtherSourcesConfig
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.yields.experiments import read_other_runs, read_parts

logger = logging.getLogger("millprint")


def main(
    screening: str, split: str, train_path: str, test_path: str, factors: list[Factor], others: OtherSourcesConfig
) -> None:
    """Write both parts in the order of the split, the runs of others last."""
    train, test = read_parts(screening, split, factors)
    if others.in_training:
        added = read_other_runs(others, {screening: [*train["case"], *test["case"]]}, "the configuration")
        logger.info("%d runs of other sources join the %d training rows", len(added), len(train))
        train = pd.concat([train, added[train.columns]], ignore_index=True)
    write_table(train, train_path)
    write_table(test, test_path)


if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    with job(snakemake.log[0], "split screening runs"):
        factors, others = [Factor(**factor) for factor in own.factors], OtherSourcesConfig(**own.other_sources)
        main(given.screening, given.split, made.train, made.test, factors, others)
