"""The processor time and the memory of a command with all its children."""

import os
import subprocess
import sys
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from millprint.errors import MillprintError


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
    output, errors = Path(folder) / "growth.out", Path(folder) / "growth.err"
    with output.open("w") as out, errors.open("w") as err:
        process = subprocess.Popen(command, cwd=folder, stdout=out, stderr=err)
        late = threading.Timer(limit_s, process.kill)
        late.start()
        _, status, used = os.wait4(process.pid, 0)
        in_time = late.is_alive()
        late.cancel()
    process.returncode = os.waitstatus_to_exitcode(status)
    if not in_time:
        return None
    if process.returncode:
        words = errors.read_text(errors="replace").strip().splitlines()
        raise MillprintError(f"{' '.join(command)}: {words[-1] if words else f'status {process.returncode}'}")
    return Spent(used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, output.read_text(errors="replace"))


def own_work(*words: str | Path | int) -> list[str]:
    """The command for a piece of millprint.growth.work."""
    return [sys.executable, "-m", "millprint.growth.work", *map(str, words)]
