"""Writes the Workflow Run RO-Crate of a run next to its results.

params: `results`, `sources`, `snakefiles`. input: `targets`, `configuration`. output: `crate`, `sources`.
"""

from millprint.provenance.crate_files import write_crate
from millprint.provenance.lineage import read_jobs
from millprint.run.job import job

if "snakemake" in globals():
    with job(snakemake.log[0], "write crate") as logger:
        given = snakemake.params
        targets = [*snakemake.input.targets, snakemake.input.configuration]
        count = write_crate(given.results, targets, list(given.sources), list(given.snakefiles), read_jobs())
        logger.info("%s: %d files", snakemake.output.crate, count)
