"""Writes what a run was: its configuration, which can be used again with --configfile; its gallery; the RO-Crate.

Settings: all of them; of the gallery the figures as the workflow lists them, and the folder of results; of the crate
the files of the configuration and of the workflow, and that folder.
Inputs: none; the files of the run, which name the figures; or `targets` and `configuration`.
Outputs: `run`, a YAML file; `html`, every figure with its caption, its tables, and how it was made; or `crate`, and
copies of what was read in the folder `sources`.
"""

import platform
from pathlib import Path

import yaml

from millprint.config.errors import ConfigError
from millprint.run.files import whole_file
from millprint.run.job import job
from millprint.run.machine import commit, package_versions


def build_gallery(figures: list[dict], results: str, config: dict, output: str) -> int:
    """Write the page of `figures`, as `Listed` has them, from the folder `results`; returns their number."""
    # Slow to import, and not needed for the configuration.
    from millprint.provenance.lineage import read_jobs
    from millprint.report.gallery import Listed, gallery_page, show

    jobs, folder = read_jobs(), Path(results)
    shown = []
    for listed in (Listed(**figure) for figure in figures):
        if (drawn := jobs.get(str(folder / listed.path))) is None:
            raise ConfigError(f"{folder / listed.path}: Snakemake has no record of the job that drew this figure")
        shown.append((listed.stage, show(listed, folder, drawn, config)))
    with whole_file(output) as partial:
        partial.write_text(gallery_page(config["name"], shown, commit()))
    return len(shown)


def record(config: dict, output: str) -> None:
    """Write the configuration, headed by the versions of what the run uses."""
    versions = ", ".join(f"{name} {number}" for name, number in package_versions().items())
    head = f"# Python {platform.python_version()}; {versions}\n"
    with whole_file(output) as partial:
        partial.write_text(head + yaml.safe_dump(config, sort_keys=False))


if "snakemake" in globals():
    asked, made, given = snakemake.input, snakemake.output, snakemake.params
    with job(snakemake.log[0], "record run") as logger:
        if made.get("html"):
            count = build_gallery(given.figures, given.results, snakemake.config, made.html)
            logger.info("%s: %d figures", made.html, count)
        elif made.get("crate"):
            from millprint.provenance.crate import write_crate
            from millprint.provenance.lineage import read_jobs

            targets = [*asked.targets, asked.configuration]
            count = write_crate(given.results, targets, list(given.sources), list(given.snakefiles), read_jobs())
            logger.info("%s: %d files", made.crate, count)
        else:
            record(given.config, made.run)
