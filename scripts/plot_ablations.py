"""Draws the ablations of appendix A.

input: `ablations`. output: `svg`, `png`.
"""

from millprint.figures.style import save
from millprint.run.files import read_table
from millprint.run.job import job
from millprint.thesis.figures.chapter6_figures import plot_ablations
from millprint.thesis.surrogate.measure_tables import scatter_in_words


def main(table: str, svg: str, png: str) -> None:
    ablations = read_table(table, numeric=["stable"], text=["variant", "says"])
    save(plot_ablations(ablations, scatter_in_words(ablations)), svg, png)


if "snakemake" in globals():
    with job(snakemake.log[0], "draw the ablations"):
        main(snakemake.input.ablations, snakemake.output.svg, snakemake.output.png)
