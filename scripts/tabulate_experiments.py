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

if "snakemake" in globals():
    given, made = snakemake.input, snakemake.output
    settings = DesignConfig(**snakemake.params.design)
    with job(snakemake.log[0], "tabulate experiments") as log:
        for line in write_design(given.screening, dict(made.items()), settings):
            log.warning("the runs depart from the design: %s", line)
        write_table(half_life_table(), made.half_life)
        write_table(wear_table(read_wear(given.weighings)), made.wear)
        # What other groups report, do not report and contradict.
        studies, yields = read_literature(given.studies), read_reported_yields(given.yields)
        missing = missingness_table(studies)
        write_table(missing, made.missingness)
        write_table(literature_checks(studies, yields), made.checks)
        save(literature(studies, yields), *made.figure, tsv=made.tsv)
        save(missingness(missing), *made.missingness_figure)
