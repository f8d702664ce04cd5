"""Checks of the thesis's sections before the first job: tables, formulas, simulations that the chapters need."""

import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.surrogate_cases import check_surrogate_cases
from millprint.config.sweep import Case
from millprint.config.workflow import ChapterSections, WorkflowConfig
from millprint.dose.wear import read_materials
from millprint.fingerprint.cases import has_chapters
from millprint.run.tables import Text, read_measured
from millprint.thesis.calibration.calibration_checks import calibration_faults
from millprint.thesis.claims.conclusions import read_conclusions
from millprint.thesis.claims.elsewhere import read_stored
from millprint.thesis.claims.natures import BASES, NATURES
from millprint.thesis.curves.regimes import read_regimes
from millprint.thesis.curves.sweep_checks import curve_faults
from millprint.thesis.doe.chemistry import check_formulas
from millprint.thesis.doe.literature import read_literature, read_reported_yields
from millprint.thesis.doe.runs import read_runs
from millprint.thesis.doe.wet_lab import read_wear
from millprint.thesis.fit.fit_checks import fit_faults
from millprint.thesis.yields.experiments import check_region, read_experiments
from millprint.thesis.yields.run_tables import (
    check_folds,
    check_yield_tables,
    read_other_runs,
    read_parts,
    read_rows,
    with_other_runs,
)


def chapter_faults(
    config: WorkflowConfig,
    mills: dict[str, MillConfig],
    contacts: dict[str, ContactConfig],
    cases: dict[str, Case],
    source: str,
) -> list[str]:
    """A line for each fault of the chapters' sections; raises ConfigError for a table that cannot be read."""
    faults, chapters = curve_faults(config, cases, source), config.chapters
    if chapters and has_chapters(config, cases):
        check_tables(chapters, source)
        read_materials(config.dose.wear.materials, config.dose.wear.material)
        check_surrogate_cases(chapters.surrogate, cases, source)
        faults += [*calibration_faults(config, mills, contacts), *fit_faults(config, mills, source)]
    return faults


def check_tables(config: ChapterSections, source: str) -> None:
    """Check every measured table, and the formulas of the reaction."""
    check_formulas(config.doe.chemistry, f"{source}: doe.chemistry")
    read_runs(config.data.screening, config.doe.factors, positive=["bpr", "molar_ratio"])
    read_wear(config.data.wear)
    check_claims(config)
    read_literature(config.doe.literature)
    read_reported_yields(config.doe.literature_yields)
    check_yield_tables(config.yields, config.data.screening, config.data.split, config.doe, source)
    regimes = read_regimes(config.data.regimes)
    check_other_sources(config, regimes, source)
    proposals, published = config.yields.proposals, config.yields.proposals.curves == "published"
    if published:
        check_region(proposals.region, regimes, source)
    if proposals.experiments:
        runs = read_runs(config.data.screening, config.doe.factors)["case"]
        read_experiments(proposals.experiments, regimes if published else None, [*runs.astype(str), *regimes["case"]])


def check_claims(config: ChapterSections) -> None:
    """Check what the claims are, what rests on them, and their verdicts on other machines."""
    columns = [Text("id", unique=True), Text("nature", list(NATURES)), Text("basis", list(BASES))]
    claims = read_measured(config.data.claims, columns)
    read_conclusions(config.data.conclusions, claims["id"])
    read_stored(config.data.verdicts)


def check_other_sources(config: ChapterSections, regimes: pd.DataFrame, source: str) -> None:
    """Check the table of others' runs, and that every source leaves enough runs to train on."""
    own = pd.concat(read_parts(config.data.screening, config.data.split, config.doe.factors), ignore_index=True)
    taken = {
        config.data.screening: own["case"],
        config.data.regimes: regimes["case"],
        config.yields.out_of_domain: read_rows(config.yields.out_of_domain)["case"],
    }
    settings = config.yields.other_sources
    others = read_other_runs(settings, taken, source)
    check_folds(with_other_runs(own, others, settings.own), config.yields.evaluation.folds, source)
