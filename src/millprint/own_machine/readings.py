"""Files of the user: tables of a thermometer or a wattmeter, and the table of own measurements."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.config.errors import ConfigError
from millprint.config.rows import append_row, read_cells
from millprint.config.setup_models import SETTINGS
from millprint.run.files import whole_file
from millprint.run.tables import Number, read_measured, refuse_rows
from millprint.validation.measured import COLUMNS, UNKNOWN, read_measurements

# Names of a column, with the factor and the offset to SI.
TIME = {"time_s": (1.0, 0.0), "time_min": (60.0, 0.0), "time_h": (3600.0, 0.0)}
TEMPERATURE = {"temperature_degC": (1.0, 0.0), "temperature_K": (1.0, -273.15)}
POWER = {"power_W": (1.0, 0.0), "power_kW": (1e3, 0.0)}
# Columns that tell more of a measurement, but change nothing in its comparison.
LEFT_OUT = ("class", "mill", "description", "note")
POSSIBLE = {"time": (-1e6, 1e7), "temperature": (-50.0, 400.0), "power": (0.0, 1e5)}


def read_series(path: str | Path, quantity: Mapping[str, tuple[float, float]], fewest: int) -> pd.DataFrame:
    """Columns `time_s` and `value` of a table; quantity: TEMPERATURE or POWER.

    Raises ConfigError, in one line, as `read_measured`, for a missing column, a number out of range, times that do not
    rise, and fewer than `fewest` rows.
    """
    header, found = read_cells(path).header, {}
    for column, known in (("time_s", TIME), ("value", quantity)):
        first, *others = known
        name = next((name for name in known if name in header), None)
        if name is None:
            raise ConfigError(
                f"{path}: column {first} (or {' or '.join(others)}) is missing; the table has {', '.join(header)}"
            )
        frame = read_measured(path, [Number(name)], fewest_rows=0)
        (factor, offset), unit = known[name], first.split("_")[1]
        low, high = POSSIBLE[name.split("_")[0]]
        found[column] = values = frame[name] * factor + offset
        refuse_rows(
            frame, path, name, ~values.between(low, high), f"must be {low:g} to {high:g} {unit}; is the unit right?"
        )
    table = pd.DataFrame(found)
    if len(table) < fewest:
        raise ConfigError(f"{path}: {len(table)} readings: needs {fewest} or more")
    falls = np.append(False, np.diff(table["time_s"]) <= 0)
    refuse_rows(table, path, "time_s", falls, "times must rise")
    return table


def append_measured(path: str | Path, row: Mapping[str, str]) -> str:
    """Append a row to a table of own measurements, which is made if it is not there; returns the row's id.

    row: columns of `validation.measured`, of which LEFT_OUT are written if the table has them; its id gets a number if
    it is there already. Raises ConfigError as
    `append_row`, and for a table that `validation` would refuse.
    """
    if not Path(path).exists():
        with whole_file(path) as partial:
            partial.write_text("\t".join(column.name for column in COLUMNS) + "\n", encoding="utf-8")
    header = read_cells(path).header
    row = {"setup": UNKNOWN, "class": "measured, own machine", **row}
    row = {name: text for name, text in row.items() if name in header or name not in LEFT_OUT}
    known, id = set(read_measurements(path, SETTINGS, fewest_rows=0)["id"]), row["id"]
    id = next(each for each in (id, *(f"{id}_{n}" for n in range(2, len(known) + 3))) if each not in known)
    append_row(path, {**row, "id": id}, numbers=("value", "uncertainty"))
    return id
