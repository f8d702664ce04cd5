"""Draws the fingerprint of a mill on one page.

params: `mill`. input: sheet, descriptors, curves and spectra of the mill. output: `svg`, `png`, `pdf`.
"""

from millprint.config.mill import MillConfig
from millprint.dose.spectra import read_spectra
from millprint.dose.spectra_shown import of_sheet
from millprint.figures.mill_sheet_figure import plot_sheet
from millprint.figures.style import save
from millprint.fingerprint.descriptors import read_descriptors
from millprint.run.files import read_table
from millprint.run.job import job
from millprint.view.mill_picture import picture_mill


def main(tables, output, mill: MillConfig) -> None:
    """Draw the page from the tables of the mill's sweep."""
    sheet, curves = read_table(tables.sheet), read_table(tables.curves)
    own = [of_sheet(read_spectra(path), sheet) for path in (tables.spectra, tables.spectra_summary)]
    page = plot_sheet(picture_mill(mill), sheet, read_descriptors(tables.descriptors), curves, *own)
    save(page, output.svg, output.png, output.pdf)


if "snakemake" in globals():
    with job(snakemake.log[0], f"fingerprint sheet of {snakemake.params.mill['name']}"):
        main(snakemake.input, snakemake.output, MillConfig(**snakemake.params.mill))
