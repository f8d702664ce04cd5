"""A motion given as a table of points, read and checked: a smooth periodic curve through them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from millprint.config.errors import ConfigError
from millprint.config.motion_kinds import STILL
from millprint.run.tables import Number, read_measured

PLACE = ["x_m", "y_m", "z_m"]
TURN = ["rotation_x_deg", "rotation_y_deg", "rotation_z_deg"]
FEWEST_ROWS = 9
# A step this many times the median one is a gap, too wide for a curve to bridge.
GAP = 3.0
# The largest turn between two rows [deg], and the largest distance from the origin, beyond which the unit is wrong [m].
LARGEST_STEP_DEG, LARGEST_PLACE_M = 60.0, 10.0
# How far the last row may be from the first: a share of the range, or of a radian.
CLOSE = 1e-6


def _check_times(time: np.ndarray) -> None:
    if len(time) < FEWEST_ROWS:
        raise ConfigError(f"{len(time)} rows: a turn needs {FEWEST_ROWS} at least, the last like the first")
    steps = np.diff(time)
    if (steps <= 0).any():
        row = int(np.argmax(steps <= 0)) + 2
        raise ConfigError(f"column time_s, row {row} = {time[row - 1]:g}: time must rise from row to row")
    if steps.max() > GAP * np.median(steps):
        row = int(np.argmax(steps)) + 2
        raise ConfigError(
            f"column time_s, row {row} = {time[row - 1]:g}: a gap of {steps.max():g} s, where rows are mostly "
            f"{np.median(steps):g} s apart; at most {GAP:g} times as much"
        )


def _check_places(place: np.ndarray) -> None:
    far = np.argwhere(np.abs(place) > LARGEST_PLACE_M)
    if len(far):
        row, column = far[0]
        raise ConfigError(
            f"column {PLACE[column]}, row {row + 1} = {place[row, column]:g}: must be at most {LARGEST_PLACE_M:g} m"
        )
    apart = np.abs(place[-1] - place[0])
    if (apart > CLOSE * max(float(np.ptp(place, axis=0).max()), 1e-6)).any():
        column = int(np.argmax(apart))
        raise ConfigError(
            f"column {PLACE[column]}: the last row = {place[-1, column]:g} is not the first, {place[0, column]:g}; a "
            "turn must end where it began"
        )


def _quaternions(table: pd.DataFrame) -> np.ndarray:
    """Quaternions (n, 4) of the rows, w first, their signs chosen so that they do not jump."""
    given = [name for name in TURN if name in table.columns]
    if not given:
        return np.tile([1.0, 0.0, 0.0, 0.0], (len(table), 1))
    if len(given) < len(TURN):
        missing = next(name for name in TURN if name not in given)
        raise ConfigError(f"column {missing} is missing next to {given[0]}; a rotation has three columns, or none")
    turned = Rotation.from_rotvec(np.radians(table[TURN].to_numpy()))
    steps = np.degrees((turned[1:] * turned[:-1].inv()).magnitude())
    if steps.max() > LARGEST_STEP_DEG:
        row = int(np.argmax(steps)) + 2
        raise ConfigError(
            f"columns rotation_*_deg, row {row}: a turn by {steps.max():.3g} degrees from the row before; rows must be "
            f"close enough that it is at most {LARGEST_STEP_DEG:g}"
        )
    if (turned[-1] * turned[0].inv()).magnitude() > CLOSE:
        raise ConfigError("columns rotation_*_deg: the last row is not the first; a turn must end as it began")
    quaternion = turned.as_quat()[:, [3, 0, 1, 2]]
    flips = np.where((quaternion[1:] * quaternion[:-1]).sum(axis=1) < 0, -1.0, 1.0)
    return quaternion * np.concatenate([[1.0], np.cumprod(flips)])[:, None]


def curve_through(points: Sequence[Sequence[float]]) -> tuple[np.ndarray, np.ndarray]:
    """The curve through computed points (Drive.points), as of `read_path`. Raises ConfigError likewise."""
    return _curve(pd.DataFrame(points, columns=["time_s", *PLACE, *TURN][: len(points[0])]))


def read_path(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """The curve through a table of points: ends (m + 1,) of its pieces, and their coefficients (m, 4, 7).

    The argument is turns of the mill since the table's first row; a piece is a polynomial of the turns since its start,
    the highest power first, of x, y, z [m] and the quaternion. The pieces cover two turns where the body comes back
    after one with the sign of its quaternion turned over (any whole turn about an axis does that), else one.
    Raises ConfigError, in one line, for a table that is not one turn.
    """
    columns = [*map(Number, ("time_s", *PLACE)), *(Number(name, optional=True) for name in TURN)]
    table = read_measured(path, columns, fewest_rows=0)
    try:
        return _curve(table)
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from None


def _curve(table: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
    time, place = table["time_s"].to_numpy(dtype=float), table[PLACE].to_numpy(dtype=float)
    _check_times(time)
    _check_places(place)
    quaternion = _quaternions(table)
    turn, values = (time - time[0]) / (time[-1] - time[0]), np.hstack([place, quaternion])
    if not np.ptp(values, axis=0).any():
        raise ConfigError(f"all rows have the same place: {STILL}")
    if quaternion[-1] @ quaternion[0] < 0:
        again = np.hstack([place[1:], -quaternion[1:]])
        turn, values = np.concatenate([turn, 1.0 + turn[1:]]), np.vstack([values, again])
    values[-1] = values[0]
    spline = CubicSpline(turn, values, bc_type="periodic")
    # In the order of all other arrays of the kernels, which would be compiled again for another one.
    return spline.x, np.ascontiguousarray(np.moveaxis(spline.c, 0, 1))
