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

# What Snakemake imports when it starts, and what it imports later to read a Snakefile and to build the graph of jobs.
IMPORTED = (
    *("snakemake.cli", "snakemake.assets", "snakemake.profiles", "snakemake.report", "snakemake.storage"),
    *("docutils.core", "jinja2", "nbformat", "pydantic", "requests", "smart_open", "yaml"),
)


def run(
    arguments: list[str], folder: Path, environment: Mapping[str, str], timeout: float, one_stream: bool
) -> subprocess.CompletedProcess:
    """Run Snakemake with these arguments in `folder`. Both streams are in `stdout` if `one_stream`, else apart."""
    with TemporaryDirectory() as written:
        streams = [str(Path(written, name)) for name in ("out", "out" if one_stream else "err")]
        request = {
            "arguments": arguments,
            "folder": str(folder),
            "environment": dict(environment),
            "streams": streams,
            "timeout": timeout,
        }
        server = _server(environment.get("PYTHONPATH", ""))
        print(json.dumps(request), file=server.stdin, flush=True)
        status = json.loads(server.stdout.readline())
        out, err = (Path(stream).read_text() for stream in streams)
    if status is None:
        raise subprocess.TimeoutExpired(["snakemake", *arguments], timeout, out, err)
    return subprocess.CompletedProcess(["snakemake", *arguments], status, out, err)


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
    """Answer every request on standard input with the exit status of its fork, or null if that took too long."""
    for name in IMPORTED:
        importlib.import_module(name)
    while request := sys.stdin.readline():
        told = json.loads(request)
        timeout = told.pop("timeout")
        child = os.fork()
        if child == 0:
            # Ends with the exit status of Snakemake, after all that is to be done at the end of a process.
            _become_snakemake(**told)
        print(json.dumps(_status_of(child, timeout)), flush=True)


def _become_snakemake(arguments: list[str], folder: str, environment: dict[str, str], streams: list[str]) -> None:
    """Do what `python -m snakemake` does in a shell. Raises SystemExit."""
    from snakemake.cli import main

    os.setsid()
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.path[0], sys.argv = folder, ["snakemake", *arguments]
    # Appended to, so that two descriptors of one file do not write over each other.
    for descriptor, path in enumerate([os.devnull, *streams]):
        opened = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND)
        os.dup2(opened, descriptor)
        os.close(opened)
    main(arguments)


def _status_of(child: int, timeout: float) -> int | None:
    """The exit status of a process; None if it was ended, with all that it had started, after `timeout` seconds."""
    signal.signal(signal.SIGALRM, lambda *_: os.killpg(child, signal.SIGKILL))
    signal.setitimer(signal.ITIMER_REAL, timeout)
    try:
        _, status = os.waitpid(child, 0)
    except KeyboardInterrupt:
        # The keyboard reaches this process, but not the session of the fork.
        os.killpg(child, signal.SIGKILL)
        raise
    late = not signal.getitimer(signal.ITIMER_REAL)[0]
    signal.setitimer(signal.ITIMER_REAL, 0)
    return None if late else os.waitstatus_to_exitcode(status)


if __name__ == "__main__":
    serve()
