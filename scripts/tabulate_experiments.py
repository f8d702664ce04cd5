"""Tabulates experiments: the design and its check, half-lives, wear, powder and gas of the runs, and the literature.

params: sections `design`, `half_life`, `powder`, `chemistry`, `gas`. input: `screening`, `weighings`, `studies`,
`yields`. output: the tables, and the figures of the literature.
"""

from millprint.config.design import DesignConfig, Factor
from millprint.config.doe import ChemistryConfig, GasConfig, HalfLifeConfig, PowderConfig
from millprint.figures.style import save
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.doe.literature import (
    literature_checks,
    missingness_table,
    read_literature,
    read_reported_yields,
    unreported_table,
)
from millprint.thesis.doe.runs import read_runs
from millprint.thesis.doe.wet_lab import half_life_table, powder_table, read_wear, wear_table
from millprint.thesis.doe.written import write_design
from millprint.thesis.figures.chapter2_figures import literature, missingness


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
        for line in write_design(given.screening, outputs, settings):
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
