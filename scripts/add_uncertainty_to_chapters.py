"""Intervals by contact parameters for the chapters: of the fingerprint of chapter 3, and of printed values.

The fingerprint also gets those by the shape of a fitted jar. The table has each of the thesis's values that come from
the DEM, with ours and its interval by contact parameters only.

Settings: fingerprint.cycle_fill_ratio; the folder of results.
Inputs: `fingerprint`, `contact` and `shape` (factors), `claims`.
Outputs: `fingerprint`, and the table of printed values as `thesis`.
"""

from millprint.fingerprint.bands import FURTHER
from millprint.fingerprint.model import Fingerprint
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.claims.claim_intervals import tabulate_contact_intervals

if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    with job(snakemake.log[0], "chapters and contact parameters") as logger:
        files = {origin: str(path) for origin in FURTHER if (path := given.get(origin))}
        found = Fingerprint.read(given.fingerprint).with_factors(files)
        found.write(made.fingerprint)
        table = tabulate_contact_intervals(own.results, given.claims, found.further["contact"], own.cycle_fill_ratio)
        write_table(table, made.thesis)
        known = table[table["inside"] != ""]
        logger.info("%d of %d printed values lie inside", (known["inside"] == "yes").sum(), len(known))
