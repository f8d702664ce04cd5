"""Draws the Sobol indices of the contact parameters, the intervals of a mill, and its fingerprint on one page."""

from millprint.config.mill import MillConfig
from millprint.dose.spectra import read_spectra
from millprint.dose.spectra_shown import of_sheet
from millprint.figures.mill_sheet import plot_sheet
from millprint.figures.style import save
from millprint.figures.uncertainty import plot_indices, plot_intervals
from millprint.files import read_table
from millprint.fingerprint.descriptors import read_descriptors
from millprint.job import job
from millprint.view.mill_picture import picture_mill


def main(inputs, output, mill: MillConfig) -> None:
    """Draw all three."""
    save(plot_indices(read_table(inputs.indices), mill.title), output.indices_svg, output.indices_png)
    intervals = plot_intervals(read_table(inputs.intervals), read_table(inputs.sets), mill.title)
    save(intervals, output.intervals_svg, output.intervals_png)
    sheet = read_table(inputs.sheet)
    spectra = [of_sheet(read_spectra(path), sheet) for path in (inputs.spectra, inputs.spectra_summary)]
    tables = sheet, read_descriptors(inputs.descriptors), read_table(inputs.curves), *spectra
    save(plot_sheet(picture_mill(mill), *tables), output.sheet_svg, output.sheet_png, output.sheet_pdf)


if "snakemake" in globals():
    with job(snakemake.log[0], f"plot the uncertainty of {snakemake.wildcards.mill}"):
        main(snakemake.input, snakemake.output, MillConfig(**snakemake.params.mill))
