"""Measured tables: the columns of each are declared once, and the first fault raises an error of one line."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf, isfinite, nan
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from millprint.config.charge import Quantity
from millprint.config.errors import ConfigError
from millprint.config.rows import Cells, read_cells
from millprint.config.wording import other_unit
from millprint.run.files import FINITE, FINITE_OR_EMPTY, refuse_missing, row_name

CASE = "case"


@dataclass(frozen=True)
class Number:
    """A column of finite numbers from `low` to `high`; `above` excludes `low` itself.

    A table may lack an `optional` column. A column that `may_be_blank` may have empty cells. Per cent of which none is
    above 1 are `asked` about, unless the program itself made the table.
    """

    name: str
    low: float = -inf
    high: float = inf
    above: bool = False
    optional: bool = False
    may_be_blank: bool = False
    asked: bool = True

    @property
    def is_percent(self) -> bool:
        """Whether the column is a share in per cent: a cell may have the sign."""
        return self.name.endswith("_percent") and (self.low, self.high) == (0, 100)

    def check(self, frame: pd.DataFrame, path: str | Path) -> None:
        """Raise ConfigError for the first number outside the bounds."""
        values = frame[self.name]
        refuse_rows(frame, path, self.name, values.notna() & ~self._within(values), self._why)

    def _within(self, value: Quantity) -> Quantity:
        """Whether numbers are within the bounds."""
        return (value > self.low if self.above else value >= self.low) & (value <= self.high)

    def _why(self, row: pd.Series) -> str:
        unit, bounds = self.name.rpartition("_")[2], f"must be {self._bounds()}"
        asked = other_unit(float(row[self.name]), unit, lambda meant: bool(self._within(meant)))
        return f"{bounds}; {asked}" if asked else bounds

    def _bounds(self) -> str:
        least = f"above {self.low:g}" if self.above else f"at least {self.low:g}"
        if self.high == inf:
            return least
        return f"{least} and at most {self.high:g}" if self.above else f"between {self.low:g} and {self.high:g}"


@dataclass(frozen=True)
class Text:
    """A column of text from `choices`, if there are any; may be empty if `may_be_blank`; no duplicates if `unique`.

    A table may lack an `optional` column. In a column `of_numbers`, such as `1 to 2,5`, numbers become plain ones.
    """

    name: str
    choices: Sequence[str] = ()
    unique: bool = False
    may_be_blank: bool = False
    optional: bool = False
    of_numbers: bool = False

    def check(self, frame: pd.DataFrame, path: str | Path) -> None:
        """Raise ConfigError for the first text that is not a choice, or is empty or repeated in a unique column."""
        values = frame[self.name]
        if self.choices:
            bad = ~values.isin(self.choices) & ~(values.isna() & self.may_be_blank)
            refuse_rows(frame, path, self.name, bad, f"must be {' or '.join(self.choices)}")
        if self.unique:
            empty = np.flatnonzero(values.isna())
            if len(empty):
                raise ConfigError(f"{path}: column {self.name}, row {empty[0] + 1}: must not be empty")
            repeated = values[values.duplicated()]
            if len(repeated):
                raise ConfigError(
                    f"{path}: column {self.name} = {repeated.iloc[0]} appears twice: "
                    f"each row needs a {self.name} of its own"
                )


def read_measured(path: str | Path, columns: Sequence[Number | Text], fewest_rows: int = 1) -> pd.DataFrame:
    """Read a table that people write, by `read_cells`, and check its columns; others are kept, as text.

    Numbers may have decimal commas, and thousands; an empty cell is NaN. Raises ConfigError, in one line, for what
    cannot be read, a missing column, a cell without a number or with two readings, too few rows, and for the first
    invalid cell.
    """
    cells = read_cells(path)
    refuse_missing(path, [column.name for column in columns if not column.optional], cells.header)
    frame = pd.DataFrame(cells.rows, columns=cells.header, dtype=object)
    frame = frame.where(frame != "")
    if len(frame) < fewest_rows:
        raise ConfigError(f"{path}: {len(frame) or 'no'} rows; the table needs at least {fewest_rows}")
    present = [column for column in columns if column.name in frame]
    for column in present:
        if isinstance(column, Number):
            frame[column.name] = _numbers(cells, column, frame)
        elif column.of_numbers:
            frame[column.name] = _plain_texts(cells, column, frame)
    for column in present:
        column.check(frame, path)
    return frame


def _numbers(cells: Cells, column: Number, frame: pd.DataFrame) -> np.ndarray:
    """The numbers of a column (rows,), NaN where a cell is empty that may be. Raises ConfigError for any other cell."""
    found = np.full(len(cells.rows), nan)
    for row, cell in enumerate(cells.column(column.name)):
        if not cell and column.may_be_blank:
            continue
        place = f"column {column.name}, {row_name(frame, row, column.name)}"
        number = cells.plain(cell.removesuffix("%") if column.is_percent else cell, place)
        if number is None or not isfinite(float(number)):
            right = FINITE_OR_EMPTY if column.may_be_blank else FINITE
            raise ConfigError(f"{cells.path}: {place} = {cell!r}: must be {right}")
        found[row] = float(number)
    if column.is_percent and column.asked and not any("%" in cell for cell in cells.column(column.name)):
        refuse_shares(frame.assign(**{column.name: found}), cells.path, column.name)
    return found


def _plain_texts(cells: Cells, column: Text, frame: pd.DataFrame) -> pd.Series:
    """The texts of a column with plain numbers in them, NaN for an empty cell. Raises ConfigError for two readings."""
    found: list[str | float] = []
    for row, cell in enumerate(cells.column(column.name)):
        place = f"column {column.name}, {row_name(frame, row, column.name)}"
        plain = [cells.plain(part, place) or part for part in re.split(r"(\d[\d.,]*)", cell)]
        found.append("".join(plain) or nan)
    return pd.Series(found, dtype=object)


def refuse_shares(frame: pd.DataFrame, path: str | Path, column: str) -> None:
    """Raise ConfigError for per cent of which none is above 1: they may be shares of 1.

    A cell with the sign %, such as 0.35 %, says what it is.
    """
    largest = frame[column].max()
    if 0 < largest <= 1:
        row = int(np.flatnonzero(frame[column] == largest)[0])
        raise ConfigError(
            f"{path}: column {column}, {row_name(frame, row, column)} = {largest:g}: no value is above 1: is that "
            f"{100 * largest:g} % or {largest:g} %? Write {100 * largest:g}, or {largest:g} % with the sign"
        )


def refuse_copies(frame: pd.DataFrame, path: str | Path, conditions: Sequence[str], result: str) -> None:
    """Raise ConfigError if half of the repeated runs or more have the same result as another, to each digit.

    A model that learns from some copies and is tested on others seems to know everything. Repetitions of a run scatter;
    results at an end, 0 or 100 %, may be the same.
    """
    inner = frame[~frame[result].isin([0, 100])]
    repeated = inner.duplicated(list(conditions), keep=False)
    twins = inner[inner.duplicated([*conditions, result], keep=False)]
    if twins.empty or 2 * len(twins) < repeated.sum():
        return
    first = twins.iloc[0]
    again = twins[(twins[[*conditions, result]] == first[[*conditions, result]]).all(axis=1)].iloc[1]
    copies = int(twins.duplicated([*conditions, result]).sum())
    raise ConfigError(
        f"{path}: copies of runs in {copies} rows: case {again[CASE]} has the settings of case {first[CASE]} and the "
        f"same {result} = {first[result]:g}, as repeated runs hardly do; leave copies out, or give more digits"
    )


def read_printed(claims_path: str | Path) -> pd.Series:
    """The values that the thesis prints, as text, by the id of the claim. Raises ConfigError as `read_measured`."""
    return read_measured(claims_path, [Text("id", unique=True), Text("value")]).set_index("id")["value"]


def refuse_rows(
    frame: pd.DataFrame, path: str | Path, column: str, bad: ArrayLike, why: str | Callable[[pd.Series], str]
) -> None:
    """Raise ConfigError for the first row where `bad` is true: file, column, row, value, and what to write.

    bad: (rows,) truth values. why: the end of the message, or a function that makes it from the row.
    """
    places = np.flatnonzero(np.asarray(bad, dtype=bool))
    if not len(places):
        return
    row = frame.iloc[places[0]]
    value = repr(row[column]) if isinstance(row[column], str) else f"{row[column]:g}"
    place, what = row_name(frame, places[0], column), why if isinstance(why, str) else why(row)
    raise ConfigError(f"{path}: column {column}, {place} = {value}: {what}")
