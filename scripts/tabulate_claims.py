"""Writes the table of every claim of the thesis with its verdict, its summary by chapter, and the errata."""

from pathlib import Path

from millprint.claims.elsewhere import compare_verdicts, in_a_line, read_stored
from millprint.claims.errata import collect_errata
from millprint.claims.tabulate import collect_findings, count_verdicts, tabulate_claims
from millprint.figures.style import save
from millprint.files import read_table, whole_file, write_table
from millprint.job import job
from millprint.report.summary import claims_page, plot_verdicts, summary_page


def write_page(text: str, path: str) -> None:
    with whole_file(path) as partial:
        partial.write_text(text)


def main(name: str, results: str, claims_path: str, intervals_path: str, stored_path: str, output) -> str:
    """Compare every claim with the tables in `results`, and those with an interval by that.

    Returns a line on the verdicts that differ from those that another machine gave to a run of this name.
    """
    findings = collect_findings(results, claims_path, intervals=read_table(intervals_path, text=["lower", "upper"]))
    table = tabulate_claims(claims_path, findings)
    counts, errata = count_verdicts(table), collect_errata(results, Path(claims_path).parent, table)
    stored = read_stored(stored_path)
    differences = compare_verdicts(table, stored, name)
    told = in_a_line(differences, stored, name)
    write_table(table, output.claims)
    write_table(differences, output.elsewhere)
    write_table(counts, output.counts)
    write_table(errata, output.errata)
    write_page(summary_page(name, table, counts, errata, Path(results), told), output.summary)
    write_page(claims_page(name, table, findings, Path(results)), output.page)
    save(plot_verdicts(counts), output.svg, output.png)
    return told


if "snakemake" in globals():
    with job(snakemake.log[0], "tabulate claims") as logger:
        inputs, own = snakemake.input, snakemake.params
        told = main(own.name, own.results, inputs.claims, inputs.intervals, inputs.verdicts, snakemake.output)
        logger.info("wrote %s; %s", snakemake.output.claims, told)
        # Where whoever runs the thesis sees it.
        print(told)
