"""What a job shows: a log file that says what was done and how long it took, and a bar with a time to go."""

import logging
import sys
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tqdm import tqdm

from millprint.errors import MillprintError

logger = logging.getLogger("millprint")


@contextmanager
def job(log_path: str, title: str) -> Iterator[logging.Logger]:
    """Log one job to `log_path`; an error of the user's ends the job with one line instead of a traceback."""
    Path(log_path).parent.mkdir(parents=True, exist_ok=True)
    handler = logging.FileHandler(log_path, mode="w")
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s", "%Y-%m-%d %H:%M:%S"))
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    logging.captureWarnings(True)
    logging.getLogger("py.warnings").addHandler(handler)
    warnings.simplefilter("default")
    start = time.perf_counter()
    logger.info("%s: begin", title)
    try:
        yield logger
    except MillprintError as error:
        logger.error("%s", error)
        print(f"error: {title}: {error}", file=sys.stderr)
        raise SystemExit(1) from None
    except BaseException:
        logger.exception("%s: failed", title)
        raise
    else:
        logger.info("%s: done in %.1f s", title, time.perf_counter() - start)
    finally:
        logger.removeHandler(handler)
        handler.close()


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
