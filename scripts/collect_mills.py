"""Do the curves of the thesis collapse for each mill? A table with a row for each mill, and a figure.

input: the collapse table of each mill. output: `table`, `svg`, `png`.
"""

from millprint.figures.mills import plot_collapse
from millprint.figures.style import save
from millprint.fingerprint.mill_collapse import COLLAPSE_MAX, one_row_a_mill
from millprint.run.files import read_table, write_table
from millprint.run.job import job

if "snakemake" in globals():
    with job(snakemake.log[0], "collect the collapse of all mills"):
        table = one_row_a_mill([read_table(path) for path in snakemake.input])
        write_table(table, snakemake.output.table)
        save(plot_collapse(table, COLLAPSE_MAX), snakemake.output.svg, snakemake.output.png)
