"""Tabulates the simulations of the sweeps, of either engine.

Settings: none.
Inputs: `summaries`, with a run.h5 next to each.
Outputs: `table` (simulations.tsv): power, speed of the balls, contacts between balls, toe and shoulder.
"""

from millprint.run.files import write_table
from millprint.run.job import job
from millprint.validation.tumbling_runs import tabulate

if "snakemake" in globals():
    with job(snakemake.log[0], "simulations"):
        write_table(tabulate(snakemake.input.summaries), snakemake.output.table)
