"""Computes half-lives, ball wear with its iron, and the powder masses and gas volumes of the screening runs."""

from millprint.config.doe import DoeConfig
from millprint.doe.runs import read_runs
from millprint.doe.wear import read_wear, wear_table
from millprint.doe.wet_lab import half_life_table, powder_table
from millprint.files import write_table
from millprint.job import job


def main(screening: str, weighings: str, half_life: str, wear: str, powder: str, settings: DoeConfig) -> None:
    """Write the tables of the wet laboratory."""
    runs = read_runs(screening, settings, positive=["bpr", "molar_ratio"])
    write_table(half_life_table(settings), half_life)
    write_table(wear_table(read_wear(weighings)), wear)
    write_table(powder_table(settings, runs), powder)


if "snakemake" in globals():
    with job(snakemake.log[0], "compute wet lab"):
        settings = DoeConfig(**snakemake.params.settings)
        main(**dict(snakemake.input.items()), **dict(snakemake.output.items()), settings=settings)
