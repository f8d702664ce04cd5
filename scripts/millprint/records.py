"""Records of the files that every job wrote, so that a file damaged afterwards is found.

Snakemake records digests of what a job reads, not of what it writes: it sees that a file is younger, not that it is
broken. A job's record is a JSON file beside its log: for each file the bytes, the SHA-256 digest and the date.
"""

import hashlib
import json
import os
import sys
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from millprint.files import whole_file


class Damage(NamedTuple):
    """A file that has changed since its job: its path, what is wrong with it, and the record of the job."""

    path: str
    what: str
    record: Path

    def __str__(self) -> str:
        return f"{self.path}: {self.what}"


def digest(path: str | Path) -> str:
    """SHA-256 of the content of a file."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def record_path(log_path: str | Path) -> Path:
    """The path of the record of the job with this log."""
    return Path(log_path).with_suffix(".json")


def read_record(path: Path) -> dict[str, dict]:
    """Bytes, digest and date of each file; empty if there is no readable record."""
    try:
        content = json.loads(path.read_text())
        files = {name: dict(entry) for name, entry in content["files"].items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}
    return files if all({"bytes", "sha256", "date_ns"} <= set(entry) for entry in files.values()) else {}


def entry_of(file: str | Path) -> dict:
    """The entry of a file: bytes, digest and date [ns since 1970]."""
    found = os.stat(file)
    return {"sha256": digest(file), "bytes": found.st_size, "date_ns": found.st_mtime_ns}


def write_record(path: Path, files: Iterable[str | Path], origin: str = "") -> None:
    """Record those of the `files` that exist; origin: a digest of what they were made from, if the job has one."""
    _write(path, {name: entry_of(name) for name in map(str, files) if Path(name).is_file()}, origin)


def replace_entries(path: Path, entries: dict[str, dict]) -> None:
    """Write bytes, digest and date of each file into a record, and keep what it says of their origin."""
    _write(path, entries, made_from(path))


def made_from(path: Path) -> str:
    """The digest of what the files of a record were made from; empty if there is none, or no readable record."""
    try:
        return str(json.loads(path.read_text()).get("made_from", ""))
    except (OSError, ValueError, AttributeError):
        return ""


def _write(path: Path, entries: dict[str, dict], origin: str) -> None:
    with whole_file(path) as partial:
        content = {"files": entries, **({"made_from": origin} if origin else {})}
        partial.write_text(json.dumps(content, indent=1, sort_keys=True) + "\n")


def damaged_files(logs: str | Path) -> list[Damage]:
    """Every recorded file that exists with another content. Only files with another size or date are read."""
    return [damage for record in _records(logs) for damage in _compare(record, read_record(record))]


def report_damaged(logs: str | Path) -> None:
    """Say on stderr, in a line each, which recorded files are damaged, before the jobs of a run begin.

    Snakemake dates every output once more after its job, so that each has another date than its record says, and has to
    be read. Those that are as recorded get their new date into the record: the next look at them is quick.
    """
    for record in _records(logs):
        entries = read_record(record)
        damages = list(_compare(record, entries))
        for damage in damages:
            print(f"found: {damage}; make verify tells more", file=sys.stderr, flush=True)
        _renew_dates(record, entries, {damage.path for damage in damages})


def _records(logs: str | Path) -> list[Path]:
    return sorted(Path(logs).rglob("*.json"))


def _compare(record: Path, entries: dict[str, dict]) -> Iterator[Damage]:
    """The files of a record whose content has changed."""
    for name, entry in entries.items():
        try:
            found = os.stat(name)
        except OSError:
            # Missing: Snakemake makes it again when needed.
            continue
        if (found.st_size, found.st_mtime_ns) == (entry["bytes"], entry["date_ns"]):
            continue
        dated = time.strftime("dated %Y-%m-%d %H:%M", time.localtime(found.st_mtime))
        if found.st_size < entry["bytes"]:
            yield Damage(name, f"truncated, {found.st_size} bytes of {entry['bytes']} ({dated})", record)
            continue
        try:
            same = found.st_size == entry["bytes"] and digest(name) == entry["sha256"]
        except OSError as error:
            yield Damage(name, f"cannot be read: {error.strerror} ({dated})", record)
            continue
        if not same:
            yield Damage(name, f"changed since it was written ({dated})", record)


def _renew_dates(record: Path, entries: dict[str, dict], damaged: set[str]) -> None:
    """Update the dates of all undamaged files in a record, unless a job has changed the record in the meantime."""
    renewed = {}
    for name, entry in entries.items():
        there = name not in damaged and Path(name).is_file()
        renewed[name] = {**entry, "date_ns": os.stat(name).st_mtime_ns} if there else entry
    if renewed != entries and read_record(record) == entries:
        replace_entries(record, renewed)


def keep(damage: Damage) -> None:
    """Record a file as it is now, so that its present content is the result."""
    # Marked, because the job may run again to make another of its files, and must not overwrite this one.
    entry = {**entry_of(damage.path), "kept": True}
    replace_entries(damage.record, {**read_record(damage.record), damage.path: entry})


def is_kept(entry: dict) -> bool:
    """Whether the user has kept the changed content of this file."""
    return bool(entry.get("kept"))


def set_aside(path: str) -> Path:
    """Rename a file to NAME.damaged, or to NAME.damaged.2 and so on if that exists. Returns the new path."""
    number, aside = 1, Path(f"{path}.damaged")
    while aside.exists():
        number += 1
        aside = Path(f"{path}.damaged.{number}")
    os.replace(path, aside)
    return aside
