"""Finds the largest time step that leaves every descriptor unchanged; is the configured step small enough?"""

from millprint.config.fingerprint import ConvergenceConfig
from millprint.dem.convergence import DESCRIPTORS, SERIES, column_of
from millprint.dem.step_choice import choose_step, in_words
from millprint.files import read_table, write_json
from millprint.job import job


def main(table_path: str, settings: ConvergenceConfig, configured_s: float, output: str) -> dict:
    """Evaluate the table of the time-step sweep; write the result and return it."""
    deviations = [column_of(name, "deviation_percent") for name in DESCRIPTORS]
    columns = [*SERIES[2:], "time_step_s", "rayleigh_fraction", "seeds", "closure", "closure_worst", *deviations]
    choice = choose_step(read_table(table_path, numeric=columns, text=SERIES[:2]), settings, configured_s)
    write_json(choice, output)
    return choice


if "snakemake" in globals():
    with job(snakemake.log[0], "choose the time step") as logger:
        choice = main(
            snakemake.input.table,
            ConvergenceConfig(**snakemake.params.settings),
            snakemake.params.configured_s,
            snakemake.output.choice,
        )
        say = logger.info if choice["configured_step_holds"] else logger.warning
        say("%s", in_words(choice))
