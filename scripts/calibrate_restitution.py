"""The drop test: restitution of every contact set from simulated bounces and, if given, from measured bounces.

Draws every drop, and the track of each oscillating ball with its fit (Fig. 3.3).

Settings: calibration.drop_test, calibration.interval, dem.time_step_s, dem.rayleigh_fraction_max; contact sets.
Inputs: `measured` bounces; `track`, `fit`, `profile`, `paths` of the friction fits.
Outputs: `drops`, `restitution`, `over_speed` of measured bounces, and the figures.
"""

import logging

import pandas as pd

from millprint.config.calibration import DropTestConfig
from millprint.config.contact_set import ContactConfig
from millprint.figures.style import in_pairs, save
from millprint.run.files import read_table, write_table
from millprint.run.job import job
from millprint.thesis.drop import (
    read_heights,
    restitution_over_speed,
    simulate_drops,
    summarise_drops,
    table_in_words,
)
from millprint.thesis.figures.chapter3_and_4_figures import plot_drops, plot_friction_fit

logger = logging.getLogger("millprint")

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
    diameter, heights = settings.ball_diameter_mm * 1e-3, [h * 1e-3 for h in settings.heights_mm]
    tables = {
        contact.name: simulate_drops(contact, time_step_s, rayleigh_fraction_max, diameter, heights)
        for contact in contacts
    }
    if settings.measured:
        tables[MEASURED] = read_heights(settings.measured).assign(contact=MEASURED)
        found = restitution_over_speed(tables[MEASURED], interval)
        write_table(found, output.over_speed)
        for line in table_in_words(found):
            logger.info("%s", line)
    write_table(pd.concat(tables.values(), ignore_index=True), output.drops)
    rows = [{"contact": name, **summarise_drops(table, interval)} for name, table in tables.items()]
    write_table(pd.DataFrame(rows), output.restitution)


if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    with job(snakemake.log[0], "calibrate restitution"):
        contacts = [ContactConfig(**contact) for contact in own.contacts]
        settings = DropTestConfig(**own.settings)
        main(made, contacts, own.time_step_s, own.rayleigh_fraction_max, settings, own.interval)
        drops, means = (read_table(path, text=["contact"]) for path in (made.drops, made.restitution))
        save(plot_drops(drops, means), *made.drops_figure)
        tables = zip(given.track, given.paths, given.fit, given.profile, strict=True)
        for files, figure in zip(tables, in_pairs(made.friction_figures), strict=True):
            save(plot_friction_fit(*map(read_table, files)), *figure)
