"""Files in the folder of the results: which of them a crate describes, and where copies of the inputs are."""

import re
from collections.abc import Iterable, Iterator
from hashlib import sha256
from pathlib import Path, PurePosixPath

from millprint.run.output_digests import read_record

# The description of a run, in the folder of its results.
CRATE = "ro-crate-metadata.json"
# Next to it: copies of the inputs of a run, and of its workflow.
SOURCES = "crate"
# Folders whose files change with every further run, and what they contain.
UNCHECKED = {
    "logs": "the log of every job, and the record of the files that it wrote",
    "benchmarks": "run times and memory of the jobs, as Snakemake measured them",
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
