"""The table of predictions that every set-up makes."""

from math import nan

import numpy as np
import pandas as pd

DEM = "DEM"
SCATTER = "scatter of seeds"
BLOCKS = "scatter of blocks of time"
CONTACT = "contact parameters"
BALLS = "spread of the balls"
# Origins of an interval; both where they are added.
INTERVALS = ("", SCATTER, BLOCKS, CONTACT, f"{SCATTER} and {CONTACT}", f"{BLOCKS} and {CONTACT}", BALLS)
# Units of quantities that are not negative, so that their intervals do not go below 0.
NOT_NEGATIVE = ("W", "J/rev")
PREDICTION_COLUMNS = ("id", "x", "quantity", "unit", "model", "predicted", "lower", "upper", "interval")


def prediction(
    quantity: str,
    unit: str,
    predicted: float,
    *,
    id: str = "",
    x: float = nan,
    lower: float = nan,
    upper: float = nan,
    interval: str = "",
    model: str = DEM,
) -> dict:
    """A row of a table of predictions."""
    values = (id, x, quantity, unit, model, predicted, lower, upper, interval)
    return dict(zip(PREDICTION_COLUMNS, values, strict=True))


def check_predictions(table: pd.DataFrame, setup: str) -> pd.DataFrame:
    """The table with its columns in order. Raises ValueError for a wrong column, interval or end."""
    if set(table.columns) != set(PREDICTION_COLUMNS):
        raise ValueError(f"{setup}: columns {sorted(table.columns)}; expected {', '.join(PREDICTION_COLUMNS)}")
    if unknown := sorted(set(table["interval"]) - set(INTERVALS)):
        raise ValueError(f"{setup}: interval by {unknown[0]!r}; known: {', '.join(filter(None, INTERVALS))}")
    outside = (table["lower"] > table["predicted"]) | (table["upper"] < table["predicted"])
    if outside.any():
        row = table[outside].iloc[0]
        raise ValueError(f"{setup}: {row['quantity']} at {row['x']:g}: predicted value outside its own interval")
    negative = (table["lower"] < np.minimum(table["predicted"], 0)) & table["unit"].isin(NOT_NEGATIVE)
    if negative.any():
        row = table[negative].iloc[0]
        raise ValueError(f"{setup}: {row['quantity']} at {row['x']:g}: interval from {row['lower']:g} {row['unit']} on")
    return table[list(PREDICTION_COLUMNS)]
