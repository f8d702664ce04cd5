"""What the commands `warm` and `watt` share: their options, what they print, and the table of the user."""

import datetime
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from millprint.estimate.estimates import WIDEST, Estimate, Interval
from millprint.estimate.judge import judge
from millprint.own_machine.prediction import Condition, origins_of, predicted_power
from millprint.own_machine.readings import append_measured
from millprint.validation.waiting import POWER, fixed_before

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def add_options(parser: ArgumentParser) -> None:
    """The options of every measurement."""
    parser.add_argument("--table", type=Path, help="table of your own measurements; a row is added to it")
    parser.add_argument("--date", type=_day, help="day of the measurement, as 2026-11-27 (default: now)")
    parser.add_argument("--figure", type=Path, help="figure: its name without an ending; PNG and SVG are written")


def _day(text: str) -> str:
    """A day of the calendar."""
    try:
        return datetime.date.fromisoformat(text).isoformat()
    except ValueError:
        raise ArgumentTypeError(f"{text!r}: must be a day, as 2026-11-27") from None


def given(options: Namespace, *names: str) -> dict[str, object]:
    """The options of these names that were given."""
    return {name: value for name in names if (value := getattr(options, name)) is not None}


def say_power(condition: Condition, measured: Estimate, date: str | None) -> str:
    """Print a measured power and the predicted one; returns the verdict with the prediction.

    date: day of the measurement, now if None: what was fixed later does not judge it.
    """
    predicted = predicted_power(condition)
    verdict = judge(predicted, measured, widest=WIDEST)
    print(f"measured power: {measured}\npredicted power: {predicted} ({origins_of(predicted)})\nverdict: {verdict}")
    note = f"predicted {predicted}: {verdict}"
    if (row := _fixed_power(condition, date)) is None:
        return note
    fixed = Estimate(row["value"], "W", mean=Interval(row["lower"], row["upper"]), how="predicted")
    verdict = judge(fixed, measured, widest=WIDEST)
    print(f"fixed for release {row['release']} on {row['date']} UTC: {fixed}: {verdict}")
    return f"{note}; fixed on {row['date']}, digest {row['digest']}: {fixed}: {verdict}"


def _fixed_power(condition: Condition, date: str | None) -> dict | None:
    """The power that was fixed before for balls of one size in an included mill; None if there is none."""
    card = condition.card
    if len(card.balls.sizes) > 1:
        return None
    diameter_mm = card.balls.sizes[0].diameter_mm
    date = date or datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M")
    return fixed_before(date, card.machine.name, diameter_mm, card.balls.fill_ratio, card.machine.speed_rpm, POWER)


def keep(options: Namespace, row: dict[str, str], figure: "Figure | None") -> None:
    """Add the row to the user's table and write the figure, where they were asked for."""
    if options.table:
        print(f"{options.table}: row {append_measured(options.table, row)}")
    if figure and options.figure:
        # Slow to import, and only a figure needs it.
        from millprint.figures.style import save

        stem = options.figure.with_suffix("")
        save(figure, stem.with_suffix(".svg"), stem.with_suffix(".png"))
        print(f"{stem}.png")
