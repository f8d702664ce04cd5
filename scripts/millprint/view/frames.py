"""An animation's frames as arrays ready to be drawn: what is seen of balls and jar from above and from the side."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import trimesh

from millprint.config.motion import motion_kind
from millprint.config.view import ViewConfig
from millprint.errors import ConfigError
from millprint.view.snapshots import Block, Poses, Snapshots, open_run

# Edges at which the wall turns by more than this are drawn, besides the silhouette [rad].
SHARP = np.radians(30)
MARGIN_MM = 4.0
MM = 1e3


@dataclass(frozen=True)
class View:
    """A direction to look in: axes that point right, up and towards the eye (the last with its sign)."""

    title: str
    right: int
    up: int
    towards: int
    sign: int

    def flat(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) [m] as they are seen, (..., 2) [mm]."""
        return points[..., [self.right, self.up]] * MM

    def nearness(self, vectors: np.ndarray) -> np.ndarray:
        """How far points or directions (..., 3) lie towards the eye."""
        return self.sign * vectors[..., self.towards]


VIEWS = (View("from above", 0, 1, 2, 1), View("from the side, along y", 0, 2, 1, -1))


@dataclass(frozen=True)
class Panel:
    """What one view shows all the time: limits (2, 2) low and high [mm], path of the jar's middle (m, 2) [mm]."""

    title: str
    labels: tuple[str, str]
    limits_mm: np.ndarray
    path_mm: np.ndarray


@dataclass(frozen=True)
class Picture:
    """One view at one time, everything from the back to the front.

    wall_mm (t, 3, 2) triangles that face the eye, with how squarely they do, wall_shade (t,), 1 for head on;
    outline_mm (k, 2, 2); centre_mm (balls, 2) and speed_m_s (balls,); jar_mm (2,) the jar's middle; insert_mm
    (j, 2, 2) lines of the inserts, which show through the balls.
    """

    wall_mm: np.ndarray
    wall_shade: np.ndarray
    outline_mm: np.ndarray
    centre_mm: np.ndarray
    speed_m_s: np.ndarray
    jar_mm: np.ndarray
    insert_mm: np.ndarray


@dataclass(frozen=True)
class Frame:
    """A moment: time [s] and revolutions since the mill started (None for a mill at rest), a picture a view."""

    time_s: float
    revolution: float | None
    pictures: tuple[Picture, ...]


@dataclass(frozen=True)
class Movie:
    """Everything that an animation draws, panels row by row. Speeds are relative to the wall, which moves."""

    heading: str
    radius_mm: float
    speed_max_m_s: float
    delay_ms: int
    slow_motion: float
    panels: tuple[Panel, ...]
    frames: tuple[Frame, ...]
    columns: int = 1


class Shape:
    """A body's triangles, and the edges that can be seen."""

    def __init__(self, vertices_m: np.ndarray, triangles: np.ndarray) -> None:
        mesh = trimesh.Trimesh(vertices_m, triangles, process=False)
        self.vertices_m, self.triangles, self.normals = vertices_m, triangles, mesh.face_normals
        self.middle_m = mesh.bounds.mean(axis=0)
        self.edges, self.sides = mesh.face_adjacency_edges, mesh.face_adjacency
        self.is_sharp = mesh.face_adjacency_angles > SHARP

    def seen(self, view: View, vertices_m: np.ndarray, rotation: np.ndarray) -> tuple[np.ndarray, ...]:
        """Triangles that face the eye, how squarely, and the lines of silhouette and sharp edges."""
        facing = view.nearness(self.normals @ rotation.T)
        front = np.flatnonzero(facing > 1e-6)
        depth = view.nearness(vertices_m)[self.triangles[front]].mean(axis=1)
        front = front[np.argsort(depth)]
        flat = view.flat(vertices_m)
        is_seen = facing > 1e-6
        is_line = self.is_sharp | (is_seen[self.sides[:, 0]] != is_seen[self.sides[:, 1]])
        return flat[self.triangles[front]], facing[front], flat[self.edges[is_line]]


def read_movie(run: str | Path, settings: ViewConfig, start_s: float | None = None) -> Movie:
    """The first revolutions of a run's snapshots, or those from start_s (since the start of the mill) [s] on.

    Raises ConfigError for a run without snapshots or a start outside them.
    """
    with open_run(run) as file:
        snapshots = _chosen(file, settings, start_s)
        blocks = list(snapshots.blocks())
    frequency_hz = frequency_of(snapshots.config)
    shapes = [Shape(body.vertices_m, body.triangles) for body in snapshots.bodies]
    frames = [frame for block in blocks for frame in _frames(block, snapshots, shapes, frequency_hz)]
    middle = np.concatenate([block.poses.to_laboratory(shapes[0].middle_m[None])[:, 0] for block in blocks])
    low, high = bounds_of(snapshots, blocks)
    delay_ms = delay_of(settings.frames_per_second)
    interval_s = float(snapshots.time_s[-1] - snapshots.time_s[0]) / max(1, len(snapshots) - 1)
    return Movie(
        heading=heading_of(snapshots),
        radius_mm=snapshots.radius_m * MM,
        speed_max_m_s=max(float(frame.pictures[0].speed_m_s.max()) for frame in frames),
        delay_ms=delay_ms,
        slow_motion=delay_ms / 1e3 / interval_s if interval_s else 1.0,
        panels=tuple(
            panel_of(view, view.title, (low, high), middle[: settings.frames_per_revolution + 1]) for view in VIEWS
        ),
        frames=tuple(frames),
    )


def panel_of(view: View, title: str, corners: tuple[np.ndarray, np.ndarray], path_m: np.ndarray) -> Panel:
    """A panel that holds everything between two corners (3,) [m], with the path (m, 3) [m] of the jar's middle."""
    return Panel(
        title,
        (f"{'xyz'[view.right]} [mm]", f"{'xyz'[view.up]} [mm]"),
        view.flat(np.array(corners)) + MARGIN_MM * np.array([[-1.0], [1.0]]),
        view.flat(path_m),
    )


def frequency_of(config: dict) -> float:
    """Revolutions of the mill in a second; 0 for one at rest."""
    motions = [config["mill"]["motion"], *(insert["motion"] for insert in config["mill"].get("inserts", []))]
    moves = any(motion_kind(motion["kind"]).moves for motion in motions if motion)
    return config["case"]["speed_rpm"] / 60 if moves else 0.0


def _chosen(file: h5py.File, settings: ViewConfig, start_s: float | None) -> Snapshots:
    """As many snapshots as the settings want, at equal distances."""
    every = Snapshots(file)
    time_s, wanted = every.time_s, round(settings.revolutions * settings.frames_per_revolution)
    frequency_hz = frequency_of(every.config)
    if start_s is not None and not time_s[0] - 1e-9 <= start_s < time_s[-1]:
        raise ConfigError(
            f"{file.filename}: no snapshots from {start_s:g} s on; there are some from {time_s[0]:g} to "
            f"{time_s[-1]:g} s after the start of the mill"
        )
    first = 0 if start_s is None else int(np.searchsorted(time_s, start_s - 1e-9))
    if not frequency_hz or len(time_s) < 2:
        return Snapshots(file, max(1, (len(time_s) - first) // wanted), first)
    interval_s = (time_s[-1] - time_s[0]) / (len(time_s) - 1)
    stride = max(1, round(1 / frequency_hz / settings.frames_per_revolution / interval_s))
    # The frame that ends the last revolution would repeat the jar's place of the first.
    last = min(len(time_s), first + round(settings.revolutions / frequency_hz / interval_s))
    return Snapshots(file, stride, first, max(last, first + 1))


def heading_of(snapshots: Snapshots) -> str:
    """The mill and the case, as an animation's heading."""
    mill, case = snapshots.config["mill"], snapshots.config["case"]
    return f"{mill['title']}\n{snapshots.balls} balls of {case['ball_diameter_mm']:g} mm, {case['speed_rpm']:g} rpm"


def bounds_of(snapshots: Snapshots, blocks: list[Block]) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corner (3,) of all that the walls pass through [m]."""
    moved = [block.poses.to_laboratory(snapshots.geometry.vertices_m) for block in blocks]
    return np.min([points.min(axis=(0, 1)) for points in moved], axis=0), np.max(
        [points.max(axis=(0, 1)) for points in moved], axis=0
    )


def draw_bodies(
    view: View, shapes: list[Shape], vertices: list[np.ndarray], rotations: list[np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """What a view shows of the vessel and of the inserts in it: triangles, how squarely they face the eye, the lines
    of the vessel, and those of the inserts. vertices (v, 3) [m] in the laboratory and rotations (3, 3), one a body."""
    seen = [shape.seen(view, *pose) for shape, *pose in zip(shapes, vertices, rotations, strict=True)]
    wall, shade = (np.concatenate([part[k] for part in seen]) for k in (0, 1))
    inserts = np.concatenate([np.empty((0, 2, 2)), *(part[2] for part in seen[1:])])
    return wall, shade, seen[0][2], inserts


def _frames(block: Block, snapshots: Snapshots, shapes: list[Shape], frequency_hz: float) -> list[Frame]:
    position, velocity = (block.balls[name] for name in ("position_m", "velocity_m_s"))
    return frames_at(snapshots.time_s[block.rows], position, velocity, block.body_poses, shapes, frequency_hz)


def frames_at(
    times_s: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
    body_poses: Sequence[Poses],
    shapes: list[Shape],
    frequency_hz: float,
) -> list[Frame]:
    """Frames of balls at `position` with `velocity`, (n, balls, 3) each, in a mill at n poses of its bodies."""
    speed = np.linalg.norm(velocity - body_poses[0].velocity_at(position), axis=-1)
    frames = []
    for k, time_s in enumerate(times_s):
        pictures = tuple(picture_of(view, shapes, body_poses, k, position[k], speed[k]) for view in VIEWS)
        frames.append(Frame(float(time_s), time_s * frequency_hz if frequency_hz else None, pictures))
    return frames


def delay_of(frames_per_second: float) -> int:
    """Time that a frame is shown [ms]; the delays of a GIF are hundredths of a second."""
    return 10 * round(100 / frames_per_second)


def picture_of(
    view: View, shapes: list[Shape], body_poses: Sequence[Poses], k: int, position: np.ndarray, speed: np.ndarray
) -> Picture:
    """One view at pose k of the bodies, the vessel first, with balls at (balls, 3) [m] of speeds (balls,) [m/s]."""
    turns, places = [pose.rotation[k] for pose in body_poses], [pose.position_m[k] for pose in body_poses]
    vertices = [shape.vertices_m @ turn.T + place for shape, turn, place in zip(shapes, turns, places, strict=True)]
    middle = turns[0] @ shapes[0].middle_m + places[0]
    order = np.argsort(view.nearness(position))
    wall, shade, outline, inserts = draw_bodies(view, shapes, vertices, turns)
    centre = view.flat(position[order])
    return Picture(wall, shade, outline, centre, speed[order], view.flat(middle), inserts)
