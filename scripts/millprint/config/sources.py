"""Where the files that a configuration names are looked for: in the user's folder, then among those of the workflow."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from millprint.config.paths import is_marked
from millprint.config.section import Section

Kept = TypeVar("Kept", bound=Section)


def _nothing(path: str) -> str | None:
    return None


@dataclass(frozen=True)
class Sources:
    """Finds files by their path from the project's root, such as config/mills/emax.yaml.

    shipped: where a file of that path lies that came with the workflow, None if there is none. So mills, contact sets
    and tables of the workflow serve a run in any folder, and a file of the user's own takes their place.
    """

    shipped: Callable[[str], str | None] = _nothing

    def find(self, path: str) -> str:
        """The path as it is, or that of the workflow's file where the working folder has none."""
        return path if Path(path).exists() else self.shipped(path) or path

    def names(self, folder: str | Path) -> list[str]:
        """Names of the YAML files of a folder, the user's and the workflow's."""
        folders = [folder, self.shipped(str(folder))]
        return sorted({file.stem for place in folders if place for file in Path(place).glob("*.yaml")})

    def resolve(self, section: Kept) -> Kept:
        """A section with the place of every file that it names; see `find`."""
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


# The files of the working folder alone.
WORKING_FOLDER = Sources()
