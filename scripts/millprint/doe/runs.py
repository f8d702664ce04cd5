"""The measured runs: a table of settings and yields, checked against the factors of the design."""

import numpy as np
import pandas as pd

from millprint.config.doe import DoeConfig, Factor
from millprint.errors import ConfigError
from millprint.files import read_table

YIELD = "yield_percent"


def _codes(frame: pd.DataFrame, factor: Factor, path: str) -> np.ndarray:
    """Level codes of one factor's settings; refuses a value that is not one of its levels."""
    levels = np.asarray(factor.levels)
    near = np.isclose(frame[factor.column].to_numpy()[:, None], levels[None, :], rtol=1e-6, atol=1e-12)
    if not near.any(axis=1).all():
        row = int(np.argmin(near.any(axis=1)))
        known = ", ".join(f"{level:g}" for level in levels)
        raise ConfigError(
            f"{path}: column {factor.column}, case {frame['case'].iloc[row]} = {frame[factor.column].iloc[row]:g}: "
            f"one of the levels of factor {factor.symbol} is wanted ({known})"
        )
    return near.argmax(axis=1)


def read_runs(path: str, config: DoeConfig, positive: list[str] = ()) -> pd.DataFrame:
    """Read the runs as they were done: columns case (text), the settings, yield_percent, and a level code a factor.

    A column `treatment` is kept where there is one; `positive` names further columns that must hold numbers above 0.
    Raises ConfigError, in one line, for a missing column, a text in a numeric column, a case that appears twice, a
    setting that is no level, and a yield outside 0 to 100 %.
    """
    numeric = [*(factor.column for factor in config.factors), *positive, YIELD]
    frame = read_table(path, numeric=list(dict.fromkeys(numeric)), text=["case"])
    if frame.empty:
        raise ConfigError(f"{path}: no runs; a row for each run is wanted")
    if frame["case"].isna().any():
        raise ConfigError(f"{path}: column case, row {int(frame['case'].isna().idxmax()) + 1}: a case is wanted")
    if frame["case"].duplicated().any():
        twice = frame.loc[frame["case"].duplicated(), "case"].iloc[0]
        raise ConfigError(f"{path}: column case = {twice} appears twice: each run needs a case of its own")
    bad = ~frame[YIELD].between(0, 100)
    if bad.any():
        row = frame.loc[bad].iloc[0]
        raise ConfigError(f"{path}: column {YIELD}, case {row['case']} = {row[YIELD]:g}: between 0 and 100 is wanted")
    for column in positive:
        if (frame[column] <= 0).any():
            row = frame.loc[frame[column] <= 0].iloc[0]
            raise ConfigError(f"{path}: column {column}, case {row['case']} = {row[column]:g}: above 0 is wanted")
    for factor in config.factors:
        frame[factor.symbol] = _codes(frame, factor, path)
    if "treatment" in frame:
        # A code such as 0011 may have been read as the number 11.
        frame["treatment"] = frame["treatment"].astype(str).str.zfill(len(config.factors))
    return frame
