"""Measured tracks of a swinging ball."""

import pandas as pd

from millprint.calibration.oscillation import PLACES
from millprint.errors import ConfigError
from millprint.tables import Number, read_measured, refuse_rows

FEWEST_FRAMES = 20


def read_track(path: str) -> pd.DataFrame:
    """Read a measured track: time_s since the release, and across_mm, height_mm or both.

    across_mm is the place of the ball's centre from the jar's middle, positive on the side of the start; height_mm is
    counted from the lowest place that it can have. Frames in which the ball was not found are left out of the table.
    Raises ConfigError for a table without a place, too few frames, or times that do not rise from 0 or more.
    """
    places = [Number(column, optional=True) for column in PLACES]
    track = read_measured(path, [Number("time_s", 0), *places], FEWEST_FRAMES)
    found = [column for column in PLACES if column in track]
    if not found:
        raise ConfigError(f"{path}: column {' or '.join(PLACES)} is missing; the table has {', '.join(track.columns)}")
    before = track["time_s"].shift()
    refuse_rows(
        track.assign(before=before),
        path,
        "time_s",
        track["time_s"] <= before,
        lambda frame: f"must be more than in the row before, {frame['before']:g}",
    )
    return track[["time_s", *found]]
