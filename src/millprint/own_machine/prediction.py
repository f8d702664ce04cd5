"""What `warm` and `watt` share: the prediction of a finished card, the verdict, and the user's table."""

import datetime
from argparse import Namespace
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from millprint.card.card_model import MillingCard
from millprint.card.read import read_card
from millprint.config.errors import ConfigError
from millprint.estimate.estimates import WIDEST, Estimate, Interval
from millprint.estimate.judge import judge
from millprint.fingerprint.bands import ORIGINS
from millprint.own_machine.readings import append_measured
from millprint.run.files import read_json
from millprint.validation.waiting import POWER, fixed_before

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HOW = "`millprint card card.yaml --out FOLDER` simulates a condition"


@dataclass(frozen=True)
class Condition:
    """A card with its simulations: folders with run.h5 and summary.json."""

    card: MillingCard
    runs: list[Path]

    @property
    def summaries(self) -> list[dict]:
        """The summary of each run."""
        return [read_json(run / "summary.json") for run in self.runs]

    @property
    def words(self) -> str:
        """Mill, speed and balls in a few words."""
        balls = ", ".join(f"{group.number} balls of {group.diameter_mm:g} mm" for group in self.card.balls.sizes)
        return f"{self.card.machine.name}, {self.card.machine.speed_rpm:g} rpm, {balls}"

    def row(self, quantity: str, unit: str, measured: Estimate, note: str) -> dict[str, str]:
        """A row of the table of own measurements, without an id that is surely its own."""
        hull = measured.hull()
        half = max(hull.upper - measured.value, measured.value - hull.lower)
        return {
            "id": f"{self.card.name}_{quantity.replace(' ', '_')}",
            "mill": self.card.machine.name,
            "description": self.words,
            "quantity": quantity,
            "value": f"{measured.value:.4g}",
            "unit": unit,
            "uncertainty": f"{half:.3g}",
            "uncertainty_unit": unit,
            "note": f"{note}; card of mill {self.card.digests.get('mill', '')[:12]}",
        }


def read_condition(folder: str | Path) -> Condition:
    """The card in a folder of `millprint card`. Raises ConfigError, in one line, if card or runs are not there."""
    place = Path(folder)
    if not (place / "card.json").is_file():
        raise ConfigError(f"{folder}: no card.json in it, so nothing is predicted yet; {HOW}")
    runs = sorted(path.parent for path in place.glob("runs/seed_*/run.h5"))
    if not runs:
        raise ConfigError(f"{folder}: no runs/seed_*/run.h5 in it, the simulations of the card; {HOW}")
    return Condition(read_card(place / "card.json"), runs)


def predicted_power(condition: Condition) -> Estimate:
    """The predicted power of the walls, which a meter sees, with the intervals that judge a long measurement."""
    return replace(condition.card.fingerprint.descriptors.wall_power_W, scatter=None, how="predicted")


def origins_of(predicted: Estimate) -> str:
    """What the intervals of a prediction hold, in words."""
    known = ", ".join(ORIGINS[name].title for name in predicted.intervals)
    words = f"by {known}" if known else "without an interval"
    return words if predicted.contact else f"{words}; contact parameters not analysed"


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
