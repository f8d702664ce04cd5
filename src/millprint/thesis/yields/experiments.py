"""Ask and tell: the table of experiments that were proposed, are running or done, with what was found."""

from collections.abc import Iterable

import numpy as np
import pandas as pd

from millprint.run.tables import CASE, Number, Text, read_measured, refuse_rows
from millprint.thesis.doe.runs import YIELD
from millprint.thesis.yields.features import CONDITIONS
from millprint.thesis.yields.region import SETTINGS, Mill, curve_point, described_settings

STATUS, PROPOSED, RUNNING, DONE = "status", "proposed", "running", "done"


def read_experiments(path: str, curves: pd.DataFrame | None = None, taken: Iterable[str] = ()) -> pd.DataFrame:
    """Read the experiments: case, status, the settings of the mill, yield_percent where the status is done.

    Rows of next_experiments.tsv can be copied into it as they are; further columns are not changed. curves: master
    curves that must cover the fill ratios, or None; taken: cases of other tables. Raises ConfigError, in one line, as
    `read_measured`, for a status other than proposed, running or done, for a done experiment without a yield and for a
    yield of one that is not done, for a fill ratio outside the curves, and for a case that another table has.
    """
    table = read_measured(
        path,
        [
            Text(CASE, unique=True),
            Text(STATUS, choices=(PROPOSED, RUNNING, DONE)),
            *(Number(name, 0, above=True) for name in SETTINGS),
            Number(YIELD, 0, 100, may_be_blank=True),
        ],
        fewest_rows=0,
    )
    done, told = (table[STATUS] == DONE).to_numpy(), table[YIELD].notna().to_numpy()
    refuse_rows(table, path, YIELD, done & ~told, "a done experiment has a yield [%]")
    refuse_rows(table, path, YIELD, ~done & told, "only an experiment with the status done has a yield")
    refuse_rows(table, path, CASE, table[CASE].isin(set(taken)), "another table of runs has this case; choose another")
    if curves is not None:
        outside = np.array([np.isnan(curve_point(curves, fill)["Pn"]) for fill in table["fill_ratio"]], dtype=bool)
        low, high = curves["fill_ratio"].min(), curves["fill_ratio"].max()
        refuse_rows(table, path, "fill_ratio", outside, f"the master curves cover {low:g} to {high:g}")
    return table


def experiment_rows(table: pd.DataFrame, status: str, curves: pd.DataFrame, mill: Mill) -> pd.DataFrame:
    """The experiments of one status as rows of a yield model: case, the settings, the six conditions, yield_percent."""
    own = table.loc[table[STATUS] == status, [CASE, *SETTINGS, YIELD]].reset_index(drop=True)
    columns = list(dict.fromkeys([CASE, *SETTINGS, *CONDITIONS, YIELD]))
    return described_settings(own, curves, mill)[columns] if len(own) else pd.DataFrame(columns=columns, dtype=float)


def next_cases(count: int, taken: Iterable[str]) -> list[str]:
    """Names next_1, next_2, ... for new experiments that no case of `taken` has."""
    names: list[str] = []
    known, number = set(taken), 0
    while len(names) < count:
        number += 1
        if f"next_{number}" not in known:
            names.append(f"next_{number}")
    return names
