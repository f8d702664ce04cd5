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

from millprint.config.fingerprint import ConvergenceConfig, StudyConfig
from millprint.dem.convergence import DESCRIPTORS, SERIES, choose_step, column_of, convergence_table, in_words
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

DEVIATIONS = [column_of(name, "deviation_percent") for name in DESCRIPTORS]


def main(
    variants: list[dict],
    folder: str,
    output,
    *,
    mill: str,
    sweep_seeds: int,
    counting_rule: str,
    rules: list[dict],
    study: StudyConfig,
) -> dict:
    """Read the runs of every variant (setting, factor, value, paths of its cases), and write what they say.

    folder: that of all simulations. Returns the verdict.
    """
    groups = [[f"{folder}/{path}/summary.json" for path in variant["paths"]] for variant in variants]
    groups = [read_summaries(paths, rules) for paths in groups]
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
    save(plot_study(table, window, study.tolerance_percent), *output.figure)
    return verdict


def tabulate(
    summary_paths: list[str], varied: str, rules: list[dict], names: tuple[str, list[str]], output: str
) -> None:
    """Write the table of simulations that differ in one setting. names: of the counting rule, and of further ones."""
    summaries = [read_counted(path, rules) for path in summary_paths]
    write_table(convergence_table(summaries, varied, *names), output)


def choose(table_path: str, settings: ConvergenceConfig, taken_s: dict[float, float], output: str) -> dict:
    """Evaluate the table of the time-step sweep; write the result and return it. taken_s: as of `choose_step`."""
    columns = [*SERIES[2:], "time_step_s", "rayleigh_fraction", "seeds", "closure", "closure_worst", *DEVIATIONS]
    choice = choose_step(read_table(table_path, numeric=columns, text=SERIES[:2]), settings, taken_s)
    write_json(choice, output)
    return choice


def draw_steps(table_path: str, choice_path: str, svg: str, png: str) -> None:
    """Draw the table of the time-step sweep and the chosen step."""
    table = read_table(table_path, numeric=["ball_diameter_mm", "time_step_s", "closure", *DEVIATIONS], text=SERIES[:2])
    save(plot_timestep(table, read_json(choice_path)), svg, png)


def draw_moduli(table_path: str, svg: str, png: str) -> None:
    """Draw the table of the modulus sweep."""
    columns = ["ball_diameter_mm", "young_modulus_gpa", "power_W", "power_two_sigma_W", "processor_s", *DEVIATIONS]
    save(plot_modulus(read_table(table_path, numeric=columns, text=SERIES[:2])), svg, png)


def tabulate_sweeps(given, made, own, logger) -> None:
    """Write the tables of the sweeps of chapter 3 and draw them; a configuration may have only one of the two."""
    rules = own.rules, (own.counting_rule, own.further_rules)
    if given.of_step:
        logger.info("%d simulations of the time step", len(given.of_step))
        tabulate(given.of_step, "time_step_s", *rules, made.step_table)
        choice = choose(made.step_table, ConvergenceConfig(**own.settings), own.taken_s, made.choice)
        say = logger.info if choice["verdict"] == AGREES else logger.warning
        say("%s", in_words(choice))
        draw_steps(made.step_table, made.choice, *made.step_figure)
    if given.of_modulus:
        logger.info("%d simulations of the modulus", len(given.of_modulus))
        tabulate(given.of_modulus, "young_modulus_gpa", *rules, made.modulus_table)
        draw_moduli(made.modulus_table, *made.modulus_figure)


if "snakemake" in globals():
    made, own, mill = snakemake.output, snakemake.params, snakemake.wildcards.get("mill")
    with job(snakemake.log[0], f"study the settings of {mill or 'chapter 3'}") as logger:
        if mill:
            asked = {"counting_rule": own.counting_rule, "rules": own.rules, "study": StudyConfig(**own.study)}
            found = main(own.variants, own.folder, made, mill=mill, sweep_seeds=own.sweep_seeds, **asked)
            say = logger.info if found["verdict"] == AGREES else logger.warning
            say("%s", found["line"])
            print(found["line"], file=sys.stderr, flush=True)
        else:
            tabulate_sweeps(snakemake.input, made, own, logger)
