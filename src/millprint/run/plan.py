"""What a run needs: time, memory and disk of the jobs that Snakemake is going to run.

A rule that simulates declares the resources `processor_s`, `mem_mb` and `disk_mb`, computed from its cases
(`millprint.dem.resources`). Other jobs count as average ones, except for the longest.
"""

import shutil
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from millprint.config.errors import ConfigError


def duration(seconds: float) -> str:
    """A time in words: 40 s, 3 min 20 s, 40 min, 2 h 5 min."""
    minutes, rest = divmod(round(seconds), 60)
    if not minutes:
        return f"{rest} s"
    hours, left = divmod(minutes, 60)
    if hours:
        return f"{hours} h {left} min"
    return f"{minutes} min" if minutes >= 10 else f"{minutes} min {rest} s"


# Processor time to start a job, and a simulation, which is forked (millprint.cases.server) [s].
JOB_START_S, SIMULATION_START_S = 2.0, 0.5
# For a job that declares nothing: near the mean time of the shorter jobs of the thesis and of a smoke run [s], and the
# largest memory of both [MB].
OTHER_S, OTHER_MB, OTHER_DISK_MB = 6.0, 750.0, 2.0
# Jobs of the thesis, at its size, that take much longer, and the kernels' compilation: AMD EPYC of type Zen 3, November
# 2026 [s].
LONG_S = {
    "train_surrogate": 500.0,
    "roll_out_surrogate": 65.0,
    "hold_out_yields": 62.0,
    "permute_yields": 45.0,
    "compile_kernels": 44.0,
}


@dataclass(frozen=True)
class Job:
    """A job that is going to run: its rule, threads and files, and what its rule declares [s], [MB]."""

    rule: str
    threads: int
    outputs: tuple[str, ...]
    resources: Mapping[str, float]

    @property
    def start_s(self) -> float:
        """Processor time of its start [s]."""
        return SIMULATION_START_S if self.simulations else JOB_START_S

    @property
    def processor_s(self) -> float:
        """Processor time, start included [s]."""
        return self.start_s + (self.resources.get("processor_s") or LONG_S.get(self.rule, OTHER_S))

    @property
    def processor_max_s(self) -> float:
        """Processor time where a window has to grow to its limit, start included [s]."""
        return max(self.processor_s, self.start_s + self.resources.get("processor_max_s", 0.0))

    @property
    def memory_mb(self) -> float:
        """Largest memory [MB]."""
        return self.resources.get("mem_mb", OTHER_MB)

    @property
    def disk_mb(self) -> float:
        """Size of its files [MB]."""
        return self.resources.get("disk_mb", OTHER_DISK_MB)

    @property
    def simulations(self) -> int:
        """Simulations whose files the job writes; a job may simulate more inside."""
        return sum(Path(name).name == "summary.json" for name in self.outputs)


def run_time(jobs: Sequence[Job], cores: int) -> float:
    """Time of a run on some cores [s]: all jobs divided by the cores, or the longest job if that is longer.

    A run takes longer where jobs wait for each other while cores are free.
    """
    longest = max(job.processor_s / min(job.threads, cores) for job in jobs)
    return max(longest, sum(job.processor_s for job in jobs) / cores)


def plan_text(jobs: Sequence[Job], cores: int) -> str:
    """What the jobs need, in lines, with a remark if the disk is too small."""
    if not jobs:
        return "Everything is done; a run has nothing to do."
    longest = max(jobs, key=lambda job: job.processor_s)
    inside = sorted({job.rule for job in jobs if job.resources.get("processor_s") and not job.simulations})
    memory = sum(sorted((job.memory_mb for job in jobs), reverse=True)[:cores])
    disk, free = sum(job.disk_mb for job in jobs), free_mb(jobs[0].outputs)
    likely, most = (sum(getattr(job, name) for job in jobs) for name in ("processor_s", "processor_max_s"))
    limit = f", at most {duration(most)} until powers are known" if most > likely else ""
    more = f", and more inside {', '.join(inside)}" if inside else ""
    lines = [
        f"simulations  {sum(job.simulations for job in jobs)}{more}",
        f"time         about {duration(run_time(jobs, cores))} on {cores} core{'s' * (cores > 1)}; "
        f"{duration(likely)} of one processor{limit}; "
        f"the longest job, {longest.rule}, {duration(longest.processor_s)}",
        f"memory       up to {in_megabytes(memory)} for the largest jobs at the same time",
        f"disk         about {in_megabytes(disk)} more; {in_megabytes(free)} are free",
    ]
    return "\n".join([*lines, *(["             THE DISK IS TOO SMALL"] if disk > free else [])])


def free_mb(files: Iterable[str]) -> float:
    """Free space of the disk where the first of some files is or will be [MB]."""
    path = Path(next(iter(files), ".")).absolute()
    while not path.exists():
        path = path.parent
    return shutil.disk_usage(path).free / 1e6


def in_megabytes(value: float) -> str:
    """A size [MB] in words."""
    return f"{value:.0f} MB" if value < 1000 else f"{value / 1000:.1f} GB"


def check_disk(jobs: Sequence[Job], results: str) -> None:
    """Raise ConfigError, in one line, if `results` cannot be written, or the files of the jobs have no room there."""
    place = Path(results).absolute()
    while not place.exists():
        place = place.parent
    try:
        with tempfile.TemporaryFile(dir=place):
            pass
    except OSError as error:
        raise ConfigError(
            f"{results}: nothing can be written there ({error.strerror}); run in a folder of yours, or name another "
            "one with the key `results`"
        ) from None
    needed, free = sum(job.disk_mb for job in jobs), free_mb([results])
    if needed > free:
        raise ConfigError(
            f"{results}: the run needs about {in_megabytes(needed)} and {in_megabytes(free)} are free on that disk; "
            "make room and run the same command again"
        )
