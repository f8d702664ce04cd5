"""The thesis's values that come from the DEM, with ours and their intervals by contact parameters alone."""

import json

import pandas as pd

from millprint.claims.contact_intervals import tabulate_contact_intervals
from millprint.files import write_table
from millprint.fingerprint.bands import read_factors
from millprint.job import job


def main(files, output: str, results: str, cycle_fill_ratio: float) -> pd.DataFrame:
    """Write the table from the results of chapters 3 and 4 and the factors of the run's mill."""
    with open(files.fingerprint) as file:
        factors = read_factors(files.contact, "contact", json.load(file)["about"])
    table = tabulate_contact_intervals(results, files.claims, factors, cycle_fill_ratio)
    write_table(table, output)
    return table


if "snakemake" in globals():
    with job(snakemake.log[0], "printed values and contact parameters") as logger:
        parameters = snakemake.params
        table = main(snakemake.input, snakemake.output.thesis, parameters.results, parameters.cycle_fill_ratio)
        known = table[table["inside"] != ""]
        logger.info("%d of %d printed values lie inside", (known["inside"] == "yes").sum(), len(known))
