"""The pages of the report: which conclusions stand, claims with verdicts and errata, tables by chapter, and run times.

Settings: name; the folders of results, benchmarks and logs.
Inputs: `claims`, `intervals`, `by_jar`, `verdicts`, `conclusions`, and the `tables` that pages show.
Outputs: `summary`, `page`, `front` and the tables `claims`, `conclusions`, `counts`, `natures`, `errata`,
`elsewhere`; `pages`, one for each chapter; `runtimes` with its page `html`.
"""

from pathlib import Path

import pandas as pd
from markupsafe import Markup

from millprint.provenance.lineage import CRATE
from millprint.report.table_pages import Section, tables_page, write_chapter
from millprint.run.files import read_table, whole_file, write_table
from millprint.run.job import job
from millprint.run.machine import provenance
from millprint.thesis.claims.conclusions import (
    compare_verdicts,
    in_a_line,
    judge_conclusions,
    read_conclusions,
    read_stored,
)
from millprint.thesis.claims.errata import collect_errata
from millprint.thesis.claims.tabulate import collect_findings, count_verdicts, tabulate_claims
from millprint.thesis.report.claims_page import (
    claims_page,
    front_text,
    sum_stages,
    summary_page,
    tabulate_runtimes,
    what_falls,
)
from millprint.thesis.surrogate.measures import told_against


def write_page(text: str, path: str) -> None:
    with whole_file(path) as partial:
        partial.write_text(text)


def first_sentences(results: str) -> dict[str, str]:
    """What is said first of a chapter: of chapter 6, whether any network beats what needs none."""
    path = Path(results) / "surrogate/against_baselines.tsv"
    return {"chapter 6": told_against(read_table(path, text=["test", "verdict"]))} if path.exists() else {}


def main(name: str, results: str, inputs, output) -> str:
    """Compare every claim with the tables in `results`, and those with an interval by that too.

    Returns a line on the verdicts that differ from those that another machine gave to a run of this name.
    """
    intervals = read_table(inputs.intervals, text=["lower", "upper"])
    by_jar = read_table(inputs.by_jar, text=["id", "value"])
    findings = collect_findings(results, inputs.claims, intervals=intervals, jars=by_jar)
    table = tabulate_claims(inputs.claims, findings)
    errata = collect_errata(results, Path(inputs.claims).parent, table, findings)
    conclusions = judge_conclusions(read_conclusions(inputs.conclusions, table["id"]), table)
    stored = read_stored(inputs.verdicts)
    differences = compare_verdicts(table, stored, name)
    told = in_a_line(differences, stored, name)
    written = {
        "claims": table,
        "conclusions": conclusions,
        "elsewhere": differences,
        "counts": count_verdicts(table),
        "natures": count_verdicts(table, "nature"),
        "errata": errata,
    }
    for key, one in written.items():
        write_table(one, getattr(output, key))
    falls = what_falls(table, conclusions, stored, name)
    sentences = [*falls, f"{told[0].upper()}{told[1:]}."]
    first = first_sentences(results)
    write_page(front_text(conclusions, falls, first), output.front)
    told_first = [*first.values(), *sentences]
    write_page(summary_page(name, table, conclusions, errata, Path(results), told_first), output.summary)
    write_page(claims_page(name, table, findings, Path(results)), output.page)
    return told


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
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    with job(snakemake.log[0], "write pages") as logger:
        told = main(own.name, own.results, given, made)
        logger.info("wrote %s; %s", made.claims, told)
        # Printed too, so that whoever runs the thesis sees it.
        print(told)
        for chapter, page in zip(own.chapters, made.pages, strict=True):
            begin = first_sentences(own.results).get(f"chapter {chapter}", "")
            write_chapter(chapter, own.name, list(given.tables), own.results, page, begin)
        write_runtimes(own.name, own.benchmarks, own.logs, made)
