"""Writes the table of every claim of the thesis with its verdict, its summary by chapter, and the errata."""

from pathlib import Path

from millprint.claims.errata import collect_errata
from millprint.claims.tabulate import collect_findings, count_verdicts, tabulate_claims
from millprint.figures.claims import plot_verdicts
from millprint.figures.style import save
from millprint.files import whole_file, write_table
from millprint.job import job
from millprint.report.summary import summary_page
from millprint.report.tables import Section, tables_page


def write_page(text: str, path: str) -> None:
    with whole_file(path) as partial:
        partial.write_text(text)


def main(name: str, results: str, claims_path: str, output) -> None:
    """Compare every claim with the tables in `results`."""
    data = Path(claims_path).parent
    table = tabulate_claims(claims_path, collect_findings(Path(results), data))
    counts, errata = count_verdicts(table), collect_errata(Path(results), data, table)
    write_table(table, output.claims)
    write_table(counts, output.counts)
    write_table(errata, output.errata)
    write_page(summary_page(name, table, counts, errata), output.summary)
    note = "Deviation in per cent of the printed value. claims.tsv also says of what kind a claim is."
    every = Section("Every claim", table.drop(columns="kind"), note, cards=True)
    introduction = f"Every number that the thesis states, what the run {name} computed for it, and the verdict."
    write_page(tables_page("Claims of the thesis", introduction, [every]), output.page)
    save(plot_verdicts(counts), output.svg, output.png)


if "snakemake" in globals():
    with job(snakemake.log[0], "tabulate claims") as logger:
        main(snakemake.params.name, snakemake.params.results, snakemake.input.claims, snakemake.output)
        logger.info("wrote %s", snakemake.output.claims)
