"""Descriptors, power and run time against Young's modulus (Fig. 3.4)."""

from millprint.dem.convergence import DESCRIPTORS, SERIES, column_of, convergence_table
from millprint.figures.convergence import plot_modulus
from millprint.figures.style import save
from millprint.files import read_json, read_table, write_table
from millprint.job import job


def draw(table_path: str, svg: str, png: str) -> None:
    """Draw the table of the modulus sweep."""
    deviations = [column_of(name, "deviation_percent") for name in DESCRIPTORS]
    columns = ["ball_diameter_mm", "young_modulus_gpa", "power_W", "power_two_sigma_W", "processor_s", *deviations]
    save(plot_modulus(read_table(table_path, numeric=columns, text=SERIES[:2])), svg, png)


if "snakemake" in globals():
    own, output = snakemake.params, snakemake.output
    with job(snakemake.log[0], "compare Young's moduli") as logger:
        logger.info("%d simulations", len(snakemake.input.summaries))
        summaries = [read_json(path) for path in snakemake.input.summaries]
        table = convergence_table(summaries, "young_modulus_gpa", own.counting_rule, own.further_rules)
        write_table(table, output.table)
        draw(output.table, output.svg, output.png)
