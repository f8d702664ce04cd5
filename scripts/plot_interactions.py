"""Plots one figure of interactions: the mean yield for each combination of two factors' levels."""

from millprint.config.doe import DoeConfig
from millprint.figures.chapter2 import interactions
from millprint.figures.style import save
from millprint.files import read_table
from millprint.job import job


def main(means: str, svg: str, png: str, name: str, settings: DoeConfig) -> None:
    """Draw the panels of the figure `name`."""
    table = read_table(means, numeric=["axis_level", "curve_level", "mean_yield_percent"], text=["figure"])
    labels = {factor.symbol: factor.label for factor in settings.factors}
    save(interactions(table[table["figure"] == name], labels), svg, png)


if "snakemake" in globals():
    with job(snakemake.log[0], f"plot interactions {snakemake.wildcards.figure}"):
        main(
            snakemake.input.means,
            snakemake.output.svg,
            snakemake.output.png,
            name=snakemake.wildcards.figure,
            settings=DoeConfig(**snakemake.params.settings),
        )
