"""Tabulates experiments: the design and its check, half-lives, wear, powder and gas of the runs, and the literature.

params: sections `design`, `half_life`, `powder`, `chemistry`, `gas`. input: `screening`, `weighings`, `studies`,
`yields`. output: the tables, and the figures of the literature.
"""

from pathlib import Path

from millprint.config.design import DesignConfig, Factor
from millprint.config.doe import ChemistryConfig, GasConfig, HalfLifeConfig, PowderConfig
from millprint.figures.style import save
from millprint.run.files import write_json, write_table
from millprint.run.job import job
from millprint.thesis.doe.aliases import alias_table, confounding_table
from millprint.thesis.doe.audit import audit_table
from millprint.thesis.doe.factorial_designs import describe, design_table
from millprint.thesis.doe.literature import (
    literature_checks,
    missingness_table,
    read_literature,
    read_reported_yields,
    unreported_table,
)
from millprint.thesis.doe.runs import read_runs
from millprint.thesis.doe.wet_lab import half_life_table, powder_table, read_wear, wear_table
from millprint.thesis.figures.chapter2_figures import literature, missingness

# The tables of the design, by the names of the rule's outputs.
DESIGN_TABLES = ("design", "aliases", "confounding", "audit")


def design_paths(folder: str | Path) -> dict[str, str]:
    """The path of every file of the design in a folder."""
    names = [*(f"{name}.tsv" for name in DESIGN_TABLES), "fraction.json"]
    return {name.partition(".")[0]: str(Path(folder) / name) for name in names}


def make_design(screening: str, outputs: dict[str, str], settings: DesignConfig) -> list[str]:
    """Write the design, its aliases and the audit of the runs, and return one line for each departure from it."""
    runs = read_runs(screening, settings.factors)
    write_table(design_table(settings), outputs["design"])
    write_json(describe(settings), outputs["fraction"])
    write_table(alias_table(settings), outputs["aliases"])
    write_table(confounding_table(settings, runs), outputs["confounding"])
    found = audit_table(settings, runs)
    write_table(found, outputs["audit"])
    departures = found[found["departs"] == "yes"]
    return [f"{row.check}, {row.subject}: {row.found}, planned {row.wanted}" for row in departures.itertuples()]


def compute_wet_lab(
    screening: str,
    weighings: str,
    outputs: dict[str, str],
    factors: list[Factor],
    solution: HalfLifeConfig,
    jar: PowderConfig,
    chemistry: ChemistryConfig,
    gas: GasConfig,
) -> None:
    """Write half-lives, the wear of the balls and the iron from it, and masses of powder and volumes of gas."""
    runs = read_runs(screening, factors, positive=["bpr", "molar_ratio"])
    write_table(half_life_table(solution), outputs["half_life"])
    write_table(wear_table(read_wear(weighings)), outputs["wear"])
    write_table(powder_table(runs, jar, chemistry, gas), outputs["powder"])


def tabulate_literature(studies: str, yields: str, outputs: dict[str, str]) -> None:
    """Write what other groups report, do not report and contradict, and draw their yields against speed."""
    frame, reported = read_literature(studies), read_reported_yields(yields)
    write_table(unreported_table(frame), outputs["unreported"])
    missing = missingness_table(frame)
    write_table(missing, outputs["missingness"])
    write_table(literature_checks(frame, reported), outputs["checks"])
    save(literature(frame, reported), outputs["svg"], outputs["png"], tsv=outputs["tsv"])
    save(missingness(missing), outputs["missingness_svg"], outputs["missingness_png"])


if "snakemake" in globals():
    given, outputs, own = snakemake.input, dict(snakemake.output.items()), snakemake.params
    settings = DesignConfig(**own.design)
    with job(snakemake.log[0], "tabulate experiments") as log:
        for line in make_design(given.screening, outputs, settings):
            log.warning("the runs depart from the design: %s", line)
        compute_wet_lab(
            given.screening,
            given.weighings,
            outputs,
            settings.factors,
            HalfLifeConfig(**own.half_life),
            PowderConfig(**own.powder),
            ChemistryConfig(**own.chemistry),
            GasConfig(**own.gas),
        )
        tabulate_literature(given.studies, given.yields, outputs)
