"""Tabulates how long every job took, and what the run was made with."""

from pathlib import Path

import pandas as pd

from millprint.files import whole_file, write_table
from millprint.job import job
from millprint.machine import provenance
from millprint.report.runtimes import sum_stages, tabulate_runtimes
from millprint.report.tables import Section, tables_page


def main(name: str, benchmarks: str, logs: str, output) -> None:
    """Write the table of jobs and the page."""
    jobs = tabulate_runtimes(Path(benchmarks), Path(logs))
    made_with = pd.DataFrame(provenance().items(), columns=["what", "version"])
    write_table(jobs, output.runtimes)
    sections = [
        Section("Stages", sum_stages(jobs), "Wall times of all jobs of a stage added up; jobs run side by side."),
        Section("Made with", made_with),
        Section("Every job", jobs, "Jobs without processor time have no benchmark; their time comes from their log."),
    ]
    total = jobs["wall_s"].sum() / 60
    introduction = f"Run {name}: {len(jobs)} jobs, {total:.0f} minutes of wall time in all."
    with whole_file(output.html) as partial:
        partial.write_text(tables_page("Runtime and versions", introduction, sections))


if "snakemake" in globals():
    with job(snakemake.log[0], "tabulate runtimes"):
        main(snakemake.params.name, snakemake.params.benchmarks, snakemake.params.logs, snakemake.output)
