"""Adds the intervals by contact parameters, and by the shape of a fitted jar, to the fingerprint of a mill.

Also writes its sheet and its curves, with every interval of its own origin, and draws indices, intervals and sheet.

Settings: the mill.
Inputs: `fingerprint`, `contact` and `shape` (factors), and of the mill's sweep `collapse`, `zones`, `descriptors`,
`curves`, `spectra`, `spectra_summary`; `limits` of its heat balance; `indices`, `intervals`, `sets`.
Outputs: `fingerprint`, `sheet`, `curves`, and the drawings of indices, intervals and sheet.
"""

import numpy as np

from millprint.config.mill import MillConfig
from millprint.dose.spectra import read_spectra
from millprint.dose.spectra_shown import of_sheet, sheet_rows, temperature_rows, with_rows
from millprint.figures.mill_sheet_figure import plot_sheet
from millprint.figures.style import save
from millprint.figures.uncertainty_figures import plot_indices, plot_intervals
from millprint.fingerprint.bands import FURTHER
from millprint.fingerprint.descriptors import read_descriptors
from millprint.fingerprint.mill_sheet import tabulate_sheet
from millprint.fingerprint.model import Fingerprint
from millprint.run.files import read_table, write_table
from millprint.run.job import job
from millprint.view.frames import picture_mill


def tabulate(tables, output, mill: MillConfig) -> None:
    """Write sheet and curves from the fingerprint with its intervals and the tables of the mill's own sweep."""
    fingerprint = Fingerprint.read(output.fingerprint)
    collapse, zones, curves = (read_table(getattr(tables, name)) for name in ("collapse", "zones", "curves"))
    descriptors = read_descriptors(tables.descriptors)
    # A table has fewer digits than the fingerprint: its first and last fill ratio may lie just outside.
    fills = np.clip(curves["fill_ratio"].to_numpy(dtype=float), *fingerprint.fill_range)
    write_table(fingerprint.further_curve(fingerprint.curve(fills)), output.curves)
    sheet = tabulate_sheet(mill, fingerprint, collapse, zones, descriptors)
    write_table(with_rows(sheet, sheet_rows(read_spectra(tables.spectra_summary), fingerprint)), output.sheet)


def draw(tables, output, mill: MillConfig) -> None:
    """Draw all three, from the written tables."""
    save(plot_indices(read_table(tables.indices), mill.title), *output.indices_figure)
    intervals = plot_intervals(read_table(tables.intervals), read_table(tables.sets), mill.title)
    save(intervals, *output.intervals_figure)
    sheet = read_table(output.sheet)
    sheet = with_rows(sheet, temperature_rows(read_table(tables.limits), sheet))
    spectra = [of_sheet(read_spectra(path), sheet) for path in (tables.spectra, tables.spectra_summary)]
    shown = sheet, read_descriptors(tables.descriptors), read_table(output.curves), *spectra
    save(plot_sheet(picture_mill(mill), *shown), *output.sheet_figure, output.sheet_pdf)


if "snakemake" in globals():
    given, made = snakemake.input, snakemake.output
    with job(snakemake.log[0], f"intervals of {snakemake.wildcards.mill}") as logger:
        files = {origin: str(path) for origin in FURTHER if (path := given.get(origin))}
        found = Fingerprint.read(given.fingerprint).with_factors(files)
        found.write(made.fingerprint)
        for origin, factors in found.further.items():
            logger.info("%s: fill ratios from %g to %g", FURTHER[origin].title, *factors.fill_range)
        mill = MillConfig(**snakemake.params.mill)
        tabulate(given, made, mill)
        draw(given, made, mill)
