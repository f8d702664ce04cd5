"""Joins the batches of the simulations of the atlas.

Settings: none.
Inputs: `rows`, a table for each batch.
Outputs: `table`.
"""

import pandas as pd

from millprint.run.files import read_table, write_table
from millprint.run.job import job

if "snakemake" in globals():
    with job(snakemake.log[0], "tabulate atlas"):
        table = pd.concat([read_table(path) for path in snakemake.input.rows], ignore_index=True)
        write_table(table, snakemake.output.table, digits=6)
