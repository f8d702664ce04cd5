"""What a run records: buffers that the kernel fills, and the pieces that are taken out of them."""

import math
from dataclasses import dataclass, field

import numpy as np

from millprint.dem import state
from millprint.dem.advance import SAMPLE_COLUMNS, Recorder, Table
from millprint.mill.pose import POSE

# Rows of the table of collisions before it is emptied.
TABLE_ROWS = 1 << 16
# Snapshots and energy samples before they are taken out.
SNAPSHOTS, SAMPLES = 256, 512


@dataclass
class Recording:
    """What a window has recorded so far, in pieces.

    contacts: columns of the table of collisions; snapshots: (m, n, 12); poses: (m, bodies, 18); snapshot_works: (m, 4);
    snapshot_contacts: (contacts, 2).
    """

    edges: tuple[np.ndarray, np.ndarray]
    occupancy: np.ndarray
    height: np.ndarray
    samples: list[np.ndarray] = field(default_factory=list)
    contacts: list[tuple[np.ndarray, ...]] = field(default_factory=list)
    snapshots: list[np.ndarray] = field(default_factory=list)
    poses: list[np.ndarray] = field(default_factory=list)
    snapshot_works: list[np.ndarray] = field(default_factory=list)
    snapshot_contacts: list[np.ndarray] = field(default_factory=list)

    @property
    def height_m(self) -> float:
        """Mean height of the balls' centres over the floor [m]."""
        return float(self.height[0] / self.height[1]) if self.height[1] else math.nan

    def drain(self, table: Table, recorder: Recorder, counters: np.ndarray) -> None:
        """Take what the buffers hold and empty them."""
        rows, samples = counters[state.RECORDS], counters[state.SAMPLES]
        snapshots, contacts = counters[state.SNAPSHOTS], counters[state.SNAPSHOT_CONTACTS]
        if rows:
            self.contacts.append(tuple(column[:rows].copy() for column in table))
        if samples:
            self.samples.append(recorder.sample[:samples].copy())
        if snapshots:
            self.snapshots.append(recorder.snapshot[:snapshots].copy())
            self.poses.append(recorder.snapshot_pose[:snapshots].copy())
            self.snapshot_works.append(recorder.snapshot_work[:snapshots].copy())
            self.snapshot_contacts.append(recorder.snapshot_contact[:contacts].copy())
        counters[[state.RECORDS, state.SAMPLES, state.SNAPSHOTS, state.SNAPSHOT_CONTACTS]] = 0


def make_table(rows: int) -> Table:
    """An empty table of collisions with room for `rows`; with none it records nothing."""
    whole = np.zeros(rows, dtype=np.int64)
    return Table(whole, whole.copy(), np.zeros(rows, dtype=np.uint8), np.zeros((rows, 9)))


def silent_recorder() -> Recorder:
    """A recorder that writes nothing."""
    return make_recorder(np.zeros((2, 2)), 1.0, 0, 0, np.iinfo(np.int64).max, (0, 0, 0), 0)


def make_recorder(
    bounds: np.ndarray, cell_m: float, balls: int, bodies: int, origin: int, every: tuple[int, int, int], room: int
) -> Recorder:
    """Buffers for a window that begins at step `origin`.

    bounds: (2, 2) of the vessel in plan, for a grid of occupancy with square cells [m]; every: steps between energy
    samples, snapshots and looks at the occupancy, 0 for never; room: contacts that may be open at a time.
    """
    sample_every, snapshot_every, occupancy_every = every
    shape = np.ceil((bounds[1] - bounds[0]) / cell_m).astype(int)
    snapshots = SNAPSHOTS if snapshot_every else 0
    return Recorder(
        origin=origin,
        sample_every=sample_every,
        snapshot_every=snapshot_every,
        occupancy_every=occupancy_every,
        sample=np.zeros((SAMPLES if sample_every else 0, len(SAMPLE_COLUMNS))),
        snapshot=np.zeros((snapshots, balls, 12)),
        snapshot_pose=np.zeros((snapshots, bodies, POSE)),
        snapshot_work=np.zeros((snapshots, 4)),
        snapshot_contact=np.zeros((snapshots * (8 * balls + 16) + room if snapshots else 0, 2), dtype=np.int64),
        grid=np.array([*bounds[0], 1 / cell_m]),
        occupancy=np.zeros((*shape, 5)),
        work=np.zeros((2, state.TOTALS)),
        height=np.zeros(2),
    )


def grid_edges(bounds: np.ndarray, recorder: Recorder) -> tuple[np.ndarray, np.ndarray]:
    """Edges of the occupancy grid's cells along x and y in the vessel's frame [m]."""
    cell_m = 1 / recorder.grid[2]
    return tuple(bounds[0, axis] + cell_m * np.arange(recorder.occupancy.shape[axis] + 1) for axis in range(2))
