"""Writes the tables of a design, and those of the analysis of its runs."""

from pathlib import Path

from millprint.config.doe import AnalysisConfig, DesignConfig
from millprint.run.files import write_json, write_table
from millprint.thesis.doe.factorial_designs import alias_table, audit_table, describe, design_table
from millprint.thesis.doe.residuals import (
    contested_table,
    lack_of_fit_table,
    residual_checks,
    residual_parts_table,
    residual_table,
)
from millprint.thesis.doe.runs import read_runs
from millprint.thesis.doe.variance import (
    corrected_table,
    detectable_table,
    fit_factors,
    interaction_table,
    printed_table,
)

# The tables of the design, by the names of the rule's outputs.
DESIGN_TABLES = ("design", "aliases", "audit")
# The tables of the analysis that follow the analysis of variance, by the names of the rule's outputs.
TABLES = (
    "contested",
    "residual_parts",
    "detectable",
    "residuals",
    "residual_checks",
    "lack_of_fit",
    "interactions",
)
# Tables of the variance, by the names of the rule's outputs: the file that holds each.
VARIANCE = {"printed": "anova_printed", "corrected": "anova_corrected"}


def design_paths(folder: str | Path) -> dict[str, str]:
    """The path of every file of the design in a folder."""
    names = [*(f"{name}.tsv" for name in DESIGN_TABLES), "fraction.json"]
    return {name.partition(".")[0]: str(Path(folder) / name) for name in names}


def write_design(screening: str, outputs: dict[str, str], settings: DesignConfig) -> list[str]:
    """Write the design, its aliases and the audit of the runs, and return one line for each departure from it."""
    runs = read_runs(screening, settings.factors)
    write_table(design_table(settings), outputs["design"])
    write_json(describe(settings), outputs["fraction"])
    write_table(alias_table(settings), outputs["aliases"])
    found = audit_table(settings, runs)
    write_table(found, outputs["audit"])
    departures = found[found["departs"] == "yes"]
    return [f"{row.check}, {row.subject}: {row.found}, planned {row.wanted}" for row in departures.itertuples()]


def analysis_paths(folder: str | Path) -> dict[str, str]:
    """The path of every table of the analysis in a folder."""
    files = {**{name: name for name in TABLES}, **VARIANCE}
    return {name: str(Path(folder) / f"{file}.tsv") for name, file in files.items()}


def write_analysis(screening: str, tables: dict[str, str], settings: AnalysisConfig) -> None:
    """Write the tables of the analysis; `tables` has the path of each."""
    runs = read_runs(screening, settings.factors)
    fit = fit_factors(settings, runs)
    write_table(printed_table(settings, runs), tables["printed"])
    write_table(corrected_table(settings, runs), tables["corrected"])
    write_table(contested_table(settings, runs), tables["contested"])
    write_table(residual_parts_table(settings, runs), tables["residual_parts"])
    write_table(detectable_table(settings, runs), tables["detectable"])
    write_table(residual_table(runs, fit), tables["residuals"])
    checks = residual_checks(settings, runs, fit, settings.simulations, settings.order_seed)
    write_table(checks, tables["residual_checks"])
    write_table(lack_of_fit_table(settings, runs, fit), tables["lack_of_fit"])
    write_table(interaction_table(settings, runs), tables["interactions"])
