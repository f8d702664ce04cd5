"""Files that a configuration names stay inside the project."""

from collections.abc import Iterator
from pathlib import Path
from typing import get_args

from pydantic.fields import FieldInfo

from millprint.config.section import InProject, Section
from millprint.errors import ConfigError


def is_marked(field: FieldInfo) -> bool:
    """Whether a field holds the path of a file inside the project."""
    marks = [*field.metadata, *(mark for item in get_args(field.annotation) for mark in get_args(item))]
    return any(isinstance(mark, InProject) for mark in marks)


def named_files(section: Section, place: str = "") -> Iterator[tuple[str, str]]:
    """Dotted key and value of every path in a section and in those nested in it."""
    for name, field in type(section).model_fields.items():
        value, key = getattr(section, name), f"{place}.{name}".lstrip(".")
        if isinstance(value, str) and is_marked(field):
            yield key, value
        for index, item in enumerate(value if isinstance(value, list) else [value]):
            if isinstance(item, Section):
                yield from named_files(item, f"{key}.{index}" if isinstance(value, list) else key)


def check_paths(section: Section, source: str) -> None:
    """Raise ConfigError for the first path that leads out of the working directory, or is none."""
    root = Path.cwd().resolve()
    for key, value in named_files(section):
        try:
            inside = bool(value.strip()) and (root / value).resolve().is_relative_to(root) and Path(value).parts != ()
        except (OSError, ValueError):
            inside = False
        if not inside:
            raise ConfigError(f"{source}: {key} = {value!r}: must be the path of a file inside the project")
