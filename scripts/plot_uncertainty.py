"""Draws the Sobol indices of the contact parameters, and the intervals of a mill against fill ratio."""

from millprint.figures.style import save
from millprint.figures.uncertainty import plot_indices, plot_intervals
from millprint.files import read_table
from millprint.job import job


def main(inputs, output, title: str) -> None:
    save(plot_indices(read_table(inputs.indices), title), output.indices_svg, output.indices_png)
    intervals = plot_intervals(read_table(inputs.intervals), read_table(inputs.sets), title)
    save(intervals, output.intervals_svg, output.intervals_png)


if "snakemake" in globals():
    with job(snakemake.log[0], f"plot the uncertainty of {snakemake.wildcards.mill}"):
        main(snakemake.input, snakemake.output, snakemake.params.title)
