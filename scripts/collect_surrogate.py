"""Joins the tables of measures of all variants, with the spread of each measure over the trainings of a variant."""

from millprint.files import read_table, write_table
from millprint.job import job
from millprint.surrogate.spread import tabulate_trainings, with_spread
from millprint.surrogate.tables import join_tables


def main(tables: list[str], trainings: dict[str, list[str]], metrics: str, repeated: str) -> None:
    """Write the measures of each variant, and those of each of its trainings."""
    found = join_tables([read_table(path, text=["variant", "test", "measure"]) for path in tables])
    write_table(with_spread(found, trainings), metrics)
    write_table(tabulate_trainings(found, trainings), repeated)


if "snakemake" in globals():
    with job(snakemake.log[0], "collect the surrogate's measures"):
        outputs = snakemake.output
        main(list(snakemake.input.metrics), snakemake.params.trainings, outputs.metrics, outputs.trainings)
