"""Analyses the variance of the screening runs, as printed and as corrected, with residuals and interaction means."""

from millprint.config.doe import DoeConfig
from millprint.doe.interactions import interaction_table
from millprint.doe.model import fit_factors
from millprint.doe.residuals import residual_checks, residual_table
from millprint.doe.runs import read_runs
from millprint.doe.variance import corrected_table, printed_table
from millprint.files import write_table
from millprint.job import job


def main(
    screening: str,
    printed: str,
    corrected: str,
    residuals: str,
    residual_checks_path: str,
    interactions: str,
    settings: DoeConfig,
) -> None:
    """Write the tables of the analysis."""
    runs = read_runs(screening, settings)
    fit = fit_factors(settings, runs)
    write_table(printed_table(settings, runs), printed)
    write_table(corrected_table(settings, runs), corrected)
    write_table(residual_table(runs, fit), residuals)
    write_table(residual_checks(fit, settings.simulations, settings.order_seed), residual_checks_path)
    write_table(interaction_table(settings, runs), interactions)


if "snakemake" in globals():
    with job(snakemake.log[0], "analyse variance"):
        main(
            screening=snakemake.input.screening,
            printed=snakemake.output.printed,
            corrected=snakemake.output.corrected,
            residuals=snakemake.output.residuals,
            residual_checks_path=snakemake.output.residual_checks,
            interactions=snakemake.output.interactions,
            settings=DoeConfig(**snakemake.params.settings),
        )
