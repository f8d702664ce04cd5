"""Writes the merged configuration of a run, which can be used again with --configfile.

Settings: all of them.
Inputs: none.
Outputs: `run`, a YAML file.
"""

import platform

import yaml

from millprint.run.files import whole_file
from millprint.run.job import job
from millprint.run.machine import package_versions


def main(config: dict, output: str) -> None:
    """Write `config` as YAML, after a comment with the versions of Python and the packages."""
    versions = ", ".join(f"{name} {number}" for name, number in package_versions().items())
    with whole_file(output) as partial:
        partial.write_text(
            f"# Python {platform.python_version()}; {versions}\n{yaml.safe_dump(config, sort_keys=False)}"
        )


if "snakemake" in globals():
    with job(snakemake.log[0], "record run"):
        main(snakemake.params.config, snakemake.output.run)
