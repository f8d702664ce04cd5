"""Frames of an animation as arrays ready to be drawn, and views of a mill from its description only.

The snapshots of a run, read in blocks, because a long run does not fit into memory.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path

import h5py
import numpy as np

from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.motion_kinds import MOTIONS
from millprint.config.view import ViewConfig
from millprint.fingerprint.mill_sheet import shown_speed
from millprint.mill.bodies import Body, build_bodies
from millprint.mill.creases import nearest_on_circle
from millprint.mill.curved_surfaces import touch_points
from millprint.mill.drawn_creases import crease_feet, crease_rows
from millprint.mill.wall_words import round_triangles, walls_in_words
from millprint.run.hdf5 import open_hdf5
from millprint.run.numbers import counted

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
        first = np.cumsum([0, *(len(getattr(self, name)) for name in FEATURES)])
        kind = np.searchsorted(first, feature, side="right") - 1
        local, feet = feature - first[kind], np.empty_like(points, dtype=float)
        facets, edges, corners, curves, rims, creases = (kind == number for number in range(len(FEATURES)))
        normal, offset = self.facet_normal[local[facets]], self.facet_offset_m[local[facets]]
        feet[facets] = points[facets] - ((points[facets] * normal).sum(axis=1) - offset)[:, None] * normal
        start, end = np.moveaxis(self.edge_m[local[edges]], 1, 0)
        along = ((points[edges] - start) * (end - start)).sum(axis=1) / ((end - start) ** 2).sum(axis=1)
        feet[edges] = start + np.clip(along, 0, 1)[:, None] * (end - start)
        feet[corners] = self.corner_m[local[corners]]
        for number in np.unique(local[curves]):
            on = curves & (local == number)
            distance, direction, _ = touch_points(self.curves, number, points[on])
            feet[on] = points[on] - distance[:, None] * direction
        for number in np.unique(local[rims]):
            on = rims & (local == number)
            feet[on] = nearest_on_circle(self.rims[number], points[on])
        for number in np.unique(local[creases]):
            on = creases & (local == number)
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


# Edges with a larger angle between their facets are drawn, in addition to the silhouette [rad].
SHARP = np.radians(30)
MARGIN_MM = 4.0
MM = 1e3
# Frames shown per second; each is shown for a whole number of 0.01 s.
FRAMES_PER_SECOND = 25


@dataclass(frozen=True)
class View:
    """A direction to look in: axes that point right, up and towards the eye (the last with its sign)."""

    title: str
    right: int
    up: int
    towards: int
    sign: int

    def flat(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) [m] in the plane of the view, (..., 2) [mm]."""
        return points[..., [self.right, self.up]] * MM

    def nearness(self, vectors: np.ndarray) -> np.ndarray:
        """Component of points or directions (..., 3) towards the eye."""
        return self.sign * vectors[..., self.towards]


VIEWS = (View("from above", 0, 1, 2, 1), View("from the side, along y", 0, 2, 1, -1))


@dataclass(frozen=True)
class Panel:
    """The constant part of a view: limits (2, 2) low and high [mm], path of the jar's middle (m, 2) [mm]."""

    title: str
    labels: tuple[str, str]
    limits_mm: np.ndarray
    path_mm: np.ndarray


@dataclass(frozen=True)
class Drawing:
    """The bodies in one view at one time, from the back to the front.

    wall_mm (t, 3, 2) triangles that face the eye; wall_shade (t,) cosine of their angle to the view, 1 for head on;
    outline_mm (k, 2, 2) lines of the vessel and insert_mm (j, 2, 2) of the inserts, which show through the balls;
    wall_is_flat (t,).
    """

    wall_mm: np.ndarray
    wall_shade: np.ndarray
    outline_mm: np.ndarray
    insert_mm: np.ndarray
    wall_is_flat: np.ndarray


@dataclass(frozen=True)
class Picture(Drawing):
    """The bodies and the balls in one view, the balls from the back to the front.

    centre_mm (balls, 2), radius_mm (balls,), speed_m_s (balls,), jar_mm (2,) the jar's middle.
    """

    centre_mm: np.ndarray
    radius_mm: np.ndarray
    speed_m_s: np.ndarray
    jar_mm: np.ndarray


@dataclass(frozen=True)
class Frame:
    """A moment: time [s] and revolutions since the mill started (None at rest), and a picture for each view."""

    time_s: float
    revolution: float | None
    pictures: tuple[Picture, ...]


@dataclass(frozen=True)
class Movie:
    """Everything that an animation draws, panels row by row. Speeds are relative to the wall, which moves."""

    heading: str
    speed_max_m_s: float
    delay_ms: int
    slow_motion: float
    panels: tuple[Panel, ...]
    frames: tuple[Frame, ...]
    columns: int = 1

    @property
    def pace(self) -> str:
        """The slow motion in words: "20 times slower", or "2.5 times faster" where a slow mill is shown fast."""
        slow = self.slow_motion
        return f"{slow:.3g} times slower" if slow >= 1 else f"{1 / slow:.3g} times faster"


class Shape:
    """A body's triangles, and the edges that can be seen."""

    def __init__(self, vertices_m: np.ndarray, triangles: np.ndarray, is_flat: np.ndarray | None = None) -> None:
        """is_flat (t,): which triangles are facets of a wall that looks round; none if it is left out."""
        # Imported here: slow to import, and a milling card imports this module even if it does not simulate.
        import trimesh

        mesh = trimesh.Trimesh(vertices_m, triangles, process=False)
        self.vertices_m, self.triangles, self.normals = vertices_m, triangles, mesh.face_normals
        self.middle_m = mesh.bounds.mean(axis=0)
        self.edges, self.sides = mesh.face_adjacency_edges, mesh.face_adjacency
        self.is_sharp = mesh.face_adjacency_angles > SHARP
        self.is_flat = np.zeros(len(triangles), dtype=bool) if is_flat is None else is_flat

    def seen(self, view: View, vertices_m: np.ndarray, rotation: np.ndarray) -> tuple[np.ndarray, ...]:
        """Triangles that face the eye, cosines of their angles to the view, and lines of silhouette and sharp edges."""
        facing = view.nearness(self.normals @ rotation.T)
        front = np.flatnonzero(facing > 1e-6)
        depth = view.nearness(vertices_m)[self.triangles[front]].mean(axis=1)
        front = front[np.argsort(depth)]
        flat = view.flat(vertices_m)
        is_seen = facing > 1e-6
        is_line = self.is_sharp | (is_seen[self.sides[:, 0]] != is_seen[self.sides[:, 1]])
        return flat[self.triangles[front]], facing[front], flat[self.edges[is_line]], self.is_flat[front]


class Stage:
    """A run's snapshots and the shapes of its bodies: makes frames and movies of balls in them."""

    def __init__(self, snapshots: Snapshots) -> None:
        """Read the shapes and poses of the bodies from an open file."""
        self.snapshots, self.blocks = snapshots, list(snapshots.blocks())
        self._shapes = [Shape(body.vertices_m, body.triangles) for body in snapshots.bodies]
        self._frequency_hz = frequency_of(snapshots.config)

    def frames(self, block: Block, times_s: np.ndarray, position: np.ndarray, velocity: np.ndarray) -> list[Frame]:
        """Frames of a block's bodies at times (n,) [s], with balls at `position` [m] of `velocity` (n, balls, 3)."""
        speed = np.linalg.norm(velocity - block.poses.velocity_at(position), axis=-1)
        frames = []
        for k, time_s in enumerate(times_s):
            turns = [pose.rotation[k] for pose in block.body_poses]
            places = [pose.position_m[k] for pose in block.body_poses]
            balls = position[k], self.snapshots.radius_m, speed[k]
            pictures = tuple(_picture(view, self._shapes, turns, places, *balls) for view in VIEWS)
            revolution = time_s * self._frequency_hz if self._frequency_hz else None
            frames.append(Frame(float(time_s), revolution, pictures))
        return frames

    @cached_property
    def _corners(self) -> np.ndarray:
        """Lower and upper corner (2, 3) of the space that the vessel's walls pass through [m]."""
        moved = [block.poses.to_laboratory(self.snapshots.geometry.vertices_m) for block in self.blocks]
        low, high = (np.array([end(points, axis=(0, 1)) for points in moved]) for end in (np.min, np.max))
        return np.array([low.min(axis=0), high.max(axis=0)])

    def panel(self, view: View, title: str, path_points: int | None = None) -> Panel:
        """A panel of the space that the walls pass through, with the first points of the path of the jar's middle."""
        middle = self._shapes[0].middle_m[None]
        path = np.concatenate([block.poses.to_laboratory(middle)[:, 0] for block in self.blocks])
        return Panel(
            title,
            (f"{'xyz'[view.right]} [mm]", f"{'xyz'[view.up]} [mm]"),
            view.flat(self._corners) + MARGIN_MM * np.array([[-1.0], [1.0]]),
            view.flat(path[:path_points]),
        )

    def movie(
        self,
        frames: Sequence[Frame],
        panels: Sequence[Panel],
        interval_s: float,
        frames_per_second: float,
        columns: int = 1,
    ) -> Movie:
        """A movie of frames that are interval_s apart; the first picture of each frame sets the scale of speeds."""
        mill, case = self.snapshots.config["mill"], self.snapshots.config["case"]
        balls = balls_in_words(self.snapshots.radius_m, case.get("mixture"))
        # GIF delays are multiples of 0.01 s.
        delay_ms = 10 * round(100 / frames_per_second)
        return Movie(
            heading=f"{mill['title']}\n{balls}, {shown_speed(mill.get('speed_unit', 'rpm'), case['speed_hz'])}",
            speed_max_m_s=max(float(frame.pictures[0].speed_m_s.max()) for frame in frames),
            delay_ms=delay_ms,
            slow_motion=delay_ms / 1e3 / interval_s if interval_s else 1.0,
            panels=tuple(panels),
            frames=tuple(frames),
            columns=columns,
        )


def read_movie(run: str | Path, settings: ViewConfig, start_s: float | None = None) -> Movie:
    """The first revolutions of a run's snapshots, or those from start_s (since the start of the mill) [s] on.

    Raises ConfigError for a run without snapshots or a start outside them.
    """
    with open_hdf5(run) as file:
        stage = Stage(_chosen(file, settings, start_s))
    time_s = stage.snapshots.time_s
    frames = [
        frame
        for block in stage.blocks
        for frame in stage.frames(block, time_s[block.rows], block.balls["position_m"], block.balls["velocity_m_s"])
    ]
    panels = [stage.panel(view, view.title, settings.frames_per_revolution + 1) for view in VIEWS]
    interval_s = float(time_s[-1] - time_s[0]) / max(1, len(time_s) - 1)
    return stage.movie(frames, panels, interval_s, FRAMES_PER_SECOND)


def balls_in_words(radius_m: np.ndarray, mixture: dict | None) -> str:
    """The balls of a run for a heading: their number and size or, for a mixture, its name and range of sizes."""
    smallest, largest = 2 * MM * radius_m.min(), 2 * MM * radius_m.max()
    sizes = f"{smallest:g} mm" if mixture is None else f"{mixture['name']}, {smallest:g} to {largest:g} mm"
    return f"{counted(len(radius_m), 'ball')} of {sizes}"


def frequency_of(config: dict) -> float:
    """Revolutions of the mill per second; 0 for a mill at rest."""
    motions = [config["mill"]["motion"], *(insert["motion"] for insert in config["mill"].get("inserts", []))]
    moves = any(MOTIONS[motion["kind"]].moves for motion in motions if motion)
    return config["case"]["speed_hz"] if moves else 0.0


def _chosen(file: h5py.File, settings: ViewConfig, start_s: float | None) -> Snapshots:
    """The number of snapshots in the settings, equally spaced in time."""
    every = Snapshots(file)
    time_s, frames = every.time_s, round(settings.revolutions * settings.frames_per_revolution)
    frequency_hz = frequency_of(every.config)
    if start_s is not None and not time_s[0] - 1e-9 <= start_s < time_s[-1]:
        raise ConfigError(
            f"{file.filename}: no snapshots from {start_s:g} s on; there are some from {time_s[0]:g} to "
            f"{time_s[-1]:g} s after the start of the mill"
        )
    first = 0 if start_s is None else int(np.searchsorted(time_s, start_s - 1e-9))
    if not frequency_hz or len(time_s) < 2:
        return Snapshots(file, max(1, (len(time_s) - first) // frames), first)
    interval_s = (time_s[-1] - time_s[0]) / (len(time_s) - 1)
    stride = max(1, round(1 / frequency_hz / settings.frames_per_revolution / interval_s))
    # The frame at the end of the last revolution would repeat the jar's position in the first.
    last = min(len(time_s), first + round(settings.revolutions / frequency_hz / interval_s))
    return Snapshots(file, stride, first, max(last, first + 1))


def draw_bodies(view: View, shapes: list[Shape], vertices: list[np.ndarray], rotations: list[np.ndarray]) -> Drawing:
    """The vessel and its inserts in a view; vertices (v, 3) [m] in the laboratory and a rotation for each body."""
    seen = [shape.seen(view, *pose) for shape, *pose in zip(shapes, vertices, rotations, strict=True)]
    walls, shades, lines, flat = zip(*seen, strict=True)
    inserts = np.concatenate([np.empty((0, 2, 2)), *lines[1:]])
    return Drawing(np.concatenate(walls), np.concatenate(shades), lines[0], inserts, np.concatenate(flat))


def _picture(
    view: View,
    shapes: list[Shape],
    turns: list[np.ndarray],
    places: list[np.ndarray],
    position: np.ndarray,
    radius: np.ndarray,
    speed: np.ndarray,
) -> Picture:
    """One view of bodies, the vessel first, and balls: position (balls, 3) [m], radius [m], speed [m/s] (balls,)."""
    vertices = [shape.vertices_m @ turn.T + place for shape, turn, place in zip(shapes, turns, places, strict=True)]
    middle = turns[0] @ shapes[0].middle_m + places[0]
    order = np.argsort(view.nearness(position))
    drawing = draw_bodies(view, shapes, vertices, turns)
    return Picture(
        **vars(drawing),
        centre_mm=view.flat(position[order]),
        radius_mm=radius[order] * MM,
        speed_m_s=speed[order],
        jar_mm=view.flat(middle),
    )


FRAMES = 8
PATH_POINTS = 361
# A margin around everything that moves, as a fraction of its size.
MARGIN = 0.06


@dataclass(frozen=True)
class Look(Drawing):
    """A mill in one view at one moment, with the marked point mark_mm (2,)."""

    mark_mm: np.ndarray


@dataclass(frozen=True)
class MillPicture:
    """Views of a mill at the start of a turn, and a strip of FRAMES moments in the view that shows most of its motion.

    path_mm (m, 2): the path of a marked point of the wall (of the first insert, if the vessel does not move) in the
    view of the strip; limits_mm (2, 2) of every view in turn, and of the strip; mark_mm in a `Look` is that point.
    """

    title: str
    walls: str
    speed_unit: str
    views: tuple[View, ...]
    looks: tuple[Look, ...]
    limits_mm: tuple[np.ndarray, ...]
    strip_view: View
    strip: tuple[Look, ...]
    strip_limits_mm: np.ndarray
    path_mm: np.ndarray


def _picture_of(view: View, bodies: list[Body], shapes: list[Shape], mark: tuple[int, np.ndarray], turn: float) -> Look:
    vertices = [body.to_laboratory(shape.vertices_m, turn) for body, shape in zip(bodies, shapes, strict=True)]
    drawing = draw_bodies(view, shapes, vertices, [body.motion.rotation(turn) for body in bodies])
    body, point = mark
    return Look(**vars(drawing), mark_mm=view.flat(bodies[body].to_laboratory(point[None], turn))[0])


def _limits(view: View, points: np.ndarray) -> np.ndarray:
    flat = view.flat(points).reshape(-1, 2)
    low, high = flat.min(axis=0), flat.max(axis=0)
    return np.array([low, high]) + MARGIN * (high - low).max() * np.array([[-1.0], [1.0]])


def picture_mill(mill: MillConfig) -> MillPicture:
    """The picture of a mill; raises ConfigError for a shape or a motion that is refused."""
    bodies = build_bodies(mill)
    shapes = [Shape(*body.vessel.triangles(), round_triangles(body.vessel)) for body in bodies]
    # One turn per second, so that times are turns.
    turns = np.arange(FRAMES) / FRAMES
    moving = next((k for k, body in enumerate(bodies) if body.motion.frequency_hz), 0)
    corners = shapes[moving].vertices_m
    # The vertex farthest from the middle of the body's bounds is easiest to follow.
    mark = moving, corners[np.argmax(np.linalg.norm(corners - shapes[moving].middle_m, axis=1))]
    times = np.linspace(0, 1, PATH_POINTS)
    path = np.array([bodies[moving].to_laboratory(mark[1][None], time)[0] for time in times])
    everywhere = np.concatenate([
        body.to_laboratory(shape.vertices_m, turn) for turn in turns for body, shape in zip(bodies, shapes, strict=True)
    ])  # fmt: skip
    spans = [np.ptp(view.flat(path), axis=0) for view in VIEWS]
    strip_view = VIEWS[int(np.argmax([span.prod() + 1e-6 * span.sum() for span in spans]))]
    start = [body.to_laboratory(shape.vertices_m, 0.0) for body, shape in zip(bodies, shapes, strict=True)]
    return MillPicture(
        title=mill.title,
        walls=f"wall: {walls_in_words(bodies)}",
        speed_unit=mill.speed_unit,
        views=VIEWS,
        looks=tuple(_picture_of(view, bodies, shapes, mark, 0.0) for view in VIEWS),
        limits_mm=tuple(_limits(view, np.concatenate(start)) for view in VIEWS),
        strip_view=strip_view,
        strip=tuple(_picture_of(strip_view, bodies, shapes, mark, turn) for turn in turns),
        strip_limits_mm=_limits(strip_view, everywhere),
        path_mm=strip_view.flat(path),
    )
