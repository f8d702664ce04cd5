"""The fingerprint of each contact set: its fitted curves as a table and as a model, and the coverage of its bands.

Is the scaling universal? Numbers of the collapse, universal curves, exponents by regression, and zones.

params: `mill`, `contacts`, `volume_m3`, `interval`, `smooth_points`. input: `descriptors` and `counting_rules`. output:
FILES for each contact set, and `collapse`, `universal`, `exponents`, `zones`.
"""

from types import SimpleNamespace

import pandas as pd

from millprint.config.mixture import ONE_SIZE
from millprint.fingerprint.coverage import tabulate_coverage
from millprint.fingerprint.descriptors import CHARGE, as_built, read_descriptors
from millprint.fingerprint.exponents import fit_exponents
from millprint.fingerprint.master_curves import (
    CURVE_COLUMNS,
    at_shared_fills,
    average_curves,
    conditions_of,
    fill_grid,
    universal_descriptors,
)
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.zones import find_zones
from millprint.run.files import read_table, write_table
from millprint.run.job import job
from millprint.thesis.curves.collapse import tabulate_collapse

# What is written for each contact set, by the names of the rule's outputs.
FILES = ("means", "curves", "coverage", "fingerprint")


def main(
    descriptors_path: str, output, mill: str, contact: str, volume_m3: float, interval: float, smooth_points: int
) -> None:
    """Average the descriptors of one mill and contact set, and fit the fingerprint."""
    conditions = conditions_of(read_descriptors(descriptors_path), mill, contact)
    built = as_built(conditions)
    write_table(average_curves(built), output.means)
    fingerprint = Fingerprint.fit(conditions, volume_m3, interval)
    write_table(fingerprint.curve(fill_grid(built["fill_ratio"].unique(), smooth_points))[CURVE_COLUMNS], output.curves)
    write_table(tabulate_coverage(fingerprint), output.coverage)
    fingerprint.write(output.fingerprint)


def measure_scaling(
    descriptors_path: str,
    counting_rules_path: str,
    fingerprints: list[str],
    output,
    mill: str,
    contacts: list[str],
    interval: float,
) -> None:
    """Write collapse, universal curves and zones of `mill`, and the exponents of every mill of the sweeps."""
    descriptors = read_descriptors(descriptors_path)
    # The chapters are of balls of one size.
    counting_rules = read_table(counting_rules_path).assign(**{CHARGE: ONE_SIZE})
    own = descriptors[(descriptors["mill"] == mill) & descriptors["contact"].isin(contacts)]
    write_table(tabulate_collapse(own), output.collapse)
    write_table(average_curves(universal_descriptors(at_shared_fills(as_built(own)))), output.universal)
    write_table(fit_exponents(descriptors, counting_rules, interval), output.exponents)
    zones = pd.concat([find_zones(Fingerprint.read(path)) for path in fingerprints], ignore_index=True)
    write_table(zones, output.zones)


if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    with job(snakemake.log[0], "fit master curves") as log:
        for number, contact in enumerate(own.contacts):
            output = SimpleNamespace(**{name: made[name][number] for name in FILES})
            main(given.descriptors, output, own.mill, contact, own.volume_m3, own.interval, own.smooth_points)
            log.info("fitted: %s", contact)
        measure_scaling(
            given.descriptors, given.counting_rules, made.fingerprint, made, own.mill, own.contacts, own.interval
        )
