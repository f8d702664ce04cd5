"""How well the scaling collapses conditions on one curve: the spread before and after, as numbers."""

import numpy as np
import pandas as pd

from millprint.fingerprint.condition import SCALED_BY
from millprint.fingerprint.descriptors import NOTHING, as_built
from millprint.fingerprint.exponents import with_power_per_ball
from millprint.fingerprint.master_curves import WEIGHTED, at_shared_fills, universal_descriptors

# Scaled quantity -> the column that it scales; none for the ratio, which has no unit.
DIMENSIONAL = {
    "Pn": "normal_power_per_ball_W",
    "Pt": "tangential_power_per_ball_W",
    "f": "specific_frequency_hz",
    "ratio": None,
    **{quantity: name for name, quantity in SCALED_BY.items() if quantity in WEIGHTED},
}
COLLAPSE_COLUMNS = [
    *("scope", "compared", "quantity", "fill_ratio", "conditions"),
    *("spread_dimensional", "spread_scaled", "spread_universal"),
]
# What differs between the compared conditions, by what a sweep varied.
MACHINE = "speed and ball size"


def _spread(values: np.ndarray) -> float:
    return float(values.std(ddof=1) / values.mean())


def _rows(descriptors: pd.DataFrame, scope: str, compared: str = MACHINE) -> list[tuple]:
    universal, descriptors = universal_descriptors(descriptors), with_power_per_ball(descriptors)
    # As arrays: the claims are computed from hundreds of such tables, for their intervals.
    before = {name: descriptors[column].to_numpy() for name, column in DIMENSIONAL.items() if column}
    after = {name: (descriptors[name].to_numpy(), universal[name].to_numpy()) for name in DIMENSIONAL}
    rows = []
    for fill, at in sorted(descriptors.groupby("fill_ratio").indices.items()):
        for quantity in DIMENSIONAL if len(at) > 1 else ():
            dimensional = _spread(before[quantity][at]) if quantity in before else np.nan
            spreads = [_spread(values[at]) for values in after[quantity]]
            rows.append((scope, compared, quantity, fill, len(at), dimensional, *spreads))
    return rows


def _with_reference(runs: pd.DataFrame, varied: str) -> pd.DataFrame:
    """The conditions of a sweep over amplitude or density, and the otherwise equal ones as built."""
    alike = ["ball_diameter_mm", "fill_ratio", "speed_rpm"]
    swept = runs[runs["varied"] == varied]
    built = as_built(runs)
    return pd.concat([swept, built.merge(swept[alike].drop_duplicates(), on=alike)], ignore_index=True)


def tabulate_collapse(descriptors: pd.DataFrame) -> pd.DataFrame:
    """Standard deviation over mean at each fill ratio with two or more conditions, for each contact set and for all.

    spread_dimensional: of power [W] or frequency [1/s] over the balls, or of an energy [J], before any scaling;
    spread_scaled: after Eqs 3.28 and 3.29; spread_universal: after Eqs 3.31 and 3.32. `scope` is a contact set, or
    `universal` for all together, which is left out unless there are at least two. `compared` says what differs between
    the conditions: speed and ball size, or what a sweep varied besides (amplitude, density).
    """
    rows = []
    contacts = sorted(descriptors["contact"].unique())
    for contact in contacts:
        runs = descriptors[descriptors["contact"] == contact]
        rows += _rows(as_built(runs), contact)
        for varied in sorted(set(runs["varied"]) - {NOTHING}):
            rows += _rows(_with_reference(runs, varied), contact, varied)
    if len(contacts) > 1:
        rows += _rows(at_shared_fills(as_built(descriptors)), "universal")
    return pd.DataFrame(rows, columns=COLLAPSE_COLUMNS)
