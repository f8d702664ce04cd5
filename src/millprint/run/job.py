"""The log file of a job, its run time, and errors that end it with one line."""

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
from pathlib import Path

import psutil

from millprint.config.errors import MillprintError
from millprint.run import files
from millprint.run.output_digests import record_path, write_record
from millprint.run.progress import job_title

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
