"""Descriptors against the time step; the largest step that leaves all of them unchanged; is the configured one small
enough?"""

from millprint.config.fingerprint import ConvergenceConfig
from millprint.dem.convergence import DESCRIPTORS, SERIES, column_of, convergence_table
from millprint.dem.step_choice import choose_step, in_words
from millprint.figures.convergence import plot_timestep
from millprint.figures.style import save
from millprint.files import read_json, read_table, write_json, write_table
from millprint.job import job

DEVIATIONS = [column_of(name, "deviation_percent") for name in DESCRIPTORS]


def choose(table_path: str, settings: ConvergenceConfig, configured_s: float, output: str) -> dict:
    """Evaluate the table of the time-step sweep; write the result and return it."""
    columns = [*SERIES[2:], "time_step_s", "rayleigh_fraction", "seeds", "closure", "closure_worst", *DEVIATIONS]
    choice = choose_step(read_table(table_path, numeric=columns, text=SERIES[:2]), settings, configured_s)
    write_json(choice, output)
    return choice


def draw(table_path: str, choice_path: str, svg: str, png: str) -> None:
    """Draw the table of the time-step sweep and the chosen step."""
    table = read_table(table_path, numeric=["ball_diameter_mm", "time_step_s", "closure", *DEVIATIONS], text=SERIES[:2])
    save(plot_timestep(table, read_json(choice_path)), svg, png)


if "snakemake" in globals():
    own, output = snakemake.params, snakemake.output
    with job(snakemake.log[0], "compare time steps") as logger:
        logger.info("%d simulations", len(snakemake.input.summaries))
        summaries = [read_json(path) for path in snakemake.input.summaries]
        write_table(convergence_table(summaries, "time_step_s", own.counting_rule, own.further_rules), output.table)
        choice = choose(output.table, ConvergenceConfig(**own.settings), own.configured_s, output.choice)
        say = logger.info if choice["configured_step_holds"] else logger.warning
        say("%s", in_words(choice))
        draw(output.table, output.choice, output.svg, output.png)
