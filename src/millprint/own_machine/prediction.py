"""What was predicted of the user's condition: a finished card, and its simulations."""

from dataclasses import dataclass, replace
from pathlib import Path

from millprint.card.card_model import MillingCard
from millprint.card.read import read_card
from millprint.config.errors import ConfigError
from millprint.estimate.estimates import Estimate
from millprint.run.files import read_json

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
    """The predicted power of all balls, with the intervals that a measurement of a long time is judged by."""
    return replace(condition.card.fingerprint.descriptors.power_W, scatter=None, how="predicted")


# What the intervals of a prediction are by.
TITLES = {"mean": "the mean", "contact": "contact parameters", "shape": "shape of the jar"}


def origins_of(predicted: Estimate) -> str:
    """What the intervals of a prediction hold, in words."""
    known = ", ".join(TITLES[name] for name in predicted.intervals)
    words = f"by {known}" if known else "without an interval"
    return words if predicted.contact else f"{words}; contact parameters not analysed"
