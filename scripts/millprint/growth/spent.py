"""The processor time and the memory of a command with all its children."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import psutil

from millprint.errors import MillprintError

# How often memory is looked at [s].
LOOK_S = 0.02


@dataclass(frozen=True)
class Spent:
    """Processor time with that of its children [s], largest memory of one process [MB], what it printed."""

    processor_s: float
    memory_mb: float
    said: str


def spent(command: Sequence[str], folder: str | Path, limit_s: float) -> Spent | None:
    """Run a command in a folder; None if it has not ended after `limit_s` of wall time, when it is killed.

    Raises MillprintError with its last words if it fails.
    """
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        process = subprocess.Popen(command, cwd=folder, stdout=out, stderr=err)
        end, in_time, memory_mb = time.monotonic() + limit_s, True, 0.0
        while (ended := os.wait4(process.pid, os.WNOHANG))[0] == 0:
            memory_mb = max(memory_mb, _peak_mb(process.pid))
            if in_time and time.monotonic() > end:
                in_time = False
                process.kill()
            time.sleep(LOOK_S)
        out.seek(0)
        err.seek(0)
        said, words = out.read(), err.read().strip().splitlines()
    _, status, used = ended
    process.returncode = os.waitstatus_to_exitcode(status)
    if not in_time:
        return None
    if process.returncode:
        raise MillprintError(f"{' '.join(command)}: {words[-1] if words else f'status {process.returncode}'}")
    return Spent(used.ru_utime + used.ru_stime, memory_mb, said)


def _peak_mb(process: int) -> float:
    """The largest memory that a process or one of its children has had so far [MB].

    From the kernel's own record of each: `ru_maxrss` of a child counts the memory of the parent that started it.
    """
    peak = 0.0
    try:
        numbers = [process, *(child.pid for child in psutil.Process(process).children(recursive=True))]
    except psutil.Error:
        return peak
    for number in numbers:
        try:
            status = Path(f"/proc/{number}/status").read_text()
        except OSError:
            continue
        kilobytes = [line.split()[1] for line in status.splitlines() if line.startswith("VmHWM:")]
        peak = max(peak, *map(float, kilobytes), 0.0)
    return peak / 1024


def own_work(*words: str | Path | int) -> list[str]:
    """The command for a piece of millprint.growth.work."""
    return [sys.executable, "-m", "millprint.growth.work", *map(str, words)]
