"""Writes the table of every claim of the thesis with its verdict, and its summary by chapter."""

from pathlib import Path

from millprint.claims.tabulate import collect_findings, count_verdicts, tabulate_claims
from millprint.figures.claims import plot_verdicts
from millprint.figures.style import save
from millprint.files import write_table
from millprint.job import job


def main(results: str, claims_path: str, output) -> None:
    """Hold every claim against the tables under `results`."""
    findings = collect_findings(Path(results), Path(claims_path).parent)
    table = tabulate_claims(claims_path, findings)
    counts = count_verdicts(table)
    write_table(table, output.claims)
    write_table(counts, output.summary)
    save(plot_verdicts(counts), output.svg, output.png)


if "snakemake" in globals():
    with job(snakemake.log[0], "tabulate claims") as logger:
        main(snakemake.params.results, snakemake.input.claims, snakemake.output)
        logger.info("wrote %s", snakemake.output.claims)
