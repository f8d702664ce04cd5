"""The drop test: restitution of every contact set from simulated bounces, and of measured bounces where given."""

import pandas as pd

from millprint.calibration.drop_test import read_heights, simulate_drops, summarise_drops
from millprint.config.calibration import DropTestConfig
from millprint.config.contact import ContactConfig
from millprint.config.sweep import DemConfig
from millprint.files import write_table
from millprint.job import job

MEASURED = "measured"


def main(output, contacts: list[ContactConfig], dem: DemConfig, settings: DropTestConfig, interval: float) -> None:
    """Drop a ball from every height with every contact set; read the user's drops."""
    heights = [height * 1e-3 for height in settings.heights_mm]
    tables = {name.name: simulate_drops(name, dem, settings.ball_diameter_mm * 1e-3, heights) for name in contacts}
    if settings.measured:
        tables[MEASURED] = read_heights(settings.measured).assign(contact=MEASURED)
    write_table(pd.concat(tables.values(), ignore_index=True), output.drops)
    rows = [{"contact": name, **summarise_drops(table, interval)} for name, table in tables.items()]
    write_table(pd.DataFrame(rows), output.restitution)


if "snakemake" in globals():
    with job(snakemake.log[0], "calibrate restitution"):
        main(
            snakemake.output,
            [ContactConfig(**contact) for contact in snakemake.params.contacts],
            DemConfig(**snakemake.params.dem),
            DropTestConfig(**snakemake.params.settings["drop_test"]),
            snakemake.params.settings["interval"],
        )
