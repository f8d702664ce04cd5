"""Measurements by others (config/data/measured.tsv), what a prediction reads, and the numbers that it makes."""

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from math import inf, nan
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.setup_models import SETTINGS, Asked, SetupConfig, quantities_of
from millprint.config.sweep import Case, DemConfig
from millprint.config.wording import close_to
from millprint.config.workflow import WorkflowConfig
from millprint.run.files import read_json, read_table
from millprint.run.tables import Number, Text, read_measured, refuse_rows

DEM = "DEM"
# The file of the simulations that are done; it is removed once the predictions are written.
KEPT = "runs.partial"
SCATTER = "scatter of seeds"
BLOCKS = "scatter of blocks of time"
CONTACT = "contact parameters"
COUNT = "number of balls"
# Origins of an interval; both where they are added.
INTERVALS = (
    *("", SCATTER, BLOCKS, CONTACT, f"{SCATTER} and {CONTACT}", f"{BLOCKS} and {CONTACT}"),
    f"{SCATTER} and {COUNT}",
)
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


@dataclass(frozen=True)
class Inputs:
    """What a prediction may use; it gets only the places x of the measured points, not their values.

    settings: the section of the set-up; mill: None without one; contacts: by name, first the one that predicts; cases:
    the simulations of its sweeps by path; runs: the folder results/dem; places: id, quantity, unit and x of the
    measured points of this set-up; folder: of the set-up's tables, if it simulates before it predicts; other_codes: as
    `read_other_codes`, if anything is known.
    """

    settings: Any
    mill: MillConfig | None
    contacts: dict[str, ContactConfig]
    dem: DemConfig
    cases: dict[str, Case]
    runs: Path
    places: pd.DataFrame
    folder: Path = Path()
    other_codes: pd.DataFrame | None = None

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

    def simulated(self, runs: Mapping[str, dict], simulate: Callable[[dict], dict], title: str) -> list[dict]:
        """What each run gives, in order; a stopped job continues with those that are done, in the set-up's folder."""
        # Imported here: slow to import, and checks of the input import this module.
        from millprint.cases.simulate import simulate_each

        shared = [part for part in (self.settings, self.contact, self.mill, self.dem) if part is not None]
        done = self.folder / KEPT if self.folder != Path() else None
        return list(simulate_each(runs, simulate, shared, title, done).values())

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


UNKNOWN = "unknown"
# Unit -> the tolerated deviation in place of 10 % of the measured value, if any: a ratio of two angles, of two places
# or of two small counts has little meaning.
UNITS: dict[str, float | None] = {
    "W": None, "J/rev": None, "rad/s": None, "m/s": None, "1/s": None, "-": None, "degC": None,
    "deg": 3.0, "m": 0.003, "rings": 0.5,
}  # fmt: skip
PERCENT = "%"
COLUMNS: list[Number | Text] = [
    Text("id", unique=True), Text("setup"), Text("mill", optional=True), Text("description", optional=True),
    Text("quantity"), Text("x", optional=True), Text("value", of_numbers=True), Text("unit", choices=tuple(UNITS)),
    Number("uncertainty", 0, above=True, may_be_blank=True, optional=True), Text("uncertainty_unit", optional=True),
    Text("class", optional=True), Text("source", optional=True), Text("note", optional=True),
]  # fmt: skip
# Columns of the table with a row for each point.
POINT_COLUMNS = (
    *("id", "setup", "quantity", "x_name", "x", "measured", "measured_lower", "measured_upper", "unit", "class"),
    *("source", "note"),
)


NUMBER = r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?"
PAIR = re.compile(rf"({NUMBER}):({NUMBER})")
RANGE = re.compile(rf"({NUMBER}) to ({NUMBER})")
BOUND = re.compile(rf"(below|above) ({NUMBER})")


@dataclass(frozen=True)
class Point:
    """A measured number at x (nan for a single number), with the bounds of a range (nan if it is not a range)."""

    x: float
    value: float
    lower: float = nan
    upper: float = nan


def parse_value(text: str) -> list[Point]:
    """The points of a value: `1.5`, a series `x:value;x:value`, a range `1 to 2`, or a bound `below 3`.

    Raises ValueError for any other text.
    """
    text = text.strip()
    if re.fullmatch(NUMBER, text):
        return [Point(nan, float(text))]
    if found := RANGE.fullmatch(text):
        low, high = float(found[1]), float(found[2])
        if low > high:
            raise ValueError(text)
        return [Point(nan, (low + high) / 2, low, high)]
    if found := BOUND.fullmatch(text):
        limit = float(found[2])
        return [Point(nan, limit, *((-inf, limit) if found[1] == "below" else (limit, inf)))]
    pairs = [PAIR.fullmatch(part.strip()) for part in text.split(";")]
    if not all(pairs):
        raise ValueError(text)
    return [Point(float(pair[1]), float(pair[2])) for pair in pairs if pair]


def _is_value(text: str) -> bool:
    try:
        return bool(parse_value(text))
    except ValueError:
        return False


def read_measurements(path: str | Path, setups: Collection[str], fewest_rows: int = 1) -> pd.DataFrame:
    """The measured rows of a file; columns that it lacks are empty. setups: names that a row may have, and `unknown`.

    Raises ConfigError, in one line with file, row, key and value, for an unknown unit or set-up, a value that is not a
    number, series, range or bound, and an uncertainty without a unit or in a unit other than the value's or per cent.
    """
    frame = read_measured(path, COLUMNS, fewest_rows)
    for name in (column.name for column in COLUMNS if isinstance(column, Text)):
        frame[name] = frame[name].fillna("") if name in frame else ""
    frame["class"] = frame["class"].replace("", "measured")
    if "uncertainty" not in frame:
        frame["uncertainty"] = nan
    known = [*setups, UNKNOWN]
    refuse_rows(frame, path, "setup", ~frame["setup"].isin(known), f"unknown set-up; known: {', '.join(known)}")
    values = frame["value"].map(_is_value)
    refuse_rows(
        frame, path, "value", ~values.astype(bool), "must be a number, a series x:value;x:value, `1 to 2` or `below 3`"
    )
    series = frame["value"].str.contains(":")
    refuse_rows(frame, path, "x", series & (frame["x"] == ""), "must say what the x of a series is, with its unit")
    has_unit = frame["uncertainty_unit"] != ""
    wrong = (has_unit != frame["uncertainty"].notna()) | (
        has_unit & (frame["uncertainty_unit"] != frame["unit"]) & (frame["uncertainty_unit"] != PERCENT)
    )
    refuse_rows(
        frame,
        path,
        "uncertainty_unit",
        wrong,
        lambda row: f"must be {row['unit']} or {PERCENT} where there is an uncertainty, and empty where there is none",
    )
    return frame


def check_measured(path: str | Path, setups: Mapping[str, SetupConfig]) -> None:
    """Raise ConfigError for a table that no prediction can be compared with; setups: those that can be chosen."""
    rows = read_measurements(path, setups)
    check_quantities(rows, path, {name: quantities_of(setup) for name, setup in setups.items()})


def check_validation(config: WorkflowConfig) -> None:
    """Raise ConfigError for a table that the validation reads and that is refused."""
    if config.validation.chosen:
        check_measured(config.validation.measured, SETTINGS)


def check_quantities(rows: pd.DataFrame, path: str | Path, known: Mapping[str, Mapping[str, Asked]]) -> None:
    """Raise ConfigError, in one line, for the first row whose quantity or unit its set-up does not predict.

    known: by set-up, as of `quantities_of`.
    """
    own = rows[rows["setup"].isin(list(known))]
    for row in own.to_dict("records"):
        asked = known[row["setup"]]
        place = f"{path}: id {row['id']}"
        if row["quantity"] not in asked:
            raise ConfigError(
                f"{place}: quantity = {row['quantity']!r}: set-up {row['setup']} does not predict it"
                f"{close_to(row['quantity'], asked)}; `millprint quantities` lists all"
            )
        if row["unit"] != asked[row["quantity"]].unit:
            raise ConfigError(f"{place}: unit = {row['unit']!r}: must be {asked[row['quantity']].unit}")


def measured_points(rows: pd.DataFrame) -> pd.DataFrame:
    """A row for each measured number (POINT_COLUMNS).

    measured_lower, measured_upper: the value minus and plus its uncertainty, or the ends of a range; empty if nothing
    is stated. x is empty for a single number.
    """
    points = []
    for row in rows.to_dict("records"):
        for point in parse_value(row["value"]):
            share = abs(point.value) / 100 if row["uncertainty_unit"] == PERCENT else 1.0
            # An uncertainty that is not stated is NaN, and so are the ends.
            half = row["uncertainty"] * share
            lower, upper = (
                (point.lower, point.upper) if point.lower == point.lower else (point.value - half, point.value + half)
            )
            points.append(
                {**row, "x_name": row["x"], "x": point.x, "measured": point.value, "measured_lower": lower,
                 "measured_upper": upper}
            )  # fmt: skip
    return pd.DataFrame(points, columns=list(POINT_COLUMNS))
