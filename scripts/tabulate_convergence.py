"""Descriptors against the time step and against Young's modulus (Fig. 3.4): tables and figures.

Of the time step also the largest one that leaves every descriptor unchanged: is the one of the sweeps small enough?

Settings: convergence, fingerprint.counting_rule; the steps that the sweeps take.
Inputs: summaries, `of_step` and `of_modulus`.
Outputs: `step_table`, `choice` of the step, `modulus_table`, and the figures; those of a sweep that there is.
"""

from millprint.config.fingerprint import ConvergenceConfig
from millprint.dem.convergence import DESCRIPTORS, SERIES, column_of, convergence_table
from millprint.dem.step_choice import choose_step, in_words
from millprint.figures.style import save
from millprint.run.files import read_json, read_table, write_json, write_table
from millprint.run.job import job
from millprint.thesis.figures.convergence_plots import plot_modulus, plot_timestep

DEVIATIONS = [column_of(name, "deviation_percent") for name in DESCRIPTORS]


def tabulate(summary_paths: list[str], varied: str, rules: tuple[str, list[str]], output: str) -> None:
    """Write the table of simulations that differ in one setting. rules: the counting rule, and further ones."""
    write_table(convergence_table([read_json(path) for path in summary_paths], varied, *rules), output)


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


if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    rules = own.counting_rule, own.further_rules
    with job(snakemake.log[0], "tabulate convergence") as logger:
        # A configuration may have only one of the sweeps.
        if given.of_step:
            logger.info("%d simulations of the time step", len(given.of_step))
            tabulate(given.of_step, "time_step_s", rules, made.step_table)
            choice = choose(made.step_table, ConvergenceConfig(**own.settings), own.taken_s, made.choice)
            say = logger.info if choice["taken_steps_hold"] else logger.warning
            say("%s", in_words(choice))
            draw_steps(made.step_table, made.choice, made.step_svg, made.step_png)
        if given.of_modulus:
            logger.info("%d simulations of the modulus", len(given.of_modulus))
            tabulate(given.of_modulus, "young_modulus_gpa", rules, made.modulus_table)
            draw_moduli(made.modulus_table, made.modulus_svg, made.modulus_png)
