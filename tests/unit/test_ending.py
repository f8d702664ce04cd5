"""What a run says at its end: of each target, and of jobs that failed."""

import logging
import re
import threading
from pathlib import Path

import pytest
from snakemake_interface_logger_plugins.common import LogEvent

from millprint.cli.commands import COMMANDS
from millprint.run import ending
from millprint.run.ending import (
    OneLineAJob,
    advice,
    endings,
    failure_lines,
    failures_of,
    given_run,
    stop_timers,
    success_lines,
)
from millprint.run.plan import Job, duration
from tests.conftest import ROOT

VALUES = {"results": "results", "mill": "emax", "contact": "calibrated", "given": " mine.yaml"}
RULE = re.compile(r"^( *)(?:rule|checkpoint) (\w+):\n((?:\1 +.*\n|\n)*)", re.MULTILINE)

# The log of Snakemake after a job that failed, one that was killed, and a second try of the first.
LOG = """
[Mon Nov 23 02:01:18 2026]
Error in rule permute_yields:
    message: None
    jobid: 339
    input: results/yield/train.tsv, results/yield/test.tsv
    output: results/yield/permutations.tsv, results/yield/permutation_test.tsv
    log: {log} (check log file(s) for error details)
RuleException:
CalledProcessError in file "/home/x/workflow/rules/dem.smk", line 48:
Command 'set -euo pipefail;  python3 /x/tmpqz7tnwkn.run_dem_case.py' died with <Signals.SIGKILL: 9>.
[Mon Nov 23 02:01:18 2026]
Error in rule run_dem_case:
    message: None
    jobid: 393
    output: results/dem/a/b/c/run.h5, results/dem/a/b/c/summary.json
    log: results/logs/dem/a/b/c.log (check log file(s) for error details)
Error in rule permute_yields:
    jobid: 339
    output: results/yield/permutations.tsv, results/yield/permutation_test.tsv
    log: {log} (check log file(s) for error details)
"""

# The same of two jobs in a group.
GROUP_LOG = """
[Thu Nov 26 08:27:03 2026]
    message: Error in group simulations
    jobs:
        rule run_dem_case:
            jobid: 0
            output: results/dem/a/b/c/run.h5, results/dem/a/b/c/summary.json
    [Thu Nov 26 08:27:03 2026]
    Error in rule run_dem_case:
        jobid: 0
        output: results/dem/a/b/c/run.h5, results/dem/a/b/c/summary.json
        log: results/logs/dem/a/b/c.log (check log file(s) for error details)
    [Thu Nov 26 08:27:03 2026]
    Error in rule run_dem_case:
        jobid: 1
        output: results/dem/a/b/d/run.h5, results/dem/a/b/d/summary.json
        log: results/logs/dem/a/b/d.log (check log file(s) for error details)
Trying to restart job 7.
"""


def target_rules() -> set[str]:
    """The rules that only collect files."""
    files = [ROOT / "workflow/Snakefile", *(ROOT / "workflow/rules").glob("*.smk")]
    rules = [(name, body) for file in files for _, name, body in RULE.findall(file.read_text())]
    return {name for name, body in rules if "output:" not in body}


def test_every_target_says_at_its_end_what_was_made_and_every_rule_says_what_it_does():
    assert target_rules() == set(endings())
    for file in (ROOT / "workflow/rules").glob("*.smk"):
        for _, name, body in RULE.findall(file.read_text()):
            assert re.search(r'^ *message:\n *"[A-Z]', body, re.MULTILINE), f"{file.name}: {name}"


def test_a_target_ends_with_three_lines_about_this_mill():
    lines = success_lines(["fingerprint"], "fingerprint", VALUES | {"mill": "mine", "results": "here"})
    assert [line.split(":")[0] for line in lines] == ["", "made", "look", "next"]
    assert "mine" in lines[1]
    assert lines[2].startswith("look:  here/mills/mine/fingerprint.svg: ")


def test_a_run_without_a_target_is_that_of_the_chapters_or_of_a_fingerprint():
    for words in ([], ["all"]):
        assert success_lines(words, "all", VALUES)[1] == f"made:  {endings()['all'].made}"
        assert "fingerprint of mill emax" in success_lines(words, "fingerprint", VALUES)[1]


def test_files_are_named_and_names_of_another_workflow_are_left_out(tmp_path):
    file = tmp_path / "a.tsv"
    file.touch()
    lines = success_lines([str(file), "mill_fingerprint"], "all", VALUES)
    assert lines[1] == f"made:  {file}"
    assert len(lines) == 4
    assert success_lines(["mill_fingerprint"], "all", VALUES) == []


def test_failed_jobs_are_listed_once_with_their_logs_and_the_last_error(tmp_path):
    own, log = tmp_path / "permute.log", tmp_path / "snakemake.log"
    own.write_text(
        "2026-11-23 02:01:17 INFO permute yields: begin\n2026-11-23 02:01:18 ERROR a.tsv: row 3: yield = 130 %\n"
    )
    log.write_text(LOG.format(log=own))
    assert [(each.rule, each.output) for each in failures_of(log.read_text())] == [
        ("permute_yields", "results/yield/permutations.tsv"),
        ("run_dem_case", "results/dem/a/b/c/run.h5"),
    ]
    lines = failure_lines([log])
    assert lines[1].startswith("failed: 2 jobs")
    assert f"    log: {own}: a.tsv: row 3: yield = 130 %" in lines
    assert "    log: results/logs/dem/a/b/c.log" in lines
    assert "memory" in lines[-1]


def test_a_full_disk_is_what_to_look_at(tmp_path):
    log = tmp_path / "snakemake.log"
    log.write_text(f"WorkflowError:\nOSError: [Errno 28] No space left on device\n{LOG.format(log='none')}")
    assert failure_lines([log])[-1] == (
        "try:    no space left: make room on the disk of the results, and the same command goes on where it stopped"
    )


def test_a_log_of_snakemake_that_is_gone_is_no_second_failure(tmp_path):
    assert failure_lines([tmp_path / "none.log"])[1].startswith("failed: 0 jobs")


@pytest.mark.parametrize(
    ("signals", "word"), [({"SIGTERM"}, "stopped"), ({"SIGKILL", "SIGTERM"}, "memory"), (set(), "fix")]
)
def test_what_to_try_depends_on_how_jobs_ended(signals, word):
    assert word in advice(signals)


def test_a_run_that_has_ended_waits_for_no_timer():
    timer = threading.Timer(60, lambda: None)
    timer.start()
    stop_timers()
    timer.join(timeout=10)
    assert not timer.is_alive()


def test_what_to_do_next_is_a_command_that_exists():
    """Each `millprint COMMAND`, and each `millprint run TARGET`, which goes on with the mill of the run."""
    lines = [ending.lines(VALUES)[2] for ending in endings().values()]
    words = [found for line in lines for found in re.findall(r"millprint (\S+) (\S+) (\S+)", line)]
    assert len(words) >= 10 and all(command in COMMANDS for command, _, _ in words)
    runs = [(target, mill) for command, target, mill in words if command == "run"]
    assert all(target in endings() and (mill == "mine.yaml" or target == "all") for target, mill in runs), runs
    assert not any("snakemake" in line for line in lines)


def test_the_mill_of_a_run_is_named_in_its_next_command():
    assert given_run([Path("a mill.yaml")], {"mill": "x"}) == " 'a mill.yaml'"
    assert given_run([], {"mill": "planetary"}) == " planetary" and given_run([], {}) == ""


def record(event: LogEvent | None, msg: str = "", **given: object) -> logging.LogRecord:
    return logging.makeLogRecord({"event": event, "msg": msg, **given})


def job_record(jobid: int, message: str) -> logging.LogRecord:
    given = {"jobid": jobid, "rule_name": "run_dem_case", "rule_msg": message, "threads": 1}
    return record(LogEvent.JOB_INFO, **given, output=["a/summary.json"], resources={"processor_s": 8}, reason="files")


def test_a_job_is_one_line_and_the_time_to_go_follows_from_those_that_ended(monkeypatch):
    now = iter([0.0, 20.0])
    monkeypatch.setattr(ending.time, "monotonic", lambda: next(now))
    jobs = [Job("run_dem_case", 1, (f"{case}/summary.json",), {"processor_s": 8}) for case in "abcd"]
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


def test_a_dry_run_has_one_line_for_each_rule():
    quiet = OneLineAJob(list, lambda: True)
    assert [quiet.filter(job_record(number, "Simulating")) for number in range(3)] == [True, False, False]


def test_every_job_that_failed_in_a_group_is_named():
    assert [(each.output, each.log) for each in failures_of(GROUP_LOG)] == [
        ("results/dem/a/b/c/run.h5", "results/logs/dem/a/b/c.log"),
        ("results/dem/a/b/d/run.h5", "results/logs/dem/a/b/d.log"),
    ]
