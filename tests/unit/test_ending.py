"""What a run says at its end: of each target, and of jobs that failed."""

import logging
import re
import subprocess
import sys

import pytest
from snakemake_interface_logger_plugins.common import LogEvent

from millprint.cli.commands import COMMANDS
from millprint.run import plan
from millprint.run.plan import Job, OneLineAJob, duration, endings
from tests.conftest import ROOT

VALUES = {"results": "results", "mill": "emax", "contact": "calibrated", "given": " mine.yaml"}
RULE = re.compile(r"^( *)(?:rule|checkpoint) (\w+):\n((?:\1 +.*\n|\n)*)", re.MULTILINE)


def target_rules() -> set[str]:
    """The rules that say what they are for, which `snakemake --list` shows."""
    files = [ROOT / "workflow/Snakefile", *(ROOT / "workflow/rules").glob("*.smk")]
    rules = [(name, body) for file in files for _, name, body in RULE.findall(file.read_text())]
    return {name for name, body in rules if body.lstrip().startswith('"""')}


def test_every_target_says_at_its_end_what_was_made_and_every_other_rule_says_what_it_does():
    assert target_rules() == set(endings())
    for file in (ROOT / "workflow/rules").glob("*.smk"):
        for _, name, body in RULE.findall(file.read_text()):
            assert name in endings() or re.search(r'^ *message:\n *"[A-Z]', body, re.MULTILINE), f"{file.name}: {name}"


def test_what_to_do_next_is_a_command_that_exists():
    """Each `millprint COMMAND`, and each `millprint run TARGET`, which goes on with the mill of the run."""
    lines = [ending.lines(VALUES)[2] for ending in endings().values()]
    words = [found for line in lines for found in re.findall(r"millprint (\S+) (\S+) (\S+)", line)]
    assert len(words) >= 10 and all(command in COMMANDS for command, _, _ in words)
    runs = [(target, mill) for command, target, mill in words if command == "run"]
    assert all(target in endings() and (mill == "mine.yaml" or target == "all") for target, mill in runs), runs
    assert not any("snakemake" in line for line in lines)


def record(event: LogEvent | None, msg: str = "", **given: object) -> logging.LogRecord:
    return logging.makeLogRecord({"event": event, "msg": msg, **given})


def job_record(jobid: int, message: str) -> logging.LogRecord:
    given = {"jobid": jobid, "rule_name": "run_dem_case", "rule_msg": message, "threads": 1}
    return record(LogEvent.JOB_INFO, **given, output=["a/summary.json"], resources={"processor_s": 8}, reason="files")


def test_a_job_is_one_line_and_the_time_to_go_follows_from_those_that_ended(monkeypatch):
    now = iter([0.0, 20.0])
    monkeypatch.setattr(plan.time, "monotonic", lambda: next(now))
    jobs = [Job("run_dem_case", 1, (f"{case}/summary.json",), {"processor_s": 9}) for case in "abcd"]
    quiet = OneLineAJob(lambda: jobs, lambda: False)
    assert quiet.filter(record(LogEvent.RESOURCES_INFO, cores=2))
    started = job_record(1, "Simulating a")
    assert quiet.filter(started) and started.event is None and started.msg == "Simulating a"
    assert not quiet.filter(record(LogEvent.JOB_FINISHED, job_id=1))
    ended = record(LogEvent.PROGRESS, done=1, total=4)
    job_s = jobs[0].processor_s
    # A tenth of the four jobs counts as done on two cores.
    expected = 3 * job_s * (20 + 0.4 * job_s / 2) / (1.4 * job_s)
    assert quiet.filter(ended) and ended.msg == f"  1 of 4 jobs are done; about {duration(expected)} to go"
    assert not quiet.filter(record(None, "Select jobs to execute..."))
    assert quiet.filter(record(None, "note: the disk")) and quiet.filter(record(LogEvent.JOB_ERROR))


@pytest.mark.parametrize(
    ("typed", "begin", "end"),
    [
        ("fingerprnt", "unknown target; ", "did you mean fingerprint?"),
        ("nosuch", "unknown target; ", ", gallery"),
        ("chapter3", "this target is of the thesis", "run fingerprint"),
    ],
)
def test_an_unknown_target_is_told_with_the_nearest_one(typed, begin, end):
    said = record(
        None, f"MissingRuleException:\nNo rule to produce {typed} (if you use input functions make sure ...)."
    )
    assert OneLineAJob(list, lambda: False).filter(said)
    assert said.msg.startswith(f"error: {typed}: {begin}") and said.msg.endswith(end)


TIMED = """
import threading
from millprint.run.plan import stop_timers_at_the_end

stop_timers_at_the_end()
threading.Timer(600, print, ["too late"]).start()
"""


def test_no_timer_keeps_a_run_from_its_end():
    done = subprocess.run([sys.executable, "-c", TIMED], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout == done.stderr == ""
