"""Simulate one case of a sweep."""

from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.run import run_case
from millprint.job import job

if "snakemake" in globals():
    with job(snakemake.log[0], f"DEM {snakemake.params.case['mill']}/{snakemake.params.case['contact']}"):
        run_case(
            Case(**snakemake.params.case),
            MillConfig(**snakemake.params.mill),
            ContactConfig(**snakemake.params.contact),
            DemConfig(**snakemake.params.settings),
            snakemake.output.run,
            snakemake.output.summary,
            cores=snakemake.threads,
        )
