"""Sliding work of runs by what slides, and its means over seeds."""

from millprint.dose.sliding import mean_conditions, tabulate_sliding
from millprint.files import write_table
from millprint.job import job


def main(runs: list[str], summaries: list[str], output) -> None:
    """Write a row for each run, and one for each condition."""
    table = tabulate_sliding(list(zip(runs, summaries, strict=True)))
    write_table(table, output.runs)
    write_table(mean_conditions(table), output.conditions)


if "snakemake" in globals():
    with job(snakemake.log[0], "measure sliding"):
        main(snakemake.input.runs, snakemake.input.summaries, snakemake.output)
