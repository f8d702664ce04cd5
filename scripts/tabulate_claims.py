"""Writes which conclusions of the thesis stand, every claim with its verdicts, counts of them, and the errata.

params: `name` of the run, and the folder `results`. input: `claims`, `intervals`, `verdicts`, `conclusions`. output:
the tables, and the pages of the report.
"""

from pathlib import Path

from millprint.figures.style import save
from millprint.run.files import read_table, whole_file, write_table
from millprint.run.job import job
from millprint.thesis.claims.conclusions import (
    compare_verdicts,
    in_a_line,
    judge_conclusions,
    read_conclusions,
    read_stored,
)
from millprint.thesis.claims.errata import collect_errata
from millprint.thesis.claims.tabulate import collect_findings, count_verdicts, tabulate_claims
from millprint.thesis.report.claims_page import claims_page, front_text, plot_verdicts, summary_page, what_falls


def write_page(text: str, path: str) -> None:
    with whole_file(path) as partial:
        partial.write_text(text)


def main(name: str, results: str, inputs, output) -> str:
    """Compare every claim with the tables in `results`, and those with an interval by that too.

    Returns a line on the verdicts that differ from those that another machine gave to a run of this name.
    """
    intervals = read_table(inputs.intervals, text=["lower", "upper"])
    findings = collect_findings(results, inputs.claims, intervals=intervals)
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
    write_page(front_text(conclusions, falls), output.front)
    write_page(summary_page(name, table, conclusions, errata, Path(results), sentences), output.summary)
    write_page(claims_page(name, table, findings, Path(results)), output.page)
    save(plot_verdicts(written["counts"]), output.svg, output.png)
    return told


if "snakemake" in globals():
    with job(snakemake.log[0], "tabulate claims") as logger:
        told = main(snakemake.params.name, snakemake.params.results, snakemake.input, snakemake.output)
        logger.info("wrote %s; %s", snakemake.output.claims, told)
        # Printed too, so that whoever runs the thesis sees it.
        print(told)
