"""Predictions for the included mills that wait for a measurement: fixed, with their date and a digest.

They are those of the included fingerprints, which need no simulation, and of the box on a leaf spring. The table has
one generation of rows a release, which tools/fix_mill_predictions.py writes: those of earlier releases stay, and a
measurement is judged by the newest generation that is older than it.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from millprint.config.included import shipped
from millprint.fingerprint.readers import find_ready_made
from millprint.run.tables import Number, Text, read_measured

TABLE = "config/data/waiting_predictions.tsv"
CONDITION = ("ball_diameter_mm", "fill_ratio", "speed_rpm")
COLUMNS = ("mill", *CONDITION, "quantity", "value", "lower", "upper", "unit", "interval", "release", "date", "digest")
POWER, IMPACTS = "power of the walls", "impacts a second"
BY_CONTACT = "contact parameters that nobody has measured"


def read_waiting(path: str | Path = TABLE) -> pd.DataFrame:
    """The table of fixed predictions. Raises ConfigError as `read_measured`."""
    ends = [Number(name, optional=True, may_be_blank=True) for name in ("lower", "upper")]
    numbers = [*map(Number, (*CONDITION, "value")), *ends]
    texts = [Text(name) for name in COLUMNS if name not in {number.name for number in numbers}]
    return read_measured(path, [*numbers, *texts])


def fixed_before(
    date: str, mill: str, diameter_mm: float, fill_ratio: float, speed_rpm: float, quantity: str
) -> dict | None:
    """The newest row of a quantity at a condition that is older than a date, with the interval of its mean.

    date: of the measurement, as 2026-11-27, or with the time (UTC). None if there is none, or the mill is another one
    here.
    """
    path = shipped(TABLE)
    if path is None or find_ready_made(mill) is None:
        return None
    table = read_waiting(path)
    same = (table["mill"] == mill) & (table["quantity"] == quantity) & (table["interval"] != BY_CONTACT)
    same &= table["date"] < date
    for name, value in zip(CONDITION, (diameter_mm, fill_ratio, speed_rpm), strict=True):
        same &= np.isclose(table[name], value, rtol=1e-3)
    return table[same].sort_values("date").iloc[-1].to_dict() if same.any() else None
