"""Figure: the energy balance and the descriptors against the time step."""

from millprint.dem.convergence import DESCRIPTORS, SERIES, column_of
from millprint.figures.convergence import plot_timestep
from millprint.figures.style import save
from millprint.files import read_json, read_table
from millprint.job import job


def main(table_path: str, choice_path: str, output) -> None:
    """Draw the table of the time-step sweep and the chosen step."""
    deviations = [column_of(name, "deviation_percent") for name in DESCRIPTORS]
    table = read_table(table_path, numeric=["ball_diameter_mm", "time_step_s", "closure", *deviations], text=SERIES[:2])
    save(plot_timestep(table, read_json(choice_path)), output.svg, output.png)


if "snakemake" in globals():
    with job(snakemake.log[0], "plot time step"):
        main(snakemake.input.table, snakemake.input.choice, snakemake.output)
