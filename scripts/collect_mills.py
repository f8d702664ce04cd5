"""Do the curves of the thesis collapse for each mill, and how often are new simulations within its bands?

A table of the collapse with a row for each mill, and its figure; and the coverage of each mill with a sum over them.

Settings: mills.box.
Inputs: `collapse` and `coverage`, a table of each mill in the order of the box.
Outputs: `table`, `svg`, `png` of the collapse; `coverage`.
"""

from millprint.figures.mill_pictures import plot_collapse
from millprint.figures.style import save
from millprint.fingerprint.coverage import sum_coverage
from millprint.fingerprint.mill_collapse import COLLAPSE_MAX, one_row_a_mill
from millprint.run.files import read_table, write_table
from millprint.run.job import job

if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    with job(snakemake.log[0], "collect the mills") as logger:
        table = one_row_a_mill([read_table(path) for path in given.collapse])
        write_table(table, made.table)
        save(plot_collapse(table, COLLAPSE_MAX), made.svg, made.png)
        counted = {name: read_table(path) for name, path in zip(own.mills, given.coverage, strict=True)}
        found = sum_coverage(counted)
        write_table(found, made.coverage)
        for row in found[found["quantity"] == "powers"].itertuples():
            logger.info("%s: %d of %d powers of new simulations", row.mill, row.held, row.conditions)
