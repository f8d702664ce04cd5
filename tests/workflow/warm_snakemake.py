"""Snakemake in forks of a process that has imported it, because importing it takes a third of a dry run.

The fork is a process of its own, in another folder and with the caller's variables. It knows nothing of millprint
before it reads the Snakefile, so that the library is that of its project. As a program, this file is what forks.
"""

import atexit
import importlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.conftest import ROOT
from tests.workflow import warm_scripts

# What Snakemake imports when it starts, and what it imports later to read a Snakefile and to build the graph of jobs.
IMPORTED = (
    *("snakemake.cli", "snakemake.assets", "snakemake.profiles", "snakemake.report", "snakemake.storage"),
    *("docutils.core", "jinja2", "nbformat", "pydantic", "requests", "smart_open", "yaml"),
)


class Started:
    """A fork that runs in parallel with this process, with a process group of its own."""

    def __init__(self, server: subprocess.Popen, pid: int) -> None:
        self.server, self.pid = server, pid
        self.returncode: int | None = None

    def wait(self, timeout: float) -> int:
        """Wait for its end and give its exit status. After `timeout` seconds it is killed: TimeoutExpired."""
        if self.returncode is None:
            self.returncode = _asked(self.server, wait_for=self.pid, timeout=timeout)
            if self.returncode is None:
                raise subprocess.TimeoutExpired("snakemake", timeout)
        return self.returncode

    def poll(self) -> int | None:
        """Its exit status; None as long as it runs."""
        if self.returncode is None:
            self.returncode = _asked(self.server, look_at=self.pid)
        return self.returncode

    def kill(self) -> None:
        """Kill only it, not the processes that it has started."""
        if self.poll() is None:
            os.kill(self.pid, signal.SIGKILL)


def start(arguments: list[str], folder: Path, environment: Mapping[str, str], out: Path, err: Path) -> Started:
    """Start Snakemake with these arguments in `folder`. Its streams are appended to two files, or to one."""
    server = _server(environment.get("PYTHONPATH", ""))
    request = {
        "arguments": arguments,
        "folder": str(folder),
        "environment": dict(environment),
        "streams": [str(out), str(err)],
    }
    return Started(server, _asked(server, start=request))


def run(
    arguments: list[str], folder: Path, environment: Mapping[str, str], timeout: float, one_stream: bool
) -> subprocess.CompletedProcess:
    """Run Snakemake with these arguments in `folder`. Both streams are in `stdout` if `one_stream`, else apart."""
    with TemporaryDirectory() as written:
        streams = [Path(written, name) for name in ("out", "out" if one_stream else "err")]
        started = start(arguments, folder, environment, *streams)
        try:
            status = started.wait(timeout)
        except subprocess.TimeoutExpired:
            texts = (stream.read_text() for stream in streams)
            raise subprocess.TimeoutExpired(["snakemake", *arguments], timeout, *texts) from None
        out, err = (stream.read_text() for stream in streams)
    return subprocess.CompletedProcess(["snakemake", *arguments], status, out, err)


def _asked(server: subprocess.Popen, **request) -> int | None:
    """The answer of the process that forks."""
    print(json.dumps(request), file=server.stdin, flush=True)
    return json.loads(server.stdout.readline())


@cache
def _server(python_path: str) -> subprocess.Popen:
    """The process that forks. It ends with this one."""
    server = subprocess.Popen(
        [sys.executable, "-m", "tests.workflow.warm_snakemake"],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": python_path},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    atexit.register(server.stdin.close)
    return server


def serve() -> None:
    """Answer every request on standard input: start a fork, wait for its end, or look whether it has ended."""
    for name in IMPORTED:
        importlib.import_module(name)
    warm_scripts.import_libraries()
    while line := sys.stdin.readline():
        print(json.dumps(_answer(**json.loads(line))), flush=True)


def _answer(
    start: dict | None = None, wait_for: int | None = None, timeout: float = 0, look_at: int | None = None
) -> int | None:
    """The process id of a fork that was started, or the exit status of one; None if it runs, or took too long."""
    if wait_for:
        return _status_of(wait_for, timeout)
    if look_at:
        ended, status = os.waitpid(look_at, os.WNOHANG)
        return os.waitstatus_to_exitcode(status) if ended else None
    child = os.fork()
    if child == 0:
        # Ends with the exit status of Snakemake.
        _become_snakemake(**start)
    # Here and in the fork: whoever comes first makes the group, which the caller may kill at once.
    os.setpgid(child, child)
    return child


def _become_snakemake(arguments: list[str], folder: str, environment: dict[str, str], streams: list[str]) -> None:
    """Do what `python -m snakemake` does in a shell. Never returns."""
    from snakemake.cli import main

    os.setpgid(0, 0)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.path[0], sys.argv = folder, ["snakemake", *arguments]
    # Appended to, so that two descriptors of one file do not write over each other.
    for descriptor, path in enumerate([os.devnull, *streams]):
        opened = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND)
        os.dup2(opened, descriptor)
        os.close(opened)
    warm_scripts.fork_scripts()
    try:
        main(arguments)
    except SystemExit as ended:
        warm_scripts.end(int(ended.code or 0))


def _status_of(child: int, timeout: float) -> int | None:
    """The exit status of a process; None if it was ended, with all that it had started, after `timeout` seconds."""
    signal.signal(signal.SIGALRM, lambda *_: os.killpg(child, signal.SIGKILL))
    signal.setitimer(signal.ITIMER_REAL, timeout)
    try:
        _, status = os.waitpid(child, 0)
    except KeyboardInterrupt:
        # The keyboard reaches this process, but not the group of the fork.
        os.killpg(child, signal.SIGKILL)
        raise
    late = not signal.getitimer(signal.ITIMER_REAL)[0]
    signal.setitimer(signal.ITIMER_REAL, 0)
    return None if late else os.waitstatus_to_exitcode(status)


if __name__ == "__main__":
    serve()
