"""Which job made a file, from what and when, read from the records that Snakemake keeps of every output.

Snakemake writes a JSON file for every output when its job has ended. Its name is the output's path in URL-safe base64.
If it is too long for a file name, it is cut into parts, and all parts but the last are folders that begin with @.

Files in the folder of the results: which of them a crate describes, where copies of the inputs are, and a check.

The check compares a folder of results, or a copy of it anywhere, with the crate in it.
"""

import json
import re
from base64 import urlsafe_b64decode
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote

from millprint.config.errors import ConfigError
from millprint.run.digest import digest, read_record
from millprint.run.job import progress

METADATA = Path(".snakemake/metadata")


@dataclass(frozen=True)
class Job:
    """The job that made a file: its rule, inputs, begin and end [s since 1970]."""

    rule: str
    inputs: tuple[str, ...]
    begin: float
    end: float


@dataclass(frozen=True)
class Lineage:
    """The files made on the way to some targets, the files that no job made, and begin and end of the jobs."""

    made: tuple[str, ...]
    sources: tuple[str, ...]
    begin: datetime
    end: datetime


def read_jobs() -> dict[str, Job]:
    """The job of every output that Snakemake has a record of, by the output's path; unreadable records are left out."""
    jobs = {}
    for path in METADATA.rglob("*"):
        # A folder is the beginning of a long name.
        if path.is_dir():
            continue
        try:
            name = "".join(part.removeprefix("@") for part in path.relative_to(METADATA).parts)
            record = json.loads(path.read_text())
            job = Job(record["rule"], tuple(record["input"]), float(record["starttime"]), float(record["endtime"]))
            jobs[urlsafe_b64decode(name).decode()] = job
        except (ValueError, KeyError, TypeError, AttributeError):
            continue
    return jobs


def trace(targets: Iterable[str], jobs: Mapping[str, Job]) -> Lineage:
    """Follow the jobs back from the targets to the files that no job made.

    Raises ConfigError for a target without a job, or if there is no target.
    """
    waiting, made, sources = list(targets), set(), set()
    if unknown := [name for name in waiting if name not in jobs]:
        raise ConfigError(
            f"{unknown[0]}: Snakemake has no record of the job that made this file; run the same command again"
        )
    if not waiting:
        raise ConfigError("a run without results has no lineage")
    while waiting:
        name = waiting.pop()
        if name in made or name in sources:
            continue
        if name not in jobs:
            sources.add(name)
            continue
        made.add(name)
        waiting += jobs[name].inputs
    begin, end = min(jobs[name].begin for name in made), max(jobs[name].end for name in made)
    return Lineage(tuple(sorted(made)), tuple(sorted(sources)), _moment(begin), _moment(end))


def _moment(seconds: float) -> datetime:
    """A time in UTC, in whole seconds."""
    return datetime.fromtimestamp(round(seconds), UTC)


# The description of a run, in the folder of its results.
CRATE = "ro-crate-metadata.json"
# Next to it: copies of the inputs of a run, and of its workflow.
SOURCES = "crate"
# Folders whose files change with every further run, and what they contain.
UNCHECKED = {
    "logs": "the log of every job, and the record of the files that it wrote",
    "benchmarks": "run times and memory of the jobs, as Snakemake or the job measured them",
}
# Snakemake writes its report when all jobs have ended, and again after every run.
REPORT = "report.html"
# The folders of a project that hold what a run reads.
KEPT_FOLDERS = ("config", "workflow")


def is_described(path: PurePosixPath) -> bool:
    """Whether a crate has the digest of a file: all results except files that every further run writes again."""
    hidden = any(part.startswith(".") for part in path.parts)
    return not hidden and path.parts[0] not in UNCHECKED and path.name != REPORT and str(path) != CRATE


def files_in(results: Path) -> Iterator[PurePosixPath]:
    """Every file of a folder of results that a crate describes, by its path in the folder."""
    for path in sorted(results.rglob("*")):
        if path.is_file() and is_described(inside := PurePosixPath(path.relative_to(results).as_posix())):
            yield inside


def recorded(results: Path) -> dict[str, str]:
    """The SHA-256 that jobs recorded for every file of the results, by its path from the working folder."""
    records = sorted((results / "logs").rglob("*.json"))
    return {name: entry["sha256"] for record in records for name, entry in read_record(record).items()}


def places(sources: Iterable[str]) -> dict[str, str]:
    """The place of the copy of each source in the results: its path in the project, which is the same on every machine.

    The place of a file outside the project's folders begins with a part of the digest of its path. Raises ValueError if
    two files would have the same place.
    """
    found = {source: f"{SOURCES}/{_place(source)}" for source in sources}
    if len(set(found.values())) < len(found):
        raise ValueError("two inputs of a run have the same place in its crate")
    return found


def _place(source: str) -> str:
    parts = PurePosixPath(source).parts
    if not PurePosixPath(source).is_absolute() and ".." not in parts:
        return PurePosixPath(source).as_posix()
    # Of a checkout elsewhere, or of Snakemake's cache of a remote one.
    last = max((index for index, part in enumerate(parts) if part in KEPT_FOLDERS), default=None)
    if last is not None:
        return "/".join(parts[last:])
    name = re.sub(r"[^\w.-]", "_", parts[-1])
    return f"outside/{sha256(source.encode()).hexdigest()[:8]}/{name}"


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
