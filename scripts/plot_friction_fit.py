"""Draws the track of the oscillating ball, its fit, and how well it determines the friction pair (Fig. 3.3)."""

from millprint.figures.calibration import plot_friction_fit
from millprint.figures.style import save
from millprint.files import read_table
from millprint.job import job


def main(files, output) -> None:
    """Draw the track with its fit and the profiles of both coefficients."""
    fit = read_table(files.fit, numeric=["estimate", "lower", "upper"], text=["parameter"])
    profile = read_table(files.profile, numeric=["value", "excess", "threshold"], text=["parameter"])
    paths = read_table(files.paths, numeric=["time_s", "across_mm", "height_mm"], text=["path"])
    save(plot_friction_fit(read_table(files.track, numeric=["time_s"]), paths, fit, profile), output.svg, output.png)


if "snakemake" in globals():
    with job(snakemake.log[0], f"plot friction fit of {snakemake.wildcards.experiment}"):
        main(snakemake.input, snakemake.output)
