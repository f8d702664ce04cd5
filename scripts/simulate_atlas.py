"""Simulates some rows of the design of the atlas.

Settings: the kind, the part of the design, the first row and their number.
Inputs: `held_out`, the table of the held-out mills.
Outputs: `rows`.
"""

from pathlib import Path

from millprint.atlas.design import rows_of
from millprint.atlas.simulate_rows import simulate_rows
from millprint.run.files import write_table
from millprint.run.job import job


def main(output: str, kind: str, part: str, first: int, count: int, held_out: str) -> None:
    """Simulate the rows first, first + 1, ...; a killed job continues from those that are done."""
    rows = rows_of(kind, part, first, count, held_out)
    title = f"{kind}, {part} {first} to {first + count - 1}"
    write_table(simulate_rows(rows, Path(output).with_suffix(".done"), title), output, digits=6)


if "snakemake" in globals():
    own = snakemake.wildcards
    with job(snakemake.log[0], f"atlas {own.kind} {own.part} {own.batch}"):
        first = int(own.batch) * snakemake.params.count
        main(snakemake.output.rows, own.kind, own.part, first, snakemake.params.count, snakemake.input.held_out)
