"""The values that the jar and the counting rule were fitted to, those held back, and the error of each.

Settings: fit.contact, fit.fitted, fingerprint.counting_rule; the mill.
Inputs: `descriptors`, `cycles`, `published`, `sensitivity`.
Outputs: `fit`.
"""

import pandas as pd

from millprint.config.mill import MillConfig
from millprint.run.files import read_table, write_table
from millprint.run.job import job
from millprint.thesis.curves.regimes import read_published
from millprint.thesis.fit.jar_search import fit_table, parameter_rows, parameters_of
from millprint.thesis.fit.published import computed_values, published_values, with_roles

TEXT = ["mill", "contact", "varied"]


def main(files, output_path: str, mill: MillConfig, contact: str, fitted: list[str], rule: str) -> pd.DataFrame:
    """Write the table from the descriptors and revolutions of the sweeps, and from the table of the sensitivity."""
    values = with_roles(published_values(read_published(*files.published), contact), fitted)
    descriptors, cycles = (read_table(path, text=TEXT) for path in (files.descriptors, files.cycles))
    values = computed_values(values, descriptors, cycles, mill.name, contact).assign(counting_rule=rule)
    parameters = parameter_rows(parameters_of(mill.geometry), mill.geometry.end_radius_mm, rule)
    write_table(fit_table(parameters, values, read_table(files.sensitivity)), output_path)
    return values


if "snakemake" in globals():
    with job(snakemake.log[0], "tabulate the fit") as logger:
        table = main(
            snakemake.input,
            snakemake.output.fit,
            MillConfig(**snakemake.params.mill),
            snakemake.params.contact,
            snakemake.params.fitted,
            snakemake.params.counting_rule,
        )
        for role, part in table.groupby("role"):
            logger.info("%s: largest error %.1f %% of %d values", role, part["error_percent"].abs().max(), len(part))
