"""Collects how often new simulations are within the bands of several mills, with a sum over the mills.

params: names of `mills`. input: the coverage table of each, in this order. output: `table`.
"""

from millprint.fingerprint.unseen_runs import sum_coverage
from millprint.run.files import read_table, write_table
from millprint.run.job import job

if "snakemake" in globals():
    with job(snakemake.log[0], "collect the coverage of the mills") as logger:
        names = snakemake.params.mills
        tables = {name: read_table(path) for name, path in zip(names, snakemake.input, strict=True)}
        found = sum_coverage(tables)
        write_table(found, snakemake.output.table)
        for row in found[found["quantity"] == "powers"].itertuples():
            logger.info("%s: %d of %d powers of new simulations", row.mill, row.held, row.conditions)
