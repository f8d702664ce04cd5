"""What was measured in each set-up and its prediction: verdicts, coverage, what is assumed, figures.

Of a tumbling mill also its charge at several speeds, and a table of power with both intervals, toe, shoulder and rings;
of some drums the flowing bed, each ball coloured by its speed.

Settings: validation (every chosen set-up with its mill and contact sets), name.
Inputs: `measured`, `predictions`; of tumbling mills `runs` and `charges`; `beds` (run.h5 of a drum).
Outputs: `verdicts`, `counts`, `coverage`, `assumptions`, their `page`; `figures`, and of the first quantity
`first`; `charges` and `intervals`; `beds` and `bed_tsvs`.
"""

from pathlib import Path

import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.setup_models import (
    FILES,
    LOST,
    SETTINGS,
    SetupConfig,
    TumblingConfig,
    quantities_of,
    read_settings,
)
from millprint.figures.style import in_pairs, save
from millprint.figures.validation_figures import plot_bed, plot_charge, plot_setup, plot_shaken
from millprint.mill.bodies import build_bodies
from millprint.report.table_pages import write_chapter
from millprint.run.files import read_table, write_table
from millprint.run.job import job
from millprint.validation.drums import slab_of_bed
from millprint.validation.measured import measured_points, read_measurements
from millprint.validation.setups import PREDICTED, assumption_table, setup_named
from millprint.validation.shaken import SAME
from millprint.validation.tumbling import intervals
from millprint.validation.verdicts import count_verdicts, give_verdicts, tabulate_coverage


def read_setup(name: str, given: dict) -> tuple[SetupConfig, MillConfig | None, dict[str, ContactConfig]]:
    """A set-up from plain values: its `settings`, its `mill` (or none) and its `contacts`."""
    settings = read_settings(name, given["settings"])
    mill = MillConfig(**given["mill"]) if given["mill"] else None
    return settings, mill, {contact["name"]: ContactConfig(**contact) for contact in given["contacts"]}


def tabulate(setups: dict[str, dict], predicted: dict[str, pd.DataFrame], points: pd.DataFrame, output) -> None:
    """Write the verdicts, counts, coverage and assumptions. By name: setups, as `read_setup` takes them, and what is
    predicted of each.
    """
    assumed = [row for name, given in setups.items() for row in assumption_table(name, *read_setup(name, given))]
    variants = {name: PREDICTED[file.kind].variants for name, file in FILES.items()}
    verdicts = give_verdicts(points, predicted, variants)
    write_table(verdicts, output.verdicts)
    write_table(count_verdicts(verdicts), output.counts)
    write_table(tabulate_coverage(verdicts), output.coverage)
    write_table(pd.DataFrame(assumed), output.assumptions)


def draw(
    name: str, predictions: pd.DataFrame, points: pd.DataFrame, paths: tuple[str, str], first: tuple[str, str]
) -> None:
    """Draw every quantity of a set-up and, for a page, only its first. points: what was measured in all set-ups."""
    own, title = points[points["setup"] == name], setup_named(name).title
    x_names = {quantity: asked.x for quantity, asked in quantities_of(SETTINGS[name]).items()}
    shown = predictions[predictions["quantity"] == predictions["quantity"].iloc[0]]
    for rows, files in ((predictions, paths), (shown, first)):
        if name == "shaken_box":
            save(plot_shaken(rows, LOST, SAME, x_names[LOST]), *files)
        else:
            save(plot_setup(rows, own, title, x_names), *files)


def draw_charge(
    settings: TumblingConfig, mill: MillConfig, runs_path: str, charge_path: str, paths: tuple[str, str], output: str
) -> None:
    """Draw the charge of a tumbling mill, and write the table of its intervals."""
    table = intervals(read_table(runs_path), settings)
    write_table(table, output)
    vessel = build_bodies(mill)[0].vessel
    unit = "rpm" if settings.critical_speed_rpm is None else "% of the critical speed"
    save(plot_charge(read_table(charge_path), table, vessel, mill.geometry.axis, unit), *paths)


if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    with job(snakemake.log[0], "judge set-ups") as log:
        points = measured_points(read_measurements(given.measured, FILES))
        # Columns that may be empty, or hold numbers in one set-up and words in another.
        text = ["id", "quantity", "unit", "model", "interval"]
        paths = zip(own.setups, given.predictions, strict=True)
        predicted = {name: read_table(path, text=text) for name, path in paths}
        tabulate(own.setups, predicted, points, made)
        tables = (made.verdicts, made.counts, made.coverage, made.assumptions)
        write_chapter(own.chapter, own.name, tables, own.results, made.page)
        figures = zip(predicted.values(), in_pairs(made.figures), in_pairs(made.first), strict=True)
        for name, (predictions, *paths) in zip(own.setups, figures, strict=True):
            draw(name, predictions, points, *paths)
            log.info("drawn: %s", name)
        charges = zip(given.runs, given.charges, in_pairs(made.charges), made.intervals, strict=True)
        for name, paths in zip(own.tumbling, charges, strict=True):
            settings, mill, _ = read_setup(name, own.setups[name])
            draw_charge(settings, mill, *paths)
            log.info("charge drawn: %s", name)
        beds = zip(own.beds.items(), given.beds, in_pairs(made.beds), made.bed_tsvs, strict=True)
        for (name, (radius_m, diameter_m)), run, paths, tsv in beds:
            balls = slab_of_bed(Path(run), diameter_m)
            save(plot_bed(balls, radius_m, diameter_m, setup_named(name).title), *paths, tsv=tsv)
            log.info("bed drawn: %s", name)
