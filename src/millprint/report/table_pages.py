"""Tables of the report as HTML, and the pages of the chapters."""

import re
from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import pandas as pd

from millprint.run.files import read_table, whole_file
from millprint.run.html_pages import embed_files, render_page
from millprint.run.outputs import listed_tables

FOLDER = Path(__file__).parent
DIGITS = 4


def section_id(title: str) -> str:
    """The anchor of a section, for links: the words of its title, joined by hyphens."""
    return re.sub(r"\W+", "-", title.lower()).strip("-")


@dataclass(frozen=True)
class Cell:
    """The text of a cell and, for a number, the value that it is sorted by."""

    text: str
    value: float | None = None

    @property
    def number(self) -> bool:
        """Whether the cell is a number."""
        return self.value is not None


@dataclass(frozen=True)
class Section:
    """A table under its title; `cards` for one that a phone shows row by row, since its cells hold sentences."""

    title: str
    frame: pd.DataFrame
    note: str = ""
    cards: bool = False

    @property
    def id(self) -> str:
        """The anchor of the table, for links."""
        return section_id(self.title)

    @property
    def columns(self) -> list[str]:
        """The headings of the columns."""
        return [str(name).replace("_", " ") for name in self.frame.columns]

    @cached_property
    def rows(self) -> list[list[Cell]]:
        """The cells, row by row."""
        columns = [_cells(self.frame.iloc[:, index]) for index in range(self.frame.shape[1])]
        return [list(row) for row in zip(*columns, strict=True)]


def _cells(column: pd.Series) -> list[Cell]:
    """The cells of a column: numbers if it holds nothing else, and numbers that were read as text keep their digits."""
    blank = column.isna() | (column.astype(str).str.strip() == "")
    numbers = pd.to_numeric(column.where(~blank), errors="coerce")
    if (numbers.isna() & ~blank).any() or pd.api.types.is_bool_dtype(column):
        # Text that is markup, such as a link, stays so.
        texts = [value if isinstance(value, str) else str(value) for value in column]
        return [Cell("" if empty else text) for text, empty in zip(texts, blank, strict=True)]
    is_text = not pd.api.types.is_numeric_dtype(column)
    return [
        Cell("") if empty else Cell(str(value) if is_text else f"{value:.{DIGITS}g}", float(number))
        for value, number, empty in zip(column, numbers, blank, strict=True)
    ]


def tables_page(title: str, introduction: str, sections: list[Section], template: Path = FOLDER / "tables.html") -> str:
    """A page with all tables, each with its title."""
    return render_page(
        template,
        title=title,
        introduction=introduction,
        sections=sections,
        style=embed_files(FOLDER, "page.css"),
        script=embed_files(FOLDER, "tables.js"),
    )


def write_chapter(chapter: str, name: str, tables: Collection[str], results: str, output: str, begin: str = "") -> None:
    """Write the page of a chapter, with those of its tables in the folder `results` that `tables` lists.

    name: of the run; begin: the first sentence.
    """
    sections = [
        Section(listed.title, read_table(path), f"{listed.note} {listed.path}".strip())
        for listed in listed_tables()[chapter]
        if (path := f"{results}/{listed.path}") in tables
    ]
    title, about = (
        (f"Chapter {chapter}", f"thesis chapter {chapter}") if chapter.isdigit() else (chapter, chapter.lower())
    )
    introduction = (
        f"{begin} Tables of {about} as the run {name} computed them. A click on a column sorts by it.".strip()
    )
    with whole_file(output) as partial:
        partial.write_text(tables_page(f"{title}: tables", introduction, sections))
