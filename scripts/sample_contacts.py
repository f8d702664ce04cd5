"""Simulates one job's share of the samples of a mill: contact parameters and fill ratio by a space-filling design.

Settings: uncertainty, mills, dem, fingerprint.counting_rule; the mill with its sweep, and the contact set.
Inputs: `sweep` where it was derived.
Outputs: `samples`.
"""

from pathlib import Path

from millprint.cases.of_mill import varied_case
from millprint.config.contact_set import ContactConfig
from millprint.config.fingerprint import UncertaintyConfig
from millprint.config.mill_sweep import MillsConfig
from millprint.config.sweep import DemConfig
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.uncertainty.samples import check_contact, design_of, run_samples, space_of, with_sweep

if "snakemake" in globals():
    own, output, number = snakemake.params, snakemake.output.samples, int(snakemake.wildcards.number)
    with job(snakemake.log[0], f"sample {snakemake.wildcards.mill}, job {number}"):
        mill = with_sweep(own.mill, own.sweep, next(iter(snakemake.input.sweep), None))
        contact, settings = ContactConfig(**own.contact), UncertaintyConfig(**own.settings)
        check_contact(space_of(mill, settings), contact)
        # The samples number, number + jobs, ...; a killed job continues from its rows.
        samples = design_of(mill, settings).iloc[number :: settings.jobs]
        done, title = Path(output).with_suffix(".done"), f"{mill.name}, samples {number + 1} of {settings.jobs}"
        case = varied_case(mill, MillsConfig(**own.mills), settings)
        table = run_samples(case, mill, contact, DemConfig(**own.dem), samples, own.counting_rule, done, title)
        table.insert(0, "sample", table.index)
        write_table(table, output, digits=17)
        done.unlink()
