"""What failed in a run, where the log is, and what to try. The Snakefile imports this, so no heavy imports here."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

# Snakemake's message about a failed job; that of a job in a group is indented.
FAILED = re.compile(r"^[ \t]*Error in (?:rule|checkpoint) (\w+):\n((?:(?!\s+Error in )[ \t]+.*\n?)*)", re.MULTILINE)
LOG = re.compile(r"^\s+log: (\S+?)(?:,| \(|$)", re.MULTILINE)
OUTPUT = re.compile(r"^\s+output: (\S+?)(?:,|$)", re.MULTILINE)
SCRIPT = re.compile(r"Command '.*\.(\w+)\.py' died with <Signals\.(\w+)")
# A line of a job's own log.
ERROR = re.compile(r"^\S+ \S+ ERROR (.+)$", re.MULTILINE)
SHOWN = 5
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
    lines = ["", f"failed: {len(failures)} {'job' if len(failures) == 1 else 'jobs'}; what was finished before is kept"]
    for each in failures[:SHOWN]:
        lines.append(f"  {each.rule}{f' for {each.output}' if each.output else ''}")
        if each.log:
            lines.append(f"    log: {each.log}{f': {each.reason}' if each.reason else ''}")
    if len(failures) > SHOWN:
        lines.append(f"  and {len(failures) - SHOWN} more; all are in {', '.join(map(str, snakemake_logs))}")
    full = NO_ROOM.search("\n".join([text, *(each.reason for each in failures)]))
    return [*lines, f"try:    {f'{full[0].lower()}: {MAKE_ROOM}' if full else advice(killed)}"]


def advice(signals: set[str]) -> str:
    """What to try after jobs that were ended by these signals, or failed on their own."""
    if "SIGKILL" in signals:
        return "a job was killed from outside, most often for lack of memory: the same command with fewer --cores"
    if signals & {"SIGTERM", "SIGINT"}:
        return "the run was stopped: the same command goes on where it stopped"
    return "fix what the log says, then the same command goes on; snakemake -n says what is left to do"
