"""The measurements of growth, as rows of one table."""

import json
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from millprint.growth.planning import commands, write_plain, write_project
from millprint.growth.spent import Spent, own_work, spent
from millprint.growth.table import MEASURED_COLUMNS

# More empty jobs are planned, but not run.
RUN_MAX = 3000
ASKED = 200
# Threads wait for each other in every step: with fewer balls than this, for longer than they work.
THREADED_FROM = 5000
# A browser without a window that opens a page, runs its scripts, and ends.
OPEN = ("--headless", "--no-sandbox", "--disable-gpu", "--dump-dom")


def row(part: str, what: str, size: float, used: Spent | None, limit_s: float, **given: float | str) -> dict:
    """A row of the table; what was not measured, or not within `limit_s`, stays empty."""
    over = {"note": f"not within {limit_s:g} s"}
    values = {"processor_s": used.processor_s, "memory_MB": used.memory_mb} if used else over
    return {**dict.fromkeys(MEASURED_COLUMNS, ""), "part": part, "what": what, "size": size, **values, **given}


def measure_planning(snakefile: Path, mills: Path, sizes: Sequence[int], limit_s: float) -> Iterator[dict]:
    """Reading the Snakefile, a dry run, and Snakemake's own part of it, for runs of so many simulations."""
    for size in sizes:
        with tempfile.TemporaryDirectory() as place:
            whole, plain = Path(place) / "whole", Path(place) / "plain"
            cases = write_project(whole, mills, size)
            write_plain(plain, cases)
            for what, folder, command in commands(snakefile, plain, whole, size <= RUN_MAX):
                yield row("planning", what, cases, spent(command, folder, limit_s), limit_s, unit="cases")


def measure_fingerprints(descriptors: Path, sizes: Sequence[int], limit_s: float) -> Iterator[dict]:
    """Fitting a fingerprint to so many conditions, its file, and asking it for one more."""
    with tempfile.TemporaryDirectory() as place:
        for size in sizes:
            out = Path(place) / f"{size}.json"
            used = spent(own_work("fit", descriptors.absolute(), size, out), place, limit_s)
            found = json.loads(used.said) if used else {}
            yield row("fingerprint", "fit", size, used, limit_s, unit="conditions", **found)
            if used is None:
                # A larger one takes longer still.
                return
            used = spent(own_work("ask", out, ASKED), place, limit_s)
            found = json.loads(used.said) if used else {}
            once = {"processor_s": found["processor_s"]} if found else {}
            yield row("fingerprint", "ask once", size, used, limit_s, unit="conditions", **once)


def measure_pages(pages: Sequence[Path], browser: str | None, limit_s: float) -> Iterator[dict]:
    """The size of pages, and the processor time in which a browser opens each."""
    for page in pages:
        size = page.stat().st_size / 1e6
        if browser is None:
            yield row("pages", page.name, size, None, limit_s, file_MB=size, unit="MB", note="no browser here")
            continue
        with tempfile.TemporaryDirectory() as place:
            command = [browser, *OPEN, f"--user-data-dir={place}/profile", page.absolute().as_uri()]
            yield row("pages", page.name, size, spent(command, place, limit_s), limit_s, file_MB=size, unit="MB")


def measure_simulations(config: Path, sizes: Sequence[int], threads: Sequence[int], limit_s: float) -> Iterator[dict]:
    """Memory and cost of a ball and a step of a short stretch with so many balls; value: processor time of one [ns].

    Processor time, which other programs disturb less, and of all threads together; with several, wall time is noted.
    Several threads are measured from THREADED_FROM balls on.
    """
    for size in sizes:
        for number in (number for number in threads if number == 1 or size >= THREADED_FROM):
            # In the folder of the project, from which mills and contact sets are read.
            used = spent(own_work("simulate", config, size, number), Path.cwd(), limit_s)
            found = json.loads(used.said) if used else {}
            timed = {"processor_s": found["processor_s"], "value": found["processor_ns"]} if found else {}
            name = "one thread" if number == 1 else f"{number} threads"
            if found and number > 1:
                timed["note"] = f"{found['ns_per_ball_step']:.3g} ns by the clock"
            yield row("simulation", name, size, used, limit_s, unit="balls", **timed)


def find_browser() -> str | None:
    """A browser that can run without a window, or None."""
    names = ("chromium-headless-shell", "chrome-headless-shell", "chromium", "google-chrome")
    return next((found for name in names if (found := shutil.which(name))), None)
