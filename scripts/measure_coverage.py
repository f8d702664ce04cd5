"""Counts how often new simulations, and conditions left out of the fit, are within the bands of a mill's fingerprint.

Settings: mills, dem; the mill with its sweep, and the contact set.
Inputs: `fingerprint`, and `sweep` where it was derived.
Outputs: `coverage` and `held_out`.
"""

from pathlib import Path

import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import MillsConfig
from millprint.config.sweep import DemConfig
from millprint.fingerprint.cases import held_out_cases
from millprint.fingerprint.coverage import (
    HELD_OUT_COLUMNS,
    count_held_out,
    predict_held_out,
    simulate_held_out,
    tabulate_coverage,
)
from millprint.fingerprint.model import Fingerprint
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.uncertainty.samples import with_sweep


def main(
    fingerprint: Fingerprint, output, mill: MillConfig, contact: ContactConfig, mills: MillsConfig, dem: DemConfig
) -> pd.DataFrame:
    """Simulate the new conditions of a mill and write both tables; a killed job continues from those that are done."""
    coverage, predicted = tabulate_coverage(fingerprint), pd.DataFrame(columns=HELD_OUT_COLUMNS)
    done = Path(output.held_out).with_suffix(".done")
    if cases := held_out_cases(mill, mills):
        found = simulate_held_out(cases, mill, contact, dem, fingerprint.about["counting_rule"], done)
        predicted = predict_held_out(fingerprint, found)
        coverage = pd.concat([count_held_out(fingerprint, predicted), coverage], ignore_index=True)
    write_table(predicted, output.held_out)
    write_table(coverage, output.coverage)
    done.unlink(missing_ok=True)
    return coverage


if "snakemake" in globals():
    with job(snakemake.log[0], f"measure the coverage of {snakemake.wildcards.mill}") as logger:
        found = main(
            Fingerprint.read(snakemake.input.fingerprint),
            snakemake.output,
            with_sweep(snakemake.params.mill, snakemake.params.sweep, next(iter(snakemake.input.sweep), None)),
            ContactConfig(**snakemake.params.contact),
            MillsConfig(**snakemake.params.mills),
            DemConfig(**snakemake.params.dem),
        )
        for row in found[found["quantity"] == "powers"].itertuples():
            logger.info("%d of %d powers of new simulations lie within their bands", row.held, row.conditions)
