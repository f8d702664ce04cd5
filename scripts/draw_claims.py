"""Intervals of the values of the thesis: by chance, or by contact parameters.

By chance, claims are computed again from redrawn simulations and further trainings. By contact parameters, the
fingerprint of chapter 3 gets its intervals, also those by the shape of a fitted jar, and each printed value that comes
from the DEM stands next to ours and its interval.

Settings: claims, fingerprint.counting_rule, convergence.counting_rules, trainings of every variant; or
fingerprint.cycle_fill_ratio; the folder of results.
Inputs: `claims`; `summaries`, and those with several Young's moduli as `of_modulus`; or `fingerprint`, `contact` and
`shape` (factors).
Outputs: `intervals`; or `fingerprint`, and the table of printed values as `thesis`.
"""

import pandas as pd

from millprint.config.workflow import ClaimsConfig
from millprint.estimate.judge import AGREES, OPEN
from millprint.fingerprint.bands import FURTHER
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import read_counted, read_summaries
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.claims.claim_intervals import (
    Repeated,
    over_draws,
    repeated_trainings,
    tabulate_contact_intervals,
    tabulate_intervals,
)
from millprint.thesis.curves.collapse import draw_tables


def main(
    results: str, claims: str, summaries: list[str], of_modulus: list[str], rules: list[dict], settings: ClaimsConfig,
    trainings: dict[str, list[str]], tables: dict, output: str,
) -> pd.DataFrame:  # fmt: skip
    """Write the interval of every claim that has one; tables: settings of `redrawn_tables`."""
    drawn = draw_tables(
        read_summaries(summaries, rules),
        [read_counted(path, rules) for path in of_modulus],
        settings.draws,
        settings.seed,
        **tables,
    )
    repeated = [Repeated(drawn, over_draws), *repeated_trainings(results, trainings)]
    table = tabulate_intervals(results, claims, repeated, settings.level)
    write_table(table, output)
    return table


def add_contact_intervals(inputs, output, results: str, cycle_fill_ratio: float) -> pd.DataFrame:
    """Write the fingerprint with its intervals, and the table of printed values, which is returned."""
    files = {origin: str(path) for origin in FURTHER if (path := inputs.get(origin))}
    found = Fingerprint.read(inputs.fingerprint).with_factors(files)
    found.write(output.fingerprint)
    table = tabulate_contact_intervals(results, inputs.claims, found.further["contact"], cycle_fill_ratio)
    write_table(table, output.thesis)
    return table


if "snakemake" in globals():
    inputs, made, own = snakemake.input, snakemake.output, snakemake.params
    with job(snakemake.log[0], "draw claims again") as logger:
        if made.get("thesis"):
            table = add_contact_intervals(inputs, made, own.results, own.cycle_fill_ratio)
            known = table[table["verdict"] != OPEN]
            logger.info("%d of %d printed values lie inside", (known["verdict"] == AGREES).sum(), len(known))
        else:
            simulations = list(inputs.summaries), list(inputs.of_modulus), own.rules
            settings = ClaimsConfig(**own.settings)
            written = (settings, own.trainings, own.tables, made.intervals)
            table = main(own.results, inputs.claims, *simulations, *written)
            logger.info("intervals: %s", table["interval_from"].value_counts().to_dict())
