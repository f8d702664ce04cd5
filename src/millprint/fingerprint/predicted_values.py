"""What a fingerprint predicts for a condition: its quantities with their bands."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from millprint.fingerprint.bands import Band, Interval, factor_of, mean_columns, new_columns
from millprint.fingerprint.condition import BASIC, CURVES, WEIGHTED_BASIC, scaled_quantities
from millprint.fingerprint.processes import Told

# The quantities from which `scaled_quantities` calculates all others.
KNOWN = (*BASIC, *WEIGHTED_BASIC)


@dataclass(frozen=True)
class Prediction:
    """Descriptors of one condition, each with its bands; `outside` names the variables outside the simulated range.

    missing: why an interval of a further origin (contact parameters, shape of the jar) is None, by origin.
    """

    balls: int
    weighted_normal_energy_J: Band
    weighted_tangential_energy_J: Band
    weighted_normal_frequency_hz: Band
    weighted_tangential_frequency_hz: Band
    strong_frequency_hz: Band
    normal_energy_J: Band
    tangential_energy_J: Band
    specific_frequency_hz: Band
    normal_power_W: Band
    tangential_power_W: Band
    power_W: Band
    tangential_share: Band
    outside: tuple[str, ...]
    missing: Mapping[str, str]


def bands(table: pd.DataFrame) -> dict[str, Band]:
    """The quantities of the first row of a table of `banded`, each with its two bands."""
    row = {name: float(value) for name, value in table.iloc[0].items()}
    found = {}
    for name in CURVES:
        lower, upper = (row[column] for column in new_columns(name))
        found[name] = Band(row[name], lower, upper, mean=Interval(*(row[column] for column in mean_columns(name))))
    return found


def banded(told: Mapping[str, Told], width: float) -> pd.DataFrame:
    """For each quantity: Q, Q_lower and Q_upper of a new simulation, and Q_mean_lower and Q_mean_upper of the mean.

    Ends that are not known are NaN.
    told: logarithms and deviations (m,) of each; width: of the bands, in deviations.
    """
    values = scaled_quantities({name: np.exp(told[name].logs) for name in KNOWN})
    table: dict[str, np.ndarray] = {}
    for name in CURVES:
        new, mean = (factor_of(width * deviations) for deviations in (told[name].of_new, told[name].of_mean))
        table[name] = values[name]
        for columns, factor in ((new_columns(name), new), (mean_columns(name), mean)):
            table |= dict(zip(columns, (values[name] / factor, values[name] * factor), strict=True))
    return pd.DataFrame(table)
