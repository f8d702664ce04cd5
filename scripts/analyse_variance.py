"""Analyses the variance of the screening runs: as printed, as corrected, confounded terms, and residuals."""

from pathlib import Path

from millprint.config.doe import AnalysisConfig
from millprint.doe.contested import contested_table, residual_parts_table, rival_models_table
from millprint.doe.model import fit_factors
from millprint.doe.residuals import lack_of_fit_table, residual_checks, residual_table
from millprint.doe.runs import read_runs
from millprint.doe.trends import interaction_table, trend_table
from millprint.doe.variance import corrected_table, detectable_table, printed_table
from millprint.files import write_table
from millprint.job import job

# The tables of the analysis beside those of the variance, by the names of the rule's outputs.
TABLES = (
    "trends",
    "contested",
    "rival_models",
    "residual_parts",
    "detectable",
    "residuals",
    "residual_checks",
    "lack_of_fit",
    "interactions",
)
# Tables of the variance, by the names of the rule's outputs: the file that holds each.
VARIANCE = {"printed": "anova_printed", "corrected": "anova_corrected"}


def paths_in(folder: str | Path) -> dict[str, str]:
    """The path of every table of the analysis in a folder."""
    files = {**{name: name for name in TABLES}, **VARIANCE}
    return {name: str(Path(folder) / f"{file}.tsv") for name, file in files.items()}


def main(screening: str, tables: dict[str, str], settings: AnalysisConfig) -> None:
    """Write the tables of the analysis; `tables` has the path of each."""
    runs = read_runs(screening, settings.factors)
    fit = fit_factors(settings, runs)
    write_table(printed_table(settings, runs), tables["printed"])
    write_table(corrected_table(settings, runs), tables["corrected"])
    write_table(trend_table(settings, runs), tables["trends"])
    write_table(contested_table(settings, runs), tables["contested"])
    write_table(rival_models_table(settings, runs), tables["rival_models"])
    write_table(residual_parts_table(settings, runs), tables["residual_parts"])
    write_table(detectable_table(settings, runs), tables["detectable"])
    write_table(residual_table(runs, fit), tables["residuals"])
    checks = residual_checks(settings, runs, fit, settings.simulations, settings.order_seed)
    write_table(checks, tables["residual_checks"])
    write_table(lack_of_fit_table(settings, runs, fit), tables["lack_of_fit"])
    write_table(interaction_table(settings, runs), tables["interactions"])


if "snakemake" in globals():
    with job(snakemake.log[0], "analyse variance"):
        main(snakemake.input.screening, dict(snakemake.output.items()), AnalysisConfig(**snakemake.params.settings))
