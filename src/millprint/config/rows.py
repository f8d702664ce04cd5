"""Tables that people write: the one reader of their cells and numbers, and the one way to add a row.

A comment is a line that begins with #, and nothing else. Cells are separated by tabs, semicolons or commas, as the
header shows or Excel's line `sep=;` says; a cell in quotes may have any of them. Words such as None and NA are words:
only an empty cell is nothing. Files are in UTF-8, UTF-16 with its mark, or Windows-1252.
"""

import csv
import io
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from millprint.config.errors import ConfigError
from millprint.config.section import first_repeated

PLAIN = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?", re.IGNORECASE)
BLANKS = " \u00a0\u2009\u202f'’"
SPACED = re.compile(rf"[-+]?[1-9]\d{{0,2}}([{BLANKS}]\d{{3}})+([.,]\d*)?")


def _pattern(mark: str, group: str) -> re.Pattern:
    """Numbers with a decimal mark, and thousands between which another sign stands."""
    whole = rf"(\d+|[1-9]\d{{0,2}}(\{group}\d{{3}})+)"
    return re.compile(rf"[-+]?({whole}(\{mark}\d*)?|\{mark}\d+)(e[-+]?\d+)?", re.IGNORECASE)


FORMS = {".": _pattern(".", ","), ",": _pattern(",", ".")}


def readings(text: str) -> dict[str, str]:
    """The plain number that a text is, by the decimal mark with which it is one: "1,041" is 1041 or 1.041."""
    text = text.strip().replace("−", "-")
    if SPACED.fullmatch(text):
        text = re.sub(f"[{BLANKS}]", "", text)
    return {
        mark: text.replace("," if mark == "." else ".", "").replace(mark, ".")
        for mark, form in FORMS.items()
        if form.fullmatch(text)
    }


def meanings(text: str) -> list[str]:
    """The plain numbers that a text may mean; a point that can be one is a decimal point."""
    return [text] if PLAIN.fullmatch(text) else list(dict.fromkeys(readings(text).values()))


SEPARATORS = "\t;,"
# How the files of workbooks begin.
WORKBOOKS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
UTF_16 = {b"\xff\xfe": "utf-16-le", b"\xfe\xff": "utf-16-be"}


@dataclass(frozen=True)
class Cells:
    """The cells of a table as texts without blanks around them; each row has a cell for each column of the header.

    separator, encoding, line_end: of the file, for further rows.
    """

    path: str
    header: list[str]
    rows: list[list[str]]
    separator: str
    encoding: str
    line_end: str

    @cached_property
    def mark(self) -> str:
        """The decimal mark that columns of numbers prove, as 0,5 and 1.234,5 do; a point where no number needs it.

        Empty if none or both are proved.
        """
        if not any("," in cell or cell.count(".") > 1 for row in self.rows for cell in row):
            return "."
        columns = [[readings(cell) for cell in column if cell] for column in zip(*self.rows, strict=True)]
        proved = {mark for column in columns if all(column) for found in column if len(found) == 1 for mark in found}
        return proved.pop() if len(proved) == 1 else ""

    def column(self, name: str) -> list[str]:
        """The cells of a column."""
        place = self.header.index(name)
        return [row[place] for row in self.rows]

    def plain(self, text: str, place: str) -> str | None:
        """The plain number in a cell, such as 0.5 for 0,5; None if it has none. Raises ConfigError for two readings.

        Where nothing proves a mark, a point is one, and 1,041 has two.
        """
        found = [readings(text)[self.mark]] if self.mark in readings(text) else meanings(text)
        if len(found) > 1:
            words = f"is {' or '.join(found)}; write the one that is meant, with a point for decimals"
            raise ConfigError(f"{self.path}: {place} = {text!r}: {words}")
        return found[0] if found else None


def read_cells(path: str | Path) -> Cells:
    """The cells of a table; tabs at the end of a line may be missing, as editors drop them.

    Raises ConfigError, in one line, for what cannot be read, and for a row of another length.
    """
    try:
        content = Path(path).read_bytes()
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such table") from None
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror})") from None
    text, encoding = _decoded(content, path)
    end = re.search(r"\r\n|\n|\r", text)
    said = re.match(r'"?sep=(.)"?(\r\n|\n|\r)', text, re.IGNORECASE)
    text = text[said.end() :] if said else text
    separator = said[1] if said else _separator(text)
    header, *rows = _records(text, separator, path) or [[]]
    found = [row for row in rows if any(row)]
    # A separator at the end of each line makes cells without anything.
    while header and not header[-1] and not any(row[len(header) - 1 :] > [""] for row in found):
        header.pop()
    if not header:
        raise ConfigError(f"{path}: is empty: names of columns and rows are missing")
    if "" in header:
        raise ConfigError(f"{path}: column {header.index('') + 1} has no name in the header")
    if twice := first_repeated(header):
        raise ConfigError(f"{path}: column {twice} appears twice")
    for number, row in enumerate(found, start=1):
        while len(row) > len(header) and not row[-1]:
            row.pop()
        if separator == "\t":
            row += [""] * (len(header) - len(row))
        if len(row) != len(header):
            hint = "; a comma in a cell? Separate by tabs or semicolons" if separator == "," else ""
            raise ConfigError(f"{path}: row {number} has {len(row)} cells, the header {len(header)}{hint}")
    return Cells(str(path), header, found, separator, encoding, end[0] if end else "\n")


def _decoded(content: bytes, path: str | Path) -> tuple[str, str]:
    """The text of a file, and the encoding for what is added to it."""
    if content.startswith(WORKBOOKS):
        raise ConfigError(f"{path}: is a workbook (XLSX, XLS or ODS); save its sheet as CSV")
    encoding = UTF_16.get(content[:2], "utf-8")
    known = [encoding, *(["cp1252"] if encoding == "utf-8" else [])]
    for encoding in known:
        try:
            text = content.decode(encoding).removeprefix("\ufeff")
        except UnicodeDecodeError:
            continue
        if found := re.search(r"[\x00-\x08\x0e-\x1f]", text):
            raise ConfigError(f"{path}: is not a table but another kind of file (it has the sign {ord(found[0])})")
        return text, encoding
    raise ConfigError(f"{path}: is in none of the encodings {', '.join(known)}; save it as UTF-8")


def _separator(text: str) -> str:
    """What separates the cells of the first line that is not a comment, outside of quotes."""
    first = next((line for line in io.StringIO(text) if line.strip() and not line.startswith("#")), "")
    unquoted = re.sub(r'"[^"]*"', "", first)
    return next((mark for mark in SEPARATORS if mark in unquoted), "\t")


def _records(text: str, separator: str, path: str | Path) -> list[list[str]]:
    """The cells of each line, or of several where a cell in quotes holds the end of a line; without comments."""
    records: list[list[str]] = []
    begun = -1

    def lines() -> Iterator[str]:
        nonlocal begun
        for line in io.StringIO(text, newline=""):
            within = begun == len(records)
            if within or (line.strip() and not line.startswith("#")):
                begun = len(records)
                yield line

    try:
        for record in csv.reader(lines(), delimiter=separator, skipinitialspace=True, strict=True):
            records.append([cell.strip() for cell in record])
    except csv.Error as error:
        place = f"row {len(records)}" if records else "the header"
        raise ConfigError(f'{path}: {place}: a cell that begins with " must end with it ({error})') from None
    return records


def read_rows(path: str | Path) -> list[dict[str, Any]]:
    """The rows of a table, each as a mapping of keys to texts, those of a section (column SECTION.KEY) in their own.

    An empty cell is a key that is left out; columns of numbers have plain ones. Raises ConfigError, in one line, for a
    table without rows or that cannot be read.
    """
    cells = read_cells(path)
    header = cells.header
    if both := next((one for one in header if any(other.startswith(f"{one}.") for other in header)), None):
        raise ConfigError(f"{path}: column {both}: is a section; its keys have columns of their own, {both}.KEY")
    if not cells.rows:
        raise ConfigError(f"{path}: no rows; the table needs one at least")
    columns = {name: cells.column(name) for name in header}
    for name, column in columns.items():
        if all(readings(cell) for cell in column if cell):
            places = (f"row {number}: {name}" for number in range(1, len(column) + 1))
            columns[name] = [cells.plain(cell, place) or "" for cell, place in zip(column, places, strict=True)]
    return [_nested(dict(zip(columns, row, strict=True))) for row in zip(*columns.values(), strict=True)]


def _nested(row: dict[str, str]) -> dict[str, Any]:
    """The filled cells of a row, those of a section in a mapping of their own."""
    content: dict[str, Any] = {}
    for column, cell in row.items():
        if cell:
            *sections, key = column.split(".")
            inner = content
            for section in sections:
                inner = inner.setdefault(section, {})
            inner[key] = cell
    return content


def append_row(path: str | Path, row: Mapping[str, str], numbers: Sequence[str]) -> None:
    """Add a row at the end of a table; what is there stays as it is, byte for byte.

    row: texts by column; numbers: those with a decimal point, which becomes a comma in a table that has such. Raises
    ConfigError, in one line, and changes nothing, for a table that cannot be read, that lacks a column of the row, or
    whose encoding lacks a letter.
    """
    cells = read_cells(path)
    if missing := [name for name, text in row.items() if text and name not in cells.header]:
        raise ConfigError(f"{path}: has no column {', '.join(missing)}, which the new row needs; add it to the header")
    comma = numbers if cells.mark == "," else ()
    texts = [row.get(name, "").replace(".", "," if name in comma else ".") for name in cells.header]
    line = io.StringIO(newline="")
    # A line that begins with # would be a comment.
    csv.writer(
        line,
        delimiter=cells.separator,
        lineterminator=cells.line_end,
        quoting=csv.QUOTE_ALL if texts[0].startswith("#") else csv.QUOTE_MINIMAL,
    ).writerow(texts)
    try:
        added = line.getvalue().encode(cells.encoding)
        before = Path(path).read_bytes()
        if before and not before.endswith(cells.line_end[-1].encode(cells.encoding)):
            added = cells.line_end.encode(cells.encoding) + added
        with open(path, "ab") as file:
            try:
                file.write(added)
                file.flush()
                os.fsync(file.fileno())
            except OSError:
                os.truncate(path, len(before))
                raise
    except UnicodeEncodeError as error:
        letter = error.object[error.start]
        raise ConfigError(f"{path}: {letter!r} is not in {cells.encoding}; save it as UTF-8") from None
    except OSError as error:
        raise ConfigError(f"{path}: no row can be added ({error.strerror})") from None
