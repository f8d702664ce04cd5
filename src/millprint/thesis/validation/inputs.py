"""What a prediction reads, and the numbers that it makes, with their intervals."""

from dataclasses import dataclass, field
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.run.files import read_json, read_table
from millprint.run.tables import Number, Text, read_measured

DEM = "DEM"
SCATTER = "scatter of seeds"
BLOCKS = "scatter of blocks of time"
CONTACT = "contact parameters"
BALLS = "spread of the balls"
# Origins of an interval; both where they are added.
INTERVALS = ("", SCATTER, BLOCKS, CONTACT, f"{SCATTER} and {CONTACT}", f"{BLOCKS} and {CONTACT}", BALLS)
# Units of quantities that are not negative, so that their intervals do not go below 0.
NOT_NEGATIVE = ("W", "J/rev")
PREDICTION_COLUMNS = ("id", "x", "quantity", "unit", "model", "predicted", "lower", "upper", "interval")


def prediction(
    quantity: str,
    unit: str,
    predicted: float,
    *,
    id: str = "",
    x: float = nan,
    lower: float = nan,
    upper: float = nan,
    interval: str = "",
    model: str = DEM,
) -> dict:
    """A row of a table of predictions."""
    values = (id, x, quantity, unit, model, predicted, lower, upper, interval)
    return dict(zip(PREDICTION_COLUMNS, values, strict=True))


def check_predictions(table: pd.DataFrame, setup: str) -> pd.DataFrame:
    """The table with its columns in order. Raises ValueError for a wrong column, interval or end."""
    if set(table.columns) != set(PREDICTION_COLUMNS):
        raise ValueError(f"{setup}: columns {sorted(table.columns)}; expected {', '.join(PREDICTION_COLUMNS)}")
    if unknown := sorted(set(table["interval"]) - set(INTERVALS)):
        raise ValueError(f"{setup}: interval by {unknown[0]!r}; known: {', '.join(filter(None, INTERVALS))}")
    outside = (table["lower"] > table["predicted"]) | (table["upper"] < table["predicted"])
    if outside.any():
        row = table[outside].iloc[0]
        raise ValueError(f"{setup}: {row['quantity']} at {row['x']:g}: predicted value outside its own interval")
    negative = (table["lower"] < np.minimum(table["predicted"], 0)) & table["unit"].isin(NOT_NEGATIVE)
    if negative.any():
        row = table[negative].iloc[0]
        raise ValueError(f"{setup}: {row['quantity']} at {row['x']:g}: interval from {row['lower']:g} {row['unit']} on")
    return table[list(PREDICTION_COLUMNS)]


PLACE_COLUMNS = ("id", "quantity", "unit", "x")
OTHER_CODES: list[Number | Text] = [
    Text("mill"),
    Text("contact"),
    Text("code"),
    Number("speed_rpm", 0, above=True),
    Number("balls", 1),
    Number("power_W", 0, above=True),
]


def read_other_codes(path: str | Path) -> pd.DataFrame:
    """Power of tumbling mills by other DEM codes, a row for each speed. Raises ConfigError as `read_measured`."""
    return read_measured(path, OTHER_CODES, fewest_rows=0)


def _no_codes() -> pd.DataFrame:
    return pd.DataFrame(columns=[column.name for column in OTHER_CODES])


@dataclass(frozen=True)
class Inputs:
    """What a prediction may use; it gets only the places x of the measured points, not their values.

    settings: the section of the set-up; mill: None without one; contacts: by name, first the one that predicts; cases:
    the simulations of its sweeps by path; runs: the folder results/dem; places: id, quantity, unit and x of the
    measured points of this set-up; folder: of the set-up's tables, if it simulates before it predicts; other_codes: as
    `read_other_codes`.
    """

    settings: Any
    mill: MillConfig | None
    contacts: dict[str, ContactConfig]
    dem: DemConfig
    cases: dict[str, Case]
    runs: Path
    places: pd.DataFrame
    folder: Path = Path()
    other_codes: pd.DataFrame = field(default_factory=_no_codes)

    @property
    def contact(self) -> ContactConfig:
        """The contact set that predicts."""
        return self.contacts[self.settings.contact]

    def summary(self, path: str) -> dict:
        """The summary of a case. Raises DamagedFile if it is not valid JSON."""
        return read_json(self.runs / path / "summary.json")

    def table(self, name: str) -> pd.DataFrame:
        """A table in the set-up's folder. Raises ConfigError as `read_table`."""
        return read_table(self.folder / name)

    def places_of(self, quantity: str) -> pd.Series:
        """The measured places of a quantity."""
        return self.places.loc[self.places["quantity"] == quantity, "x"].dropna()

    def ids_of_single(self, quantity: str) -> str:
        """The id of a measured number without an x; empty if it was not measured."""
        ids = self.places.loc[self.places["quantity"] == quantity, "id"]
        return "" if ids.empty else str(ids.iloc[0])

    def ids_of(self, quantity: str) -> dict[float, str]:
        """The ids of the measured points of a quantity by their x."""
        points = self.places[self.places["quantity"] == quantity]
        return dict(zip(points["x"], points["id"], strict=True))
