"""Which processes are alive: a run locks a file of its own, its jobs end with it, attempts at a job take turns."""

import atexit
import fcntl
import logging
import os
import socket
import sys
import threading
import time
from pathlib import Path
from typing import NamedTuple, TextIO

import psutil

from millprint import RUN_VARIABLE

logger = logging.getLogger("millprint")

# In the working folder of Snakemake: a file HOST-PID for each run that has started jobs.
RUNS = Path(".snakemake/millprint/runs")

LIVING, DEAD, UNKNOWN = "living", "dead", "unknown"

POLL_S = 0.5
# Files whose locks this process holds. The operating system releases them when it ends, even if it is killed.
_held: dict[Path, TextIO] = {}
_watching = False


class Run(NamedTuple):
    """A run of Snakemake that began jobs, and whether its process is LIVING or DEAD; UNKNOWN where nothing tells."""

    path: Path
    host: str
    pid: int
    state: str

    @property
    def is_here(self) -> bool:
        """Whether the run was started on this machine."""
        return self.host == socket.gethostname()


def hold(folder: str | Path = RUNS) -> None:
    """Hold a file HOST-PID in `folder` for the lifetime of this process, under a lock of the system's own.

    Snakemake's own lock does not tell whether the run that left it is alive; this one does, for the kernel lets go of
    it however the process ends. At a normal end the file is removed. Files of other runs are left as they are.
    """
    path = Path(folder).absolute() / f"{socket.gethostname()}-{os.getpid()}"
    if path in _held:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    # Opened to append, so that a file of the same name from an earlier process keeps its content.
    _held[path] = open(path, "a+")  # noqa: SIM115 (open as long as the process lives)
    os.utime(path)
    try:
        fcntl.flock(_held[path], fcntl.LOCK_SH)
    except OSError:
        # On a file system without locks, the content tells others that the state of this run is unknown.
        logger.debug("%s: no locks here", path)
    atexit.register(_let_go, path, os.getpid())


def _let_go(path: Path, pid: int) -> None:
    """Remove the file of this run, but not from a forked process."""
    if os.getpid() == pid:
        path.unlink(missing_ok=True)


def runs_of(folder: str | Path = RUNS) -> list[Run]:
    """Every run with a file in `folder`, sorted by name, with its state: LIVING, DEAD or UNKNOWN."""
    found = []
    for path in sorted(Path(folder).glob("*-*")):
        host, _, number = path.name.rpartition("-")
        if number.isdecimal() and (state := _state(path, host, int(number))):
            found.append(Run(path, host, int(number), state))
    return found


def _state(path: Path, host: str, pid: int) -> str | None:
    """The state of the run with this file; None if the run has ended in the meantime and the file is gone."""
    # If locks are local to a machine, a file of another machine looks unlocked.
    if host != socket.gethostname():
        return UNKNOWN
    try:
        with open(path, "r+") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        held_since = path.stat().st_mtime
    except BlockingIOError:
        return LIVING
    except FileNotFoundError:
        return None
    except OSError:
        return UNKNOWN
    # Some file systems grant every lock. A process of this number that is younger than the file is another process.
    return LIVING if _lives(pid, before=held_since + 1) else DEAD


def announce() -> None:
    """Tell every process that this one starts, through the environment, whose it is.

    Snakemake has nothing of the kind: its jobs are processes of their own, and outlive a Snakemake that was killed.
    """
    os.environ[RUN_VARIABLE] = f"{socket.gethostname()} {os.getpid()} {psutil.Process().create_time()}"


def outlive_run() -> None:
    """Belong to no run, with every process that this one starts: a job of a cluster's queue, whose Snakemake may end.

    Its node can be the machine that it was submitted from, so that the machine's name does not tell.
    """
    os.environ.pop(RUN_VARIABLE, None)


def _lives(pid: int, before: float, after: float = 0.0) -> bool:
    """Whether a process of this number is alive that was started between two times [s since 1970]."""
    try:
        process = psutil.Process(pid)
        return after < process.create_time() < before and process.status() != psutil.STATUS_ZOMBIE
    except psutil.Error:
        return False


def end_with_run() -> None:
    """End this process soon after the run that started it has ended, so that no job outlives a killed Snakemake.

    A job that went on would write beside the next run's. On another machine than the run's nothing is watched.
    """
    global _watching
    words = os.environ.get(RUN_VARIABLE, "").rsplit(" ", 2)
    if _watching or len(words) != 3 or words[0] != socket.gethostname() or int(words[1]) == os.getpid():
        return
    _watching = True
    pid, started = int(words[1]), float(words[2])

    def watch() -> None:
        while _lives(pid, before=started + 1, after=started - 1):
            time.sleep(POLL_S)
        print(f"error: the run of process {pid} has ended, and with it this job of it", file=sys.stderr, flush=True)
        # Not sys.exit, which would only end this thread.
        os._exit(143)

    threading.Thread(target=watch, daemon=True, name="end with run").start()


def wait_for_turn(log: TextIO) -> None:
    """Lock the log of a job; if an earlier attempt at the same job is still running, wait for its end."""
    try:
        try:
            fcntl.flock(log, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            print(f"waiting: another process still writes {log.name}", file=sys.stderr, flush=True)
            fcntl.flock(log, fcntl.LOCK_EX)
    except OSError:
        # Without locks two attempts may run at once; both write the same complete files.
        return
