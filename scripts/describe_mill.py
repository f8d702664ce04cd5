"""The fingerprint of a mill from its own sweep: descriptors, curves, collapse, zones, spectra, its sheet.

Settings: the mill; mills.counting_rule, fingerprint.interval, fingerprint.smooth_points,
dose.spectra.
Inputs: `summaries` and their `runs`.
Outputs: `descriptors`, `curves`, `fingerprint` (JSON), `collapse`, `zones`, `sheet`, `spectra`, `spectra_summary`.
"""

from millprint.config.mill import MillConfig
from millprint.dose.spectra import tabulate_spectra
from millprint.dose.spectra_shown import sheet_rows, with_rows
from millprint.fingerprint.descriptors import tabulate_descriptors, with_impacts
from millprint.fingerprint.mill_collapse import find_zones, tabulate_mill_collapse
from millprint.fingerprint.mill_sheet import tabulate_sheet
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import charges_of, read_summaries
from millprint.observables.condition import fill_grid
from millprint.observables.definitions import CURVE_COLUMNS
from millprint.run.files import write_table
from millprint.run.job import job


def main(given, made, own, mill: MillConfig) -> None:
    """Read the summaries of the mill's sweep and their run.h5, in the same order, and write its tables."""
    runs = read_summaries(given.summaries, own.rules)
    descriptors = tabulate_descriptors(runs, own.counting_rule)
    write_table(descriptors, made.descriptors)
    fitted = with_impacts(descriptors)
    fingerprint = Fingerprint.fit(descriptors, mill.volume_ml * 1e-6, own.interval, charges_of(runs))
    fills = fill_grid(fitted["fill_ratio"].unique(), own.smooth_points)
    write_table(fingerprint.curve(fills)[CURVE_COLUMNS], made.curves)
    fingerprint.write(made.fingerprint)
    collapse = tabulate_mill_collapse(fitted, own.interval)
    write_table(collapse, made.collapse)
    zones = find_zones(fingerprint)
    write_table(zones, made.zones)
    spectra, read_off = tabulate_spectra(list(zip(given.runs, runs, strict=True)), own.spectra_rules)
    write_table(spectra, made.spectra)
    write_table(read_off, made.spectra_summary)
    sheet = tabulate_sheet(mill, fingerprint, collapse, zones, descriptors)
    write_table(with_rows(sheet, sheet_rows(read_off, fingerprint)), made.sheet)


if "snakemake" in globals():
    mill = MillConfig(**snakemake.params.mill)
    with job(snakemake.log[0], f"describe {mill.name}"):
        main(snakemake.input, snakemake.output, snakemake.params, mill)
