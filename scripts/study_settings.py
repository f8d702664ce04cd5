"""Are the settings of a mill's sweep good enough? Tables, figure, and a verdict in one line.

Settings: convergence.study, mills.counting_rule; the variants of the mill's sweep.
Inputs: `summaries` of every variant.
Outputs: `table`, `window`, `verdict` (JSON), `line` (text), and the figure.
"""

import sys

from millprint.config.fingerprint import StudyConfig
from millprint.figures.style import save
from millprint.figures.uncertainty_figures import plot_study
from millprint.fingerprint.readers import read_summaries
from millprint.fingerprint.study import (
    GOOD,
    changes_of_halves,
    check_study,
    conclude,
    study_row,
    tabulate_study,
    tabulate_window,
)
from millprint.run.files import whole_file, write_json, write_table
from millprint.run.job import job


def main(
    variants: list[dict], folder: str, output, *, mill: str, sweep_seeds: int, counting_rule: str, study: StudyConfig
) -> dict:
    """Read the runs of every variant (setting, factor, value, paths of its cases), and write what they say.

    folder: that of all simulations. Returns the verdict.
    """
    groups = [read_summaries(f"{folder}/{path}/summary.json" for path in variant["paths"]) for variant in variants]
    rows = [
        study_row(variant["setting"], variant["factor"], variant["value"], runs, counting_rule)
        for variant, runs in zip(variants, groups, strict=True)
    ]
    table, window = tabulate_study(rows), tabulate_window(groups[0])
    halves = changes_of_halves([run for runs in groups for run in runs])
    verdict = conclude(mill, check_study(table, halves, sweep_seeds, study), study)
    write_table(table, output.table)
    write_table(window, output.window)
    write_json(verdict | {"reference": groups[0][0]["case"]}, output.verdict)
    with whole_file(output.line) as file:
        file.write_text(verdict["line"] + "\n")
    save(plot_study(table, window, study.tolerance_percent), output.svg, output.png)
    return verdict


if "snakemake" in globals():
    with job(snakemake.log[0], f"study the settings of {snakemake.wildcards.mill}") as logger:
        found = main(
            snakemake.params.variants,
            snakemake.params.folder,
            snakemake.output,
            mill=snakemake.wildcards.mill,
            sweep_seeds=snakemake.params.sweep_seeds,
            counting_rule=snakemake.params.counting_rule,
            study=StudyConfig(**snakemake.params.study),
        )
        say = logger.info if found["verdict"] == GOOD else logger.warning
        say("%s", found["line"])
        print(found["line"], file=sys.stderr, flush=True)
