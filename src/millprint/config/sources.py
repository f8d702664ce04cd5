"""The files that a configuration names: where they are searched, and a check that they stay inside the project."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar, get_args

from pydantic.fields import FieldInfo

from millprint.config.errors import ConfigError
from millprint.config.section import InProject, Section

Kept = TypeVar("Kept", bound=Section)

# Of the project: a file for each mill and for each contact set.
MILL_FOLDER, CONTACT_FOLDER = "config/mills", "config/contacts"

PACKAGE = Path(__file__).parents[1]
# setup.py copies folders of the project there; a checkout has them once, at its root.
COPY = PACKAGE / "included"


def shipped(path: str) -> str | None:
    """The location of a file or folder of this project, by its path from the project's root; None if it is not there.

    An installed library has the folders that setup.py copies.
    """
    place = (COPY if COPY.is_dir() else PACKAGE.parents[1]) / path
    return str(place) if place.exists() else None


def _nothing(path: str) -> str | None:
    return None


@dataclass(frozen=True)
class Sources:
    """Finds files by their path from the project's root, such as config/mills/emax.yaml.

    shipped: the location of the workflow's own file of that path, None if it has none. So mills, contact sets
    and tables of the workflow serve a run in any folder, and a user's file takes precedence.
    """

    shipped: Callable[[str], str | None] = _nothing

    def find(self, path: str) -> str:
        """The path itself, or that of the workflow's file if the working folder has no such file."""
        return path if Path(path).exists() else self.shipped(path) or path

    def names(self, folder: str | Path) -> list[str]:
        """Names of the YAML files of a folder, the user's and the workflow's."""
        folders = [folder, self.shipped(str(folder))]
        return sorted({file.stem for place in folders if place for file in Path(place).glob("*.yaml")})

    def resolve(self, section: Kept) -> Kept:
        """The section with the location of every file that it names; see `find`."""
        changes: dict = {}
        for name, field in type(section).model_fields.items():
            value = getattr(section, name)
            if isinstance(value, str) and is_marked(field):
                changes[name] = self.find(value)
            elif isinstance(value, Section):
                changes[name] = self.resolve(value)
            elif isinstance(value, list):
                changes[name] = [self.resolve(item) if isinstance(item, Section) else item for item in value]
        changed = {name: value for name, value in changes.items() if value != getattr(section, name)}
        return section.model_copy(update=changed) if changed else section


# Only the files of the working folder.
WORKING_FOLDER = Sources()


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
    """Raise ConfigError for the first text that is not a path inside the working directory."""
    root = Path.cwd().resolve()
    for key, value in named_files(section):
        try:
            inside = bool(value.strip()) and (root / value).resolve().is_relative_to(root) and Path(value).parts != ()
        except (OSError, ValueError):
            inside = False
        if not inside:
            raise ConfigError(f"{source}: {key} = {value!r}: must be the path of a file inside the project")
