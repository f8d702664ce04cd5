"""Which job made a file, from what and when, read from the records that Snakemake keeps of every output.

Snakemake writes a JSON file for every output when its job has ended. Its name is the output's path in URL-safe base64.
If it is too long for a file name, it is cut into parts, and all parts but the last are folders that begin with @.
"""

import json
from base64 import urlsafe_b64decode
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from millprint.config.errors import ConfigError

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


def read_jobs(metadata: Path = METADATA) -> dict[str, Job]:
    """The job of every output that Snakemake has a record of, by the output's path; unreadable records are left out."""
    jobs = {}
    for path in Path(metadata).rglob("*"):
        # A folder is the beginning of a long name.
        if path.is_dir():
            continue
        try:
            name = "".join(part.removeprefix("@") for part in path.relative_to(metadata).parts)
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
