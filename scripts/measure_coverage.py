"""Counts how often new simulations, and conditions left out of the fit, are within the bands of a mill's fingerprint.

Settings: the counting rule.
Inputs: `summaries` of the new simulations, and `fingerprint`.
Outputs: `coverage` and `held_out`.
"""

import pandas as pd

from millprint.fingerprint.coverage import (
    HELD_OUT_COLUMNS,
    count_held_out,
    describe_each,
    predict_held_out,
    tabulate_coverage,
)
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import read_summaries
from millprint.run.files import write_table
from millprint.run.job import job


def main(summaries: list[str], rules: list[dict], fingerprint: Fingerprint, output) -> pd.DataFrame:
    """Compare the new simulations, if any, with what the fingerprint predicts, and write both tables."""
    coverage, predicted = tabulate_coverage(fingerprint), pd.DataFrame(columns=HELD_OUT_COLUMNS)
    if summaries:
        found = describe_each(read_summaries(summaries, rules), fingerprint.about["counting_rule"])
        predicted = predict_held_out(fingerprint, found)
        coverage = pd.concat([count_held_out(fingerprint, predicted), coverage], ignore_index=True)
    write_table(predicted, output.held_out)
    write_table(coverage, output.coverage)
    return coverage


if "snakemake" in globals():
    given = snakemake.input
    with job(snakemake.log[0], f"measure the coverage of {snakemake.wildcards.mill}") as logger:
        found = main(
            list(given.summaries), snakemake.params.rules, Fingerprint.read(given.fingerprint), snakemake.output
        )
        for row in found[found["quantity"] == "powers"].itertuples():
            logger.info("%d of %d powers of new simulations lie within their bands", row.held, row.conditions)
