"""Tabulates descriptors against the time step or against Young's modulus."""

from millprint.dem.convergence import convergence_table
from millprint.files import read_json, write_table
from millprint.job import job

if "snakemake" in globals():
    with job(snakemake.log[0], f"tabulate convergence in {snakemake.params.varied}") as logger:
        logger.info("%d simulations", len(snakemake.input.summaries))
        write_table(
            convergence_table(
                [read_json(path) for path in snakemake.input.summaries],
                snakemake.params.varied,
                snakemake.params.counting_rule,
                snakemake.params.further_rules,
            ),
            snakemake.output.table,
        )
