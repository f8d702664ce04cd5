"""Tables that people write as input: a row for each thing, a column for each key, in a section with a dot."""

import csv
from pathlib import Path
from typing import Any

from millprint.config.errors import ConfigError
from millprint.config.section import first_repeated


def read_rows(path: str | Path) -> list[dict[str, Any]]:
    """The rows of a table (TSV; lines that begin with # are comments), each as a mapping of keys to texts.

    An empty cell is a key that is left out. Raises ConfigError, in one line, for a table without rows or that cannot be
    read.
    """
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            lines = [line for line in file if line.strip() and not line.startswith("#")]
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such table") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: cannot be read ({error})") from None
    reader = csv.DictReader(lines, delimiter="\t")
    header = list(reader.fieldnames or [])
    if twice := first_repeated(header):
        raise ConfigError(f"{path}: column {twice} appears twice")
    if both := next((one for one in header if any(other.startswith(f"{one}.") for other in header)), None):
        raise ConfigError(f"{path}: column {both}: is a section; its keys have columns of their own, {both}.KEY")
    found = []
    for number, row in enumerate(reader, start=1):
        if None in row or None in row.values():
            raise ConfigError(f"{path}: row {number}: has not as many columns as the header")
        found.append(_nested(row))
    if not found:
        raise ConfigError(f"{path}: no rows; the table needs one at least")
    return found


def _nested(row: dict[str, str]) -> dict[str, Any]:
    """The filled cells of a row, those of a section in a mapping of their own."""
    content: dict[str, Any] = {}
    for column, cell in row.items():
        if cell.strip():
            *sections, key = column.split(".")
            inner = content
            for section in sections:
                inner = inner.setdefault(section, {})
            inner[key] = cell.strip()
    return content
