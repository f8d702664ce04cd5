"""Records of the files that every job wrote, to find files that were damaged afterwards.

Snakemake records digests of what a job reads, not of what it writes: it sees that a file is newer, not that it is
damaged. A job's record is a JSON file next to its log with size, SHA-256 digest and date of each file.
"""

import hashlib
import json
import os
import sys
import time
from collections.abc import Container, Iterable
from pathlib import Path

from millprint.run.files import whole_file


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


def write_record(path: Path, files: Iterable[str | Path]) -> None:
    """Record the `files` that exist."""
    _write(path, {name: entry_of(name) for name in map(str, files) if Path(name).is_file()})


def _write(path: Path, entries: dict[str, dict]) -> None:
    with whole_file(path) as partial:
        partial.write_text(json.dumps({"files": entries}, indent=1, sort_keys=True) + "\n")


def report_damaged(logs: str | Path) -> int:
    """Print a line on stderr for each recorded file whose content has changed since its job; returns how many.

    Only files with another size or date than in the record are read. Snakemake changes the date of every output after
    its job, so each is read once; if it is unchanged, the new date is written to the record.
    """
    found = 0
    for record in sorted(Path(logs).rglob("*.json")):
        entries = read_record(record)
        damages = {name: damage for name, entry in entries.items() if (damage := _damage_of(name, entry))}
        for name, damage in damages.items():
            print(
                f"changed: {name}: {damage}; delete it, and a run makes it again; to keep it, delete {record}",
                file=sys.stderr,
                flush=True,
            )
        _renew_dates(record, entries, damages)
        found += len(damages)
    return found


def _damage_of(name: str, entry: dict) -> str:
    """What happened to a file since it was recorded; empty if it is unchanged, or missing, which Snakemake detects."""
    try:
        found = os.stat(name)
    except OSError:
        return ""
    if (found.st_size, found.st_mtime_ns) == (entry["bytes"], entry["date_ns"]):
        return ""
    dated = time.strftime("dated %Y-%m-%d %H:%M", time.localtime(found.st_mtime))
    if found.st_size < entry["bytes"]:
        return f"truncated, {found.st_size} bytes of {entry['bytes']} ({dated})"
    try:
        same = found.st_size == entry["bytes"] and digest(name) == entry["sha256"]
    except OSError as error:
        return f"cannot be read: {error.strerror} ({dated})"
    return "" if same else f"not as its job wrote it ({dated})"


def _renew_dates(record: Path, entries: dict[str, dict], damaged: Container[str]) -> None:
    """Update the dates of all undamaged files in a record, unless a job has changed the record in the meantime."""
    renewed = {}
    for name, entry in entries.items():
        there = name not in damaged and Path(name).is_file()
        renewed[name] = {**entry, "date_ns": os.stat(name).st_mtime_ns} if there else entry
    if renewed != entries and read_record(record) == entries:
        _write(record, renewed)
