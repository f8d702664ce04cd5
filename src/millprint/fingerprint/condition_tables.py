"""Conditions as a sweep has them, in the rows of a table."""

from typing import Any

import numpy as np
import pandas as pd

from millprint.config.charge import MEASURES, fill_from
from millprint.config.errors import ConfigError
from millprint.observables.condition import Condition

# Columns of a table: the variable that each is, and the factor to its unit.
SETTINGS = {
    "ball_diameter_mm": ("ball_diameter_m", 1e-3),
    "ball_diameter_m": ("ball_diameter_m", 1.0),
    "speed_rpm": ("speed_hz", 1 / 60),
    "speed_hz": ("speed_hz", 1.0),
}
# What a mill has as built.
BUILT = ("density_kg_m3", "amplitude_m")
COLUMNS = (*SETTINGS, *MEASURES, *BUILT)


def conditions_of(table: pd.DataFrame, about: dict[str, Any]) -> Condition[np.ndarray]:
    """The conditions (m,) of a table of a mill that a fingerprint is `about`, in SI units.

    Raises ConfigError, in one line, for a column that is missing or says the same as another, and for an impossible
    value.
    """
    values = {name: pd.to_numeric(table[name], errors="coerce").to_numpy(float) for name in COLUMNS if name in table}
    for names in (("ball_diameter_mm", "ball_diameter_m"), ("speed_rpm", "speed_hz"), MEASURES):
        given = [name for name in names if name in values]
        if len(given) != 1:
            fault = f"{' and '.join(given)} say the same" if given else f"column {names[0]} is missing"
            raise ConfigError(f"conditions: {fault}; give one of {', '.join(names)}")
    for name, own in values.items():
        share = name in ("fill_ratio", "bulk_filling")
        bad = np.flatnonzero(~((own > 0) & (own < (1 if share else np.inf))))
        if len(bad):
            place = f"conditions: row {bad[0] + 1}: {name} = {table[name].iloc[bad[0]]}"
            raise ConfigError(f"{place}: must be a number over 0{' and under 1' * share}")
    built = {name: values.get(name, np.full(len(table), float(about[name]))) for name in BUILT}
    found = {variable: factor * values[name] for name, (variable, factor) in SETTINGS.items() if name in values}
    measure = next(name for name in MEASURES if name in values)
    volume_ml, diameter_mm = 1e6 * about["volume_m3"], 1e3 * found["ball_diameter_m"]
    fill = fill_from(measure, values[measure], volume_ml, diameter_mm, built["density_kg_m3"])
    for row in np.flatnonzero(fill >= 1)[:1]:
        raise ConfigError(
            f"conditions: row {row + 1}: {measure} = {values[measure][row]:g}: such balls have {fill[row]:.3g} of the "
            "jar's volume"
        )
    return Condition(fill_ratio=fill, **found, **built)
