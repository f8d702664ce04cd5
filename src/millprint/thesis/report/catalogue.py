"""The tables of a run that the report shows, by chapter: catalogue.yaml."""

from dataclasses import dataclass
from pathlib import Path

import yaml


@dataclass(frozen=True)
class ShownTable:
    """A table: its path in the results folder, its title, and a note for its readers."""

    path: str
    title: str
    note: str = ""


def _read_catalogue(path: Path) -> dict[str, tuple[ShownTable, ...]]:
    content = yaml.safe_load(path.read_text())
    return {chapter: tuple(ShownTable(**table) for table in tables) for chapter, tables in content.items()}


TABLES = _read_catalogue(Path(__file__).with_suffix(".yaml"))
