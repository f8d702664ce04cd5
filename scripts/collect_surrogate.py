"""Puts the tables of several variants and tests under one another."""

from millprint.files import read_table, write_table
from millprint.job import job
from millprint.surrogate.tables import join_tables


def main(parts: list[str], output: str) -> None:
    write_table(join_tables([read_table(part) for part in parts]), output)


if "snakemake" in globals():
    with job(snakemake.log[0], "collect the surrogate's tables"):
        for kind, output in snakemake.output.items():
            main(list(snakemake.input[kind]), output)
