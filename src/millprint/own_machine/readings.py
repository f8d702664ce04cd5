"""Files of the user: a recording, tables of a thermometer or a wattmeter, and the table of own measurements."""

import warnings
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.config.errors import ConfigError
from millprint.config.setup_models import SETTINGS
from millprint.run.files import whole_file
from millprint.run.tables import refuse_rows
from millprint.validation.measured import COLUMNS, UNKNOWN, read_measurements

SHORTEST_S, LOWEST_RATE_HZ = 5.0, 8000
SILENT = 1e-4
# Equal samples at full scale that follow each other are a clipped peak; a few do no harm.
CLIPPED_RUN, MOST_CLIPPED = 4, 5
# Names of a column, with the factor and the offset to SI.
TIME = {"time_s": (1.0, 0.0), "time_min": (60.0, 0.0), "time_h": (3600.0, 0.0)}
TEMPERATURE = {"temperature_degC": (1.0, 0.0), "temperature_K": (1.0, -273.15)}
POWER = {"power_W": (1.0, 0.0), "power_kW": (1e3, 0.0)}
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
    except (ValueError, EOFError, OSError, UnboundLocalError) as error:
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
    """Columns `time_s` and `value` of a table with tabs, semicolons or commas between its cells.

    A comma may be the decimal point where cells are not separated by it. quantity: TEMPERATURE or POWER. Raises
    ConfigError, in one line, for a missing column, a cell that is not a number or out of range, times that do not rise,
    and fewer than `fewest` rows.
    """
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such table") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: cannot be read as a table ({error})") from None
    lines = [line.strip() for line in text.splitlines() if line.strip() and not line.startswith("#")]
    mark = next((mark for mark in "\t;," if lines and mark in lines[0]), "\t")
    cells = [[cell.strip() for cell in line.split(mark)] for line in lines]
    if uneven := [number for number, row in enumerate(cells) if len(row) != len(cells[0])]:
        raise ConfigError(f"{path}: row {uneven[0]} has {len(cells[uneven[0]])} cells, the header {len(cells[0])}")
    frame = pd.DataFrame(cells[1:], columns=cells[0] if cells else [])
    table = pd.DataFrame({name: _column(frame, path, known) for name, known in (("time_s", TIME), ("value", quantity))})
    if len(table) < fewest:
        raise ConfigError(f"{path}: {len(table)} readings: needs {fewest} or more")
    falls = np.append(False, np.diff(table["time_s"]) <= 0)
    refuse_rows(table, path, "time_s", falls, "times must rise")
    return table


def _column(frame: pd.DataFrame, path: str | Path, known: Mapping[str, tuple[float, float]]) -> pd.Series:
    """The column of one of the known names, in SI."""
    name = next((name for name in known if name in frame), None)
    if name is None:
        first, *others = known
        raise ConfigError(
            f"{path}: column {first} (or {' or '.join(others)}) is missing; the table has {', '.join(map(str, frame))}"
        )
    values = pd.to_numeric(frame[name].str.replace(",", "."), errors="coerce")
    refuse_rows(frame, path, name, ~np.isfinite(values.to_numpy(dtype=float)), "must be a number")
    factor, offset = known[name]
    low, high = POSSIBLE[name.split("_")[0]]
    values = values * factor + offset
    unit = next(iter(known)).split("_")[1]
    refuse_rows(
        frame, path, name, ~values.between(low, high), f"must be {low:g} to {high:g} {unit}; is the unit right?"
    )
    return values


def append_measured(path: str | Path, row: Mapping[str, object]) -> str:
    """Append a row to a table of own measurements, which is made if it is not there; returns the row's id.

    row: columns of `validation.measured`; its id gets a number if it is there already. Raises ConfigError for a table
    that `validation` would refuse.
    """
    names = [column.name for column in COLUMNS]
    table, comments = pd.DataFrame(columns=names), ""
    if Path(path).exists():
        read_measurements(path, SETTINGS)
        comments = "".join(f"{line}\n" for line in Path(path).read_text().splitlines() if line.startswith("#"))
        table = pd.read_csv(path, sep="\t", comment="#", dtype=str, keep_default_na=False)
    known, id = set(table["id"].str.strip()), str(row["id"])
    id = next(each for each in (id, *(f"{id}_{n}" for n in range(2, len(known) + 3))) if each not in known)
    new = pd.DataFrame([{"setup": UNKNOWN, "class": "measured, own machine", **row, "id": id}])
    whole = pd.concat([table, new.astype(str)], ignore_index=True).fillna("")
    with whole_file(path) as partial:
        partial.write_text(comments + whole.to_csv(sep="\t", index=False))
    return id
