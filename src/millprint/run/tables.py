"""Measured tables: the columns of each are declared once, and the first fault raises an error of one line."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from millprint.config.errors import ConfigError
from millprint.run.files import read_table, row_name

CASE = "case"


@dataclass(frozen=True)
class Number:
    """A column of finite numbers from `low` to `high`; `above` excludes `low` itself.

    A table may lack an `optional` column. A column that `may_be_blank` may have empty cells.
    """

    name: str
    low: float = -inf
    high: float = inf
    above: bool = False
    optional: bool = False
    may_be_blank: bool = False

    def check(self, frame: pd.DataFrame, path: str | Path) -> None:
        """Raise ConfigError for the first number outside the bounds."""
        values = frame[self.name]
        too_low = values <= self.low if self.above else values < self.low
        refuse_rows(frame, path, self.name, too_low | (values > self.high), f"must be {self._bounds()}")

    def _bounds(self) -> str:
        least = f"above {self.low:g}" if self.above else f"at least {self.low:g}"
        if self.high == inf:
            return least
        return f"{least} and at most {self.high:g}" if self.above else f"between {self.low:g} and {self.high:g}"


@dataclass(frozen=True)
class Text:
    """A column of text from `choices`, if there are any; may be empty if `may_be_blank`; no duplicates if `unique`.

    A table may lack an `optional` column.
    """

    name: str
    choices: Sequence[str] = ()
    unique: bool = False
    may_be_blank: bool = False
    optional: bool = False

    def check(self, frame: pd.DataFrame, path: str | Path) -> None:
        """Raise ConfigError for the first text that is not a choice, or is empty or repeated in a unique column."""
        values = frame[self.name]
        if self.choices:
            bad = ~values.isin(self.choices) & ~(values.isna() & self.may_be_blank)
            refuse_rows(frame, path, self.name, bad, f"must be {' or '.join(self.choices)}")
        if self.unique:
            empty = np.flatnonzero(values.isna() | (values == ""))
            if len(empty):
                raise ConfigError(f"{path}: column {self.name}, row {empty[0] + 1}: must not be empty")
            repeated = values[values.duplicated()]
            if len(repeated):
                raise ConfigError(
                    f"{path}: column {self.name} = {repeated.iloc[0]} appears twice: "
                    f"each row needs a {self.name} of its own"
                )


def read_measured(path: str | Path, columns: Sequence[Number | Text], fewest_rows: int = 1) -> pd.DataFrame:
    """Read a table and check its columns; columns that are not declared are kept as they are.

    Blanks around the text of a unique column are removed. Raises ConfigError, in one line, as
    `millprint.run.files.read_table`, for too few rows, and for the first invalid cell.
    """
    numbers = [column for column in columns if isinstance(column, Number)]
    texts = [column for column in columns if isinstance(column, Text)]
    frame = read_table(
        path,
        numeric=[column.name for column in numbers if not column.optional],
        text=[column.name for column in texts if not column.optional],
        optional=[column.name for column in numbers if column.optional],
        may_be_blank=[column.name for column in numbers if column.may_be_blank],
        optional_text=[column.name for column in texts if column.optional],
    )
    if len(frame) < fewest_rows:
        raise ConfigError(f"{path}: {len(frame) or 'no'} rows; the table needs at least {fewest_rows}")
    for name in (column.name for column in texts if column.unique):
        frame[name] = frame[name].str.strip()
    for column in columns:
        if column.name in frame:
            column.check(frame, path)
    return frame


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
