"""Writes the Workflow Run RO-Crate of a run next to its results.

Settings: the files of the configuration and of the workflow, and the folder of results.
Inputs: `targets`, `configuration`.
Outputs: `crate`, and copies of what was read in the folder `sources`.
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
