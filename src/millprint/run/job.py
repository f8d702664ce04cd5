"""A job: its log file, progress and run time, and errors that end it with one line."""

import errno
import gc
import logging
import re
import resource
import sys
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

import psutil
from tqdm import tqdm

from millprint.config.errors import MillprintError
from millprint.run import files
from millprint.run.digest import record_path, write_record
from millprint.run.numbers import duration

# Time between lines [s], and time before the first line, so that a short job writes none [s].
EVERY_S, FIRST_S = 30.0, 10.0


# The title of the running job, for progress without another name.
job_title = ContextVar("job_title", default="working")


class Lines(tqdm):
    """Progress as single lines: the work, how much of it is done, and the remaining time."""

    _said_s = float("-inf")
    _shown = False

    def display(self, msg: str | None = None, pos: int | None = None) -> bool:
        """Write a line, unless the last line is younger than EVERY_S. A message, which clears a bar, is left out."""
        now = self._time()
        if msg is not None or now - self._said_s < EVERY_S:
            return False
        self._say(now)
        return True

    def __exit__(self, kind: Any, value: Any, traceback: Any) -> None:
        """Write no last line after a failure, because it would say that everything is done."""
        self._shown = self._shown and kind is None
        super().__exit__(kind, value, traceback)

    def close(self) -> None:
        """Write a last line if there was one before."""
        shown = self._shown and not self.disable
        self.leave = False
        super().close()
        if shown:
            self._say(self._time(), ended=True)

    def _say(self, now: float, ended: bool = False) -> None:
        self._said_s, self._shown = now, True
        # One call, so that lines of parallel jobs do not mix.
        self.fp.write(f"{progress_line(self.format_dict, ended)}\n")
        self.fp.flush()


def progress_line(state: dict[str, Any], ended: bool) -> str:
    """One line of progress. state: as tqdm's `format_dict`."""
    scale = 1 if isinstance(state["unit_scale"], bool) else state["unit_scale"]
    unit, done, total, elapsed = state["unit"].strip(), state["n"], state["total"], state["elapsed"]
    units = unit if unit.endswith("s") or " " in unit else f"{unit}s"
    reached = _number(done * scale)
    amount = f"{reached} {units}" if total is None else f"{reached} of {_number(total * scale)} {units}"
    text = f"{state['prefix']}: {amount}, {duration(elapsed)} so far"
    if state["postfix"]:
        text += f", {state['postfix']}"
    if ended:
        return f"{text}; done"
    # The rate of the last steps, or of all. Before the first step of this process there is none.
    rate = state["rate"] or ((done - state["initial"]) / elapsed if elapsed else 0.0)
    return text if total is None or not rate else f"{text}; about {duration((total - done) / rate)} to go"


def _number(value: float) -> str:
    return str(value) if isinstance(value, int) else f"{value:.2f}"


def progress(total: float | None, what: str | None, unit: str = "it", **options: Any) -> tqdm:
    """A progress bar with the remaining time in a terminal; lines if the output is a file or CI.

    what: the work; None for the title of the job. unit: what is counted, in the singular.
    """
    name = job_title.get() if what is None else what
    if sys.stderr.isatty():
        terminal = {"mininterval": 0.5, "dynamic_ncols": True, "leave": False}
        return tqdm(total=total, desc=name, unit=unit, file=sys.stderr, **terminal, **options)
    lines = {"mininterval": 1.0, "maxinterval": EVERY_S, "delay": FIRST_S}
    return Lines(total=total, desc=name, unit=unit, file=sys.stderr, **lines, **options)


logger = logging.getLogger("millprint")

# A full disk, a used-up quota, a file that is too large.
FULL = {errno.ENOSPC: "no space left on the disk", errno.EDQUOT: "the disk quota is used up",
        errno.EFBIG: "the file is too large for this file system"}  # fmt: skip


@contextmanager
def job(log_path: str, title: str, benchmark: str | None = None) -> Iterator[logging.Logger]:
    """Log one job to `log_path`. A MillprintError ends the job with a line for each fault and without a traceback.

    The files that it writes are recorded next to the log. benchmark: a file for `write_benchmark`.
    """
    # The garbage collector need not examine the modules that are imported now.
    gc.freeze()
    gc.enable()
    Path(log_path).parent.mkdir(parents=True, exist_ok=True)
    handler = logging.FileHandler(log_path, mode="w")
    record = record_path(log_path)
    record.unlink(missing_ok=True)
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s", "%Y-%m-%d %H:%M:%S"))
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    logging.captureWarnings(True)
    logging.getLogger("py.warnings").addHandler(handler)
    warnings.simplefilter("default")
    named = job_title.set(title)
    start = time.perf_counter()
    logger.info("%s: begin", title)
    files.written.clear()
    try:
        yield logger
        write_record(record, files.written)
        if benchmark:
            write_benchmark(benchmark)
    except MillprintError as error:
        logger.error("%s", error)
        for line in str(error).split("\n"):
            print(f"error: {title}: {line}", file=sys.stderr)
        raise SystemExit(1) from None
    except OSError as error:
        if not (reason := _full(error)):
            logger.exception("%s: failed", title)
            raise
        message = f"{error.filename or log_path}: {reason}; make room and run the same command again"
        logger.error("%s", message)
        print(f"error: {title}: {message}", file=sys.stderr)
        raise SystemExit(1) from None
    except BaseException:
        logger.exception("%s: failed", title)
        raise
    else:
        logger.info("%s: done in %.1f s", title, time.perf_counter() - start)
    finally:
        job_title.reset(named)
        logger.removeHandler(handler)
        logging.getLogger("py.warnings").removeHandler(handler)
        handler.close()
        # Without this, Python examines all objects twice more at its end: half a second if torch is imported.
        gc.freeze()


def write_benchmark(path: str | Path) -> None:
    """Time since the start of this process, and processor time and largest memory of it and of those that it started.

    With the names and units of Snakemake's benchmarks [s], [MB], which it takes by looking at a job now and then.
    """
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    wall_s = time.time() - psutil.Process().create_time()
    processor_s = sum(own.ru_utime + own.ru_stime for own in used)
    # In bytes on macOS, in kB elsewhere.
    memory = max(own.ru_maxrss for own in used) / (1024**2 if sys.platform == "darwin" else 1024)
    clock = f"{int(wall_s // 3600)}:{int(wall_s // 60 % 60):02d}:{int(wall_s % 60):02d}"
    with files.whole_file(path) as partial:
        partial.write_text(f"s\th:m:s\tmax_rss\tcpu_time\n{wall_s:.2f}\t{clock}\t{memory:.2f}\t{processor_s:.2f}\n")


def _full(error: OSError) -> str | None:
    """The message for an error of a full disk; HDF5 gives the error number only in its text."""
    found = re.search(r"errno = (\d+)", str(error))
    return FULL.get(error.errno or (int(found.group(1)) if found else 0))
