"""Splits the screening runs into training and test rows, so that training jobs cannot see a test row."""

from millprint.config.design import Factor
from millprint.files import write_table
from millprint.job import job
from millprint.predict.tables import read_parts


def main(screening: str, split: str, train_path: str, test_path: str, factors: list[Factor]) -> None:
    """Write both parts in the order of the split."""
    train, test = read_parts(screening, split, factors)
    write_table(train, train_path)
    write_table(test, test_path)


if "snakemake" in globals():
    with job(snakemake.log[0], "split screening runs"):
        main(
            snakemake.input.screening,
            snakemake.input.split,
            snakemake.output.train,
            snakemake.output.test,
            [Factor(**factor) for factor in snakemake.params.factors],
        )
