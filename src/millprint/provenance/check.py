"""Compares a folder of results, or a copy of it anywhere, with the crate in it."""

import json
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote

from millprint.config.errors import ConfigError
from millprint.provenance.inside import CRATE, files_in
from millprint.run.output_digests import digest
from millprint.run.progress import progress

MISSING, CHANGED, ADDITIONAL = "missing", "changed", "additional"


@dataclass(frozen=True)
class Fault:
    """A file that differs from the crate: what is wrong, its path in the folder, and details."""

    what: str
    path: str
    details: str

    def __str__(self) -> str:
        return f"{self.what}: {self.path}: {self.details}"


def read_crate(folder: Path) -> dict[str, dict[str, Any]]:
    """The files of a crate with a digest, by their path in its folder. Raises ConfigError if there is no crate."""
    path = folder / CRATE
    try:
        graph = json.loads(path.read_text())["@graph"]
        # The identifier of a file is its path, encoded for an address.
        return {unquote(entity["@id"]): entity for entity in graph if "sha256" in entity}
    except FileNotFoundError:
        raise ConfigError(f"{folder}: no {CRATE} here; `make crate` writes one next to the results of a run") from None
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror})") from None
    except (ValueError, KeyError, TypeError, AttributeError):
        raise ConfigError(
            f"{path}: not the description of a run; copy it again, or make it again (`make crate`)"
        ) from None


def check_folder(folder: Path) -> tuple[int, list[Fault]]:
    """The number of files that the crate of a folder lists, and the missing, changed and additional files."""
    listed = read_crate(folder)
    faults = []
    with progress(len(listed), "checking", "file") as bar:
        for path, entity in sorted(listed.items()):
            if fault := _compare(folder, path, entity):
                faults.append(fault)
            bar.update()
    for found in map(str, files_in(folder)):
        if found not in listed:
            faults.append(Fault(ADDITIONAL, found, "not a file of the run, or made after its description"))
    return len(listed), faults


def _compare(folder: Path, path: str, entity: dict[str, Any]) -> Fault | None:
    """The fault of a listed file, if it has one. Its content is read only if its size is right."""
    if PurePosixPath(path).is_absolute() or ".." in PurePosixPath(path).parts:
        return Fault(CHANGED, path, f"{CRATE} names a file outside of the folder")
    file = folder / path
    if not file.is_file():
        return Fault(MISSING, path, f"{entity.get('contentSize')} bytes are listed")
    size = file.stat().st_size
    if str(size) != str(entity.get("contentSize")):
        return Fault(CHANGED, path, f"{size} bytes instead of {entity.get('contentSize')}")
    try:
        same = digest(file) == entity["sha256"]
    except OSError as error:
        return Fault(CHANGED, path, f"cannot be read ({error.strerror})")
    return None if same else Fault(CHANGED, path, "its SHA-256 digest is another one")
