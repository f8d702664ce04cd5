"""Does a mill's sweep agree with finer settings? Tables, figure, and a verdict in one line.

For the sweeps of chapter 3 descriptors against the time step and against Young's modulus (Fig. 3.4), and the largest
step that leaves every descriptor unchanged: is the one of the sweeps small enough?

Settings: convergence.study, mills.counting_rule, and the variants of the mill's sweep; or convergence,
fingerprint.counting_rule, and the steps that the sweeps take.
Inputs: `summaries` of every variant; or summaries, `of_step` and `of_modulus`.
Outputs: `table`, `window`, `verdict` (JSON), `line` (text), and the figure; or `step_table`, `choice` of the step,
`modulus_table`, and the figures, those of a sweep that there is.
"""

import sys

import pandas as pd

from millprint.config.fingerprint import ConvergenceConfig, StudyConfig
from millprint.dem.convergence import SERIES, choose_step, convergence_table, in_words
from millprint.estimate.judge import AGREES
from millprint.figures.style import save
from millprint.figures.uncertainty_figures import plot_study
from millprint.fingerprint.readers import read_counted, read_summaries
from millprint.fingerprint.study import (
    changes_of_halves,
    check_study,
    conclude,
    study_row,
    tabulate_study,
    tabulate_window,
)
from millprint.run.files import read_json, read_table, whole_file, write_json, write_table
from millprint.run.job import job
from millprint.thesis.figures.chapter3_and_4_figures import plot_modulus, plot_timestep


def study_mill(mill: str, made, own) -> dict:
    """Read the runs of every variant (setting, factor, value, paths of its cases), and write what they say.

    Returns the verdict.
    """
    groups = [
        read_summaries([f"{own.folder}/{path}/summary.json" for path in variant["paths"]], own.rules)
        for variant in own.variants
    ]
    study = StudyConfig(**own.study)
    rows = [
        study_row(variant["setting"], variant["factor"], variant["value"], runs, own.counting_rule)
        for variant, runs in zip(own.variants, groups, strict=True)
    ]
    table, window = tabulate_study(rows), tabulate_window(groups[0])
    halves = changes_of_halves([run for runs in groups for run in runs])
    verdict = conclude(mill, check_study(table, halves, own.sweep_seeds, study), study)
    write_table(table, made.table)
    write_table(window, made.window)
    write_json(verdict | {"reference": groups[0][0]["case"]}, made.verdict)
    with whole_file(made.line) as file:
        file.write_text(verdict["line"] + "\n")
    save(plot_study(table, window, study.tolerance_percent), *made.figure)
    return verdict


def tabulate_sweeps(given, made, own, logger) -> None:
    """Write the tables of the sweeps of chapter 3 and draw them; a configuration may have only one of the two."""

    def tabulate(paths: list[str], varied: str, output: str) -> pd.DataFrame:
        logger.info("%d simulations of %s", len(paths), varied)
        summaries = [read_counted(path, own.rules) for path in paths]
        write_table(convergence_table(summaries, varied, own.counting_rule, own.further_rules), output)
        return read_table(output, text=SERIES[:2])

    if given.of_step:
        table = tabulate(given.of_step, "time_step_s", made.step_table)
        choice = choose_step(table, ConvergenceConfig(**own.settings), own.taken_s)
        write_json(choice, made.choice)
        say = logger.info if choice["verdict"] == AGREES else logger.warning
        say("%s", in_words(choice))
        save(plot_timestep(table, read_json(made.choice)), *made.step_figure)
    if given.of_modulus:
        table = tabulate(given.of_modulus, "young_modulus_gpa", made.modulus_table)
        save(plot_modulus(table), *made.modulus_figure)


if "snakemake" in globals():
    made, own, mill = snakemake.output, snakemake.params, snakemake.wildcards.get("mill")
    with job(snakemake.log[0], f"study the settings of {mill or 'chapter 3'}") as logger:
        if mill:
            found = study_mill(mill, made, own)
            say = logger.info if found["verdict"] == AGREES else logger.warning
            say("%s", found["line"])
            print(found["line"], file=sys.stderr, flush=True)
        else:
            tabulate_sweeps(snakemake.input, made, own, logger)
