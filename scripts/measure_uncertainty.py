"""Calculates how much the predictions for a mill depend on contact parameters, from its samples.

Settings: uncertainty; the mill with its sweep, and the contact sets.
Inputs: `samples` of the jobs, and `sweep` where it was derived.
Outputs: `samples`, `emulator`, `indices`, `intervals`, `sets`, `contact`.
"""

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.cases.of_mill import fill_ratios_of
from millprint.config.contact_set import ContactConfig
from millprint.config.fingerprint import UncertaintyConfig
from millprint.config.mill import MillConfig
from millprint.fingerprint.descriptors import with_impacts
from millprint.run.files import read_table, write_json, write_table
from millprint.run.job import job
from millprint.uncertainty.intervals import Measured, measure
from millprint.uncertainty.samples import space_of, with_sweep


def main(
    inputs, output, mill: MillConfig, contact: ContactConfig, others: list[ContactConfig], settings: UncertaintyConfig
) -> Measured:
    """Write the samples of all jobs as one table, the tables of emulator, indices and intervals, and contact.json.

    Samples without impacts have no part in the latter; the table of emulators has the number of the others.
    """
    parts = [read_table(path, text=["mill", "contact", "varied", "counting_rule", "motion"]) for path in inputs.samples]
    samples = pd.concat(parts).sort_values("sample", ignore_index=True)
    space, fills = space_of(mill, settings), fill_ratios_of(mill, settings)
    # Threads of linear algebra would slow the jobs that run at the same time.
    with threadpool_limits(1):
        measured = measure(with_impacts(samples).reset_index(drop=True), space, fills, contact, others, settings)
    write_table(samples, output.samples)
    for name in ("emulator", "indices", "intervals", "sets"):
        write_table(getattr(measured, name), getattr(output, name))
    write_json(measured.factors.model_dump(mode="json", exclude_none=True), output.contact)
    return measured


if "snakemake" in globals():
    with job(snakemake.log[0], f"measure the uncertainty of {snakemake.wildcards.mill}") as logger:
        mill = with_sweep(snakemake.params.mill, snakemake.params.sweep, next(iter(snakemake.input.sweep), None))
        contact, *others = [ContactConfig(**content) for content in snakemake.params.contacts]
        settings = UncertaintyConfig(**snakemake.params.settings)
        found = main(snakemake.input, snakemake.output, mill, contact, others, settings)
        for row in found.emulator.itertuples():
            logger.info(
                "%s: Q2 %.3f, error %.3f and scatter %.3f of a logarithm",
                row.quantity, row.q2, row.leave_one_out_error, row.scatter,
            )  # fmt: skip
