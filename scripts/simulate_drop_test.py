"""The virtual drop test: restitution of every contact set, read back from simulated bounces."""

import pandas as pd

from millprint.config.contact import ContactConfig
from millprint.config.fingerprint import DropTestConfig
from millprint.config.sweep import DemConfig
from millprint.files import write_table
from millprint.fingerprint.drop_test import simulate_drops
from millprint.job import job


def main(table_path: str, contacts: list[ContactConfig], dem: DemConfig, drop_test: DropTestConfig) -> None:
    """Drop a ball from every height with every contact set."""
    heights = [height * 1e-3 for height in drop_test.heights_mm]
    tables = [simulate_drops(contact, dem, drop_test.ball_diameter_mm * 1e-3, heights) for contact in contacts]
    write_table(pd.concat(tables, ignore_index=True), table_path)


if "snakemake" in globals():
    with job(snakemake.log[0], "simulate drop test"):
        main(
            snakemake.output.table,
            [ContactConfig(**contact) for contact in snakemake.params.contacts],
            DemConfig(**snakemake.params.dem),
            DropTestConfig(**snakemake.params.settings["drop_test"]),
        )
