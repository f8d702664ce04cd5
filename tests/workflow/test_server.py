"""The server of a run's simulations: whoever is killed, each job is done or fails as without it."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import psutil
import pytest

from millprint.cases.server import SERVER
from tests.conftest import ROOT

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="scripts go on by themselves")

RUN = """
import os, sys
from millprint.cases import server
server.start(sys.executable)
print(os.environ[server.SERVER], flush=True)
sys.stdin.read()
"""
# What a script does by itself or in a fork: it says which processes it has, and goes on as a test asks.
SCRIPT = """
import os, sys, time
from pathlib import Path
{before}
from millprint.cases.server import is_served
if not is_served():
    with open({said!r}, "a") as file:
        file.write(f"{{os.getpid()}} {{os.getppid()}}\\n")
    {then}
    Path({said!r}).with_suffix(".done").touch()
"""
GO_ON = "while not Path({said!r}).with_suffix('.go').exists(): time.sleep(0.01)"


class Job(NamedTuple):
    """A script that runs, and the file in which it says its processes."""

    process: subprocess.Popen
    said: Path

    def processes(self, count: int = 1) -> tuple[psutil.Process, psutil.Process]:
        """The process that simulates and its parent, once that has begun `count` times."""
        wait_for(lambda: self.said.exists() and len(self.said.read_text().splitlines()) >= count)
        last = self.said.read_text().splitlines()[-1]
        return tuple(psutil.Process(int(number)) for number in last.split())

    def go_on(self) -> tuple[int, str]:
        """The exit status and what it prints, after it has been allowed to end."""
        self.said.with_suffix(".go").touch()
        printed, _ = self.process.communicate(timeout=30)
        return self.process.returncode, printed


class Run(NamedTuple):
    """A process that has started a server, and the variable that its jobs have."""

    process: subprocess.Popen
    name: str
    folder: Path

    @property
    def server(self) -> psutil.Process:
        (found,) = psutil.Process(self.process.pid).children()
        return found

    def script(self, then: str = GO_ON, before: str = "") -> Job:
        """Start a script of this run."""
        said = self.folder / "said.txt"
        script = self.folder / "job.py"
        script.write_text(SCRIPT.format(said=str(said), then=then.format(said=str(said)), before=before))
        process = subprocess.Popen(
            [sys.executable, str(script)], env=environment() | {SERVER: self.name}, cwd=self.folder, text=True,
            start_new_session=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        return Job(process, said)


def environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT / "src")}


def wait_for(condition) -> None:
    end = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def is_gone(process: psutil.Process) -> bool:
    """Whether a process has ended, and be it that nobody has asked for its status."""
    return not process.is_running() or process.status() == psutil.STATUS_ZOMBIE


@pytest.fixture(scope="module", autouse=True)
def _interrupts():
    """Where the tests run in the background of a shell, their programs would ignore the interrupt."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@contextmanager
def started(folder: Path) -> Iterator[Run]:
    """A run and its server, which loads what simulations need for the first script that asks."""
    process = subprocess.Popen(
        [sys.executable, "-c", RUN], env=environment(), text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    yield Run(process, process.stdout.readline().strip(), folder)
    process.kill()
    process.communicate()


@pytest.fixture(scope="module")
def long_run(tmp_path_factory) -> Iterator[Run]:
    with started(tmp_path_factory.mktemp("run")) as run:
        yield run


@pytest.fixture
def run(long_run, tmp_path) -> Run:
    """A run whose server has other jobs too: for a test that ends neither of the two."""
    return long_run._replace(folder=tmp_path)


@pytest.fixture
def short_run(tmp_path) -> Iterator[Run]:
    """A run of its own, for a test that ends it or its server."""
    with started(tmp_path) as run:
        yield run


def test_a_fork_does_the_job_and_gives_its_status_and_what_it_prints(run):
    job = run.script(then="print('from', os.getpid()); sys.exit(3)")
    fork, guard = job.processes()
    assert job.go_on() == (3, f"from {fork.pid}\n")
    assert fork.pid != job.process.pid and guard.pid != run.server.pid


def test_the_server_ends_with_its_run_and_the_job_goes_on(short_run):
    job, server = short_run.script(), short_run.server
    fork, _ = job.processes()
    short_run.process.kill()
    wait_for(lambda: is_gone(server))
    assert not is_gone(fork)
    assert job.go_on() == (0, "")
    assert len(job.said.read_text().splitlines()) == 1


def test_without_a_server_scripts_go_on_by_themselves(short_run):
    running, server = short_run.script(), short_run.server
    running.processes()
    server.kill()
    wait_for(lambda: is_gone(server))
    assert running.go_on() == (0, "")
    running.said.with_suffix(".go").unlink()
    later = short_run.script()
    assert later.processes(2)[0].pid == later.process.pid
    assert later.go_on() == (0, "")


def test_a_job_whose_guard_dies_is_done_by_its_script(run):
    job = run.script()
    fork, guard = job.processes()
    guard.kill()
    own, _ = job.processes(2)
    assert own.pid == job.process.pid
    # Its files are closed before it is gone.
    wait_for(lambda: is_gone(fork))
    assert job.go_on() == (0, "")


def test_a_fork_ends_with_its_script(run):
    job = run.script()
    fork, guard = job.processes()
    job.process.kill()
    wait_for(lambda: is_gone(fork) and is_gone(guard))
    assert not job.said.with_suffix(".done").exists()


def test_a_script_ends_as_its_fork(run):
    job = run.script()
    job.processes()[0].kill()
    assert job.process.wait(30) == -signal.SIGKILL


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_to_the_script_reaches_the_fork(run, number):
    job = run.script()
    fork, _ = job.processes()
    job.process.send_signal(number)
    assert job.process.wait(30) == -number
    wait_for(lambda: is_gone(fork))


def test_the_keyboard_interrupts_each_job_once():
    """Snakemake, server and jobs are of one process group."""
    script = ROOT / "tests/workflow/interrupted_job.py"
    process = subprocess.Popen(
        [sys.executable, str(script)], env=environment(), start_new_session=True, text=True, stdout=subprocess.PIPE
    )
    assert process.stdout.readline() == "begun\n"
    os.killpg(process.pid, signal.SIGINT)
    printed, _ = process.communicate(timeout=30)
    assert printed == "interrupted\nended\n"


def test_a_script_of_another_python_goes_on_by_itself(run):
    job = run.script(before="sys.prefix = 'another environment'")
    assert job.processes()[0].pid == job.process.pid
    assert job.go_on() == (0, "")
