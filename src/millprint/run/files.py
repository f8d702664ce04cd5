"""Tables, JSON and other outputs, written under a temporary name and then renamed: a file is complete or absent.

Snakemake imports this module as it reads the Snakefile, so pandas is imported only where it is used.
"""

from __future__ import annotations

import glob
import hashlib
import json
import os
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import psutil

from millprint.config.errors import ConfigError, DamagedFile

if TYPE_CHECKING:
    import pandas as pd

# Columns that identify a row for a reader.
ROW_NAMES = ("case", "reference")
FINITE, FINITE_OR_EMPTY = "a finite number", "a finite number or empty"

# Every file that this process has written, for the record of its job.
written: list[Path] = []


@contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path next to `path`, renamed to `path` only if the block ends without an error.

    The content is on the disk before the renaming, so neither a killed job nor a power failure leaves half a file.
    """
    path = Path(path)
    if not path.name:
        raise ConfigError(f"'{path}': is not the name of a file that can be written")
    path.parent.mkdir(parents=True, exist_ok=True)
    _drop_left_overs(path)
    # Keeps the suffix: matplotlib, h5py and pandas choose a format by it.
    partial = path.with_name(f".partial.{os.getpid()}.{path.name}")
    try:
        yield partial
        with open(partial, "rb+") as file:
            os.fsync(file.fileno())
        os.replace(partial, path)
        written.append(path)
    finally:
        partial.unlink(missing_ok=True)


def _drop_left_overs(path: Path) -> None:
    """Remove temporary files of `path` that killed processes have left."""
    for partial in path.parent.glob(f".partial.*.{glob.escape(path.name)}"):
        number = partial.name.split(".")[2]
        if number.isdecimal() and not psutil.pid_exists(int(number)):
            partial.unlink(missing_ok=True)


def write_table(frame: pd.DataFrame, path: str | Path, digits: int = 8) -> None:
    """Write a table as TSV with one header line; numbers keep `digits` significant digits."""
    with whole_file(path) as partial:
        frame.to_csv(partial, sep="\t", index=False, float_format=f"%.{digits}g")


def read_table(
    path: str | Path, numeric: Sequence[str] = (), text: Sequence[str] = (), may_be_blank: Sequence[str] = ()
) -> pd.DataFrame:
    """Read a table that `write_table` wrote, and check its columns; `run.tables.read_measured` reads those of people.

    numeric, text: columns of numbers and of text that it must have; may_be_blank: numeric columns that may have empty
    cells. Only an empty cell is nothing. Raises ConfigError, in one line, for a missing file or column, and for a cell
    of a numeric column without a number.
    """
    import pandas as pd

    try:
        with warnings.catch_warnings():
            # A row with more columns than the header: pandas would leave out the last, or take the first as names.
            warnings.simplefilter("error", pd.errors.ParserWarning)
            frame = pd.read_csv(
                path, sep="\t", dtype=dict.fromkeys(text, str), index_col=False, keep_default_na=False, na_values=[""]
            )
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such table") from None
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror})") from None
    except pd.errors.ParserWarning:
        raise ConfigError(f"{path}: a row has more columns than the header") from None
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError, ValueError, OverflowError) as error:
        raise ConfigError(f"{path}: not a tab-separated table ({' '.join(str(error).split())})") from None
    refuse_missing(path, [*numeric, *text], list(frame.columns))
    for column in numeric:
        # pandas reads a column of only true and false as booleans.
        values = pd.to_numeric(frame[column].astype(object), errors="coerce")
        bad = ~values.abs().lt(float("inf")) | (frame[column].dtype == bool)
        if column in may_be_blank:
            bad &= frame[column].notna()
        if bad.any():
            row = int(bad.idxmax())
            place = f"column {column}, {row_name(frame, row, column)} = {frame[column].iloc[row]!r}"
            raise ConfigError(f"{path}: {place}: must be {FINITE_OR_EMPTY if column in may_be_blank else FINITE}")
        frame[column] = values
    return frame


def refuse_missing(path: str | Path, needed: Sequence[str], there: Sequence[str]) -> None:
    """Raise ConfigError for the first needed column that is not there."""
    for column in needed:
        if column not in there:
            meant = next((own for own in there if own.lower() == column.lower()), None)
            hint = f"write {column} for {meant}" if meant else f"the table has {', '.join(there)}"
            raise ConfigError(f"{path}: column {column} is missing; {hint}")


def row_name(frame: pd.DataFrame, row: int, column: str) -> str:
    """The name of row `row` (from 0) for a fault in `column`: from a column of ROW_NAMES, or its number."""
    named = [f"{name} {frame[name].iloc[row]}" for name in ROW_NAMES if name in frame and name != column]
    return named[0] if named else f"row {row + 1}"


def write_json(content: dict, path: str | Path) -> None:
    """Write a JSON file with sorted keys."""
    with whole_file(path) as partial:
        partial.write_text(json.dumps(content, indent=1, sort_keys=True, allow_nan=False) + "\n")


def read_format(path: str | Path, formats: Sequence[str], what: str, hint: str = "") -> dict:
    """Read a JSON file whose key `format` is one of `formats`.

    Raises ConfigError, in one line, for a file that is missing, is not JSON or has another format. what: a noun for the
    file; hint: the end of each line, where such a file comes from.
    """
    end = f"; {hint}" if hint else ""
    try:
        content = read_json(path)
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such {what}{end}") from None
    except ValueError as error:
        raise ConfigError(f"{path}: not a {what} ({str(error).splitlines()[0]}){end}") from None
    given = content.get("format") if isinstance(content, dict) else None
    if given not in formats:
        raise ConfigError(f"{path}: format = {given!r}: must be {' or '.join(map(repr, formats))}{end}")
    return content


class Content(dict):
    """The keys and values of a JSON file, also of a part of it; a key that is missing raises DamagedFile."""

    path: str | Path = ""

    def __missing__(self, key: str) -> NoReturn:
        raise DamagedFile(f"{self.path}: key {key} is missing; delete it and run the same command again")


def read_json(path: str | Path) -> dict:
    """Read a JSON file with keys and values. Raises DamagedFile for one that is not, and for a key that it lacks."""

    def with_place(found: dict) -> Content:
        content = Content(found)
        content.path = path
        return content

    try:
        content = json.loads(Path(path).read_text(), object_hook=with_place)
    except ValueError as error:
        raise DamagedFile(f"{path}: not valid JSON ({error}); delete it and run the same command again") from None
    if not isinstance(content, dict):
        raise DamagedFile(f"{path}: has no keys and values; delete it and run the same command again")
    return content


# HDF5 allows a user block of this size at the start of a file, so that a sealed HDF5 file can be opened directly.
BLOCK = 512
MARK = b"millprint sealed sha256 "


def checksum_header(payload: bytes) -> bytes:
    """The block of BLOCK bytes in front of a payload, which contains its digest."""
    return (MARK + hashlib.sha256(payload).hexdigest().encode() + b"\n").ljust(BLOCK, b"\0")


def read_checksummed(path: str | Path) -> bytes:
    """The payload of a sealed file. Raises ValueError if it has changed since it was sealed."""
    content = Path(path).read_bytes()
    payload = content[BLOCK:]
    if not content.startswith(MARK):
        raise ValueError("not a sealed file")
    if content[:BLOCK] != checksum_header(payload):
        raise ValueError("truncated or damaged: its digest does not match")
    return payload
