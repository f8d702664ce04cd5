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

if "snakemake" in globals():
    given, made = snakemake.input, snakemake.output
    with job(snakemake.log[0], f"measure the coverage of {snakemake.wildcards.mill}") as logger:
        fingerprint = Fingerprint.read(given.fingerprint)
        coverage, predicted = tabulate_coverage(fingerprint), pd.DataFrame(columns=HELD_OUT_COLUMNS)
        if given.summaries:
            summaries = read_summaries(list(given.summaries), snakemake.params.rules)
            predicted = predict_held_out(fingerprint, describe_each(summaries, fingerprint.about["counting_rule"]))
            coverage = pd.concat([count_held_out(fingerprint, predicted), coverage], ignore_index=True)
        write_table(predicted, made.held_out)
        write_table(coverage, made.coverage)
        for row in coverage[coverage["quantity"] == "powers"].itertuples():
            logger.info("%d of %d powers of new simulations lie within their bands", row.held, row.conditions)
