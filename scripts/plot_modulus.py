"""Figure 3.4: power and run time against Young's modulus."""

from millprint.figures.chapter3 import plot_modulus
from millprint.figures.style import save
from millprint.files import read_table
from millprint.job import job


def main(modulus_path: str, output) -> None:
    """Draw the table of the modulus sweep."""
    columns = ["young_modulus_gpa", "power_W", "power_two_sigma_W", "wall_clock_s"]
    save(plot_modulus(read_table(modulus_path, numeric=columns)), output.svg, output.png)


if "snakemake" in globals():
    with job(snakemake.log[0], "plot modulus"):
        main(snakemake.input.modulus, snakemake.output)
