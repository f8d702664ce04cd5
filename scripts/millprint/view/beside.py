"""Balls of a prediction beside those of the simulation: frames of both in one movie."""

from pathlib import Path

import numpy as np

from millprint.errors import ConfigError
from millprint.view.frames import (
    MM,
    VIEWS,
    Frame,
    Movie,
    Shape,
    bounds_of,
    delay_of,
    frames_at,
    frequency_of,
    heading_of,
    panel_of,
)
from millprint.view.snapshots import Snapshots, open_run

NAMES = ("DEM", "surrogate")
# Where a ball that ran away is drawn: out of every picture, and no number that a renderer chokes on [m].
AWAY_M = 1.0


def movie_beside(
    run: str | Path,
    time_s: np.ndarray,
    position_m: np.ndarray,
    velocity_m_s: np.ndarray,
    every: int,
    frames_per_second: int,
) -> Movie:
    """A movie with the simulation on the left and a prediction of it on the right.

    time_s (n,) of motion, position_m and velocity_m_s (n, balls, 3): the prediction, of which every `every`-th frame
    is shown. Raises ConfigError for a run without snapshots at those times.
    """
    chosen = slice(None, None, every)
    with open_run(run) as file:
        first, stride, last = _rows(file["snapshots/time_s"][:] if "snapshots" in file else None, time_s[chosen], run)
        snapshots = Snapshots(file, stride, first, last)
        blocks = list(snapshots.blocks())
    shapes = [Shape(body.vertices_m, body.triangles) for body in snapshots.bodies]
    frequency_hz, rows = frequency_of(snapshots.config), [time_s[chosen][block.rows] for block in blocks]
    simulated, predicted = [], []
    for block, moments in zip(blocks, rows, strict=True):
        place, motion = (
            np.nan_to_num(values[chosen][block.rows], nan=AWAY_M, posinf=AWAY_M, neginf=-AWAY_M)
            for values in (position_m, velocity_m_s)
        )
        rest = block.body_poses, shapes, frequency_hz
        simulated += frames_at(moments, block.balls["position_m"], block.balls["velocity_m_s"], *rest)
        predicted += frames_at(moments, np.clip(place, -AWAY_M, AWAY_M), motion, *rest)
    middle = np.concatenate([block.poses.to_laboratory(shapes[0].middle_m[None])[:, 0] for block in blocks])
    corners = bounds_of(snapshots, blocks)
    interval_s = float(time_s[chosen][1] - time_s[chosen][0])
    delay_ms = delay_of(frames_per_second)
    return Movie(
        heading=heading_of(snapshots),
        radius_mm=snapshots.radius_m * MM,
        speed_max_m_s=max(float(frame.pictures[0].speed_m_s.max()) for frame in simulated),
        delay_ms=delay_ms,
        slow_motion=delay_ms / 1e3 / interval_s,
        panels=tuple(panel_of(view, f"{name}, {view.title}", corners, middle) for view in VIEWS for name in NAMES),
        frames=tuple(_together(*pair) for pair in zip(simulated, predicted, strict=True)),
        columns=len(NAMES),
    )


def _together(simulated: Frame, predicted: Frame) -> Frame:
    pairs = zip(simulated.pictures, predicted.pictures, strict=True)
    return Frame(simulated.time_s, simulated.revolution, tuple(picture for pair in pairs for picture in pair))


def _rows(recorded_s: np.ndarray | None, wanted_s: np.ndarray, run: str | Path) -> tuple[int, int, int]:
    """First, stride and last of the snapshots at the wanted times."""
    refusal = f"{run}: no snapshots at the frames of the roll-out: set snapshot_interval_s to divide them"
    if recorded_s is None:
        raise ConfigError(refusal)
    rows = np.searchsorted(recorded_s, wanted_s - 1e-6)
    if len(rows) < 2 or rows[-1] >= len(recorded_s) or np.abs(recorded_s[rows] - wanted_s).max() > 1e-5:
        raise ConfigError(refusal)
    return int(rows[0]), int(rows[1] - rows[0]), int(rows[-1]) + 1
