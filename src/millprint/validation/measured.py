"""Measurements by others: config/data/measured.tsv, a row for each number or series."""

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from math import inf, nan
from pathlib import Path

import pandas as pd

from millprint.config.errors import ConfigError
from millprint.config.quantities import Asked, quantities_of
from millprint.config.setup_models import SetupConfig
from millprint.config.wording import close_to
from millprint.run.tables import Number, Text, read_measured, refuse_rows

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
    Text("quantity"), Text("x", optional=True), Text("value"), Text("unit", choices=tuple(UNITS)),
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


def read_measurements(path: str | Path, setups: Collection[str]) -> pd.DataFrame:
    """The measured rows of a file; columns that it lacks are empty. setups: names that a row may have, and `unknown`.

    Raises ConfigError, in one line with file, row, key and value, for an unknown unit or set-up, a value that is not a
    number, series, range or bound, and an uncertainty without a unit or in a unit other than the value's or per cent.
    """
    frame = read_measured(path, COLUMNS)
    for name in (column.name for column in COLUMNS if isinstance(column, Text)):
        frame[name] = frame[name].fillna("").str.strip() if name in frame else ""
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
