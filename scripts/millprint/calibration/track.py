"""Measured tracks of a swinging ball."""

import pandas as pd

from millprint.calibration.oscillation import PLACES
from millprint.doe.bounds import check_bounds
from millprint.errors import ConfigError
from millprint.files import read_table

FEWEST_FRAMES = 20


def read_track(path: str) -> pd.DataFrame:
    """Read a measured track: time_s since the release, and across_mm, height_mm or both.

    across_mm is the place of the ball's centre from the jar's middle, positive on the side of the start; height_mm is
    counted from the lowest place that it can have. Frames in which the ball was not found are left out of the table.
    Raises ConfigError for a table without a place, too few frames, or times that do not rise from 0 or more.
    """
    track = read_table(path, numeric=["time_s"])
    found = [column for column in PLACES if column in track]
    if not found:
        raise ConfigError(f"{path}: column {' or '.join(PLACES)} is missing; the table has {', '.join(track.columns)}")
    track = read_table(path, numeric=["time_s", *found])
    if len(track) < FEWEST_FRAMES:
        raise ConfigError(f"{path}: {len(track)} frame(s); at least {FEWEST_FRAMES} are wanted")
    check_bounds(track, path, "time_s", 0)
    falling = track["time_s"].diff() <= 0
    if falling.any():
        row = int(falling.idxmax())
        raise ConfigError(
            f"{path}: column time_s, row {row + 1} = {track['time_s'][row]:g}: more than the row before, "
            f"{track['time_s'][row - 1]:g}, is wanted"
        )
    return track[["time_s", *found]]
