"""Files in the folder of the results: which of them a run describes, and where copies of its inputs lie."""

import re
from collections.abc import Iterable, Iterator
from hashlib import sha256
from pathlib import Path, PurePosixPath

from millprint.run.records import read_record

# The description of a run, in the folder of its results.
CRATE = "ro-crate-metadata.json"
# Beside it: copies of what a run read, and of its workflow.
SOURCES = "crate"
# Folders whose files change whenever anything runs again, and what they hold.
UNCHECKED = {
    "logs": "what every job said, and the record of the files that it wrote",
    "benchmarks": "run times and memory of the jobs, as Snakemake measured them",
}
# Snakemake writes its report when all jobs have ended, and again after every run.
REPORT = "report.html"
# The folders of a project that hold what a run reads.
KEPT_FOLDERS = ("config", "workflow")


def is_described(path: PurePosixPath) -> bool:
    """Whether a crate says what a file must hold: all of the results except what every further run writes anew."""
    hidden = any(part.startswith(".") for part in path.parts)
    return not hidden and path.parts[0] not in UNCHECKED and path.name != REPORT and str(path) != CRATE


def files_in(results: Path) -> Iterator[PurePosixPath]:
    """Every file of a folder of results that a crate describes, as its path in there."""
    for path in sorted(results.rglob("*")):
        if path.is_file() and is_described(inside := PurePosixPath(path.relative_to(results).as_posix())):
            yield inside


def recorded(results: Path) -> dict[str, str]:
    """SHA-256 of every file of the results as its job recorded it, by its path from the working folder."""
    records = sorted((results / "logs").rglob("*.json"))
    return {name: entry["sha256"] for record in records for name, entry in read_record(record).items()}


def places(sources: Iterable[str]) -> dict[str, str]:
    """Where the copy of each source lies in the results: at its path in the project, which names no machine.

    A file outside of the project's folders lies under a part of the digest of its path. Raises ValueError if two files
    would share a place.
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
