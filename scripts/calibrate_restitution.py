"""The drop test: restitution of every contact set from simulated bounces and, if given, from measured bounces."""

import pandas as pd

from millprint.calibration.drop_test import read_heights, simulate_drops, summarise_drops
from millprint.config.calibration import DropTestConfig
from millprint.config.contact import ContactConfig
from millprint.files import write_table
from millprint.job import job

MEASURED = "measured"


def main(
    output,
    contacts: list[ContactConfig],
    time_step_s: float,
    rayleigh_fraction_max: float,
    settings: DropTestConfig,
    interval: float,
) -> None:
    """Simulate drops from every height with every contact set, and add the user's measured drops."""
    drop = (
        time_step_s,
        rayleigh_fraction_max,
        settings.ball_diameter_mm * 1e-3,
        [h * 1e-3 for h in settings.heights_mm],
    )
    tables = {contact.name: simulate_drops(contact, *drop) for contact in contacts}
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
            snakemake.params.time_step_s,
            snakemake.params.rayleigh_fraction_max,
            DropTestConfig(**snakemake.params.settings),
            snakemake.params.interval,
        )
