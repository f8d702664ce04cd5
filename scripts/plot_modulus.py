"""Figure 3.4: power, run time and descriptors against Young's modulus."""

from millprint.dem.convergence import DESCRIPTORS, SERIES, column_of
from millprint.figures.convergence import plot_modulus
from millprint.figures.style import save
from millprint.files import read_table
from millprint.job import job


def main(table_path: str, output) -> None:
    """Draw the table of the modulus sweep."""
    deviations = [column_of(name, "deviation_percent") for name in DESCRIPTORS]
    columns = ["ball_diameter_mm", "young_modulus_gpa", "power_W", "power_two_sigma_W", "processor_s", *deviations]
    save(plot_modulus(read_table(table_path, numeric=columns, text=SERIES[:2])), output.svg, output.png)


if "snakemake" in globals():
    with job(snakemake.log[0], "plot modulus"):
        main(snakemake.input.table, snakemake.output)
