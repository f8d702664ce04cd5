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
    drop = (
        time_step_s,
        rayleigh_fraction_max,
        settings.ball_diameter_mm * 1e-3,
        [h * 1e-3 for h in settings.heights_mm],
    )
    tables = {contact.name: simulate_drops(contact, *drop) for contact in contacts}
    if settings.measured:
        tables[MEASURED] = read_heights(settings.measured).assign(contact=MEASURED)
        found = restitution_over_speed(tables[MEASURED], interval)
        write_table(found, output.over_speed)
        for line in table_in_words(found):
            logger.info("%s", line)
    write_table(pd.concat(tables.values(), ignore_index=True), output.drops)
    rows = [{"contact": name, **summarise_drops(table, interval)} for name, table in tables.items()]
    write_table(pd.DataFrame(rows), output.restitution)


def draw_drops(drops_path: str, restitution_path: str, svg: str, png: str) -> None:
    """Draw every drop and the mean of each contact set."""
    drops = read_table(drops_path, numeric=["drop_height_mm", "restitution"], text=["contact"])
    means = read_table(restitution_path, numeric=["mean", "lower", "upper"], text=["contact"])
    save(plot_drops(drops, means), svg, png)


def draw_fit(track_path: str, fit_path: str, profile_path: str, paths_path: str, svg: str, png: str) -> None:
    """Draw a track with its fit and the profiles of both coefficients."""
    track = read_table(track_path, numeric=["time_s"])
    fit = read_table(fit_path, numeric=["estimate", "lower", "upper"], text=["parameter"])
    profile = read_table(profile_path, numeric=["value", "excess", "threshold"], text=["parameter"])
    paths = read_table(paths_path, numeric=["time_s", "across_mm", "height_mm"], text=["path"])
    save(plot_friction_fit(track, paths, fit, profile), svg, png)


if "snakemake" in globals():
    given, made = snakemake.input, snakemake.output
    with job(snakemake.log[0], "calibrate restitution"):
        main(
            made,
            [ContactConfig(**contact) for contact in snakemake.params.contacts],
            snakemake.params.time_step_s,
            snakemake.params.rayleigh_fraction_max,
            DropTestConfig(**snakemake.params.settings),
            snakemake.params.interval,
        )
        draw_drops(made.drops, made.restitution, *made.drops_figure)
        tables = zip(given.track, given.fit, given.profile, given.paths, strict=True)
        for files, figure in zip(tables, in_pairs(made.friction_figures), strict=True):
            draw_fit(*files, *figure)
