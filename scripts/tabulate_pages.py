"""Writes a page of tables for each of some chapters, to sort and filter, and how long every job of the run took.

params: `chapters`, `name`, `results`, and the folders `benchmarks` and `logs`. input: `tables`. output: `pages`, and
`runtimes` with its page `html`.
"""

from pathlib import Path

import pandas as pd
from markupsafe import Markup

from millprint.provenance.inside import CRATE
from millprint.run.files import whole_file, write_table
from millprint.run.job import job
from millprint.run.machine import provenance
from millprint.thesis.report.claims_page import sum_stages, tabulate_runtimes
from millprint.thesis.report.table_pages import Section, tables_page, write_chapter


def write_runtimes(name: str, benchmarks: str, logs: str, output) -> None:
    """Write the table of jobs and the page."""
    jobs = tabulate_runtimes(Path(benchmarks), Path(logs))
    made_with = pd.DataFrame(provenance().items(), columns=["what", "version"])
    write_table(jobs, output.runtimes)
    note = Markup(
        '<a href="../{}">{}</a> has all of this, every input and file with its digest, and the dates.'
    ).format(CRATE, CRATE)
    sections = [
        Section("Stages", sum_stages(jobs), "Wall times of all jobs of a stage added up; jobs run side by side."),
        Section("Made with", made_with, note),
        Section("Every job", jobs, "Jobs without processor time have no benchmark; their time comes from their log."),
    ]
    total = jobs["wall_s"].sum() / 60
    introduction = f"Run {name}: {len(jobs)} jobs, {total:.0f} minutes of wall time in all."
    with whole_file(output.html) as partial:
        partial.write_text(tables_page("Runtime and versions", introduction, sections))


if "snakemake" in globals():
    chapters = snakemake.params.chapters
    with job(snakemake.log[0], f"show the tables of {', '.join(chapters)}"):
        tables = list(snakemake.input.tables)
        for chapter, page in zip(chapters, snakemake.output.pages, strict=True):
            write_chapter(chapter, snakemake.params.name, tables, snakemake.params.results, page)
        own = snakemake.params
        write_runtimes(own.name, own.benchmarks, own.logs, snakemake.output)
