"""The records of a run: buffers that the step loop writes to, pieces copied from them, and the file of a restart.

Energy samples, snapshots, occupancy and the table of collisions. Their columns are in dem.layout.
"""

import hashlib
import json
import logging
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import h5py
import numpy as np

from millprint.config.identity import dem_identity, shared_identity
from millprint.dem import state
from millprint.dem.contact_events import book_works, listed, write_collision
from millprint.dem.law import get_of, put_of
from millprint.dem.layout import (
    COLLISION,
    COUNTER,
    ENDED,
    GRID,
    HEIGHT,
    LANE,
    OCCUPANCY,
    SAMPLE,
    SNAPSHOT,
    SNAPSHOT_TOTAL,
    TOTAL,
    TOTAL_WIDTH,
)
from millprint.dem.neighbours import named_pairs
from millprint.mill.kernel_columns import names_of, width_of
from millprint.mill.motion import POSE
from millprint.mill.vectors import dot, row, subtract
from millprint.mill.walls import direction_to_body, to_body, wall_velocity
from millprint.run.digest import simulation_digest
from millprint.run.files import checksum_header, read_checksummed
from millprint.run.hdf5 import whole_hdf5
from millprint.run.kernel import inlined, inner, kernel, kernel_digest

if TYPE_CHECKING:
    from millprint.dem.simulation import Simulation

SAMPLE_NAMES = names_of(SAMPLE)

# Rows of the table of collisions, after which it is emptied.
TABLE_ROWS = 1 << 16
# Numbers of snapshots and energy samples, after which they are copied.
SNAPSHOT_ROWS, SAMPLE_ROWS = 256, 512


class Table(NamedTuple):
    """Finished contacts; an empty table records none."""

    first: np.ndarray  # (rows,) ball
    second: np.ndarray  # (rows,) ball, or -1 - patch of the wall
    # (rows,) feature of the wall on which the row ended, -1 for two balls, where a contact gets a row for each feature
    # that it passes; (0,) where it gets one row
    facet: np.ndarray
    contact: np.ndarray  # (rows,) number of the contact
    ended: np.ndarray  # (rows,) layout.RowEnds
    value: np.ndarray  # (rows, width) layout.CollisionColumns


class Recorder(NamedTuple):
    """Buffers of one call of `advance`, and how often to write to them; an interval of 0 means never."""

    origin: int  # step at which the recorded window begins
    sample_every: int  # steps
    snapshot_every: int  # steps
    occupancy_every: int  # steps
    sample: np.ndarray  # (samples, width) layout.SampleColumns
    snapshot: np.ndarray  # (snapshots, n, width) layout.SnapshotColumns
    snapshot_pose: np.ndarray  # (snapshots, bodies, width) mill.pose.PoseColumns
    snapshot_total: np.ndarray  # (snapshots, width) layout.SnapshotTotalColumns
    snapshot_contact: np.ndarray  # (contacts, 2) ball, and ball or -1 - feature of the wall
    grid: np.ndarray  # (width,) layout.GridColumns
    occupancy: np.ndarray  # (columns, rows, width) layout.OccupancyColumns
    height: np.ndarray  # (width,) layout.HeightColumns
    works_before: np.ndarray  # (width,) layout.TotalColumns before the present step
    works_now: np.ndarray  # (width,) and now


@inner()
def all_works(contacts, counters, totals, out):
    """Totals with the works so far of the contacts that are open, and the elastic energies of the last evaluation."""
    for c in range(TOTAL_WIDTH):
        out[c] = totals[c]
    for lane in range(counters[COUNTER.used]):
        if contacts.slot[lane] >= 0:
            book_works(contacts, lane, out)
            out[TOTAL.elastic_normal_J] += get_of(contacts, lane, LANE.elastic_normal)
            out[TOTAL.elastic_tangential_J] += get_of(contacts, lane, LANE.elastic_tangential)


@inner()
def average_works(before, out):
    """Totals at the present time: half of this step's work is still to come; the elastic energies are those of now."""
    for c in range(TOTAL.elastic_normal_J):
        out[c] = 0.5 * (before[c] + out[c])


@inner()
def write_sample(balls, clock, time, totals, out):
    """One energy sample at `time` [s], with the means of the rates before and after the coming kick."""
    moving = 0.0
    turning = 0.0
    potential = 0.0
    for i in range(balls.species.size):
        mass, inertia = balls.mass[balls.species[i]], balls.inertia[balls.species[i]]
        for c in range(3):
            force, torque = balls.force[i, c], balls.torque[i, c]
            speed = balls.velocity[i, c] + 0.5 * clock.step * (force / mass + clock.gravity[c])
            angular = balls.angular_velocity[i, c] + 0.5 * clock.step * torque / inertia
            moving += 0.5 * mass * speed * speed
            turning += 0.5 * inertia * angular * angular
            potential -= mass * clock.gravity[c] * balls.position[i, c]
    out[SAMPLE.time_s] = time
    for c in range(TOTAL_WIDTH):
        out[SAMPLE.totals.wall_work_J + c] = totals[c]
    out[SAMPLE.kinetic_translation_J] = moving
    out[SAMPLE.kinetic_spin_J] = turning
    out[SAMPLE.potential_J] = potential


@inlined()
def write_open(candidates, first, i, counters, recorder):
    """Append the open contacts of ball i among first[i] to first[i + 1]."""
    for k in range(first[i], first[i + 1]):
        if candidates.lane[k] >= 0:
            contact = counters[COUNTER.snapshot_contacts]
            recorder.snapshot_contact[contact, 0] = i
            recorder.snapshot_contact[contact, 1] = candidates.partner[k]
            counters[COUNTER.snapshot_contacts] += 1


@inner()
def write_snapshot(balls, candidates, clock, time, totals, counters, recorder):
    """State of every ball and pose of every body now, the energy dissipated so far, and the open contacts."""
    number = counters[COUNTER.snapshots]
    counters[COUNTER.snapshots] += 1
    for i in range(balls.species.size):
        mass, inertia = balls.mass[balls.species[i]], balls.inertia[balls.species[i]]
        for c in range(3):
            half = 0.5 * clock.step
            force, torque = balls.force[i, c], balls.torque[i, c]
            velocity = balls.velocity[i, c] + half * (force / mass + clock.gravity[c])
            angular = balls.angular_velocity[i, c] + half * torque / inertia
            recorder.snapshot[number, i, SNAPSHOT.position_m.x + c] = balls.position[i, c]
            recorder.snapshot[number, i, SNAPSHOT.velocity_m_s.x + c] = velocity
            recorder.snapshot[number, i, SNAPSHOT.spin_rad_s.x + c] = angular
            recorder.snapshot[number, i, SNAPSHOT.contact_force_N.x + c] = force
        write_open(candidates, candidates.first, i, counters, recorder)
        for body in range(candidates.first_wall.shape[0]):
            write_open(candidates, candidates.first_wall[body], i, counters, recorder)
    for body in range(clock.load.shape[0]):
        for c in range(clock.motions.pose.shape[1]):
            recorder.snapshot_pose[number, body, c] = clock.motions.pose[body, c]
    total = recorder.snapshot_total[number]
    total[SNAPSHOT_TOTAL.time_s] = time
    total[SNAPSHOT_TOTAL.normal_J] = totals[TOTAL.normal_damping_J]
    # Dissipated: the work less what the tangential springs still hold.
    total[SNAPSHOT_TOTAL.tangential_J] = totals[TOTAL.tangential_work_J] - totals[TOTAL.elastic_tangential_J]
    total[SNAPSHOT_TOTAL.contacts] = counters[COUNTER.snapshot_contacts]


@inner()
def count_occupancy(balls, clock, recorder):
    """Add every ball to the cell of the horizontal grid that holds it, in the vessel's frame."""
    for i in range(balls.species.size):
        position = row(balls.position, i)
        point = to_body(clock.motions, 0, position)
        column = int((point[0] - recorder.grid[GRID.low_x]) * recorder.grid[GRID.cells_per_m])
        line = int((point[1] - recorder.grid[GRID.low_y]) * recorder.grid[GRID.cells_per_m])
        recorder.height[HEIGHT.total] += point[2]
        recorder.height[HEIGHT.balls] += 1
        vessel = wall_velocity(clock.motions, 0, position)
        relative = subtract(row(balls.velocity_now, i), vessel)
        recorder.height[HEIGHT.relative_squared] += dot(relative, relative)
        recorder.height[HEIGHT.vessel_squared] += dot(vessel, vessel)
        if not (0 <= column < recorder.occupancy.shape[0] and 0 <= line < recorder.occupancy.shape[1]):
            continue
        cell = recorder.occupancy[column, line]
        # The velocity relative to the vessel, along the vessel's axes.
        velocity = direction_to_body(clock.motions, 0, relative)
        cell[OCCUPANCY.balls] += 1
        for c in range(3):
            cell[OCCUPANCY.velocity.x + c] += velocity[c]
            cell[OCCUPANCY.speed_squared] += velocity[c] * velocity[c]


@inlined()
def room_left(candidates, counters, table, recorder):
    """Whether the buffers can take everything that one more step may write."""
    open_at_most = np.int64(listed(candidates))
    if table.value.shape[0] > 0 and counters[COUNTER.records] + open_at_most > table.value.shape[0]:
        return False
    if recorder.sample_every > 0 and counters[COUNTER.samples] >= recorder.sample.shape[0]:
        return False
    if recorder.snapshot_every == 0:
        return True
    return (
        counters[COUNTER.snapshots] < recorder.snapshot.shape[0]
        and counters[COUNTER.snapshot_contacts] + open_at_most <= recorder.snapshot_contact.shape[0]
    )


@inlined()
def is_due(every, since):
    """Whether something is written in the step that comes `since` steps after the origin."""
    return every > 0 and since >= 0 and since % every == 0


@inlined()
def begin_record(contacts, totals, counters, recorder, since):
    """Note the works before a step in which an energy sample or a snapshot is written; returns whether one is."""
    is_recorded = is_due(recorder.sample_every, since) or is_due(recorder.snapshot_every, since)
    if is_recorded:
        all_works(contacts, counters, totals, recorder.works_before)
    return is_recorded


@inner()
def record(balls, candidates, contacts, clock, time, since, totals, counters, recorder):
    """Write the energy sample and the snapshot that are due."""
    now = recorder.works_now
    all_works(contacts, counters, totals, now)
    average_works(recorder.works_before, now)
    if is_due(recorder.sample_every, since):
        write_sample(balls, clock, time, now, recorder.sample[counters[COUNTER.samples]])
        counters[COUNTER.samples] += 1
    if is_due(recorder.snapshot_every, since):
        write_snapshot(balls, candidates, clock, time, now, counters, recorder)


@kernel()
def begin_window(contacts, totals, counters):
    """Book and clear the works of open contacts, so that the table of collisions counts only the window."""
    for lane in range(counters[COUNTER.used]):
        if contacts.slot[lane] < 0:
            continue
        book_works(contacts, lane, totals)
        for work in LANE.history.works:
            put_of(contacts, lane, work, 0.0)


@kernel()
def end_window(candidates, contacts, walls, time, counters, table):
    """Append every contact that is still open to the table of collisions; nothing else is changed."""
    for k in range(listed(candidates)):
        if candidates.lane[k] >= 0:
            write_collision(contacts, walls, candidates.lane[k], time, ENDED.cut, counters, table)


@dataclass
class Recording:
    """What a window has recorded so far, in pieces, each an array as in the Recorder or a tuple as the Table.

    edges: of the cells of the grid of occupancy along x and y, in the vessel's frame [m].
    """

    edges: tuple[np.ndarray, np.ndarray]
    occupancy: np.ndarray
    height: np.ndarray
    samples: list[np.ndarray] = field(default_factory=list)
    contacts: list[Table] = field(default_factory=list)
    snapshots: list[np.ndarray] = field(default_factory=list)
    poses: list[np.ndarray] = field(default_factory=list)
    snapshot_works: list[np.ndarray] = field(default_factory=list)
    snapshot_contacts: list[np.ndarray] = field(default_factory=list)

    @property
    def height_m(self) -> float:
        """Mean height of the balls' centres over the floor [m]; nan where it was never measured."""
        total, count = self.height[HEIGHT.total], self.height[HEIGHT.balls]
        return float(total / count) if count else math.nan

    @property
    def speed_over_vessel(self) -> float | None:
        """Speed of the balls relative to the vessel over that of the vessel at their places, of mean squares [-].

        None for a vessel at rest.
        """
        vessel = self.height[HEIGHT.vessel_squared]
        return math.sqrt(self.height[HEIGHT.relative_squared] / vessel) if vessel > 0 else None

    @property
    def table(self) -> Table:
        """All pieces of the table of collisions as one."""
        pieces = self.contacts or [make_table(0)]
        return Table(*(np.concatenate(column) for column in zip(*pieces, strict=True)))

    def clear(self) -> None:
        """Forget everything."""
        self.occupancy[:], self.height[:] = 0, 0
        for pieces in (self.contacts, *(getattr(self, name) for name in PIECES)):
            pieces.clear()

    def drain(self, table: Table, recorder: Recorder, counters: np.ndarray, numbers: np.ndarray) -> None:
        """Copy the rows that the buffers hold to the ends of the lists, and set the counters of rows to 0.

        counters: (width,) layout.CounterColumns; numbers: (n,) of the ball in each row of the state, by which the lists
        name the balls. A list gets no piece where its buffer is empty.
        """
        rows, samples = counters[COUNTER.records], counters[COUNTER.samples]
        snapshots, contacts = counters[COUNTER.snapshots], counters[COUNTER.snapshot_contacts]
        if rows:
            piece = Table(*(column[:rows].copy() for column in table))
            first, second = named_pairs(numbers, piece.first, piece.second)
            self.contacts.append(piece._replace(first=first, second=second))
        if samples:
            self.samples.append(recorder.sample[:samples].copy())
        if snapshots:
            self.snapshots.append(recorder.snapshot[:snapshots, np.argsort(numbers)])
            self.poses.append(recorder.snapshot_pose[:snapshots].copy())
            self.snapshot_works.append(recorder.snapshot_total[:snapshots].copy())
            pairs = named_pairs(numbers, *recorder.snapshot_contact[:contacts].T)
            self.snapshot_contacts.append(np.column_stack(pairs))
        counters[[COUNTER.records, COUNTER.samples, COUNTER.snapshots, COUNTER.snapshot_contacts]] = 0


def make_table(rows: int, by_facet: bool = False) -> Table:
    """An empty table of collisions with room for `rows`; with none it records nothing.

    by_facet: a contact gets a row for each feature of the wall that it passes.
    """
    first, second, contact = (np.zeros(rows, dtype=np.int64) for _ in range(3))
    facet = np.zeros(rows if by_facet else 0, dtype=np.int64)
    value = np.zeros((rows, width_of(COLLISION)))
    return Table(first, second, facet, contact, np.zeros(rows, dtype=np.uint8), value)


def silent_recorder() -> Recorder:
    """A recorder that writes nothing."""
    return make_recorder(np.zeros((2, 2)), 1.0, 0, 0, np.iinfo(np.int64).max, (0, 0, 0), 0)


def make_recorder(
    bounds: np.ndarray, cell_m: float, balls: int, bodies: int, origin: int, every: tuple[int, int, int], room: int
) -> Recorder:
    """Buffers for a window that begins at step `origin`.

    bounds: (2, 2) of the vessel in plan, for a grid of occupancy with square cells [m]; every: steps between energy
    samples, between snapshots and between counts of the occupancy, 0 for never; room: contacts that may be open at a
    time.
    """
    sample_every, snapshot_every, occupancy_every = every
    shape = np.ceil((bounds[1] - bounds[0]) / cell_m).astype(int)
    snapshots = SNAPSHOT_ROWS if snapshot_every else 0
    grid = np.zeros(width_of(GRID))
    grid[[GRID.low_x, GRID.low_y]], grid[GRID.cells_per_m] = bounds[0], 1 / cell_m
    return Recorder(
        origin=origin,
        sample_every=sample_every,
        snapshot_every=snapshot_every,
        occupancy_every=occupancy_every,
        sample=np.zeros((SAMPLE_ROWS if sample_every else 0, width_of(SAMPLE))),
        snapshot=np.zeros((snapshots, balls, width_of(SNAPSHOT))),
        snapshot_pose=np.zeros((snapshots, bodies, width_of(POSE))),
        snapshot_total=np.zeros((snapshots, width_of(SNAPSHOT_TOTAL))),
        snapshot_contact=np.zeros((snapshots * (8 * balls + 16) + room if snapshots else 0, 2), dtype=np.int64),
        grid=grid,
        occupancy=np.zeros((*shape, width_of(OCCUPANCY))),
        height=np.zeros(width_of(HEIGHT)),
        works_before=np.zeros(TOTAL_WIDTH),
        works_now=np.zeros(TOTAL_WIDTH),
    )


def grid_edges(bounds: np.ndarray, recorder: Recorder) -> tuple[np.ndarray, np.ndarray]:
    """Edges of the occupancy grid's cells along x and y in the vessel's frame [m]."""
    cell_m = 1 / recorder.grid[GRID.cells_per_m]
    x, y = (bounds[0, axis] + cell_m * np.arange(recorder.occupancy.shape[axis] + 1) for axis in range(2))
    return x, y


logger = logging.getLogger("millprint")

# Arrays of the state that change; the rest follows from the configuration.
BALLS = (*state.MOVING, "species")
ARRAYS = ("totals", "counters", "numbers")
PIECES = ("samples", "snapshots", "poses", "snapshot_works", "snapshot_contacts")


def settings_of(simulation: "Simulation") -> dict[str, dict]:
    """Case, mill, contact set and settings of a simulation as plain values."""
    return {name: getattr(simulation, name).model_dump(mode="json") for name in ("case", "mill", "contact", "dem")}


def identity(simulation: "Simulation") -> str:
    """What must agree between a restart file and the run that continues it: all that decides its numbers.

    Tolerances are of it: until the run is finished, they decide whether its step is shortened, and when it fails.
    """
    case, mill, contact, dem = simulation.case, simulation.mill, simulation.contact, simulation.dem
    parts = {
        "case": case.model_dump(mode="json"),
        "tolerances": [case.closure_max or dem.closure_max, dem.overlap_max],
        **shared_identity(mill, contact, dem),
        "dem": dem_identity(dem),
        "code": [simulation_digest(), kernel_digest()],
        "shapes": hashlib.sha256(b"".join(body.vessel.vertices.tobytes() for body in simulation.bodies)).hexdigest(),
    }
    return json.dumps(parts, sort_keys=True)


def recorded_fraction(path: str | Path) -> float | None:
    """The step of a restart file as a fraction of its law's scale [-]; None without a file that can be read."""
    try:
        with h5py.File(path, "r") as file:
            return json.loads(file.attrs["identity"])["case"]["rayleigh_fraction"]
    except (OSError, KeyError, ValueError):
        return None


def continues(path: str | Path, simulation: "Simulation") -> bool:
    """Whether a simulation is that of a restart file, which can be read."""
    with h5py.File(path, "r") as file:
        return file.attrs["identity"] == identity(simulation)


def write_restart(path: str | Path, simulation: "Simulation", recording: Recording) -> None:
    """Write the state of a simulation and what it has recorded; a killed write leaves the file before it in place."""
    with whole_hdf5(path, checksum_header) as file:
        _write_state(file, simulation, recording)


def _write_state(file: h5py.File, simulation: "Simulation", recording: Recording) -> None:
    file.attrs["identity"] = identity(simulation)
    file.attrs["begin_step"] = simulation.begin_step
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


def read_restart(path: str | Path, simulation: "Simulation", recording: Recording) -> bool:
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


def _read_state(file: h5py.File, simulation: "Simulation") -> None:
    balls = {name: file[f"balls/{name}"][:] for name in BALLS}
    candidates = state.Candidates(**{name: file[f"candidates/{name}"][:] for name in state.Candidates._fields})
    contacts = state.Contacts(**{name: file[f"contacts/{name}"][:] for name in state.Contacts._fields})
    arrays = {name: file[name][:] for name in ARRAYS}
    clocks, begin_step = [float(seconds) for seconds in file.attrs["clocks_s"]], int(file.attrs["begin_step"])
    for name, array in balls.items():
        getattr(simulation.balls, name)[:] = array
    simulation.candidates, simulation.contacts = candidates, contacts
    for name, array in arrays.items():
        getattr(simulation, name)[:] = array
    simulation.begin_step = begin_step
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
