"""Restart: everything that a run needs to continue bit for bit, in one HDF5 file."""

import hashlib
import json
import logging
from pathlib import Path
from typing import Protocol

import h5py
import numpy as np

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem import state
from millprint.dem.layout import COUNTER
from millprint.dem.recording import Recording, Table
from millprint.mill.bodies import Body
from millprint.run.files import checksum_header, read_checksummed
from millprint.run.hdf5 import whole_hdf5
from millprint.run.kernel import kernel_digest

logger = logging.getLogger("millprint")

# Arrays of the state that change; the rest follows from the configuration.
BALLS = ("position", "rate", "rate_now", "load", "species")
ARRAYS = ("totals", "counters", "numbers")
PIECES = ("samples", "snapshots", "poses", "snapshot_works", "snapshot_contacts")


class Restartable(Protocol):
    """What a restart file needs of a simulation: its settings, its state, and its clocks [s]."""

    case: Case
    mill: MillConfig
    contact: ContactConfig
    dem: DemConfig
    bodies: list[Body]
    step: float
    balls: state.Balls
    candidates: state.Candidates
    contacts: state.Contacts
    clock: state.Clock
    totals: np.ndarray
    counters: np.ndarray
    numbers: np.ndarray
    wall_clock_s: float
    processor_s: float


def identity(simulation: Restartable) -> str:
    """What must agree between a restart file and the run that continues it: configuration, shapes, kernels."""
    parts = {name: getattr(simulation, name).model_dump(mode="json") for name in ("case", "mill", "contact", "dem")}
    shapes = hashlib.sha256(b"".join(body.vessel.vertices.tobytes() for body in simulation.bodies)).hexdigest()
    return json.dumps({**parts, "kernels": kernel_digest(), "shapes": shapes}, sort_keys=True)


def write_restart(path: str | Path, simulation: Restartable, recording: Recording) -> None:
    """Write the state of a simulation and what it has recorded; a killed write leaves the file before it in place."""
    with whole_hdf5(path, checksum_header) as file:
        _write_state(file, simulation, recording)


def _write_state(file: h5py.File, simulation: Restartable, recording: Recording) -> None:
    file.attrs["identity"] = identity(simulation)
    file.attrs["clocks_s"] = [simulation.wall_clock_s, simulation.processor_s]
    for name in BALLS:
        file[f"balls/{name}"] = getattr(simulation.balls, name)
    for group in ("candidates", "contacts"):
        for name, array in getattr(simulation, group)._asdict().items():
            file[f"{group}/{name}"] = array
    for name in ARRAYS:
        file[name] = getattr(simulation, name)
    file["occupancy"], file["height"] = recording.occupancy, recording.height
    for name in PIECES:
        pieces = getattr(recording, name)
        if pieces:
            file[f"recording/{name}"] = np.concatenate(pieces)
    # Contacts in a snapshot are counted from the beginning of its piece.
    file["recording/piece_lengths"] = [len(piece) for piece in recording.snapshot_works]
    file["recording/piece_contacts"] = [len(piece) for piece in recording.snapshot_contacts]
    for c, column in enumerate(zip(*recording.contacts, strict=True)):
        file[f"recording/contacts_{c}"] = np.concatenate(column)


def read_restart(path: str | Path, simulation: Restartable, recording: Recording) -> bool:
    """Put a simulation and its recording into the state of a restart file; returns whether there was one that fits.

    A file of another configuration, of other kernels, or one that cannot be read is not used; the log says so.
    """
    if not Path(path).is_file():
        return False
    try:
        read_checksummed(path)
        with h5py.File(path, "r") as file:
            if file.attrs["identity"] != identity(simulation):
                logger.info("%s belongs to other settings or to another version: starting again", path)
                return False
            # Nothing is changed before everything has been read.
            pieces, sums = _read_pieces(file["recording"]), (file["occupancy"][:], file["height"][:])
            _read_state(file, simulation)
    except (OSError, KeyError, ValueError) as error:
        logger.warning("%s cannot be read (%s): starting again", path, error)
        return False
    recording.occupancy[:], recording.height[:] = sums
    for name, parts in pieces.items():
        getattr(recording, name).extend(parts)
    logger.info("continuing from %s at step %d", path, simulation.counters[COUNTER.step])
    return True


def _read_state(file: h5py.File, simulation: Restartable) -> None:
    balls = {name: file[f"balls/{name}"][:] for name in BALLS}
    candidates = state.Candidates(**{name: file[f"candidates/{name}"][:] for name in state.Candidates._fields})
    contacts = state.Contacts(**{name: file[f"contacts/{name}"][:] for name in state.Contacts._fields})
    arrays = {name: file[name][:] for name in ARRAYS}
    clocks = [float(seconds) for seconds in file.attrs["clocks_s"]]
    for name, array in balls.items():
        getattr(simulation.balls, name)[:] = array
    simulation.candidates, simulation.contacts = candidates, contacts
    for name, array in arrays.items():
        getattr(simulation, name)[:] = array
    simulation.wall_clock_s, simulation.processor_s = clocks


def _read_pieces(group: h5py.Group) -> dict[str, list]:
    """The recorded pieces."""
    ends = {name: np.cumsum(group["piece_lengths"][:])[:-1] for name in PIECES}
    ends["snapshot_contacts"] = np.cumsum(group["piece_contacts"][:])[:-1]
    ends["samples"] = np.empty(0, dtype=np.int64)
    pieces: dict[str, list] = {name: np.split(group[name][:], ends[name]) for name in PIECES if name in group}
    if "contacts_0" in group:
        pieces["contacts"] = [Table(*(group[f"contacts_{c}"][:] for c in range(len(Table._fields))))]
    return pieces
