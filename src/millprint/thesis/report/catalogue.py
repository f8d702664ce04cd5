"""Tables and figures that the report shows, as YAML files name them."""

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import yaml

from millprint.config.errors import ConfigError


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


REGISTRY = Path(__file__).with_suffix(".yaml")
PLACEHOLDER = re.compile(r"\{(\w+)\}")


@dataclass(frozen=True)
class FigureData:
    """The tables of a figure, as paths in the results folder; or why it has none. words: what the braces stand for."""

    tables: tuple[str, ...]
    reason: str
    words: dict[str, str]


@cache
def _registry() -> tuple[tuple[re.Pattern[str], dict], ...]:
    """The entries with their patterns. Those without braces come first: each is about a single figure."""
    entries = yaml.safe_load(REGISTRY.read_text())
    entries.sort(key=lambda entry: len(PLACEHOLDER.findall(entry["figure"])))
    return tuple((_pattern(entry["figure"]), entry) for entry in entries)


def _pattern(figure: str) -> re.Pattern[str]:
    """A figure's path as a pattern; a word in braces is a part of a path without a slash."""
    pieces = PLACEHOLDER.split(figure)
    fixed, named = pieces[::2], pieces[1::2]
    found = [re.escape(fixed[0])]
    for name, text in zip(named, fixed[1:], strict=True):
        found += [f"(?P<{name}>[^/]+)", re.escape(text)]
    return re.compile("".join(found))


def data_of(figure: str) -> FigureData:
    """The tables of a figure, by its path in the results folder. Raises ConfigError for one that figures.yaml lacks."""
    for pattern, entry in _registry():
        if match := pattern.fullmatch(figure):
            words = match.groupdict()
            tables = tuple(table.format(**words) for table in entry.get("data", []))
            return FigureData(tables, entry.get("none", ""), words)
    raise ConfigError(f"{figure}: no table is named for this figure in millprint/thesis/report/{REGISTRY.name}")
