"""Is the scaling universal? Numbers of the collapse, universal curves, exponents by regression, and zones."""

import pandas as pd

from millprint.config.mixture import ONE_SIZE
from millprint.files import read_table, write_table
from millprint.fingerprint.collapse import tabulate_collapse
from millprint.fingerprint.curves import at_shared_fills, average_curves, universal_descriptors
from millprint.fingerprint.descriptors import CHARGE, as_built, read_descriptors
from millprint.fingerprint.exponents import fit_exponents
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.zones import find_zones
from millprint.job import job


def main(inputs, output, mill: str, contacts: list[str], interval: float) -> None:
    """Write collapse, universal curves and zones of `mill`, and the exponents of every mill of the sweeps."""
    descriptors = read_descriptors(inputs.descriptors)
    # The chapters are of balls of one size.
    counting_rules = read_table(inputs.counting_rules).assign(**{CHARGE: ONE_SIZE})
    own = descriptors[(descriptors["mill"] == mill) & descriptors["contact"].isin(contacts)]
    write_table(tabulate_collapse(own), output.collapse)
    write_table(average_curves(universal_descriptors(at_shared_fills(as_built(own)))), output.universal)
    write_table(fit_exponents(descriptors, counting_rules, interval), output.exponents)
    zones = pd.concat([find_zones(Fingerprint.read(path)) for path in inputs.fingerprints], ignore_index=True)
    write_table(zones, output.zones)


if "snakemake" in globals():
    with job(snakemake.log[0], "measure scaling"):
        own = snakemake.params
        main(snakemake.input, snakemake.output, own.mill, own.contacts, own.interval)
