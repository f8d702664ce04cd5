"""Files of the user: a recording, tables of a thermometer or a wattmeter, and the table of own measurements."""

import struct
import warnings
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

SHORTEST_S, LOWEST_RATE_HZ = 5.0, 8000
SILENT = 1e-4
# Equal samples at full scale that follow each other are a clipped peak; a few do no harm.
CLIPPED_RUN, MOST_CLIPPED = 4, 5
# Names of a column, with the factor and the offset to SI.
TIME = {"time_s": (1.0, 0.0), "time_min": (60.0, 0.0), "time_h": (3600.0, 0.0)}
TEMPERATURE = {"temperature_degC": (1.0, 0.0), "temperature_K": (1.0, -273.15)}
POWER = {"power_W": (1.0, 0.0), "power_kW": (1e3, 0.0)}
# Columns that tell more of a measurement, but change nothing in its comparison.
LEFT_OUT = ("class", "mill", "description", "note")
POSSIBLE = {"time": (-1e6, 1e7), "temperature": (-50.0, 400.0), "power": (0.0, 1e5)}


def read_recording(path: str | Path) -> tuple[np.ndarray, float]:
    """The louder channel of a WAV of 8 to 32 bit (n,), full scale 1, and its sampling rate [Hz].

    Raises ConfigError, in one line, for a file that is missing, not a WAV, too short, silent or clipped.
    """
    # Imported here: slow to import, and a table does not need it.
    from scipy.io import wavfile

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", wavfile.WavFileWarning)
            rate, samples = wavfile.read(path)
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such recording") from None
    except (ValueError, EOFError, OSError, UnboundLocalError, struct.error) as error:
        raise ConfigError(f"{path}: not a WAV ({error}); export it as WAV with 16 bit, PCM") from None
    sound = _full_scale(samples)
    if rate < LOWEST_RATE_HZ or len(sound) < SHORTEST_S * rate:
        raise ConfigError(
            f"{path}: {len(sound) / rate:.1f} s at {rate} Hz: record {SHORTEST_S:g} s or more, at {LOWEST_RATE_HZ} Hz "
            "or more"
        )
    peak = np.abs(sound).max()
    if not np.isfinite(peak) or peak < SILENT:
        raise ConfigError(f"{path}: silent; hold the microphone nearer to the mill")
    at_peak = np.abs(sound) >= 0.999 * peak
    runs = np.convolve(at_peak, np.ones(CLIPPED_RUN), "valid") >= CLIPPED_RUN
    clipped = int((np.diff(runs.astype(int)) > 0).sum())
    if peak > 0.95 and clipped > MOST_CLIPPED:
        raise ConfigError(f"{path}: {clipped} peaks are clipped; record at a lower level, or farther away")
    return sound, float(rate)


def _full_scale(samples: np.ndarray) -> np.ndarray:
    """The louder channel, -1 to 1."""
    if samples.dtype.kind == "u":
        samples = samples.astype(float) - 128
        sound = samples / 128
    elif samples.dtype.kind == "i":
        sound = samples / -float(np.iinfo(samples.dtype).min)
    else:
        sound = samples.astype(float)
    if sound.ndim == 1:
        return sound
    return sound[:, int((sound**2).sum(axis=0).argmax())] if sound.size else sound[:, 0]


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
