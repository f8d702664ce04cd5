"""What other groups reported (thesis Tables 2.1 and 2.2), and what each left out."""

import pandas as pd

from millprint.errors import ConfigError
from millprint.files import read_table

NUMERIC = [
    "borate_mass_g",
    "reductant_mass_g",
    "molar_ratio",
    "speed_rpm",
    "time_h",
    "jar_volume_ml",
    "ball_volume_percent",
    "bpr",
]
# Text, for mixed balls are given as 10/4 mm.
TEXT = ["ball_diameter_mm", "balls", "mill", "vessel"]


def read_literature(path: str) -> pd.DataFrame:
    """Read the studies; an empty cell is a parameter that the study does not report.

    Raises ConfigError for a missing column or a text in a column of numbers.
    """
    numeric = ["year", "yield_percent"]
    frame = read_table(path, numeric=numeric, text=["reference", "borate", "reductant", *NUMERIC, *TEXT])
    for column in NUMERIC:
        values = pd.to_numeric(frame[column], errors="coerce")
        bad = values.isna() & frame[column].notna()
        if bad.any():
            study = frame.loc[bad].iloc[0]
            raise ConfigError(
                f"{path}: column {column}, reference {study['reference']} = {study[column]!r}: "
                "a number is wanted, or nothing where the study does not say"
            )
        frame[column] = values
    return frame


def unreported_table(studies: pd.DataFrame) -> pd.DataFrame:
    """For each study how many of the process parameters it leaves out, and which."""
    parameters = [*NUMERIC, *TEXT]
    missing = studies[parameters].isna()
    return pd.DataFrame(
        {
            "reference": studies["reference"],
            "yield_percent": studies["yield_percent"],
            "parameters": len(parameters),
            "unreported": missing.sum(axis=1),
            "unreported_parameters": [
                ", ".join(name for name in parameters if missing.loc[row, name]) for row in studies.index
            ],
        }
    )
