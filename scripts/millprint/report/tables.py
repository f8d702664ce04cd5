"""Tables as HTML pages that sort and filter in the browser, with nothing fetched."""

import re
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from millprint.pages import embed_files, render_page

FOLDER = Path(__file__).parent
DIGITS = 4


@dataclass(frozen=True)
class Cell:
    """What a cell shows and, of a number, what it is sorted by."""

    text: str
    value: float | None = None

    @property
    def number(self) -> bool:
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
        return re.sub(r"\W+", "-", self.title.lower()).strip("-")

    @property
    def columns(self) -> list[str]:
        return [str(name).replace("_", " ") for name in self.frame.columns]

    @property
    def rows(self) -> list[list[Cell]]:
        return [[_cell(value) for value in row] for row in self.frame.itertuples(index=False, name=None)]


def _cell(value: object) -> Cell:
    if pd.isna(value):
        return Cell("")
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        try:
            # A table read as text keeps the digits that it was written with.
            return Cell(str(value), float(value)) if str(value).strip() else Cell("")
        except ValueError:
            return Cell(str(value))
    return Cell(f"{value:.{DIGITS}g}", float(value))


def tables_page(title: str, introduction: str, sections: list[Section]) -> str:
    """One page with every table, each under its title."""
    return render_page(
        FOLDER / "tables.html",
        title=title,
        introduction=introduction,
        sections=sections,
        style=embed_files(FOLDER, "page.css"),
        script=embed_files(FOLDER, "tables.js"),
    )
