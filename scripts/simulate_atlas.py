"""Simulates some rows of the design of the atlas; those that the included table has are taken from it.

Training rows that the included atlas would learn little from are skipped.

Settings: the number of rows of a batch.
Inputs: `held_out`, the table of the held-out mills; `included` and `atlas`, the table of simulations and the model that
come with the library.
Outputs: `rows`.
"""

from pathlib import Path

import pandas as pd

from millprint.atlas.atlas_model import read_model
from millprint.atlas.design import rows_of, simulate_rows
from millprint.run.files import read_table, write_table
from millprint.run.job import job


def main(output: str, kind: str, part: str, number: int, batch: int, given) -> pd.DataFrame:
    """Simulate the batch of that number, and write it; a killed job continues from the rows that are done."""
    rows = rows_of(kind, part, number * batch, batch, given.held_out)
    title = f"{kind}, {part} {number * batch} to {number * batch + len(rows) - 1}"
    table = simulate_rows(
        rows, Path(output).with_suffix(".done"), title, read_table(given.included), read_model(given.atlas)
    )
    write_table(table, output, digits=6)
    return table


if "snakemake" in globals():
    own = snakemake.wildcards
    with job(snakemake.log[0], f"atlas {own.kind} {own.part} {own.batch}"):
        main(snakemake.output.rows, own.kind, own.part, int(own.batch), snakemake.params.batch, snakemake.input)
