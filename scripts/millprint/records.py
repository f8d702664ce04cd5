"""What every job wrote, file by file, so that a file damaged afterwards is found before anything reads it.

A job's record is a JSON file beside its log: for each file the bytes, the SHA-256 digest and the date.
"""

import hashlib
import json
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from millprint.files import whole_file

DAMAGED = ".damaged"


class Damage(NamedTuple):
    """A file that is not what a job wrote."""

    path: str
    found_bytes: int
    written_bytes: int
    record: Path

    def __str__(self) -> str:
        if self.found_bytes < self.written_bytes:
            return f"{self.path}: truncated, {self.found_bytes} bytes of {self.written_bytes}"
        return f"{self.path}: changed since it was written"


def digest(path: str | Path) -> str:
    """SHA-256 of a file's content."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def record_path(log_path: str | Path) -> Path:
    """Where the record of the job with this log is."""
    return Path(log_path).with_suffix(".json")


def read_record(path: Path) -> dict[str, dict]:
    """File to bytes, digest and date; empty where there is no record or none that can be read."""
    try:
        content = json.loads(path.read_text())
        return {name: dict(entry) for name, entry in content["files"].items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


def write_record(path: Path, files: Iterable[str | Path], before: dict[str, dict]) -> None:
    """Record the `files` that are there. One that is as `before`, bit for bit, gets back the date that it had.

    So a file that was damaged and made again is no news to what was made from it.
    """
    entries = {}
    for file in sorted(map(str, files)):
        if not Path(file).is_file():
            continue
        entry = {"sha256": digest(file)}
        if before.get(file, {}).get("sha256") == entry["sha256"]:
            date = before[file]["date_ns"]
            os.utime(file, ns=(date, date))
        found = Path(file).stat()
        entries[file] = {**entry, "bytes": found.st_size, "date_ns": found.st_mtime_ns}
    with whole_file(path) as partial:
        partial.write_text(json.dumps({"files": entries}, indent=1, sort_keys=True) + "\n")


def damaged_files(logs: str | Path) -> Iterator[Damage]:
    """Every recorded file that is there with another content. Only files of another size or date are read."""
    for record in sorted(Path(logs).rglob("*.json")):
        for name, entry in read_record(record).items():
            try:
                found = os.stat(name)
            except OSError:
                continue
            if (found.st_size, found.st_mtime_ns) == (entry["bytes"], entry["date_ns"]):
                continue
            if found.st_size != entry["bytes"] or digest(name) != entry["sha256"]:
                yield Damage(name, found.st_size, entry["bytes"], record)


def set_aside(damage: Damage) -> None:
    """Move a damaged file out of the way, under a name of its own."""
    os.replace(damage.path, damage.path + DAMAGED)


def put_back_dates(record: Path) -> None:
    """Give every file of a record that is as recorded its recorded date: Snakemake dates what a job wrote anew."""
    for name, entry in read_record(record).items():
        if Path(name).is_file() and digest(name) == entry["sha256"]:
            os.utime(name, ns=(entry["date_ns"], entry["date_ns"]))
