"""What a job shows: a log file that says what was done and how long it took, and a bar with a time to go."""

import errno
import gc
import logging
import re
import sys
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tqdm import tqdm

from millprint import files
from millprint.errors import MillprintError
from millprint.liveness import end_with_run, wait_for_turn
from millprint.records import record_path, write_record

logger = logging.getLogger("millprint")

# A disk that is full, a quota, a file larger than it may be.
FULL = {errno.ENOSPC: "no space left on the disk", errno.EDQUOT: "the disk quota is used up",
        errno.EFBIG: "larger than a file may be here"}  # fmt: skip


@contextmanager
def job(log_path: str, title: str) -> Iterator[logging.Logger]:
    """Log one job to `log_path`; an error of the user's ends the job with a line for each fault, and no traceback.

    The files that it writes are recorded beside the log. It ends with the run that started it, and waits until an
    earlier attempt at it has ended.
    """
    # All that is imported by now, which stays: the collector leaves it alone.
    gc.freeze()
    gc.enable()
    end_with_run()
    Path(log_path).parent.mkdir(parents=True, exist_ok=True)
    handler = logging.FileHandler(log_path, mode="a")
    stream = handler.stream
    assert stream is not None, "a handler that has not been told to wait opens its file at once"
    wait_for_turn(stream)
    stream.truncate(0)
    record = record_path(log_path)
    record.unlink(missing_ok=True)
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s", "%Y-%m-%d %H:%M:%S"))
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    logging.captureWarnings(True)
    logging.getLogger("py.warnings").addHandler(handler)
    warnings.simplefilter("default")
    start = time.perf_counter()
    logger.info("%s: begin", title)
    files.written.clear()
    try:
        yield logger
        write_record(record, files.written)
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
        logger.removeHandler(handler)
        handler.close()
        # Python would look through everything twice more before it ends: half a second where torch is imported.
        gc.freeze()


def _full(error: OSError) -> str | None:
    """What an error of a disk without room says; HDF5 gives the number in words only."""
    found = re.search(r"errno = (\d+)", str(error))
    return FULL.get(error.errno or (int(found.group(1)) if found else 0))


def progress(total: float | None, what: str, unit: str = "it", **options: Any) -> tqdm:
    """A progress bar with a time to go on the terminal; sparse lines where the output is a file or CI."""
    terminal = sys.stderr.isatty()
    return tqdm(
        total=total,
        desc=what,
        unit=unit,
        mininterval=0.5 if terminal else 10.0,
        maxinterval=10.0 if terminal else 30.0,
        delay=0 if terminal else 10.0,
        dynamic_ncols=terminal,
        leave=not terminal,
        file=sys.stderr,
        **options,
    )
