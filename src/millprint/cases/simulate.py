"""Several simulations in one job or call: each is kept once it is done, so that a stopped call continues.

A simulation of the table that has a folder in results/dem is a job of its own, and needs none of this. Here are those
that take seconds, so that a job for each would cost more than the simulation (samples, set-ups of the validation, jars
of a search), and those of `millprint card` and of Python, which run without Snakemake.
"""

import hashlib
import json
import logging
import os
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import partial
from multiprocessing import get_context, parent_process
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import SimulationError
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig, overridden
from millprint.dem.run import run_case
from millprint.run.digest import program_digest
from millprint.run.files import checksum_header, read_checksummed, whole_file
from millprint.run.job import progress
from millprint.run.kernel import kernel_digest

logger = logging.getLogger("millprint")

# The values of a simulation, and what it gave, as JSON takes them.
Values = dict[str, Any]
# The files of a simulation, and the file of those that are done, in the folder of all.
RUN, SUMMARY, DONE = "run.h5", "summary.json", "done.json"


def simulate_each(
    runs: Mapping[str, Values],
    simulate: Callable[[Values], Values],
    shared: Iterable[BaseModel | str],
    title: str,
    done: str | Path | None = None,
    cores: int = 1,
    is_whole: Callable[[str], bool] = lambda name: True,
) -> dict[str, Values]:
    """What `simulate` gives for the values of every run, by the run's name.

    shared: what all runs have in common, besides the code of `simulate`. done: a sealed file to which each run is
    written once it is done, and from which a stopped call continues with those that have the same name, values, code
    and shared settings, and that are whole; it is left there, for the caller to remove once the results are written.
    cores: runs at a time; with several, `simulate` must be one that other processes can import. Raises SimulationError
    with the name of the run that failed.
    """
    identity, kept = "", {}
    if done:
        parts = [part if isinstance(part, str) else part.model_dump_json() for part in shared]
        code = getattr(simulate, "func", simulate).__code__.co_filename
        identity = hashlib.sha256(json.dumps([*parts, program_digest(code), kernel_digest()]).encode()).hexdigest()
        kept = _kept(Path(done), identity)
    waiting = {
        name: values
        for name, values in runs.items()
        if kept.get(name, {}).get("values") != values or not is_whole(name)
    }
    if done and waiting:
        # From here on, their files may be those of another simulation.
        kept = {name: own for name, own in kept.items() if name not in waiting}
        _keep(done, identity, kept)
    if kept:
        logger.info("continuing from %s: %d of %d simulations are done", done, len(runs) - len(waiting), len(runs))
    with progress(len(runs), title, " simulations") as bar:
        bar.update(len(runs) - len(waiting))
        for name, result in _results(waiting, simulate, cores):
            kept[name] = {"values": runs[name], "result": result}
            if done:
                _keep(done, identity, kept)
            logger.info("%s: done", name)
            bar.update()
    return {name: kept[name]["result"] for name in runs}


def _results(
    runs: Mapping[str, Values], simulate: Callable[[Values], Values], cores: int
) -> Iterator[tuple[str, Values]]:
    """Name and result of each run: one after another here, or as they end in other processes."""

    def named(name: str, result: Callable[[], Values]) -> tuple[str, Values]:
        try:
            return name, result()
        except SimulationError as error:
            raise SimulationError(f"{name}: {error}") from None

    if cores == 1 or len(runs) <= 1:
        yield from (named(name, partial(simulate, values)) for name, values in runs.items())
        return
    # Spawned, not forked: a copy of this process would have its threads.
    with ProcessPoolExecutor(cores, mp_context=get_context("spawn"), initializer=end_with_parent) as pool:
        tasks = {pool.submit(simulate, values): name for name, values in runs.items()}
        yield from (named(tasks[task], task.result) for task in as_completed(tasks))


def end_with_parent() -> None:
    """End this process of a pool as soon as its parent has ended, even if the parent was killed."""
    parent = parent_process()

    def watch() -> None:
        if parent:
            parent.join()
            # Not sys.exit, which would only end this thread.
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _keep(path: str | Path, identity: str, kept: dict[str, Values]) -> None:
    """Write the runs that are done, with a digest in front."""
    payload = json.dumps({"identity": identity, "runs": kept}).encode()
    with whole_file(path) as partial_file:
        partial_file.write_bytes(checksum_header(payload) + payload)


def _kept(path: Path, identity: str) -> dict[str, Values]:
    """The runs that an earlier call has kept; none if the file is absent, damaged, or of other settings."""
    if not path.is_file():
        return {}
    try:
        content = json.loads(read_checksummed(path))
    except (OSError, ValueError) as error:
        logger.warning("%s cannot be read (%s): starting again", path, error)
        return {}
    if content["identity"] != identity:
        logger.info("%s belongs to other settings or to another version: starting again", path)
        return {}
    return content["runs"]


def simulate_cases(
    cases: Mapping[str, Case], mill: MillConfig, contact: ContactConfig, dem: DemConfig, folder: Path, cores: int
) -> int:
    """Simulate each case into the folder of its name below `folder`, unless it is done; returns how many were done.

    A stopped case continues from its restart file. Raises SimulationError.
    """
    shared = {"mill": mill.model_dump(mode="json"), "contact": contact.model_dump(mode="json")}
    runs = {name: {"name": name, "case": case.model_dump(mode="json"), **shared} for name, case in cases.items()}
    folder.mkdir(parents=True, exist_ok=True)
    begin_s = time.time()

    def is_whole(name: str) -> bool:
        return all((folder / name / file).is_file() for file in (RUN, SUMMARY))

    simulate_each(runs, partial(_simulate_into, folder, dem), [dem], "simulating", folder / DONE, cores, is_whole)
    return sum((folder / name / SUMMARY).stat().st_mtime < begin_s for name in runs)


def _simulate_into(folder: Path, dem: DemConfig, values: Values) -> Values:
    """Simulate one case of `simulate_cases`, in this or another process; its result lies in its folder."""
    case, mill, contact = Case(**values["case"]), MillConfig(**values["mill"]), ContactConfig(**values["contact"])
    own = folder / values["name"]
    own.mkdir(exist_ok=True)
    run_case(case, *overridden(case, mill, contact), dem, own / RUN, own / SUMMARY)
    return {}
