"""Files that are whole or absent: tables, JSON and any other output, written beside their name and renamed."""

import json
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pandas as pd

from millprint.errors import ConfigError


@contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path beside `path`, renamed onto it only if the block ends without an error."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    # The suffix stays last: writers (matplotlib, h5py, pandas) choose a format by it.
    partial = path.with_name(f".partial.{os.getpid()}.{path.name}")
    try:
        yield partial
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def write_table(frame: pd.DataFrame, path: str | Path, digits: int = 8) -> None:
    """Write a table as TSV with one header line; numbers keep `digits` significant digits."""
    with whole_file(path) as partial:
        frame.to_csv(partial, sep="\t", index=False, float_format=f"%.{digits}g")


def read_table(path: str | Path, numeric: Sequence[str] = (), text: Sequence[str] = ()) -> pd.DataFrame:
    """Read a TSV (lines that begin with # are comments) and check its columns.

    Raises ConfigError, in one line, for a missing file or column and for a text in a numeric column.
    """
    try:
        frame = pd.read_csv(path, sep="\t", comment="#", dtype=dict.fromkeys(text, str))
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such table") from None
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: not a tab-separated table ({error})") from None
    for column in [*numeric, *text]:
        if column not in frame.columns:
            raise ConfigError(f"{path}: column {column} is missing; the table has {', '.join(frame.columns)}")
    for column in numeric:
        values = pd.to_numeric(frame[column], errors="coerce")
        bad = values.isna() | ~values.abs().lt(float("inf"))
        if bad.any():
            row = int(bad.idxmax())
            raise ConfigError(
                f"{path}: column {column}, row {row + 1} = {frame[column].iloc[row]!r}: a finite number is wanted"
            )
        frame[column] = values
    return frame


def write_json(content: dict, path: str | Path) -> None:
    """Write a JSON file with sorted keys."""
    with whole_file(path) as partial:
        partial.write_text(json.dumps(content, indent=1, sort_keys=True, allow_nan=False) + "\n")


def read_json(path: str | Path) -> dict:
    """Read a JSON file."""
    return json.loads(Path(path).read_text())
