"""Which processes of a run are alive: runs hold a lock, jobs end with the run that started them, one at a time."""

import fcntl
import logging
import os
import socket
import sys
import threading
import time
from pathlib import Path
from typing import TextIO

import psutil

from millprint import RUN_VARIABLE

logger = logging.getLogger("millprint")

POLL_S = 0.5
# Files whose locks this process holds until it ends, however it ends: the kernel lets go of them.
_held: list[TextIO] = []
_watching = False


def claim(path: str | Path) -> bool:
    """Hold a lock for the lifetime of this process; returns whether no other living process on it holds one.

    Any number of runs may hold it, so that one which looks (a dry run) does not stop one which works. False where the
    file system knows no locks, or where the last to hold it was another machine, of whose processes nothing is known.
    """
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    file = open(path, "a+")  # noqa: SIM115 (open as long as the process lives)
    _held.append(file)
    alone, host = False, socket.gethostname()
    try:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            alone = True
        except BlockingIOError:
            pass
        if alone:
            file.seek(0)
            alone = file.read().strip() in ("", host)
            file.truncate(0)
            file.write(host)
            file.flush()
        fcntl.flock(file, fcntl.LOCK_SH)
    except OSError:
        return False
    return alone


def announce() -> None:
    """Tell every process that this one starts, through the environment, whose it is."""
    os.environ[RUN_VARIABLE] = f"{socket.gethostname()} {os.getpid()} {psutil.Process().create_time()}"


def is_within_run() -> bool:
    """Whether a run started this process: one of its jobs, or a Snakemake within one."""
    return RUN_VARIABLE in os.environ


def _lives(pid: int, started: float) -> bool:
    try:
        process = psutil.Process(pid)
        return abs(process.create_time() - started) < 1 and process.status() != psutil.STATUS_ZOMBIE
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
        while _lives(pid, started):
            time.sleep(POLL_S)
        print(f"error: the run of process {pid} has ended, and with it this job of it", file=sys.stderr, flush=True)
        # Not sys.exit: it would only end this thread.
        os._exit(143)

    threading.Thread(target=watch, daemon=True, name="end with run").start()


def wait_for_turn(log: TextIO) -> None:
    """Hold a lock on a job's log; while an earlier attempt at the same job still lives, wait for its end."""
    try:
        try:
            fcntl.flock(log, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            print(f"waiting: another process still writes {log.name}", file=sys.stderr, flush=True)
            fcntl.flock(log, fcntl.LOCK_EX)
    except OSError:
        # A file system without locks: two attempts at once write the same, each file whole.
        return
