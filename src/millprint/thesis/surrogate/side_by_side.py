"""Balls of a prediction and of the simulation side by side, in one movie."""

from pathlib import Path

import numpy as np

from millprint.config.errors import ConfigError
from millprint.run.hdf5 import open_hdf5
from millprint.view.frames import VIEWS, Frame, Movie, Stage
from millprint.view.snapshots import Snapshots

SIDES = ("DEM", "surrogate")
# Position at which an escaped ball is drawn [m]: outside every picture, but a number that every renderer can draw.
AWAY_M = 1.0


def movie_side_by_side(
    run: str | Path,
    time_s: np.ndarray,
    position_m: np.ndarray,
    velocity_m_s: np.ndarray,
    every: int,
    frames_per_second: int,
) -> Movie:
    """A movie with the simulation on the left and a prediction of it on the right.

    time_s (n,) since the start of the motion, position_m and velocity_m_s (n, balls, 3): the prediction; one frame in
    `every` is shown. Raises ConfigError for a run without snapshots at these times.
    """
    time_s, position_m, velocity_m_s = (values[::every] for values in (time_s, position_m, velocity_m_s))
    with open_hdf5(run) as file:
        first, stride, last = _rows(file["snapshots/time_s"][:] if "snapshots" in file else None, time_s, run)
        stage = Stage(Snapshots(file, stride, first, last))
    frames = []
    for block in stage.blocks:
        moments = time_s[block.rows]
        place, motion = (
            np.nan_to_num(values[block.rows], nan=AWAY_M, posinf=AWAY_M, neginf=-AWAY_M)
            for values in (position_m, velocity_m_s)
        )
        simulated = stage.frames(block, moments, block.balls["position_m"], block.balls["velocity_m_s"])
        predicted = stage.frames(block, moments, np.clip(place, -AWAY_M, AWAY_M), motion)
        frames += [_together(*pair) for pair in zip(simulated, predicted, strict=True)]
    panels = [stage.panel(view, f"{name}, {view.title}") for view in VIEWS for name in SIDES]
    return stage.movie(frames, panels, float(time_s[1] - time_s[0]), frames_per_second, len(SIDES))


def _together(simulated: Frame, predicted: Frame) -> Frame:
    pairs = zip(simulated.pictures, predicted.pictures, strict=True)
    return Frame(simulated.time_s, simulated.revolution, tuple(picture for pair in pairs for picture in pair))


def _rows(recorded_s: np.ndarray | None, asked_s: np.ndarray, run: str | Path) -> tuple[int, int, int]:
    """First, stride and last of the snapshots at the requested times."""
    refusal = f"{run}: no snapshots at the frames of the roll-out: set snapshot_interval_s to divide them"
    if recorded_s is None:
        raise ConfigError(refusal)
    rows = np.searchsorted(recorded_s, asked_s - 1e-6)
    if len(rows) < 2 or rows[-1] >= len(recorded_s) or np.abs(recorded_s[rows] - asked_s).max() > 1e-5:
        raise ConfigError(refusal)
    return int(rows[0]), int(rows[1] - rows[0]), int(rows[-1]) + 1
