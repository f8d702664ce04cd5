"""What a run needs of time, memory and disk; a line for each job with the time to go; what to do at its end.

What a simulation takes follows from its case (`millprint.dem.resources`), and a rule that simulates inside declares the
resource `processor_s`. Other jobs count as average ones, except for the longest.

The Snakefile imports this, so no heavy imports here.
"""

import logging
import re
import shlex
import shutil
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from snakemake_interface_logger_plugins.common import LogEvent

from millprint.config.errors import ConfigError
from millprint.config.wording import close_to
from millprint.run.numbers import duration
from millprint.run.outputs import listed_targets

# Processor time to start a job, and a simulation, which is forked (millprint.cases.server) [s].
JOB_START_S, SIMULATION_START_S = 2.0, 0.5
# For a job that declares nothing: near the mean time of the shorter jobs of the thesis and of a smoke run [s], and the
# largest memory of both [MB].
OTHER_S, OTHER_MB, OTHER_DISK_MB = 6.0, 750.0, 2.0
# Jobs of the thesis, at its size, that take much longer: AMD EPYC of type Zen 3; and the kernels' compilation: Intel
# Xeon of type Rocket Lake, November 2026 [s].
LONG_S = {
    "train_surrogate": 500.0,
    "roll_out_surrogate": 65.0,
    "hold_out_yields": 62.0,
    "permute_yields": 45.0,
    "compile_kernels": 33.0,
}


@dataclass(frozen=True)
class Job:
    """A job that is going to run: its rule, threads and files, and what it takes, where that is known [s], [MB]."""

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


# With more targets than this, the lines would not be a summary.
SHOWN_TARGETS = 4


@dataclass(frozen=True)
class Ending:
    """What a target has made, the file to look at first and what it shows, and what to do next."""

    made: str
    look: str
    shows: str
    next: str

    def lines(self, values: Mapping[str, str]) -> list[str]:
        """The three lines, with names of folders and mill in place of their keys."""
        return [
            f"made:  {self.made}".format(**values),
            f"look:  {self.look}: {self.shows}".format(**values),
            f"next:  {self.next}".format(**values),
        ]


@cache
def endings() -> dict[str, Ending]:
    """Every target with its texts."""
    return {name: Ending(**texts) for name, texts in listed_targets().items()}


def given_run(files: Sequence[Path], settings: Mapping[str, object]) -> str:
    """The word after the target in a command that goes on with the same mill, with a blank before it; or nothing.

    files, settings: of --configfile and --config.
    """
    mill = files[-1] if files else settings.get("mill", "")
    return f" {shlex.quote(str(mill))}" if mill else ""


def success_lines(targets: Iterable[str], whole: str, values: Mapping[str, str]) -> list[str]:
    """The lines for the targets of a successful run.

    targets: names of rules or files; without any, and for `all`, the lines of the target `whole`. values: results,
    mill, contact and given (`given_run`). Other names, as of rules of a workflow that uses this one as a module, are
    left out, and targets whose file to look at is not there, as with --until.
    """
    named = [whole if name == "all" else name for name in targets] or [whole]
    known = list(dict.fromkeys(name for name in named if name in endings()))
    known = [name for name in known if Path(endings()[name].look.format(**values)).exists()]
    lines = [line for name in known[:SHOWN_TARGETS] for line in ["", *endings()[name].lines(values)]]
    files = [name for name in named if name not in endings() and Path(name).exists()]
    if files:
        more = f" and {len(files) - 1} more" if len(files) > 1 else ""
        lines += ["", f"made:  {files[0]}{more}", f"look:  {values['results']}/logs has the log of every job"]
        lines += ["next:  millprint plan says what the whole run would make, and how long it takes"]
    return lines


# What Snakemake says about its own work.
OF_SNAKEMAKE = ("Select jobs to execute...", "Execute ", "Using shell:", "Conda environments:", "Reasons:")
UNSAID = {LogEvent.JOB_FINISHED, LogEvent.GROUP_INFO, LogEvent.WORKFLOW_STARTED, LogEvent.JOB_STARTED}
# The share of a run that counts as done in the planned time: one or two jobs say little about the time to go.
PLANNED_SHARE = 0.1


# What it says about a target that is neither a rule nor a file of one.
UNKNOWN = re.compile(r"No rule to produce (\S+) \(if you use input functions")
# Targets of any mill that a run has only with this key.
NEEDED_KEYS = {"match": "mills.match", "scale_up": "mills.scale_up", "validation": "validation.setups"}


def _unknown(target: str) -> str:
    """Why a run does not have a target, and which one may be meant."""
    if "/" in target:
        return "no rule of this run makes this file"
    if target in NEEDED_KEYS:
        return f"this target needs the key {NEEDED_KEYS[target]}, which this run does not have"
    if target in endings():
        return "this target is of the thesis, and this run names a mill: name none, or run fingerprint"
    return f"unknown target{close_to(target, endings())}"


class OneLineAJob(logging.Filter):
    """Makes a line of what Snakemake reports about a job, and leaves out its lists of files.

    waiting: the jobs that are to run, as `millprint plan` counts them. The time to go is the plan's `run_time` of the
    jobs that are left, as much faster or slower as the jobs were that have ended, with PLANNED_SHARE of all. A dry
    run says what one job of each rule does; the table at its end has their number.
    """

    def __init__(self, waiting: Callable[[], Iterable[Job]], dry_run: Callable[[], bool]) -> None:
        super().__init__()
        self.waiting, self.dry_run = waiting, dry_run
        self.planned: list[Job] = []
        self.cores = 1
        self.begin = time.monotonic()
        self.running: dict[int, tuple[str, ...]] = {}
        self.made: set[tuple[str, ...]] = set()
        self.rules: set[str] = set()

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether a record is printed."""
        given, event = vars(record), getattr(record, "event", None)
        if event == LogEvent.JOB_INFO:
            # A file with a flag is reported as `summary.json (update)`.
            self.running[given["jobid"]] = tuple(str(name).partition(" (")[0] for name in given["output"])
            again = self.dry_run() and given["rule_name"] in self.rules
            self.rules.add(given["rule_name"])
            self._say(record, given["rule_msg"] or given["rule_name"])
            return not again
        if event == LogEvent.JOB_FINISHED:
            self.made.add(self.running.pop(given["job_id"], ()))
        elif event == LogEvent.RESOURCES_INFO:
            self.cores = given.get("cores") or given.get("nodes") or self.cores
        elif event == LogEvent.PROGRESS:
            self._say(record, f"  {given['done']} of {given['total']} jobs are done{self._to_go()}")
        elif unknown := UNKNOWN.search(str(record.msg)):
            self._say(record, f"error: {unknown[1]}: {_unknown(unknown[1])}")
        return event not in UNSAID and not (event is None and str(record.msg).startswith(OF_SNAKEMAKE))

    def _to_go(self) -> str:
        """The time to go, in words; empty where nothing is left."""
        self.planned = self.planned or list(self.waiting())
        left = [job for job in self.planned if job.outputs not in self.made]
        if not left:
            return ""
        planned_s, left_s = (sum(job.processor_s for job in jobs) for jobs in (self.planned, left))
        assumed_s = PLANNED_SHARE * planned_s
        pace = (self.cores * (time.monotonic() - self.begin) + assumed_s) / (planned_s - left_s + assumed_s)
        return f"; about {duration(pace * run_time(left, self.cores))} to go"

    @staticmethod
    def _say(record: logging.LogRecord, text: str) -> None:
        """Print a text as it is, in place of what Snakemake makes of the record."""
        record.event, record.msg = None, text


# Snakemake's message about a failed job; that of a job in a group is indented.
FAILED = re.compile(r"^[ \t]*Error in (?:rule|checkpoint) (\w+):\n((?:(?!\s+Error in )[ \t]+.*\n?)*)", re.MULTILINE)
LOG = re.compile(r"^\s+log: (\S+?)(?:,| \(|$)", re.MULTILINE)
OUTPUT = re.compile(r"^\s+output: (\S+?)(?:,|$)", re.MULTILINE)
SCRIPT = re.compile(r"Command '.*\.(\w+)\.py' died with <Signals\.(\w+)")
# A line of a job's own log.
ERROR = re.compile(r"^\S+ \S+ ERROR (.+)$", re.MULTILINE)
SHOWN_JOBS = 5
# What Snakemake says after Ctrl-C; jobs that it ended may be told as failed then.
STOPPED, GOES_ON = "Terminating processes on user request", "the same command goes on where it stopped"
# What a job or Snakemake says where a disk is full, a quota used up, or nothing can be written.
NO_ROOM = re.compile(r"no space left|quota (?:is used up|exceeded)|read-only file system", re.IGNORECASE)
MAKE_ROOM = "make room on the disk of the results, and the same command goes on where it stopped"


@dataclass(frozen=True)
class Failure:
    """A failed job: its rule, its first output, its log."""

    rule: str
    output: str
    log: str

    @property
    def reason(self) -> str:
        """The last error in the job's own log; empty if it has none, as after a kill."""
        try:
            found = ERROR.findall(Path(self.log).read_text(errors="replace"))
        except OSError:
            return ""
        return found[-1] if found else ""


def failures_of(text: str) -> list[Failure]:
    """The failed jobs in a log of Snakemake, in order, each once."""
    found: dict[tuple[str, str], Failure] = {}
    for rule, block in FAILED.findall(text):
        log, output = (match.group(1) if (match := pattern.search(block)) else "" for pattern in (LOG, OUTPUT))
        found[rule, log] = Failure(rule, output, log)
    return list(found.values())


def failure_lines(snakemake_logs: Sequence[str | Path]) -> list[str]:
    """The failed jobs of a run, and what to try, even if the logs of Snakemake name no failed job."""
    text = "".join(Path(log).read_text(errors="replace") for log in snakemake_logs if Path(log).is_file())
    failures, killed = failures_of(text), {signal for _, signal in SCRIPT.findall(text)}
    if STOPPED in text:
        return ["", f"stopped: what was finished before is kept; {GOES_ON}"]
    lines = ["", f"failed: {len(failures)} {'job' if len(failures) == 1 else 'jobs'}; what was finished before is kept"]
    for each in failures[:SHOWN_JOBS]:
        lines.append(f"  {each.rule}{f' for {each.output}' if each.output else ''}")
        if each.log:
            lines.append(f"    log: {each.log}{f': {each.reason}' if each.reason else ''}")
    if len(failures) > SHOWN_JOBS:
        lines.append(f"  and {len(failures) - SHOWN_JOBS} more; all are in {', '.join(map(str, snakemake_logs))}")
    full = NO_ROOM.search("\n".join([text, *(each.reason for each in failures)]))
    return [*lines, f"try:    {f'{full[0].lower()}: {MAKE_ROOM}' if full else advice(killed)}"]


def advice(signals: set[str]) -> str:
    """What to try after jobs that were ended by these signals, or failed on their own."""
    if "SIGKILL" in signals:
        return "a job was killed from outside, most often for lack of memory: the same command with fewer --cores"
    if signals & {"SIGTERM", "SIGINT"}:
        return f"the run was stopped: {GOES_ON}"
    return "fix what the log says, then the same command goes on; snakemake -n says what is left to do"


def stop_timers_at_the_end() -> None:
    """Let no timer keep this process from its end.

    Whenever Snakemake checks the waiting jobs, it sets a timer to check again after `max-jobs-per-timespan`, and it
    exits only after the last timer. A run that has ended does not need them. As a part of another workflow, whose
    handlers of the end are its own, a run knows its end only by that of the main thread.
    """

    def stop() -> None:
        threading.main_thread().join()
        for thread in threading.enumerate():
            if isinstance(thread, threading.Timer):
                thread.cancel()

    threading.Thread(target=stop, daemon=True).start()
