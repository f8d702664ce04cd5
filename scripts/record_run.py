"""Writes the record of a run: the merged configuration, which can be used again with --configfile, and the RO-Crate.

Settings: all of them; for the crate the files of the configuration and of the workflow, and the folder of results.
Inputs: none; for the crate `targets`, `configuration`.
Outputs: `run`, a YAML file; or `crate`, and copies of what was read in the folder `sources`.
"""

import platform

import yaml

from millprint.run.files import whole_file
from millprint.run.job import job
from millprint.run.machine import package_versions

if "snakemake" in globals():
    asked, made, given = snakemake.input, snakemake.output, snakemake.params
    with job(snakemake.log[0], "record run") as logger:
        if made.get("crate"):
            # Slow to import, and not needed for the configuration.
            from millprint.provenance.crate import write_crate
            from millprint.provenance.lineage import read_jobs

            targets = [*asked.targets, asked.configuration]
            count = write_crate(given.results, targets, list(given.sources), list(given.snakefiles), read_jobs())
            logger.info("%s: %d files", made.crate, count)
        else:
            versions = ", ".join(f"{name} {number}" for name, number in package_versions().items())
            head = f"# Python {platform.python_version()}; {versions}\n"
            with whole_file(made.run) as partial:
                partial.write_text(head + yaml.safe_dump(given.config, sort_keys=False))
