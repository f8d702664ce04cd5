"""Commands that only read change no file, even if a result is damaged and a killed run has left its lock."""

import hashlib
import os
import signal
import time
from pathlib import Path

import pytest

from tests.workflow import warm_snakemake
from tests.workflow.conftest import active_environment, ask_snakemake, copy_project, run_snakemake, share_checks

CONFIGURATION = ("--configfile", "config/smoke.yaml")
RESULT = "results/doe/anova_printed.tsv"
# Made from RESULT, and shown in the report.
REPORTED = "results/doe/pareto.svg"
# Logs and caches of a dry run: of Snakemake, and what the source files compute.
LOGS_AND_CACHES = (".snakemake/log", ".snakemake/iocache", ".numba_cache/parsed-")


def state_of(project: Path) -> dict[str, tuple[int, str]]:
    """Modification time [ns] and digest of every file, except LOGS_AND_CACHES."""
    files = (path for path in sorted(project.rglob("*")) if path.is_file() and "__pycache__" not in path.parts)
    names = {str(path.relative_to(project)): path for path in files}
    return {
        name: (path.stat().st_mtime_ns, hashlib.sha256(path.read_bytes()).hexdigest())
        for name, path in names.items()
        if not name.startswith(LOGS_AND_CACHES)
    }


@pytest.fixture(scope="module")
def disturbed(tmp_path_factory) -> Path:
    """A project with a changed result and the lock of a killed run."""
    project = copy_project(tmp_path_factory.mktemp("reading") / "millprint")
    share_checks(project)
    done = run_snakemake(project, *CONFIGURATION, "--", RESULT, REPORTED, timeout=600)
    assert done.returncode == 0, done.stdout[-4000:]
    with (project / RESULT).open("a") as file:
        file.write("a line more\n")
    words = ["--cores", "1", *CONFIGURATION, "--", "results/dem/kernels.json"]
    said = project.parent / "session.log"
    session = warm_snakemake.start(words, project, active_environment(), said, said)
    log = project / "results/logs/dem/compile_kernels.log"
    end = time.monotonic() + 120
    while not log.exists():
        assert session.poll() is None, said.read_text()
        assert time.monotonic() < end
        time.sleep(0.1)
    os.killpg(session.pid, signal.SIGKILL)
    session.wait(timeout=60)
    assert list((project / ".snakemake/locks").iterdir())
    return project


# Those that read most: the others, such as --list-target-rules and --rulegraph, read parts of it.
COMMANDS = {
    "dry run": ["-n"],
    "summary": ["--detailed-summary", "--", REPORTED],
    "report": ["--report", "report.html", REPORTED],
    "dry run on a cluster": ["-n", "--profile", "profiles/slurm", RESULT],
}


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_a_command_that_reads_changes_no_file_and_needs_no_cores(disturbed, command):
    before = state_of(disturbed)
    done = ask_snakemake(disturbed, *CONFIGURATION, *command)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    assert "Traceback" not in done.stderr
    # The file that --report writes.
    (disturbed / "report.html").unlink(missing_ok=True)
    assert state_of(disturbed) == before
    assert "changed:" not in done.stdout + done.stderr


def test_a_run_and_a_touch_stop_at_a_lock_and_change_nothing(disturbed):
    before = state_of(disturbed)
    for command in (["--touch", "--cores", "1"], ["--cores", "1"]):
        done = ask_snakemake(disturbed, *CONFIGURATION, *command, "--force", "results/dem/kernels.json")
        assert done.returncode == 1
        assert "cannot be locked" in done.stderr
        assert state_of(disturbed) == before
