"""Figure of what transfers between sources of yields."""

from millprint.figures.chapter5_sources import plot_sources
from millprint.figures.style import save
from millprint.files import read_table
from millprint.job import job


def main(scores: str, predictions: str, output) -> None:
    """Draw the figure."""
    texts = ["source", "model", "strategy"]
    table = read_table(scores, text=[*texts, "verdict"])
    points = read_table(predictions, numeric=["yield_percent", "predicted_percent"], text=texts)
    save(plot_sources(table, points), output.svg, output.png)


if "snakemake" in globals():
    with job(snakemake.log[0], "plot sources"):
        main(snakemake.input.scores, snakemake.input.predictions, snakemake.output)
