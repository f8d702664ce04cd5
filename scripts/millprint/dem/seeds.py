"""The seeds of a condition as one job: a process starts once, and every case keeps its own log, restart and failure.

Seeds that are finished stay as they are, so that a killed job, one damaged file or a further seed repeats nothing.
"""

import hashlib
import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from millprint.config.sweep import Case
from millprint.dem.resources import Resources
from millprint.records import made_from, record_path

# The longest simulations of a job together [s], by the estimate of millprint.dem.resources: some four times what they
# take.
LONGEST_S = 400
# In the environment of the jobs if the user asked for results to be made again; then no file of an earlier job is kept.
AGAIN_VARIABLE = "MILLPRINT_AGAIN"
# What is appended to the name of a finished case's files if another case of the job has failed.
APART = ".finished"


def condition_of(case: Case) -> str:
    """The path of a case without its seed."""
    return case.path.removesuffix(f"_s{case.seed}")


def seeds_together(
    sources: Iterable[Mapping[str, Case]], estimate: Callable[[Case], Resources]
) -> dict[str, tuple[int, ...]]:
    """Conditions whose seeds are one job, with their seeds in order: short, and more than one.

    sources: cases by path, such as those of a sweep; seeds of different sources are never one job, since somebody who
    asks for the one does not wait for the other. A path counts in the first source that has it.
    """
    known: set[str] = set()
    together = {}
    for cases in sources:
        own: dict[str, list[Case]] = {}
        for path, case in cases.items():
            # A disturbed twin is compared with one run, so that often only one of its seeds is wanted.
            if path not in known and not case.disturbance_m:
                own.setdefault(condition_of(case), []).append(case)
        known.update(cases)
        for condition, group in own.items():
            found = [estimate(case) for case in group]
            short = sum(each.seconds for each in found) <= LONGEST_S and not any(each.needs_own_job for each in found)
            # A condition may have seeds in two sources; those of the first share a job.
            if len(group) > 1 and short and condition not in together:
                together[condition] = tuple(sorted(case.seed for case in group))
    return together


def make_again(wanted: bool) -> None:
    """Tell the jobs that this process starts whether the user wants finished cases again (-F, -R or -f)."""
    if wanted:
        os.environ[AGAIN_VARIABLE] = "1"
    else:
        os.environ.pop(AGAIN_VARIABLE, None)


def origin_digest(values: Sequence[object], files: Iterable[str | Path]) -> str:
    """A digest of everything that a case is computed from: plain values, and files by their content."""
    total = hashlib.sha256(json.dumps(values, sort_keys=True).encode())
    for file in sorted(map(str, files)):
        total.update(Path(file).read_bytes())
    return total.hexdigest()


def is_finished(origin: str, log_path: str | Path, files: Iterable[str | Path]) -> bool:
    """Whether an earlier job has written these files from the same origin, and the user has not asked for new ones.

    A file that was changed since is left as it is, as for every other job: `make verify` decides.
    """
    if os.environ.get(AGAIN_VARIABLE):
        return False
    return made_from(record_path(log_path)) == origin and all(Path(file).is_file() for file in files)


def set_apart(files: Iterable[str | Path]) -> None:
    """Rename the files of a finished case: Snakemake removes the output of a failed job, that of all its cases."""
    for file in files:
        os.replace(file, f"{file}{APART}")


def take_back(files: Iterable[str | Path]) -> None:
    """Give files that were set apart their names again, unless there are newer ones."""
    for file in files:
        if Path(f"{file}{APART}").exists():
            if Path(file).exists():
                os.unlink(f"{file}{APART}")
            else:
                os.replace(f"{file}{APART}", file)
