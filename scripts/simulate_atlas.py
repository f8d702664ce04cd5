"""Simulates some rows of the design of the atlas; those that the included table has are taken from it.

Training rows that the included atlas would learn little from are skipped.

Settings: the first row of the batch, and the number of its rows.
Inputs: `held_out`, the table of the held-out mills; `included` and `atlas`, the table of simulations and the model that
come with the library.
Outputs: `rows`.
"""

from pathlib import Path

from millprint.atlas.atlas_model import read_model
from millprint.atlas.design import rows_of, simulate_rows
from millprint.run.files import read_table, write_table
from millprint.run.job import job

if "snakemake" in globals():
    given, own, (first, count) = snakemake.input, snakemake.wildcards, snakemake.params.rows
    with job(snakemake.log[0], f"atlas {own.kind} {own.part} {own.batch}"):
        output = snakemake.output.rows
        rows = rows_of(own.kind, own.part, first, count, given.held_out)
        title = f"{own.kind}, {own.part} {first} to {first + count - 1}"
        # A killed job continues from the rows that are done.
        done, known = Path(output).with_suffix(".done"), (read_table(given.included), read_model(given.atlas))
        write_table(simulate_rows(rows, done, title, *known), output, digits=6)
