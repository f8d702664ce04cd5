"""Writes what the tables of the yield models say, as sentences computed from them."""

from millprint.files import read_table, write_table
from millprint.job import job
from millprint.predict.statements import state


def main(inputs: dict[str, str], path: str) -> None:
    """inputs: the tables by name."""
    tables = {name: read_table(each) for name, each in inputs.items()}
    write_table(state(tables), path)


if "snakemake" in globals():
    with job(snakemake.log[0], "state yields"):
        main(dict(snakemake.input.items()), snakemake.output.statements)
