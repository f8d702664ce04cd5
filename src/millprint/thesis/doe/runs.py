"""The measured runs, checked against the factors of the design, and the contrasts of their levels."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from millprint.config.doe import DesignConfig, Factor
from millprint.config.errors import ConfigError
from millprint.run.tables import CASE, Number, Text, read_measured, refuse_copies, refuse_rows

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
    appears twice, a setting that is not a level, a yield outside 0 to 100 %, copies of runs, and equal yields.
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
    if frame[YIELD].nunique() == 1:
        raise ConfigError(f"{path}: column {YIELD} = {frame[YIELD].iloc[0]:g} in all rows: there is nothing to explain")
    refuse_copies(frame, path, list(dict.fromkeys([*(factor.column for factor in factors), *positive])), YIELD)
    if "treatment" in frame:
        # A code such as 0011 may have been read as the number 11.
        frame["treatment"] = frame["treatment"].astype(str).str.zfill(len(factors))
    return frame


def contrasts(values: ArrayLike) -> np.ndarray:
    """Orthonormal polynomial contrasts of levels at `values`: (levels, levels - 1), linear first.

    Equally spaced, three of them are the -1, 0, 1 and 1, -2, 1 of thesis Table 2.4, each over its length.
    """
    places = np.asarray(values, dtype=float)
    centred = (places - places.mean()) / np.ptp(places)
    basis = np.linalg.qr(np.vander(centred, len(places), increasing=True))[0][:, 1:]
    return basis * np.sign(basis[-1])


def level_contrasts(factor: Factor) -> np.ndarray:
    """The contrasts of a factor's levels: (levels, levels - 1). Those of names have no order, but span the levels."""
    return contrasts(factor.levels if factor.numeric else range(len(factor.levels)))


def term_columns(config: DesignConfig, codes: pd.DataFrame, term: str) -> np.ndarray:
    """Contrast columns of a term such as A or A:B: (runs, degrees of freedom)."""
    columns = np.ones((len(codes), 1))
    for symbol in term.split(":"):
        own = level_contrasts(config.factor(symbol))[codes[symbol].to_numpy()]
        columns = (columns[:, :, None] * own[:, None, :]).reshape(len(codes), -1)
    return columns
