"""Temperatures at the condition of a fingerprint sheet."""

import numpy as np
import pandas as pd

from millprint.fingerprint.mill_sheet import SHEET, Row

SECTION = "temperature"
BODIES = ("powder", "balls", "jar")


def temperature_rows(limits: pd.DataFrame, sheet: pd.DataFrame) -> pd.DataFrame:
    """Rows of a sheet: temperatures after long milling without a pause, at the sheet's condition.

    limits: of `heat_table.heat_tables`. A condition without a heat balance has a row that says so.
    """
    told = sheet[sheet["section"] == "condition"].set_index("quantity")["value"]
    columns = {"ball_diameter_mm": "ball diameter", "speed_rpm": "speed", "fill_ratio": "fill ratio"}
    same = np.ones(len(limits), dtype=bool)
    for column, quantity in columns.items():
        same &= np.isclose(limits[column], float(told[quantity]), rtol=1e-5)
    if not same.any():
        return pd.DataFrame([Row(SECTION, "temperatures", text="not calculated here")], columns=SHEET)
    own = limits[same].iloc[0]
    rows = []
    for body in BODIES:
        median, lower, upper = (float(own[f"{body}_steady_degC_{end}"]) for end in ("median", "lower", "upper"))
        rows.append(Row(SECTION, body, median, lower, upper, "°C"))
    return pd.DataFrame(rows, columns=SHEET)
