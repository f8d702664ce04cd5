"""Figure: the restitution of every drop."""

from millprint.figures.calibration import plot_drops
from millprint.figures.style import save
from millprint.files import read_table
from millprint.job import job


def main(drops_path: str, restitution_path: str, output) -> None:
    """Draw every drop and the mean of each contact set."""
    drops = read_table(drops_path, numeric=["drop_height_mm", "restitution"], text=["contact"])
    means = read_table(restitution_path, numeric=["mean", "lower", "upper"], text=["contact"])
    save(plot_drops(drops, means), output.svg, output.png)


if "snakemake" in globals():
    with job(snakemake.log[0], "plot drop test"):
        main(snakemake.input.drops, snakemake.input.restitution, snakemake.output)
