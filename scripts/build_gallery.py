"""Builds the gallery: every figure of a run with its caption, its tables, and how it was made.

Settings: name; the figures as the workflow lists them, and the folder of results.
Inputs: the files of the run, which name the figures.
Outputs: `html`.
"""

from pathlib import Path

from millprint.config.errors import ConfigError
from millprint.provenance.lineage import read_jobs
from millprint.run.files import whole_file
from millprint.run.job import job
from millprint.run.machine import commit
from millprint.thesis.report.gallery import Listed, gallery_page, show


def main(figures: list[dict], results: str, config: dict, output: str) -> int:
    """Write the page of `figures`, as `Listed` has them, from the folder `results`; returns their number."""
    jobs, folder = read_jobs(), Path(results)
    shown = []
    for listed in (Listed(**figure) for figure in figures):
        if (drawn := jobs.get(str(folder / listed.path))) is None:
            raise ConfigError(f"{folder / listed.path}: Snakemake has no record of the job that drew this figure")
        shown.append((listed.stage, show(listed, folder, drawn, config)))
    with whole_file(output) as partial:
        partial.write_text(gallery_page(config["name"], shown, commit()))
    return len(shown)


if "snakemake" in globals():
    given = snakemake.params
    with job(snakemake.log[0], "build gallery") as logger:
        count = main(given.figures, given.results, snakemake.config, snakemake.output.html)
        logger.info("%s: %d figures", snakemake.output.html, count)
