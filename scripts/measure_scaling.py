"""Is the scaling universal? The collapse as numbers, the universal curves, exponents by regression, and the zones."""

import pandas as pd

from millprint.config.fingerprint import FingerprintConfig
from millprint.files import read_table, write_table
from millprint.fingerprint.collapse import tabulate_collapse
from millprint.fingerprint.curves import at_shared_fills, average_curves, universal_descriptors
from millprint.fingerprint.descriptors import NUMBERS, TEXT
from millprint.fingerprint.exponents import fit_exponents
from millprint.fingerprint.zones import find_zones
from millprint.job import job


def main(descriptors_path: str, smooth_paths: dict[str, str], output, mill: str, settings: FingerprintConfig) -> None:
    """Write collapse, universal curves and zones of `mill`, and the exponents over every mill of the sweeps."""
    descriptors = read_table(descriptors_path, numeric=NUMBERS, text=TEXT)
    own = descriptors[(descriptors["mill"] == mill) & descriptors["contact"].isin(smooth_paths)]
    write_table(tabulate_collapse(own), output.collapse)
    write_table(average_curves(universal_descriptors(at_shared_fills(own))), output.universal)
    write_table(fit_exponents(descriptors, settings.interval), output.exponents)
    zones = [{"contact": contact} | find_zones(read_table(path)) for contact, path in smooth_paths.items()]
    write_table(pd.DataFrame(zones), output.zones)


if "snakemake" in globals():
    with job(snakemake.log[0], "measure scaling"):
        main(
            snakemake.input.descriptors,
            dict(zip(snakemake.params.contacts, snakemake.input.smooth, strict=True)),
            snakemake.output,
            snakemake.params.mill,
            FingerprintConfig(**snakemake.params.settings),
        )
