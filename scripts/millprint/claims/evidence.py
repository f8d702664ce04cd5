"""Rows of the tables that a run wrote, and what to say where it has none."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.claims.finding import Finding
from millprint.files import read_json, read_table


@dataclass(frozen=True)
class Evidence:
    """The results folder of a run."""

    results: Path

    def table(self, name: str) -> pd.DataFrame:
        """A table by its path under the results folder; an empty one where the run did not write it."""
        path = self.results / name
        return read_table(path) if path.is_file() else pd.DataFrame()

    def json(self, name: str) -> dict:
        """A JSON file by its path under the results folder; an empty mapping where the run did not write it."""
        path = self.results / name
        return read_json(path) if path.is_file() else {}


def rows(table: pd.DataFrame, **wanted: str | float) -> pd.DataFrame:
    """Rows of `table` whose columns hold the wanted text or, within rounding, the wanted number."""
    for column, value in wanted.items():
        if column not in table.columns:
            return table.iloc[:0]
        matches = np.isclose(table[column], value) if isinstance(value, float) else table[column] == value
        table = table[matches]
    return table


def parts(pattern: str, claim: str) -> tuple[str, ...]:
    """The groups of `pattern` in a claim's id; raises ValueError for an id of another form."""
    match = re.fullmatch(pattern, claim)
    if match is None:
        raise ValueError(f"claim {claim}: an id of the form {pattern} is wanted")
    return match.groups()


def not_run(what: str) -> Finding:
    """The finding of a claim whose job has not run."""
    return Finding(None, f"not run: {what}")


def yes_no(holds: bool, explanation: str) -> Finding:
    """The finding of a claim that holds or does not."""
    return Finding("yes" if holds else "no", explanation)
