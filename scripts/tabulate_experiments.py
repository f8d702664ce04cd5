"""Tabulates experiments: the design and its check, half-lives, wear, and the literature.

Settings: doe (design).
Inputs: `screening`, `weighings`, `studies`, `yields`.
Outputs: `design`, `fraction`, `aliases`, `audit`; `half_life`, `wear`; `missingness`, `checks`; figures of the
literature, and the points of one as `tsv`.
"""

from millprint.config.doe import DesignConfig
from millprint.figures.style import save
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.doe.chemistry import literature_checks, missingness_table, read_literature, read_reported_yields
from millprint.thesis.doe.residuals import write_design
from millprint.thesis.doe.wet_lab import half_life_table, read_wear, wear_table
from millprint.thesis.figures.chapter2_figures import literature, missingness


def compute_wet_lab(weighings: str, outputs: dict[str, str]) -> None:
    """Write half-lives, and the wear of the balls with the iron from it."""
    write_table(half_life_table(), outputs["half_life"])
    write_table(wear_table(read_wear(weighings)), outputs["wear"])


def tabulate_literature(studies: str, yields: str, outputs: dict[str, str]) -> None:
    """Write what other groups report, do not report and contradict, and draw their yields against speed."""
    frame, reported = read_literature(studies), read_reported_yields(yields)
    missing = missingness_table(frame)
    write_table(missing, outputs["missingness"])
    write_table(literature_checks(frame, reported), outputs["checks"])
    save(literature(frame, reported), *outputs["figure"], tsv=outputs["tsv"])
    save(missingness(missing), *outputs["missingness_figure"])


if "snakemake" in globals():
    given, outputs, own = snakemake.input, dict(snakemake.output.items()), snakemake.params
    settings = DesignConfig(**own.design)
    with job(snakemake.log[0], "tabulate experiments") as log:
        for line in write_design(given.screening, outputs, settings):
            log.warning("the runs depart from the design: %s", line)
        compute_wet_lab(given.weighings, outputs)
        tabulate_literature(given.studies, given.yields, outputs)
