"""The fingerprint sheet and the curves of a mill with every interval that is known, each of its own origin."""

import numpy as np

from millprint.config.mill import MillConfig
from millprint.files import read_table, write_table
from millprint.fingerprint.mill_sheet import tabulate_sheet
from millprint.fingerprint.model import Fingerprint
from millprint.job import job


def main(tables, output, mill: MillConfig) -> None:
    """Write both from the fingerprint with its intervals and the tables of the mill's own sweep."""
    fingerprint = Fingerprint.read(tables.fingerprint)
    collapse, zones, descriptors, curves = (
        read_table(getattr(tables, name)) for name in ("collapse", "zones", "descriptors", "curves")
    )
    # A table has fewer digits than the fingerprint: its first and last fill ratio may lie just outside.
    fills = np.clip(curves["fill_ratio"].to_numpy(dtype=float), *fingerprint.fill_range)
    write_table(fingerprint.further_curve(fingerprint.curve(fills)), output.curves)
    write_table(tabulate_sheet(mill, fingerprint, collapse, zones, descriptors["closure"].max()), output.sheet)


if "snakemake" in globals():
    with job(snakemake.log[0], f"sheet with intervals of {snakemake.params.mill['name']}"):
        main(snakemake.input, snakemake.output, MillConfig(**snakemake.params.mill))
