"""Simulates some rows of the design of the atlas; those that the included table has are taken from it.

Settings: the number of rows of a batch.
Inputs: `held_out`, the table of the held-out mills; `included`, the table of simulations that comes with the library.
Outputs: `rows`.
"""

from pathlib import Path

import pandas as pd

from millprint.atlas.design import rows_of
from millprint.atlas.simulate_rows import simulate_rows
from millprint.run.files import read_table, write_table
from millprint.run.job import job


def main(output: str, kind: str, part: str, number: int, batch: int, held_out: str, included: str) -> pd.DataFrame:
    """Simulate the batch of that number, and write it; a killed job continues from the rows that are done."""
    rows = rows_of(kind, part, number * batch, batch, held_out)
    title = f"{kind}, {part} {number * batch} to {number * batch + len(rows) - 1}"
    table = simulate_rows(rows, Path(output).with_suffix(".done"), title, read_table(included))
    write_table(table, output, digits=6)
    return table


if "snakemake" in globals():
    own = snakemake.wildcards
    with job(snakemake.log[0], f"atlas {own.kind} {own.part} {own.batch}"):
        place, batch = snakemake.output.rows, snakemake.params.batch
        main(place, own.kind, own.part, int(own.batch), batch, snakemake.input.held_out, snakemake.input.included)
