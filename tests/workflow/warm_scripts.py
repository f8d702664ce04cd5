"""Scripts of rules in forks of a process that has imported the libraries, which takes most of the time of a small job.

A script begins as it does by itself, with nothing of millprint imported. Those of test_kills, and of commands in a
shell, run by themselves.
"""

import gc
import importlib
import json
import os
import runpy
import signal
import socket
import sys
from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path
from subprocess import CalledProcessError
from threading import Lock

# What takes long to import; none of it starts a thread before it is used.
IMPORTED = (
    *("h5py", "hyperopt", "matplotlib.pyplot", "numba", "pandas", "scipy.optimize", "scipy.stats", "shap"),
    *("sklearn.ensemble", "sklearn.gaussian_process", "snakemake.iocontainers", "snakemake.logging"),
    *("statsmodels.api", "torch_geometric.nn", "trimesh"),
)
# Of millprint.cases.server, which is not imported here.
SERVER = "MILLPRINT_SERVER"
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
    """Let the Snakemake that is about to begin in this process have its scripts forked by a process without threads."""
    from snakemake.benchmark import benchmarked
    from snakemake.script import PythonScript

    requests, received = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    if os.fork() == 0:
        requests.close()
        _serve(received)
    received.close()
    lock = Lock()

    def execute_script(self: PythonScript, fname: str, edit: bool = False) -> None:
        # Its forks need no other server.
        own = {name: value for name, value in os.environ.items() if name != SERVER}
        variables = dict.fromkeys(THREADS, str(self.threads)) | {"TMPDIR": self.resources["tmpdir"]}
        request = {"script": fname, "environment": {**own, **variables}}
        own, other = socket.socketpair()
        with other, lock:
            socket.send_fds(requests, [json.dumps(request).encode()], [other.fileno()])
        with own, own.makefile() as answers:
            pid = int(answers.readline())
            measured = nullcontext() if self.bench_record is None else benchmarked(pid, self.bench_record)
            with measured:
                status = int(answers.readline())
        if status:
            raise CalledProcessError(status, ["python", fname])

    PythonScript.execute_script = execute_script


def _serve(requests: socket.socket) -> None:
    """Fork a process for each request, until Snakemake ends. Never returns in the process that is called."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    while True:
        message, descriptors, *_ = socket.recv_fds(requests, 1 << 20, 1)
        if not message:
            os._exit(0)
        (answer,) = descriptors
        if os.fork() == 0:
            requests.close()
            _watch(answer, **json.loads(message))
        os.close(answer)


def _watch(answer: int, script: str, environment: Mapping[str, str]) -> None:
    """Start a script; write its process id to `answer` at once and its exit status at its end."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    job = os.fork()
    if job == 0:
        os.close(answer)
        _run(script, environment)
    os.write(answer, f"{job}\n".encode())
    _, status = os.waitpid(job, 0)
    os.write(answer, f"{os.waitstatus_to_exitcode(status)}\n".encode())
    os._exit(0)


def _run(script: str, environment: Mapping[str, str]) -> None:
    """Do what `python script` does. Raises SystemExit."""
    os.environ.clear()
    os.environ.update(environment)
    library = environment.get("PYTHONPATH", "").split(os.pathsep)
    sys.path[:1] = [str(Path(script).parent), *filter(None, library)]
    sys.argv = [script]
    runpy.run_path(script, run_name="__main__")
    raise SystemExit
