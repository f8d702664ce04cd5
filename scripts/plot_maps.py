"""Figures 3.9 and 3.10: where the balls are, and the granular temperature."""

from millprint.errors import ConfigError
from millprint.figures.chapter3 import plot_maps
from millprint.figures.style import save
from millprint.fingerprint.occupancy import read_occupancy
from millprint.job import job


def main(run_paths: list[str], fill_ratios: list[float], output) -> None:
    """Draw one row of maps for each run."""
    if not run_paths:
        raise ConfigError("fingerprint.maps: no simulation of the sweeps has this ball diameter, speed and fill ratio")
    maps = [read_occupancy(path, f"fill {fill:g}") for path, fill in zip(run_paths, fill_ratios, strict=True)]
    save(plot_maps(maps), output.svg, output.png)


if "snakemake" in globals():
    with job(snakemake.log[0], f"plot maps of {snakemake.wildcards.contact}"):
        main(snakemake.input.runs, snakemake.params.fill_ratios, snakemake.output)
