"""Several short simulations in one process, one after another: each is kept once it is done, so that a job continues.

Each takes seconds, so that a process for each would cost more than the simulations.
"""

import hashlib
import json
import logging
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from millprint.config.errors import SimulationError
from millprint.run.files import checksum_header, read_checksummed, whole_file
from millprint.run.kernel import kernel_digest
from millprint.run.progress import progress

logger = logging.getLogger("millprint")

# The values of a simulation, and what it gave, as JSON takes them.
Values = dict[str, Any]


def simulate_each(
    runs: Mapping[str, Values],
    simulate: Callable[[Values], Values],
    shared: Iterable[BaseModel | str],
    title: str,
    done: str | Path | None = None,
) -> dict[str, Values]:
    """What `simulate` gives for the values of every run, by the run's name.

    shared: what all runs have in common, besides the code of the kernels. done: a sealed file to which each run is
    written once it is done, and from which a killed call continues with those that have the same name, values and
    shared settings; it is left there, for the caller to remove once the results are written. Raises SimulationError
    with the name of the run that failed.
    """
    parts = [part if isinstance(part, str) else part.model_dump_json() for part in shared]
    identity = hashlib.sha256(json.dumps([*parts, kernel_digest()]).encode()).hexdigest()
    kept = _kept(done, identity, runs)
    with progress(len(runs), title, " simulations") as bar:
        bar.update(len(kept))
        for name, values in runs.items():
            if name in kept:
                continue
            try:
                result = simulate(values)
            except SimulationError as error:
                raise SimulationError(f"{name}: {error}") from None
            kept[name] = {"values": values, "result": result}
            if done:
                _keep(done, identity, kept)
            logger.info("%s: done", name)
            bar.update()
    return {name: kept[name]["result"] for name in runs}


def _keep(path: str | Path, identity: str, kept: dict[str, Values]) -> None:
    """Write the runs that are done, with a digest in front."""
    payload = json.dumps({"identity": identity, "runs": kept}).encode()
    with whole_file(path) as partial:
        partial.write_bytes(checksum_header(payload) + payload)


def _kept(path: str | Path | None, identity: str, runs: Mapping[str, Values]) -> dict[str, Values]:
    """The runs that an earlier call has kept; none if the file is absent, damaged, or of other settings."""
    if path is None or not Path(path).is_file():
        return {}
    try:
        content = json.loads(read_checksummed(path))
    except (OSError, ValueError) as error:
        logger.warning("%s cannot be read (%s): starting again", path, error)
        return {}
    if content["identity"] != identity:
        logger.info("%s belongs to other settings or to another version: starting again", path)
        return {}
    same = {name: own for name, own in content["runs"].items() if name in runs and own["values"] == runs[name]}
    logger.info("continuing from %s: %d of %d simulations are done", path, len(same), len(runs))
    return same
