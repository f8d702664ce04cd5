"""Adds the intervals by contact parameters, and by the shape of a fitted jar, to the fingerprint of a mill.

Of a mill's own sweep, also writes its sheet and its curves, with every interval of its own origin.
"""

import numpy as np

from millprint.config.mill import MillConfig
from millprint.dose.spectra import read_spectra
from millprint.dose.spectra_shown import sheet_rows, with_rows
from millprint.files import read_table, write_table
from millprint.fingerprint.bands import FURTHER, read_factors
from millprint.fingerprint.mill_sheet import tabulate_sheet
from millprint.fingerprint.model import Fingerprint
from millprint.job import job


def main(fingerprint: str, factors: dict[str, str], output: str) -> Fingerprint:
    """Write the fingerprint with the factors of each origin, whose files are given by its name, and return it."""
    plain = Fingerprint.read(fingerprint)
    further = {origin: read_factors(path, origin, plain.about) for origin, path in factors.items()}
    found = plain.with_further(further)
    found.write(output)
    return found


def tabulate(tables, output, mill: MillConfig) -> None:
    """Write sheet and curves from the fingerprint with its intervals and the tables of the mill's own sweep."""
    fingerprint = Fingerprint.read(output.fingerprint)
    collapse, zones, descriptors, curves = (
        read_table(getattr(tables, name)) for name in ("collapse", "zones", "descriptors", "curves")
    )
    # A table has fewer digits than the fingerprint: its first and last fill ratio may lie just outside.
    fills = np.clip(curves["fill_ratio"].to_numpy(dtype=float), *fingerprint.fill_range)
    write_table(fingerprint.further_curve(fingerprint.curve(fills)), output.curves)
    sheet = tabulate_sheet(mill, fingerprint, collapse, zones, descriptors)
    write_table(with_rows(sheet, sheet_rows(read_spectra(tables.spectra_summary), fingerprint)), output.sheet)


if "snakemake" in globals():
    with job(snakemake.log[0], f"intervals of {snakemake.wildcards.mill}") as logger:
        given = {origin: snakemake.input.get(origin) for origin in FURTHER}
        found = main(
            snakemake.input.fingerprint,
            {origin: str(path) for origin, path in given.items() if path},
            snakemake.output.fingerprint,
        )
        for origin, factors in found.further.items():
            logger.info("%s: fill ratios from %g to %g", FURTHER[origin].title, *factors.fill_range)
        if snakemake.params.mill:
            tabulate(snakemake.input, snakemake.output, MillConfig(**snakemake.params.mill))
