"""The estimate of a plan: by stage and in all, and of each target that was asked for."""

import shutil
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from millprint.plan.costs import BALL_STEP_S, Cost, cost_of, measured_rows, own_ball_step
from millprint.plan.jobs import PlannedJob, needed_for
from millprint.plan.timetable import Timetable, timetable


@dataclass(frozen=True)
class Part:
    """A part of a plan: jobs to run for the first time, to run again, and done; what those that run take together.

    longest: place of the job that takes longest, None if nothing runs.
    """

    new: int
    again: int
    done: int
    processor_s: float
    disk_mb: float
    longest: int | None


@dataclass(frozen=True)
class Estimate:
    """The estimate of a plan, with the costs of the jobs that run, by their place.

    present_mb: size of the results that exist. own_speed: whether the speed of simulations is that of finished ones.
    """

    jobs: tuple[PlannedJob, ...]
    costs: dict[int, Cost]
    stages: dict[str, Part]
    whole: Part
    wall: dict[int, Timetable]
    present_mb: float
    ball_step_s: float
    own_speed: bool


def estimate_plan(jobs: Sequence[PlannedJob], run: str, cores: Iterable[int]) -> Estimate:
    """Estimate a plan on several numbers of cores. run: name of the run that is planned (the key `name`)."""
    rows = measured_rows()
    finished = [path for job in jobs if job.cases and not job.missing for path in job.outputs if path.suffix == ".json"]
    own = own_ball_step(finished)
    speed = own or BALL_STEP_S
    costs = {place: cost_of(job, run, rows, speed) for place, job in enumerate(jobs) if job.needed and job.stage}
    staged = dict.fromkeys(job.stage for job in jobs if job.stage)
    stages = {stage: part_of(jobs, costs, (i for i, job in enumerate(jobs) if job.stage == stage)) for stage in staged}
    return Estimate(
        jobs=tuple(jobs),
        costs=costs,
        stages=stages,
        whole=part_of(jobs, costs, range(len(jobs))),
        wall={number: walled(jobs, costs, costs, number) for number in cores},
        present_mb=sum(path.stat().st_size for job in jobs for path in job.outputs if path.is_file()) / 1e6,
        ball_step_s=speed,
        own_speed=own is not None,
    )


def part_of(jobs: Sequence[PlannedJob], costs: dict[int, Cost], places: Iterable[int]) -> Part:
    """Add up jobs. Targets, which make no file, are not counted."""
    chosen = [place for place in places if jobs[place].stage]
    running = [place for place in chosen if place in costs]
    again = sum(not jobs[place].missing for place in running)
    return Part(
        new=len(running) - again,
        again=again,
        done=len(chosen) - len(running),
        processor_s=sum(costs[place].processor_s for place in running),
        disk_mb=sum(costs[place].disk_mb for place in running),
        longest=max(running, key=lambda place: costs[place].processor_s, default=None),
    )


def walled(jobs: Sequence[PlannedJob], costs: dict[int, Cost], places: Iterable[int], cores: int) -> Timetable:
    """The time of some of the jobs on `cores` cores. A job with threads takes its processor time over their number."""
    seconds = {place: costs[place].processor_s / min(jobs[place].threads, cores) for place in places}
    return timetable(jobs, seconds, {place: costs[place].memory_mb for place in seconds}, cores)


def target_parts(estimate: Estimate, targets: dict[str, int], cores: int) -> dict[str, tuple[Part, Timetable]]:
    """What each target takes by itself, by its name. targets: the places of their jobs."""
    found = {}
    for name, last in targets.items():
        places = needed_for(estimate.jobs, last)
        running = [place for place in places if place in estimate.costs]
        part = part_of(estimate.jobs, estimate.costs, sorted(places))
        found[name] = part, walled(estimate.jobs, estimate.costs, running, cores)
    return found


def free_mb(folder: str | Path) -> float:
    """Free space of the disk that holds a folder, or will hold it [MB]."""
    path = Path(folder).absolute()
    while not path.exists():
        path = path.parent
    return shutil.disk_usage(path).free / 1e6
