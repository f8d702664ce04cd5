"""Tabulate power and run time against Young's modulus."""

from millprint.dem.modulus import modulus_table
from millprint.files import read_json, write_table
from millprint.job import job

if "snakemake" in globals():
    with job(snakemake.log[0], "tabulate modulus"):
        write_table(modulus_table([read_json(path) for path in snakemake.input.summaries]), snakemake.output.table)
