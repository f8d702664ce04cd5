"""A simulation, and what something else makes of its state at one moment, in one animation."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from millprint.config.view import ViewConfig
from millprint.errors import ConfigError
from millprint.view.frames import (
    MM,
    VIEWS,
    Frame,
    Movie,
    Shape,
    bounds_of,
    frequency_of,
    heading_of,
    panel_of,
    picture_of,
)
from millprint.view.snapshots import Block, Snapshots, open_run


@dataclass(frozen=True)
class Replay:
    """Balls over time_s (n,) after start_s of a simulation [s]: position_m and velocity_m_s (n, balls, 3)."""

    name: str
    start_s: float
    time_s: np.ndarray
    position_m: np.ndarray
    velocity_m_s: np.ndarray


def read_comparison(run: str | Path, replay: Replay, settings: ViewConfig) -> Movie:
    """The simulation and its replay from above, one panel each, from the moment that they share.

    As many revolutions as the settings want and the replay has. Raises ConfigError where the run has no snapshots
    over the time of the replay.
    """
    with open_run(run) as file:
        every = Snapshots(file)
        first, stride, rows = _rows(file.filename, every, replay, settings)
        snapshots = Snapshots(file, stride, first, first + stride * (len(rows) - 1) + 1)
        blocks = list(snapshots.blocks())
    shapes = [Shape(body.vertices_m, body.triangles) for body in snapshots.bodies]
    frames = [frame for block in blocks for frame in _frames(block, snapshots, shapes, replay, rows)]
    middle = np.concatenate([block.poses.to_laboratory(shapes[0].middle_m[None])[:, 0] for block in blocks])
    corners, view = bounds_of(snapshots, blocks), VIEWS[0]
    delay_ms = 10 * round(100 / settings.frames_per_second)
    path = middle[: settings.frames_per_revolution + 1]
    interval_s = float(snapshots.time_s[-1] - snapshots.time_s[0]) / max(1, len(snapshots) - 1)
    return Movie(
        heading=heading_of(snapshots),
        radius_mm=snapshots.radius_m * MM,
        speed_max_m_s=max(float(frame.pictures[0].speed_m_s.max()) for frame in frames),
        delay_ms=delay_ms,
        slow_motion=delay_ms / 1e3 / interval_s if interval_s else 1.0,
        panels=tuple(panel_of(view, f"{name}, {view.title}", corners, path) for name in ("simulation", replay.name)),
        frames=tuple(frames),
    )


def _rows(path: str, snapshots: Snapshots, replay: Replay, settings: ViewConfig) -> tuple[int, int, np.ndarray]:
    """First snapshot and stride between the snapshots to show, and the rows of the replay at the same times."""
    time_s = snapshots.time_s
    interval_s = float(time_s[-1] - time_s[0]) / max(1, len(time_s) - 1)
    own_s = float(replay.time_s[1] - replay.time_s[0])
    period_s = 1 / frequency_of(snapshots.config) if frequency_of(snapshots.config) else float(replay.time_s[-1])
    # The replay keeps fewer states than the run has snapshots: frames fall on its own.
    step = max(1, round(period_s / settings.frames_per_revolution / own_s))
    rows = np.arange(0, len(replay.time_s), step)
    rows = rows[replay.time_s[rows] <= settings.revolutions * period_s * (1 + 1e-9)]
    first, stride = round((replay.start_s - float(time_s[0])) / interval_s), round(step * own_s / interval_s)
    if first < 0 or stride < 1 or first + stride * (len(rows) - 1) >= len(time_s):
        raise ConfigError(
            f"{path}: no snapshots from {replay.start_s:g} s on for {replay.time_s[rows[-1]]:g} s; there are some from "
            f"{time_s[0]:g} to {time_s[-1]:g} s after the start of the mill"
        )
    return first, stride, rows


def _frames(block: Block, snapshots: Snapshots, shapes: list[Shape], replay: Replay, rows: np.ndarray) -> list[Frame]:
    poses, frequency_hz = block.poses, frequency_of(snapshots.config)
    shown = rows[block.rows]
    pairs = [
        (block.balls["position_m"], block.balls["velocity_m_s"]),
        (replay.position_m[shown], replay.velocity_m_s[shown]),
    ]
    speeds = [np.linalg.norm(velocity - poses.velocity_at(position), axis=-1) for position, velocity in pairs]
    frames = []
    for k, time_s in enumerate(snapshots.time_s[block.rows]):
        pictures = tuple(
            picture_of(VIEWS[0], shapes, block.body_poses, k, position[k], speed[k])
            for (position, _), speed in zip(pairs, speeds, strict=True)
        )
        frames.append(Frame(float(time_s), time_s * frequency_hz if frequency_hz else None, pictures))
    return frames
