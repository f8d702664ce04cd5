"""The measured runs: a table of settings and yields, checked against the factors of the design."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from millprint.config.design import Factor
from millprint.doe.bounds import CASE, check_bounds, check_cases
from millprint.errors import ConfigError
from millprint.files import read_table

YIELD = "yield_percent"
RUN_ORDER = "run_order"


def _codes(frame: pd.DataFrame, factor: Factor, path: str) -> np.ndarray:
    """Level codes of one factor's settings; refuses a value that is not one of its levels."""
    settings = frame[factor.column].to_numpy()[:, None]
    if factor.numeric:
        near = np.isclose(settings, np.asarray(factor.levels)[None, :], rtol=1e-6, atol=1e-12)
    else:
        near = settings == np.asarray(factor.levels, dtype=object)[None, :]
    if not near.any(axis=1).all():
        row = int(np.argmin(near.any(axis=1)))
        known = ", ".join(factor.text(code) for code in range(len(factor.levels)))
        value = f"{settings[row, 0]:g}" if factor.numeric else repr(settings[row, 0])
        raise ConfigError(
            f"{path}: column {factor.column}, case {frame[CASE].iloc[row]} = {value}: "
            f"one of the levels of factor {factor.symbol} is wanted ({known})"
        )
    return near.argmax(axis=1)


def _check_order(frame: pd.DataFrame, path: str) -> None:
    """The order of the runs, where there is one, gives each run its own place."""
    values = frame[RUN_ORDER]
    bad = values.duplicated() | (values != values.round())
    if bad.any():
        row = frame.loc[bad].iloc[0]
        raise ConfigError(
            f"{path}: column {RUN_ORDER}, case {row[CASE]} = {row[RUN_ORDER]:g}: a whole number of its own is wanted"
        )


def read_runs(path: str, factors: Sequence[Factor], positive: Sequence[str] = ()) -> pd.DataFrame:
    """Read the runs as they were done: columns case (text), the settings, yield_percent, and a level code a factor.

    Columns `treatment` and `run_order` are kept where there are any; `positive` names further columns that must hold
    numbers above 0. Raises ConfigError, in one line, for a missing column, a text in a numeric column, a case that
    appears twice, a setting that is no level, and a yield outside 0 to 100 %.
    """
    numeric = [*(factor.column for factor in factors if factor.numeric), *positive, YIELD]
    names = [factor.column for factor in factors if not factor.numeric]
    frame = read_table(path, numeric=list(dict.fromkeys(numeric)), text=[CASE, *names])
    if RUN_ORDER in frame:
        frame = read_table(path, numeric=list(dict.fromkeys([*numeric, RUN_ORDER])), text=[CASE, *names])
        _check_order(frame, path)
    frame[CASE] = frame[CASE].str.strip()
    check_cases(frame, path)
    check_bounds(frame, path, YIELD, 0, 100)
    for column in positive:
        check_bounds(frame, path, column, 0, above=True)
    for factor in factors:
        frame[factor.symbol] = _codes(frame, factor, path)
    if "treatment" in frame:
        # A code such as 0011 may have been read as the number 11.
        frame["treatment"] = frame["treatment"].astype(str).str.zfill(len(factors))
    return frame
