"""Plots one figure of interactions: the mean yield for each combination of two factors' levels."""

from millprint.config.design import Factor
from millprint.figures.chapter2 import interactions
from millprint.figures.style import save
from millprint.files import read_table
from millprint.job import job


def main(means: str, svg: str, png: str, name: str, factors: list[Factor]) -> None:
    """Draw the panels of the figure `name`."""
    table = read_table(means, numeric=["axis_code", "curve_code", "mean_yield_percent"], text=["figure"])
    save(interactions(table[table["figure"] == name], {factor.symbol: factor for factor in factors}), svg, png)


if "snakemake" in globals():
    with job(snakemake.log[0], f"plot interactions {snakemake.wildcards.figure}"):
        main(
            snakemake.input.means,
            snakemake.output.svg,
            snakemake.output.png,
            name=snakemake.wildcards.figure,
            factors=[Factor(**factor) for factor in snakemake.params.factors],
        )
