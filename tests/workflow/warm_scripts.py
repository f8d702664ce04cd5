"""Scripts of rules in forks of a process that has imported the libraries, which takes most of the time of a small job.

That process belongs to one run of Snakemake, and imports what each script asks of its project's millprint before it
forks, so that a module is imported once in a run; kernels are loaded once too. Scripts of test_kills, and of commands
in a shell, run by themselves.
"""

import ast
import atexit
import gc
import importlib
import io
import json
import os
import runpy
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Mapping
from contextlib import nullcontext, suppress
from pathlib import Path
from subprocess import CalledProcessError, CompletedProcess
from tempfile import NamedTemporaryFile
from threading import Lock
from typing import NoReturn

# What most scripts import, and takes long; none of it starts a thread before it is used.
IMPORTED = (
    *("h5py", "matplotlib.pyplot", "numba", "pandas", "scipy.optimize", "scipy.stats"),
    *("snakemake.iocontainers", "snakemake.logging", "statsmodels.api", "trimesh"),
)
# What functions of a module import, and takes long too.
LATER = {"millprint.thesis.yields.yield_model": ("hyperopt", "shap")}
# Of millprint.cases.server and millprint.checks.check_once, which are not imported here.
SERVER, CHECK = "MILLPRINT_SERVER", "millprint.checks.before_running"
# As Snakemake sets them for a shell.
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def import_libraries() -> None:
    """Import them, and let numba fill its own registries."""
    for name in IMPORTED:
        importlib.import_module(name)
    sys.modules["numba"].njit(_nothing)()
    # No fork need look for garbage in it.
    gc.freeze()


def _nothing() -> None:
    pass


def fork_scripts() -> None:
    """Let the Snakemake that is about to begin in this process have its scripts, and the check before its first job,
    forked by a process without threads.
    """
    from snakemake.benchmark import benchmarked
    from snakemake.script import PythonScript

    requests, received = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    if os.fork() == 0:
        requests.close()
        _serve(received)
    received.close()
    lock = Lock()

    def status_of(request: Mapping, bench_record=None) -> int:
        own, other = socket.socketpair()
        with other, lock:
            socket.send_fds(requests, [json.dumps(request).encode()], [other.fileno()])
        with own, own.makefile() as answers:
            pid = int(answers.readline())
            with nullcontext() if bench_record is None else benchmarked(pid, bench_record):
                return int(answers.readline())

    def execute_script(self: PythonScript, fname: str, edit: bool = False) -> None:
        # Its forks need no other server.
        own = {name: value for name, value in os.environ.items() if name != SERVER}
        variables = dict.fromkeys(THREADS, str(self.threads)) | {"TMPDIR": self.resources["tmpdir"]}
        if status := status_of({"words": [fname], "environment": {**own, **variables}}, self.bench_record):
            raise CalledProcessError(status, ["python", fname])

    def run_command(command: list[str], *further, **options) -> CompletedProcess:
        if CHECK not in command:
            return run(command, *further, **options)
        with NamedTemporaryFile("w") as file:
            file.write(options["input"])
            file.flush()
            words = command[command.index(CHECK) :]
            status = status_of({"words": words, "environment": dict(os.environ), "given": file.name})
        # What it says is printed already.
        return CompletedProcess(command, status, stderr="")

    run, subprocess.run = subprocess.run, run_command
    PythonScript.execute_script = execute_script


def _serve(requests: socket.socket) -> None:
    """Fork a process for each request, until Snakemake ends. Never returns in the process that is called."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    while True:
        message, descriptors, *_ = socket.recv_fds(requests, 1 << 20, 1)
        if not message:
            os._exit(0)
        (answer,) = descriptors
        request = json.loads(message)
        if request["words"][0] != CHECK:
            _prepare(request["words"][0], request["environment"])
        if os.fork() == 0:
            requests.close()
            _watch(answer, **request)
        os.close(answer)


def _prepare(script: str, environment: Mapping[str, str]) -> None:
    """Import the modules of millprint that a script imports, and load the kernels for the first simulation.

    What fails here fails again in the script, which says so.
    """
    tree = ast.parse(Path(script).read_text())
    asked = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module}
    new = sorted(name for name in asked if name.startswith("millprint.") and name not in sys.modules)
    if not new:
        return
    os.environ.update(environment)
    sys.path[:0] = [place for place in _library(environment) if place not in sys.path]
    with suppress(Exception):
        for name in [*new, *(later for module in new for later in LATER.get(module, ()))]:
            importlib.import_module(name)
        if "millprint.dem.run" in new:
            importlib.import_module("millprint.dem.compilation").run_tiny_case()
    gc.freeze()


def _library(environment: Mapping[str, str]) -> list[str]:
    """The folders that come first among those of the libraries."""
    return [place for place in environment.get("PYTHONPATH", "").split(os.pathsep) if place]


def _watch(answer: int, **request) -> None:
    """Start a program; write its process id to `answer` at once and its exit status at its end."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    job = os.fork()
    if job == 0:
        os.close(answer)
        _run(**request)
    os.write(answer, f"{job}\n".encode())
    _, status = os.waitpid(job, 0)
    os.write(answer, f"{os.waitstatus_to_exitcode(status)}\n".encode())
    os._exit(0)


def _run(words: list[str], environment: Mapping[str, str], given: str = os.devnull) -> NoReturn:
    """Do what `python script` or `python -m module` does, with a file as its input. Never returns."""
    os.environ.clear()
    os.environ.update(environment)
    program = words[0]
    sys.path[:1] = [str(Path(program).parent), *_library(environment)]
    sys.argv = words
    if program == CHECK:
        sys.stdin = io.StringIO(Path(given).read_text())
        runpy.run_module(program, run_name="__main__")
    else:
        runpy.run_path(program, run_name="__main__")
    end(0)


def end(status: int) -> NoReturn:
    """End this process as Python does, but for taking apart every module, which takes a fifth of a second."""
    threading._shutdown()
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    os._exit(status)
