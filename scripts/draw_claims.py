"""Computes claims again from redrawn simulations and further trainings, for their intervals.

Settings: claims, fingerprint.counting_rule, convergence.counting_rules; trainings of every variant.
Inputs: `claims`, `summaries`, and those with several Young's moduli as `of_modulus`.
Outputs: `intervals`.
"""

import pandas as pd

from millprint.config.workflow import ClaimsConfig
from millprint.fingerprint.readers import read_summaries
from millprint.run.files import read_json, write_table
from millprint.run.job import job
from millprint.thesis.claims.claim_intervals import Repeated, over_draws, repeated_trainings, tabulate_intervals
from millprint.thesis.curves.collapse import draw_tables


def main(
    results: str, claims: str, summaries: list[str], of_modulus: list[str], settings: ClaimsConfig,
    trainings: dict[str, list[str]], tables: dict, output: str,
) -> pd.DataFrame:  # fmt: skip
    """Write the interval of every claim that has one; tables: settings of `redrawn_tables`."""
    drawn = draw_tables(
        read_summaries(summaries), [read_json(path) for path in of_modulus], settings.draws, settings.seed, **tables
    )
    repeated = [Repeated(drawn, over_draws), *repeated_trainings(results, trainings)]
    table = tabulate_intervals(results, claims, repeated, settings.level)
    write_table(table, output)
    return table


if "snakemake" in globals():
    with job(snakemake.log[0], "draw claims again") as logger:
        inputs, own = snakemake.input, snakemake.params
        table = main(
            own.results,
            inputs.claims,
            list(inputs.summaries),
            list(inputs.of_modulus),
            ClaimsConfig(**own.settings),
            own.trainings,
            own.tables,
            snakemake.output.intervals,
        )
        logger.info("intervals: %s", table["interval_from"].value_counts().to_dict())
