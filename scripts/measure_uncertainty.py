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
from millprint.fingerprint.descriptors import with_impacts
from millprint.run.files import read_table, write_json, write_table
from millprint.run.job import job
from millprint.uncertainty.intervals import measure
from millprint.uncertainty.samples import space_of, with_sweep

if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    with job(snakemake.log[0], f"measure the uncertainty of {snakemake.wildcards.mill}") as logger:
        mill = with_sweep(own.mill, own.sweep, next(iter(given.sweep), None))
        contact, *others = [ContactConfig(**content) for content in own.contacts]
        settings = UncertaintyConfig(**own.settings)
        text = ["mill", "contact", "varied", "counting_rule", "motion"]
        samples = pd.concat(read_table(path, text=text) for path in given.samples)
        samples = samples.sort_values("sample", ignore_index=True)
        write_table(samples, made.samples)
        space, fills = space_of(mill, settings), fill_ratios_of(mill, settings)
        # Samples without impacts have no part in what follows; the table of emulators has the number of the others.
        described = with_impacts(samples).reset_index(drop=True)
        # Threads of linear algebra would slow the jobs that run at the same time.
        with threadpool_limits(1):
            found = measure(described, space, fills, contact, others, settings)
        for name in ("emulator", "indices", "intervals", "sets"):
            write_table(getattr(found, name), made[name])
        write_json(found.factors.model_dump(mode="json", exclude_none=True), made.contact)
        for row in found.emulator.itertuples():
            logger.info(
                "%s: Q2 %.3f, error %.3f and scatter %.3f of a logarithm",
                row.quantity, row.q2, row.leave_one_out_error, row.scatter,
            )  # fmt: skip
