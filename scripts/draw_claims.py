"""Intervals of the values of the thesis: by chance, or by contact parameters.

By chance, claims are computed again from redrawn simulations and further trainings. By contact parameters, the
fingerprint of chapter 3 gets its intervals, also those by the shape of a fitted jar, and each printed value that comes
from the DEM stands next to ours and its interval.

Settings: claims, fingerprint.counting_rule, convergence.counting_rules, trainings of every variant; or
fingerprint.cycle_fill_ratio; the folder of results.
Inputs: `claims`; `summaries`, those with several Young's moduli as `of_modulus`, and where a jar was fitted the others
that fit as well, `equal_jars`, with their simulations, `of_jars`; or `fingerprint`, `contact` and `shape` (factors).
Outputs: `intervals` and `by_jar`; or `fingerprint`, and the table of printed values as `thesis`.
"""

import pandas as pd

from millprint.config.workflow import ClaimsConfig
from millprint.estimate.judge import AGREES, OPEN
from millprint.fingerprint.bands import FURTHER
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import read_counted, read_summaries
from millprint.run.files import read_json, write_table
from millprint.run.job import job
from millprint.thesis.claims.tabulate import (
    JAR_TABLE,
    Repeated,
    over_draws,
    repeated_trainings,
    tabulate_contact_intervals,
    tabulate_intervals,
    tabulate_jars,
)
from millprint.thesis.fit.open_shape import read_equal_jars
from millprint.thesis.scaling import draw_tables, tables_of


def main(given, made, own) -> pd.DataFrame:
    """Write the interval of every claim that has one."""
    settings = ClaimsConfig(**own.settings)
    of_modulus = [read_counted(path, own.rules) for path in given.of_modulus]
    drawn = draw_tables(
        read_summaries(given.summaries, own.rules), of_modulus, settings.draws, settings.seed, **own.tables
    )
    repeated = [Repeated(drawn, over_draws), *repeated_trainings(own.results, own.trainings)]
    table = tabulate_intervals(own.results, given.claims, repeated, settings.level)
    write_table(table, made.intervals)
    return table


def judge_by_jars(
    results: str, claims: str, jars: str | None, simulated: list[str], contact: str, mill: str, output: str
) -> pd.DataFrame:
    """Write what every jar that fits as well gives for each claim; an empty table where no jar was fitted."""
    summaries = [read_json(path)["runs"] for path in simulated]
    rules = [rule["name"] for rule in summaries[0][0]["collisions"]] if summaries else []
    known = read_equal_jars(jars, rules).query(f"jar <= {len(summaries)}") if jars else pd.DataFrame()
    tables = [tables_of(summaries[row.jar - 1], mill, [contact], row.counting_rule) for row in known.itertuples()]
    table = tabulate_jars(results, claims, known, tables) if tables else pd.DataFrame(columns=JAR_TABLE)
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
            table = main(inputs, made, own)
            logger.info("intervals: %s", table["interval_from"].value_counts().to_dict())
            jars = inputs.get("equal_jars"), list(inputs.get("of_jars", [])), own.contact, own.tables["mill"]
            table = judge_by_jars(own.results, inputs.claims, *jars, made.by_jar)
            logger.info("%d claims are judged by other jars too", table["id"].nunique())
