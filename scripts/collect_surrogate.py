"""Joins the tables of measures of all variants."""

from millprint.files import read_table, write_table
from millprint.job import job
from millprint.surrogate.tables import join_tables

if "snakemake" in globals():
    with job(snakemake.log[0], "collect the surrogate's measures"):
        write_table(join_tables([read_table(part) for part in snakemake.input.metrics]), snakemake.output.metrics)
