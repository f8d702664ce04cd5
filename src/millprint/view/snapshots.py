"""The snapshots of a run, read in blocks, because a long run does not fit into memory."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial

import h5py
import numpy as np

from millprint.config.errors import ConfigError
from millprint.mill.creases import nearest_on_circle
from millprint.mill.curved_surfaces import touch_points
from millprint.mill.drawn_creases import crease_feet, crease_rows

PER_BALL = ("position_m", "velocity_m_s", "spin_rad_s", "contact_force_N")
PER_CONTACT = ("contact_first", "contact_second")
FEATURES = ("facet_normal", "edge_m", "corner_m", "curves", "rims", "creases")
GEOMETRY = ("vertices_m", "triangles", "facet_normal", "facet_offset_m", "edge_m", "corner_m", "curves", "rims")

# Numbers of one quantity in a block: tens of megabytes for all quantities together.
BLOCK_VALUES = 1_000_000


@dataclass(frozen=True)
class Geometry:
    """Walls in the body frame [m].

    vertices_m (v, 3) and triangles (t, 3), normals inward; features that a ball can touch, numbered in this order:
    facets (facet_normal . x = facet_offset_m), convex lines edge_m (e, 2, 3) by their ends, corners corner_m (c, 3),
    curves (k, width) and rims (r, width) in the columns of mill.curved_surfaces.CurveColumns and mill.rims.RimColumns,
    creases (c, rows, degree + 1) in the rows of mill.creases.CreaseRows, which runs have whose walls have some.
    """

    vertices_m: np.ndarray
    triangles: np.ndarray
    facet_normal: np.ndarray
    facet_offset_m: np.ndarray
    edge_m: np.ndarray
    corner_m: np.ndarray
    curves: np.ndarray
    rims: np.ndarray
    creases: np.ndarray = field(default_factory=partial(crease_rows, ()))

    def foot(self, feature: np.ndarray, points: np.ndarray) -> np.ndarray:
        """The point (n, 3) of wall feature (n,) that is nearest to points (n, 3), all in the body frame [m]."""
        feet = np.empty_like(points, dtype=float)
        facets, edges, corners = len(self.facet_normal), len(self.edge_m), len(self.corner_m)
        on = feature < facets
        normal, offset = self.facet_normal[feature[on]], self.facet_offset_m[feature[on]]
        feet[on] = points[on] - ((points[on] * normal).sum(axis=1) - offset)[:, None] * normal
        on = (feature >= facets) & (feature < facets + edges)
        start, end = np.moveaxis(self.edge_m[feature[on] - facets], 1, 0)
        along = ((points[on] - start) * (end - start)).sum(axis=1) / ((end - start) ** 2).sum(axis=1)
        feet[on] = start + np.clip(along, 0, 1)[:, None] * (end - start)
        on = (feature >= facets + edges) & (feature < facets + edges + corners)
        feet[on] = self.corner_m[feature[on] - facets - edges]
        for number in range(len(self.curves)):
            on = feature == facets + edges + corners + number
            distance, direction, _ = touch_points(self.curves, number, points[on])
            feet[on] = points[on] - distance[:, None] * direction
        for number, rim in enumerate(self.rims):
            on = feature == facets + edges + corners + len(self.curves) + number
            feet[on] = nearest_on_circle(rim, points[on])
        for number in range(len(self.creases)):
            on = feature == facets + edges + corners + len(self.curves) + len(self.rims) + number
            feet[on] = crease_feet(self.creases, number, points[on])
        return feet


@dataclass(frozen=True)
class Poses:
    """A body at n times: (n, 3) each, and its rotation (n, 3, 3) to the laboratory."""

    position_m: np.ndarray
    velocity_m_s: np.ndarray
    rotation: np.ndarray
    angular_velocity_rad_s: np.ndarray

    def to_laboratory(self, points: np.ndarray) -> np.ndarray:
        """Points (p, 3) of the body in the laboratory, (n, p, 3) [m]."""
        return np.einsum("nij,pj->npi", self.rotation, points) + self.position_m[:, None]

    def velocity_at(self, points: np.ndarray) -> np.ndarray:
        """Velocity of the wall, V + omega x (x - X), at laboratory points (n, p, 3) [m/s]."""
        return self.velocity_m_s[:, None] + np.cross(
            self.angular_velocity_rad_s[:, None], points - self.position_m[:, None]
        )


@dataclass(frozen=True)
class Block:
    """Consecutive chosen snapshots; `rows`: their numbers among the chosen ones.

    balls: quantities of PER_BALL, (n, balls, 3) each; poses: of the vessel, body_poses: of the vessel and the inserts;
    contact_count (n,); first and second, over the contacts of all snapshots in turn: a ball, and a ball or -1 - feature
    of the walls.
    """

    rows: slice
    balls: dict[str, np.ndarray]
    body_poses: tuple[Poses, ...]
    contact_count: np.ndarray
    first: np.ndarray
    second: np.ndarray

    @property
    def poses(self) -> Poses:
        """Where the vessel is."""
        return self.body_poses[0]

    @property
    def contact_step(self) -> np.ndarray:
        """The snapshot within the block that each contact belongs to."""
        return np.repeat(np.arange(len(self.contact_count)), self.contact_count)


def body_of_feature(bodies: Sequence[Geometry], feature: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The body (n,) that features (n,) belong to, and their numbers (n,) within it.

    Features are numbered as the simulation does: the facets of all bodies first, then convex lines, corners, curves,
    rims and creases.
    """
    counts = np.array([[len(getattr(body, name)) for body in bodies] for name in FEATURES])
    owner = np.concatenate([np.repeat(np.arange(len(bodies)), row) for row in counts])
    # The order within a body is the same: facets, lines, corners, curves, rims, creases.
    before = np.cumsum(np.vstack([np.zeros(len(bodies), dtype=int), counts[:-1]]), axis=0)
    local = np.concatenate([first + np.arange(k) for k, first in zip(counts.ravel(), before.ravel(), strict=True)])
    return owner[feature], local[feature]


def _geometry(group: h5py.Group) -> Geometry:
    creases = group["creases"][:] if "creases" in group else crease_rows(())
    return Geometry(**{name: group[name][:] for name in GEOMETRY}, creases=creases)


class Snapshots:
    """One snapshot in `every` of an open run.h5, from row `first` up to, but without, row `last`.

    time_s (n,); normal_J and tangential_J (n,) dissipated since the previous chosen snapshot, 0 for the first;
    contact_count (n,); radius_m (balls,) of every ball. Raises ConfigError for a run without snapshots, and KeyError
    for a part that is missing.
    """

    def __init__(self, file: h5py.File, every: int = 1, first: int = 0, last: int | None = None) -> None:
        path = file.filename
        if every < 1:
            raise ConfigError(f"every = {every}: must be 1 or more, to take every n-th snapshot")
        if "snapshots" not in file:
            raise ConfigError(
                f"{path}: no snapshots: set snapshot_interval_s in the sweep of this case, and simulate it again"
            )
        self._group = file["snapshots"]
        self.config = json.loads(file.attrs["config"])
        self.inserts = [insert["name"] for insert in self.config["mill"].get("inserts", [])]
        groups = ["geometry", *(f"geometry/inserts/{name}" for name in self.inserts)]
        self.bodies = tuple(_geometry(file[group]) for group in groups)
        self.balls = self._group["position_m"].shape[1]
        self.radius_m = file["balls/radius_m"][:]
        self._rows = slice(first, len(self._group["time_s"]) if last is None else last, every)
        self.time_s = self._group["time_s"][self._rows]
        if not len(self.time_s):
            raise ConfigError(f"{path}: no snapshot between numbers {first} and {last}")

        self.contact_count = np.diff(self._group["contact_offset"][:])[self._rows]
        self.normal_J, self.tangential_J = (self._since_before(name) for name in ("normal_J", "tangential_J"))

    def __len__(self) -> int:
        return len(self.time_s)

    @property
    def geometry(self) -> Geometry:
        """The vessel's walls."""
        return self.bodies[0]

    def _since_before(self, name: str) -> np.ndarray:
        """Energy since the previous chosen snapshot, including the snapshots between."""
        begin, end, every = self._rows.start, self._rows.stop, self._rows.step
        total = np.cumsum(self._group[name][begin:end])[::every]
        return np.diff(total, prepend=total[0])

    def blocks(self) -> Iterator[Block]:
        """The chosen snapshots in turn, as many at a time as fit into memory."""
        largest = max(self.balls, sum(len(body.vertices_m) for body in self.bodies))
        size = max(1, BLOCK_VALUES // (3 * largest))
        for begin in range(0, len(self), size):
            rows = slice(begin, min(begin + size, len(self)))
            yield self._block(rows)

    def _block(self, rows: slice) -> Block:
        every = self._rows.step
        stored = slice(self._rows.start + rows.start * every, self._rows.start + (rows.stop - 1) * every + 1, every)
        offset = self._group["contact_offset"][stored.start : stored.stop + 1]
        is_chosen = np.zeros(len(offset) - 1, dtype=bool)
        is_chosen[::every] = True
        kept = np.repeat(is_chosen, np.diff(offset))
        first, second = (self._group[name][offset[0] : offset[-1]][kept] for name in PER_CONTACT)
        balls = {name: self._group[name][stored] for name in PER_BALL}
        groups = [self._group, *(self._group[f"inserts/{name}"] for name in self.inserts)]
        poses = tuple(self._poses(group, stored) for group in groups)
        return Block(rows, balls, poses, self.contact_count[rows], first, second)

    @staticmethod
    def _poses(group: h5py.Group, stored: slice) -> Poses:
        """Poses of a body; the rotation of a body that only translates is not recorded."""
        position, velocity = group["body_position_m"][stored], group["body_velocity_m_s"][stored]
        if "body_rotation" in group:
            return Poses(position, velocity, group["body_rotation"][stored], group["body_spin_rad_s"][stored])
        return Poses(position, velocity, np.broadcast_to(np.eye(3), (len(position), 3, 3)), np.zeros_like(position))
