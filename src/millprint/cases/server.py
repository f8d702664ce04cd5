"""Simulations in forks of one process that has loaded what a case needs, kernels included: loading takes a second.

A run of Snakemake on this machine starts the process (`start`), which ends with the run, however that ends: it waits
for the end of a pipe. The script of a simulation asks it (`is_served`), and a fork then runs the same script, so that
a job is one case, with its files, log, exit status and signals. Where nobody answers, the script goes on by itself, to
the same bytes: on a cluster, in another environment or container, for another user, and without Linux.

A job has three processes: its script, which waits; a guard, forked by the server, which waits for both others; and the
fork that simulates, which ends with its guard. A guard ends with its script. A script whose guard has died simulates
by itself, from the restart file.
"""

import atexit
import gc
import json
import os
import runpy
import select
import signal
import socket
import struct
import subprocess
import sys
import time
from typing import NoReturn

import millprint

# Set by `start` for the jobs of a run: the name of the server's socket.
SERVER = "MILLPRINT_SERVER"
PASSED_ON = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
# In this time a signal of the keyboard has reached every process of a job [s].
AT_ONCE_S = 0.05
NUMBER = struct.Struct("i")
# prctl(2): the signal that a process gets when the one that forked it ends.
PR_SET_PDEATHSIG = 1


def start(python: str) -> None:
    """Start the server for the jobs of this process; nothing is loaded before the first simulation asks.

    python: the program. The socket has a name of Linux's own and no file that could be left behind.
    """
    if not hasattr(os, "pidfd_open") or not sys.platform.startswith("linux"):
        return
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind("")
        listener.listen(socket.SOMAXCONN)
        server = subprocess.Popen(
            [python, "-P", "-m", __name__, str(listener.fileno())],
            stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, pass_fds=[listener.fileno()],
        )  # fmt: skip
        os.environ[SERVER] = listener.getsockname()[1:].decode()
    assert server.stdin
    # A kill closes the pipe too.
    atexit.register(server.stdin.close)


def is_served() -> bool:
    """Whether the server of the run has done the job of this script; if it failed there, this process ends alike."""
    name = os.environ.pop(SERVER, "")
    if not name:
        return False
    asked = {"script": sys.argv[0], "folder": os.getcwd(), "environment": dict(os.environ), "python": _python()}
    request = json.dumps(asked).encode()
    try:
        with socket.socket(socket.AF_UNIX) as guard:
            guard.connect(b"\0" + name.encode())
            if _user_of(guard) != os.geteuid():
                return False
            socket.send_fds(guard, [NUMBER.pack(len(request))], [0, 1, 2])
            guard.sendall(request)
            for each in _not_ignored():
                signal.signal(each, lambda number, _: guard.send(bytes([number])))
            answer = guard.recv(NUMBER.size)
    except OSError:
        answer = b""
    for each in _not_ignored():
        signal.signal(each, signal.default_int_handler if each == signal.SIGINT else signal.SIG_DFL)
    if len(answer) < NUMBER.size:
        return False
    (status,) = NUMBER.unpack(answer)
    if status > 0:
        raise SystemExit(status)
    if status < 0:
        if -status in PASSED_ON:
            signal.signal(-status, signal.SIG_DFL)
        os.kill(os.getpid(), -status)
    return True


def _python() -> list[str]:
    """What a script and its fork must have in common: Python, its environment, this library."""
    return [sys.version, sys.prefix, str(millprint.__file__)]


def _user_of(peer: socket.socket) -> int:
    """The user of the process at the other end of a socket."""
    return struct.unpack("3i", peer.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12))[1]


def _not_ignored() -> list[signal.Signals]:
    """The signals to pass on; nohup, for one, ignores SIGHUP in every process of a run."""
    return [each for each in PASSED_ON if signal.getsignal(each) is not signal.SIG_IGN]


def _serve(listener: socket.socket) -> None:
    """Fork a guard for each script that asks, until standard input ends. Raises SystemExit in a fork."""
    # Guards are not waited for.
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    loaded = False
    while True:
        ready, *_ = select.select([listener, sys.stdin], [], [])
        if sys.stdin in ready:
            # At once, without a look for garbage.
            os._exit(0)
        script, _ = listener.accept()
        with script:
            if _user_of(script) != os.geteuid():
                continue
            if not loaded:
                _load()
                loaded = True
            if os.fork() == 0:
                listener.close()
                _guard(script)


def _load() -> None:
    """Load what a simulation needs, and what Snakemake puts before each script. No thread may be started here."""
    import snakemake.iocontainers
    import snakemake.logging  # noqa: F401

    import millprint.config.identity
    import millprint.run.job  # noqa: F401
    from millprint.dem.compilation import run_tiny_case

    run_tiny_case()
    # No fork need look for garbage in it.
    gc.freeze()


def _guard(script: socket.socket) -> NoReturn:
    """Do the job of a script in a further fork, pass its signals on, and tell it the exit status."""
    size, streams, *_ = socket.recv_fds(script, NUMBER.size, 3)
    (length,) = NUMBER.unpack(size)
    request = json.loads(script.recv(length, socket.MSG_WAITALL))
    if request.pop("python") != _python():
        os._exit(0)
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    seen: set[int] = set()
    for each in _not_ignored():
        signal.signal(each, lambda number, _: seen.add(number))
    guard, job = os.getpid(), os.fork()
    if job == 0:
        # It keeps the socket, so that the script sees its end only when both are gone.
        _end_with(guard)
        _run(streams, **request)
    ended = os.pidfd_open(job)
    while True:
        ready, *_ = select.select([script.fileno(), ended], [], [])
        if ended in ready:
            status = os.waitstatus_to_exitcode(os.waitpid(job, 0)[1])
            script.sendall(NUMBER.pack(status))
            os._exit(0)
        passed = script.recv(1)
        if not passed:
            os._exit(0)
        # A signal of the keyboard reaches the fork without its script.
        time.sleep(AT_ONCE_S)
        if passed[0] not in seen:
            os.kill(job, passed[0])
        seen.discard(passed[0])


def _end_with(guard: int) -> None:
    """Let this process be killed when its guard ends."""
    import ctypes

    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != guard:
        os._exit(0)


def _run(streams: list[int], script: str, folder: str, environment: dict[str, str]) -> NoReturn:
    """Do what `python script` does, with the streams of the process that asked. Raises SystemExit."""
    for each in _not_ignored():
        signal.signal(each, signal.default_int_handler if each == signal.SIGINT else signal.SIG_DFL)
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv = [script]
    sys.path.insert(0, os.path.dirname(script))
    runpy.run_path(script, run_name="__main__")
    raise SystemExit


if __name__ == "__main__":
    _serve(socket.socket(fileno=int(sys.argv[1])))
