"""Simulates one job's share of the samples of a mill: contact parameters and fill ratio by a space-filling design.

Settings: uncertainty, mills, dem, fingerprint.counting_rule; the mill with its sweep, and the contact set.
Inputs: `sweep` where it was derived.
Outputs: `samples`.
"""

from pathlib import Path

import pandas as pd

from millprint.cases.of_mill import varied_case
from millprint.config.contact_set import ContactConfig
from millprint.config.fingerprint import UncertaintyConfig
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import MillsConfig
from millprint.config.sweep import DemConfig
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.uncertainty.samples import check_contact, design_of, run_samples, space_of, with_sweep


def main(
    output: str, mill: MillConfig, contact: ContactConfig, mills: MillsConfig, dem: DemConfig, rule: str,
    settings: UncertaintyConfig, number: int,
) -> pd.DataFrame:  # fmt: skip
    """Simulate the samples number, number + jobs, ... and write their table; a killed job continues from its rows."""
    check_contact(space_of(mill, settings), contact)
    samples = design_of(mill, settings).iloc[number :: settings.jobs]
    done = Path(output).with_suffix(".done")
    title = f"{mill.name}, samples {number + 1} of {settings.jobs}"
    table = run_samples(varied_case(mill, mills, settings), mill, contact, dem, samples, rule, done, title)
    table.insert(0, "sample", table.index)
    write_table(table, output, digits=17)
    done.unlink()
    return table


if "snakemake" in globals():
    with job(snakemake.log[0], f"sample {snakemake.wildcards.mill}, job {snakemake.wildcards.number}"):
        mill = with_sweep(snakemake.params.mill, snakemake.params.sweep, next(iter(snakemake.input.sweep), None))
        main(
            snakemake.output.samples,
            mill,
            ContactConfig(**snakemake.params.contact),
            MillsConfig(**snakemake.params.mills),
            DemConfig(**snakemake.params.dem),
            snakemake.params.counting_rule,
            UncertaintyConfig(**snakemake.params.settings),
            int(snakemake.wildcards.number),
        )
