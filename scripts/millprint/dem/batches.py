"""Short cases as one job: a process starts once, and every case keeps its own log, restart and failure.

Cases that are finished stay as they are, so that a failed case, one damaged file or a further seed repeats nothing.
If the process of a job is killed, Snakemake removes the files of all its cases.
"""

import hashlib
import json
import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from millprint.config.sweep import Case
from millprint.dem.resources import Resources
from millprint.records import made_from, record_path

# Times by the estimate of millprint.dem.resources, which is two to four times what simulations take [s]: of the longest
# seeds that share a job; of conditions in a job, about; and of the shortest job that is worth its start.
LONGEST_S, BATCH_S, SHORTEST_S = 400, 40, 8
# The short conditions of a sweep are at least so many jobs, if each is worth its start, so that all cores have work.
BATCHES = 4
# Of a sweep that makes more jobs than this, each is longer, up to LONGEST_S: Snakemake and Python take 2 s for a job.
MANY = 200
# Conditions of up to so many seeds share a rule, in which Snakemake looks for a file seed by seed.
FEW_SEEDS = 12
# In the environment of the jobs if the user asked for results to be made again; then no file of an earlier job is kept.
AGAIN_VARIABLE = "MILLPRINT_AGAIN"
# What is appended to the name of a finished case's files if another case of the job has failed.
APART = ".finished"


def condition_of(case: Case) -> str:
    """The path of a case without its seed."""
    return case.path.removesuffix(f"_s{case.seed}")


def batches(
    sources: Iterable[Mapping[str, Case]], estimate: Callable[[Case], Resources], sweeps: Mapping[str, str]
) -> list[tuple[Case, ...]]:
    """The cases that share a job, for each such job: the short seeds of a condition, and short conditions of a sweep.

    sources: cases by path. Cases of different sources never share a job: who asks for one source does not wait for
    another. A path counts in the first source that has it. sweeps: by path, the name of a case's sweep,
    where a source has several: a change of one sweep leaves the jobs of the others as they are, but for sweeps that are
    shorter than a job is worth its start. Those share jobs.
    """
    known: set[str] = set()
    seen: set[str] = set()
    found: list[tuple[Case, ...]] = []
    for cases in sources:
        own: dict[str, list[Case]] = {}
        for path, case in cases.items():
            # A disturbed twin is compared with one run, so that often only one of its seeds is wanted.
            if path not in known and not case.disturbance_m:
                own.setdefault(condition_of(case), []).append(case)
        known.update(cases)
        by_sweep: dict[str, list[tuple[list[Case], list[float]]]] = {}
        for condition, group in own.items():
            group.sort(key=lambda case: case.seed)
            parts = [estimate(case) for case in group]
            # A condition may have seeds in two sources; those of the first share a job.
            if condition not in seen and not any(part.needs_own_job for part in parts):
                times = [part.seconds for part in parts]
                by_sweep.setdefault(sweeps.get(group[0].path, ""), []).append((group, times))
        seen.update(own)
        for conditions in _sweeps_together(by_sweep.values()):
            found += [tuple(batch) for batch in _divided(conditions) if len(batch) > 1]
    return found


def _sweeps_together(
    sweeps: Iterable[list[tuple[list[Case], list[float]]]],
) -> list[list[tuple[list[Case], list[float]]]]:
    """The conditions of each sweep, and those of all sweeps together that are not worth a job."""
    long, quick = [], []
    for conditions in sweeps:
        if sum(sum(times) for _, times in conditions) < SHORTEST_S:
            quick += conditions
        else:
            long.append(conditions)
    return [*long, quick] if quick else long


def _divided(conditions: Sequence[tuple[list[Case], list[float]]]) -> list[list[Case]]:
    """Conditions of a sweep, each with its cases and their times [s], as batches of about the same time, in order."""
    everything = sum(sum(times) for _, times in conditions)
    longest = min(LONGEST_S, max(BATCH_S, everything / MANY))
    whole = [(group, sum(times)) for group, times in conditions if sum(times) <= LONGEST_S]
    short = [(group, seconds) for group, seconds in whole if seconds <= longest]
    total = sum(seconds for _, seconds in short)
    number = max(1, math.ceil(total / min(longest, max(SHORTEST_S, total / BATCHES))))
    divided: dict[int, list[Case]] = {}
    before = 0.0
    for group, seconds in short:
        middle = before + seconds / 2
        divided.setdefault(int(number * middle / total) if total else 0, []).extend(group)
        before += seconds
    parted = [part for group, times in conditions if sum(times) > LONGEST_S for part in _parts(group, times, longest)]
    return [*divided.values(), *(group for group, seconds in whole if seconds > longest), *parted]


def _parts(group: list[Case], times: list[float], longest: float) -> list[list[Case]]:
    """The seeds of a condition that take too long together, in parts of about the longest time [s]."""
    each = max(1, int(longest / max(times)))
    return [group[start : start + each] for start in range(0, len(group), each)]


def by_rule(shared: Iterable[tuple[Case, ...]]) -> tuple[list[tuple[Case, ...]], dict[str, tuple[int, ...]]]:
    """What `batches` found, as the batches that need a rule each, and the seeds of each condition that is one job."""
    single: dict[str, list[tuple[Case, ...]]] = {}
    several = []
    for cases in shared:
        conditions = set(map(condition_of, cases))
        if len(conditions) > 1:
            several.append(cases)
        else:
            single.setdefault(conditions.pop(), []).append(cases)
    whole = {}
    for name, own in single.items():
        if len(own) == 1 and len(own[0]) <= FEW_SEEDS:
            whole[name] = tuple(case.seed for case in own[0])
        else:
            several += own
    return several, whole


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

    A file that was changed since is left as it is, as for every other job: the run reports it at its start.
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
