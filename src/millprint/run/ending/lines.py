"""What a run prints: a line for each job, and the time to go. The Snakefile imports this, so no heavy imports here."""

import logging
import re
import time
from collections.abc import Callable, Iterable

from snakemake_interface_logger_plugins.common import LogEvent

from millprint.config.wording import close_to
from millprint.run.ending.success import endings
from millprint.run.plan import Job, duration

# What Snakemake says about its own work.
OF_SNAKEMAKE = ("Select jobs to execute...", "Execute ", "Using shell:", "Conda environments:", "Reasons:")
UNSAID = {LogEvent.JOB_FINISHED, LogEvent.GROUP_INFO, LogEvent.WORKFLOW_STARTED, LogEvent.JOB_STARTED}


# What it says about a target that is neither a rule nor a file of one; files of this workflow have a /.
UNKNOWN = re.compile(r"No rule to produce ([^/\s]+) \(if you use input functions")


class OneLineAJob(logging.Filter):
    """Makes a line of what Snakemake reports about a job, and leaves out its lists of files.

    waiting: the jobs that are to run, as `millprint plan` counts them. The time to go is that of their plan, as much
    faster or slower as the jobs were that have ended. A dry run says what one job of each rule does; the table at its
    end has their number.
    """

    def __init__(self, waiting: Callable[[], Iterable[Job]], dry_run: Callable[[], bool]) -> None:
        super().__init__()
        self.waiting, self.dry_run = waiting, dry_run
        self.planned_s: float | None = None
        self.done_s, self.begin = 0.0, time.monotonic()
        self.running: dict[int, float] = {}
        self.rules: set[str] = set()

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether a record is printed."""
        given, event = vars(record), getattr(record, "event", None)
        if event == LogEvent.JOB_INFO:
            self.running[given["jobid"]] = job_of(record).processor_s
            again = self.dry_run() and given["rule_name"] in self.rules
            self.rules.add(given["rule_name"])
            self._say(record, given["rule_msg"] or given["rule_name"])
            return not again
        if event == LogEvent.JOB_FINISHED:
            self.done_s += self.running.pop(given["job_id"], 0.0)
        elif event == LogEvent.PROGRESS:
            self._say(record, f"  {given['done']} of {given['total']} jobs are done{self._to_go()}")
        elif unknown := UNKNOWN.search(str(record.msg)):
            self._say(record, f"error: {unknown[1]}: unknown target{close_to(unknown[1], endings())}")
        return event not in UNSAID and not (event is None and str(record.msg).startswith(OF_SNAKEMAKE))

    def _to_go(self) -> str:
        """The time to go, in words; empty before the first job has ended."""
        if self.planned_s is None:
            self.planned_s = sum(job.processor_s for job in self.waiting())
        left_s, spent = self.planned_s - self.done_s, time.monotonic() - self.begin
        return f"; about {duration(left_s * spent / self.done_s)} to go" if self.done_s and left_s > 0 else ""

    @staticmethod
    def _say(record: logging.LogRecord, text: str) -> None:
        """Print a text as it is, in place of what Snakemake makes of the record."""
        record.event, record.msg = None, text


def job_of(record: logging.LogRecord) -> Job:
    """A job, as Snakemake reports it to every logger."""
    given = vars(record)
    resources = {name: value for name, value in given["resources"].items() if isinstance(value, int | float)}
    # A file with a flag is reported as `summary.json (update)`.
    outputs = tuple(str(name).partition(" (")[0] for name in given["output"])
    return Job(given["rule_name"], given["threads"], outputs, resources)
