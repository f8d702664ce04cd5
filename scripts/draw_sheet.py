"""Draws the fingerprint of a mill on one page."""

from millprint.config.mill import MillConfig
from millprint.figures.mills import plot_sheet
from millprint.figures.style import save
from millprint.files import read_table
from millprint.fingerprint.descriptors import read_descriptors
from millprint.job import job
from millprint.view.mill_picture import picture_mill

if "snakemake" in globals():
    with job(snakemake.log[0], f"fingerprint sheet of {snakemake.params.mill['name']}"):
        sheet, curves = (read_table(snakemake.input[name]) for name in ("sheet", "curves"))
        descriptors = read_descriptors(snakemake.input.descriptors)
        figure = plot_sheet(picture_mill(MillConfig(**snakemake.params.mill)), sheet, descriptors, curves)
        save(figure, snakemake.output.svg, snakemake.output.png, snakemake.output.pdf)
