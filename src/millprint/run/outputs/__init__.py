"""What a run makes: outputs.yaml, the one list from which reports, gallery and the end of a run take their texts.

The Snakefile imports this, so no heavy imports here. It has a folder of its own, since an edit of the list reruns the
jobs whose scripts import from that folder (millprint.run.digest).
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

from millprint.config.errors import ConfigError
from millprint.config.load import read_yaml

LISTED = Path(__file__).with_name("outputs.yaml")
PLACEHOLDER = re.compile(r"\{(\w+)\}")


class _Kept(dict[str, str]):
    """Words in place of braces; an unknown one stays as it is."""

    def __missing__(self, key: str) -> str:
        return f"{{{key}}}"


@dataclass(frozen=True)
class Output:
    """A figure, page or table; see the head of outputs.yaml. words: what the braces of the path stand for."""

    path: str
    chapter: str
    caption: str = ""
    labels: Mapping[str, str] = field(default_factory=dict)
    data: tuple[str, ...] = ()
    none: str = ""
    title: str = ""
    note: str = ""
    words: Mapping[str, str] = field(default_factory=dict)

    @property
    def pattern(self) -> re.Pattern[str]:
        """The path as a pattern; a word in braces is a part of a path without a slash."""
        pieces = PLACEHOLDER.split(self.path)
        found = [f"(?P<{piece}>[^/]+)" if number % 2 else re.escape(piece) for number, piece in enumerate(pieces)]
        return re.compile("".join(found))

    def filled(self, words: Mapping[str, str]) -> "Output":
        """The same with words in place of the braces; a label keeps a word that is not given."""
        labels = {name: text.format_map(_Kept(words)) for name, text in self.labels.items()}
        data = tuple(table.format(**words) for table in self.data)
        return replace(self, chapter=self.chapter.format(**words), labels=labels, data=data, words=words)


@cache
def _content() -> dict[str, Any]:
    content = read_yaml(LISTED)
    assert isinstance(content, dict)
    return content


@cache
def listed_outputs() -> tuple[Output, ...]:
    """Every output of the list, in its order."""
    chapters = _content()["outputs"].items()
    return tuple(Output(chapter=chapter, **record) for chapter, records in chapters for record in records)


@cache
def _captioned() -> tuple[tuple[re.Pattern[str], Output], ...]:
    """Figures and pages with their patterns. Those without braces come first: each is about a single file."""
    kept = sorted((each for each in listed_outputs() if each.caption), key=lambda each: each.path.count("{"))
    return tuple((each.pattern, each) for each in kept)


def captioned(path: str, **further: str) -> Output:
    """A figure or page by its path in the results folder; further: words of its labels that the path does not have.

    Raises ConfigError for one that the list lacks.
    """
    for pattern, each in _captioned():
        if match := pattern.fullmatch(path):
            return each.filled({**match.groupdict(), **further})
    raise ConfigError(f"{path}: no record of this figure or page in millprint/run/outputs/{LISTED.name}")


@cache
def listed_tables() -> dict[str, tuple[Output, ...]]:
    """The tables that pages show, by chapter: `2` to `6`, and `Validation`."""
    found: dict[str, tuple[Output, ...]] = {}
    for each in listed_outputs():
        if each.title:
            name = each.chapter.removeprefix("Chapter ")
            found[name] = (*found.get(name, ()), each)
    return found


def listed_targets() -> dict[str, dict[str, str]]:
    """The texts at the end of each target."""
    return _content()["targets"]
