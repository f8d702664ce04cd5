"""What every table from the bench is held to: one row a case, and numbers within their bounds."""

import pandas as pd

from millprint.errors import ConfigError

CASE = "case"


def check_cases(frame: pd.DataFrame, path: str) -> None:
    """Raise ConfigError for a table without rows, a row without a case, and a case that appears twice."""
    if frame.empty:
        raise ConfigError(f"{path}: no runs; a row for each run is wanted")
    if frame[CASE].isna().any():
        raise ConfigError(f"{path}: column case, row {int(frame[CASE].isna().idxmax()) + 1}: a case is wanted")
    twice = frame[CASE].duplicated()
    if twice.any():
        raise ConfigError(
            f"{path}: column case = {frame.loc[twice, CASE].iloc[0]} appears twice: each run needs a case of its own"
        )


def check_bounds(
    frame: pd.DataFrame,
    path: str,
    column: str,
    low: float = float("-inf"),
    high: float = float("inf"),
    above: bool = False,
) -> None:
    """Raise ConfigError, naming the case or row, for a number below `low` or above `high`; `above` leaves `low` out."""
    values = frame[column]
    bad = ~((values > low if above else values >= low) & (values <= high))
    if not bad.any():
        return
    row = int(bad.to_numpy().argmax())
    place = f"case {frame[CASE].iloc[row]}" if CASE in frame else f"row {row + 1}"
    if high < float("inf"):
        wanted = f"between {low:g} and {high:g}"
    else:
        wanted = f"above {low:g}" if above else f"at least {low:g}"
    raise ConfigError(f"{path}: column {column}, {place} = {values.iloc[row]:g}: {wanted} is wanted")
