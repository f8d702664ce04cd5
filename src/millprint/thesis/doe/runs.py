"""The measured runs: a table of settings and yields, checked against the factors of the design."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from millprint.config.doe import Factor
from millprint.run.tables import CASE, Number, Text, read_measured, refuse_rows

YIELD = "yield_percent"
RUN_ORDER = "run_order"
PERCENT_YIELD = Number(YIELD, 0, 100)


def _codes(frame: pd.DataFrame, factor: Factor, path: str) -> np.ndarray:
    """Level codes (runs,) of one factor's settings; refuses a value that is not one of its levels."""
    settings = frame[factor.column].to_numpy()[:, None]
    if factor.numeric:
        near = np.isclose(settings, np.asarray(factor.levels)[None, :], rtol=1e-6, atol=1e-12)
    else:
        near = settings == np.asarray(factor.levels, dtype=object)[None, :]
    known = ", ".join(factor.text(code) for code in range(len(factor.levels)))
    why = f"must be one of the levels of factor {factor.symbol} ({known})"
    refuse_rows(frame, path, factor.column, ~near.any(axis=1), why)
    return near.argmax(axis=1)


def read_runs(path: str, factors: Sequence[Factor], positive: Sequence[str] = ()) -> pd.DataFrame:
    """Read the measured runs: columns case (text), the settings, yield_percent, and a level code a factor.

    Columns `treatment` and `run_order` are kept where there are any; `positive` names further columns that must hold
    numbers above 0. Raises ConfigError, in one line, for a missing column, a text in a numeric column, a case that
    appears twice, a setting that is not a level, and a yield outside 0 to 100 %.
    """
    numeric = [factor.column for factor in factors if factor.numeric and factor.column not in positive]
    names = [factor.column for factor in factors if not factor.numeric]
    frame = read_measured(
        path,
        [
            *(Text(name, unique=name == CASE) for name in dict.fromkeys([CASE, *names])),
            *map(Number, numeric),
            *(Number(name, 0, above=True) for name in positive),
            PERCENT_YIELD,
            Number(RUN_ORDER, optional=True),
        ],
    )
    if RUN_ORDER in frame:
        order = frame[RUN_ORDER]
        bad = order.duplicated() | (order != order.round())
        refuse_rows(frame, path, RUN_ORDER, bad, "must be a whole number that no other run has")
    for factor in factors:
        frame[factor.symbol] = _codes(frame, factor, path)
    if "treatment" in frame:
        # A code such as 0011 may have been read as the number 11.
        frame["treatment"] = frame["treatment"].astype(str).str.zfill(len(factors))
    return frame
