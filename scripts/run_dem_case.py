"""Simulates one case of a sweep."""

import sys

from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig, threads_of
from millprint.dem.run import run_case
from millprint.job import job

if "snakemake" in globals():
    with job(snakemake.log[0], f"DEM {snakemake.params.case['mill']}/{snakemake.params.case['contact']}"):
        case, dem = Case(**snakemake.params.case), DemConfig(**snakemake.params.settings)
        if snakemake.threads < threads_of(case, dem):
            print(
                f"warning: {case.path} has {threads_of(case, dem)} threads and gets {snakemake.threads} cores, "
                "so that it is slower; raise --cores",
                file=sys.stderr,
            )
        run_case(
            case,
            MillConfig(**snakemake.params.mill),
            ContactConfig(**snakemake.params.contact),
            dem,
            snakemake.output.run,
            snakemake.output.summary,
            cores=snakemake.threads,
        )
