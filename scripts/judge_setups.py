"""What was measured in each set-up, beside its prediction: verdicts, what is assumed and when it was fixed, figures.

Of a tumbling mill also its charge at several speeds, and a table of power with both intervals, toe, shoulder and rings.
"""

import pandas as pd

from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.setups.base import SetupConfig
from millprint.config.setups.tumbling import TumblingConfig
from millprint.config.sweep import DemConfig
from millprint.config.validation import ValidationConfig
from millprint.figures.charge import plot_charge
from millprint.figures.style import save
from millprint.figures.validation import plot_setup
from millprint.files import read_table, write_table
from millprint.job import job
from millprint.mill.bodies import build_bodies
from millprint.report.chapter_pages import write_chapter
from millprint.validation.fixed import read_fixed, settings_digest, status_of
from millprint.validation.measured import measured_points, read_measurements
from millprint.validation.setups import SETUPS, assumption_table, setup_named
from millprint.validation.tumbling import intervals
from millprint.validation.verdicts import count_verdicts, give_verdicts


def read_setup(name: str, given: dict) -> tuple[SetupConfig, MillConfig | None, dict[str, ContactConfig]]:
    """A set-up from plain values: its `settings`, its `mill` (or none) and its `contacts`."""
    # The section of a set-up is of a class of its own.
    settings = type(getattr(ValidationConfig(), name))(**given["settings"])
    mill = MillConfig(**given["mill"]) if given["mill"] else None
    return settings, mill, {contact["name"]: ContactConfig(**contact) for contact in given["contacts"]}


def read_predictions(path: str) -> pd.DataFrame:
    """What is predicted of a set-up."""
    return read_table(
        path,
        numeric=["x", "predicted", "lower", "upper"],
        text=["id", "quantity", "unit", "model", "interval"],
        may_be_blank=["x", "lower", "upper"],
    )


def tabulate(setups: dict[str, dict], dem: DemConfig, predicted, points: pd.DataFrame, fixed_path: str, output) -> None:
    """Write the verdicts, their counts and the assumptions. setups: as `read_setup` takes them, by name."""
    fixed, statuses, assumed = read_fixed(fixed_path), {}, []
    for name, given in setups.items():
        settings, mill, contacts = read_setup(name, given)
        statuses[name] = status_of(name, settings_digest(settings, mill, contacts, dem), fixed)
        assumed += [{**row, "settings": statuses[name]} for row in assumption_table(name, settings, mill, contacts)]
    unknown = [name for name, setup in SETUPS.items() if not setup.known]
    verdicts = give_verdicts(points, pd.concat(predicted), statuses, unknown=unknown)
    write_table(verdicts, output.verdicts)
    write_table(count_verdicts(verdicts), output.counts)
    write_table(pd.DataFrame(assumed), output.assumptions)


def draw(
    name: str, predictions: pd.DataFrame, points: pd.DataFrame, svg: str, png: str, first_svg: str, first_png: str
) -> None:
    """Draw every quantity of a set-up and, for a page, its first alone. points: what was measured in all set-ups."""
    own, title = points[points["setup"] == name], setup_named(name).title
    save(plot_setup(predictions, own, title), svg, png)
    first = predictions[predictions["quantity"] == predictions["quantity"].iloc[0]]
    save(plot_setup(first, own, title), first_svg, first_png)


def draw_charge(
    settings: TumblingConfig, mill: MillConfig, runs_path: str, charge_path: str, svg: str, png: str, output: str
) -> None:
    """Draw the charge of a tumbling mill, and write the table of its intervals."""
    table = intervals(read_table(runs_path), settings)
    write_table(table, output)
    vessel = build_bodies(mill, settings.speed_rpm(settings.speeds[0]))[0].vessel
    unit = "rpm" if settings.critical_speed_rpm is None else "% of the critical speed"
    save(plot_charge(read_table(charge_path), table, vessel, mill.geometry.axis, unit), svg, png)


if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    with job(snakemake.log[0], "judge set-ups") as log:
        points = measured_points(read_measurements(given.measured, SETUPS))
        predicted = [read_predictions(path) for path in given.predictions]
        tabulate(own.setups, DemConfig(**own.dem), predicted, points, given.fixed, made)
        write_chapter(own.chapter, own.name, (made.verdicts, made.counts, made.assumptions), own.results, made.page)
        figures = zip(predicted, made.svgs, made.pngs, made.first_svgs, made.first_pngs, strict=True)
        for name, (predictions, *paths) in zip(own.setups, figures, strict=True):
            draw(name, predictions, points, *paths)
            log.info("drawn: %s", name)
        charges = zip(given.runs, given.charges, made.charge_svgs, made.charge_pngs, made.intervals, strict=True)
        for name, paths in zip(own.tumbling, charges, strict=True):
            settings, mill, _ = read_setup(name, own.setups[name])
            draw_charge(settings, mill, *paths)
            log.info("charge drawn: %s", name)
