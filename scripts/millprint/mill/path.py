"""A motion given as a table of points: a smooth periodic curve through them, as pieces of cubic polynomials.

Place: a periodic cubic spline X(u) of the turn u = t f. Rotation: a periodic cubic spline q(u) of quaternions (w, x, y,
z), normalised when it is used, so that
    R = R(q / |q|),  omega = 2 Im(dq/dt q*) / |q|^2
holds exactly: a change of the length of q turns nothing.
"""

from pathlib import Path

import numpy as np
import pandas as pd
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from millprint.errors import ConfigError
from millprint.files import read_table
from millprint.kernel import inlined

PLACE = ["x_m", "y_m", "z_m"]
TURN = ["rotation_x_deg", "rotation_y_deg", "rotation_z_deg"]
FEWEST_ROWS = 9
# A step this many times the median one is a gap, which no curve should bridge by guess.
GAP = 3.0
# The largest turn between two rows [deg], and distances from the origin that are no slip of the unit [m].
LARGEST_STEP_DEG, LARGEST_PLACE_M = 60.0, 10.0
# How far the last row may be from the first: a share of the range, or of a radian.
CLOSE = 1e-6


def _refuse(path: str | Path, what: str) -> ConfigError:
    return ConfigError(f"{path}: {what}")


def _check_times(time: np.ndarray, path: str | Path) -> None:
    if len(time) < FEWEST_ROWS:
        raise _refuse(path, f"{len(time)} rows: a turn needs {FEWEST_ROWS} at least, the last like the first")
    steps = np.diff(time)
    if (steps <= 0).any():
        row = int(np.argmax(steps <= 0)) + 2
        raise _refuse(path, f"column time_s, row {row} = {time[row - 1]:g}: time must rise from row to row")
    if steps.max() > GAP * np.median(steps):
        row = int(np.argmax(steps)) + 2
        raise _refuse(
            path,
            f"column time_s, row {row} = {time[row - 1]:g}: a gap of {steps.max():g} s, where rows are mostly "
            f"{np.median(steps):g} s apart; at most {GAP:g} times as much",
        )


def _check_places(place: np.ndarray, path: str | Path) -> None:
    far = np.abs(place) > LARGEST_PLACE_M
    if far.any():
        row, column = (int(index[0]) for index in np.nonzero(far))
        raise _refuse(
            path,
            f"column {PLACE[column]}, row {row + 1} = {place[row, column]:g}: at most {LARGEST_PLACE_M:g} m is wanted",
        )
    apart = np.abs(place[-1] - place[0])
    if (apart > CLOSE * max(float(np.ptp(place, axis=0).max()), 1e-6)).any():
        column = int(np.argmax(apart))
        raise _refuse(
            path,
            f"column {PLACE[column]}: the last row = {place[-1, column]:g} is not the first, {place[0, column]:g}; a "
            "turn must end where it began",
        )


def _quaternions(table: pd.DataFrame, path: str | Path) -> np.ndarray:
    """Quaternions (n, 4) of the rows, w first, without the jumps of sign that a rotation leaves open."""
    given = [name for name in TURN if name in table.columns]
    if not given:
        return np.tile([1.0, 0.0, 0.0, 0.0], (len(table), 1))
    if len(given) < len(TURN):
        missing = next(name for name in TURN if name not in given)
        raise _refuse(path, f"column {missing} is missing beside {given[0]}; a rotation has three columns, or none")
    turned = Rotation.from_rotvec(np.radians(table[TURN].to_numpy()))
    steps = np.degrees((turned[1:] * turned[:-1].inv()).magnitude())
    if steps.max() > LARGEST_STEP_DEG:
        row = int(np.argmax(steps)) + 2
        raise _refuse(
            path,
            f"columns rotation_*_deg, row {row}: a turn by {steps.max():.3g} degrees from the row before; rows must be "
            f"close enough that it is at most {LARGEST_STEP_DEG:g}",
        )
    if (turned[-1] * turned[0].inv()).magnitude() > CLOSE:
        raise _refuse(path, "columns rotation_*_deg: the last row is not the first; a turn must end as it began")
    quaternion = turned.as_quat()[:, [3, 0, 1, 2]]
    flips = np.where((quaternion[1:] * quaternion[:-1]).sum(axis=1) < 0, -1.0, 1.0)
    return quaternion * np.concatenate([[1.0], np.cumprod(flips)])[:, None]


def read_path(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """The curve through a table of points: ends (m + 1,) of its pieces, and their coefficients (m, 4, 7).

    The argument is turns of the mill since the table's first row; a piece is a polynomial of the turns since its start,
    the highest power first, of x, y, z [m] and the quaternion. The pieces cover two turns where the body comes back
    after one with the sign of its quaternion turned over (any whole turn about an axis does that), else one.
    Raises ConfigError, in one line, for a table that is not one turn.
    """
    table = read_table(path, numeric=["time_s", *PLACE])
    given = [name for name in TURN if name in table.columns]
    table = read_table(path, numeric=["time_s", *PLACE, *given])
    time, place = table["time_s"].to_numpy(dtype=float), table[PLACE].to_numpy(dtype=float)
    _check_times(time, path)
    _check_places(place, path)
    quaternion = _quaternions(table, path)
    turn, values = (time - time[0]) / (time[-1] - time[0]), np.hstack([place, quaternion])
    if quaternion[-1] @ quaternion[0] < 0:
        again = np.hstack([place[1:], -quaternion[1:]])
        turn, values = np.concatenate([turn, 1.0 + turn[1:]]), np.vstack([values, again])
    values[-1] = values[0]
    spline = CubicSpline(turn, values, bc_type="periodic")
    return spline.x, np.moveaxis(spline.c, 0, 1)


def path_values(
    breaks: np.ndarray, pieces: np.ndarray, turns: np.ndarray, frequency_hz: float
) -> tuple[np.ndarray, np.ndarray]:
    """The curve (..., 7) and its rate of change [1/s] at turns (...) since the start."""
    spline = CubicSpline.construct_fast(np.moveaxis(pieces, 0, 1), breaks, extrapolate="periodic")
    return spline(turns), frequency_hz * spline(turns, 1)


def rotation_of(quaternion: np.ndarray) -> np.ndarray:
    """Rotation matrices (..., 3, 3) of quaternions (..., 4) of any length, w first."""
    w, x, y, z = np.moveaxis(quaternion / np.linalg.norm(quaternion, axis=-1, keepdims=True), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def spin_of(quaternion: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Angular velocity (..., 3) [rad/s] of quaternions (..., 4) that change at a rate (..., 4) [1/s]."""
    w, v, dw, dv = quaternion[..., :1], quaternion[..., 1:], rate[..., :1], rate[..., 1:]
    return 2 * (w * dv - dw * v - np.cross(dv, v)) / (quaternion**2).sum(axis=-1, keepdims=True)


@inlined()
def find_piece(breaks, first, last, turns):
    """The piece, of those numbered from `first` to before `last`, that holds `turns`; breaks has a start each."""
    low, high = first, last - 1
    while low < high:
        middle = (low + high + 1) // 2
        if breaks[middle] <= turns:
            low = middle
        else:
            high = middle - 1
    return low


@inlined()
def write_path(piece, part, turns, frequency, pose, body):
    """Write the pose of a body by one piece of its curve, `turns` after the piece's start; rates in 1/s."""
    for c in range(3):
        a, b, k = piece[part, 0, c], piece[part, 1, c], piece[part, 2, c]
        pose[body, c] = ((a * turns + b) * turns + k) * turns + piece[part, 3, c]
        pose[body, 3 + c] = frequency * ((3.0 * a * turns + 2.0 * b) * turns + k)


@inlined()
def _component(piece, part, c, turns):
    a, b, k = piece[part, 0, c], piece[part, 1, c], piece[part, 2, c]
    value = ((a * turns + b) * turns + k) * turns + piece[part, 3, c]
    return value, (3.0 * a * turns + 2.0 * b) * turns + k


@inlined()
def write_path_rotation(piece, part, turns, frequency, pose, body):
    """Write rotation and angular velocity [rad/s] of a body by one piece of its curve of quaternions."""
    w, dw = _component(piece, part, 3, turns)
    x, dx = _component(piece, part, 4, turns)
    y, dy = _component(piece, part, 5, turns)
    z, dz = _component(piece, part, 6, turns)
    over = 1.0 / (w * w + x * x + y * y + z * z)
    scale = 2.0 * frequency * over
    pose[body, 6] = scale * (w * dx - dw * x - (dy * z - dz * y))
    pose[body, 7] = scale * (w * dy - dw * y - (dz * x - dx * z))
    pose[body, 8] = scale * (w * dz - dw * z - (dx * y - dy * x))
    pose[body, 9] = 1.0 - 2.0 * over * (y * y + z * z)
    pose[body, 10] = 2.0 * over * (x * y - w * z)
    pose[body, 11] = 2.0 * over * (x * z + w * y)
    pose[body, 12] = 2.0 * over * (x * y + w * z)
    pose[body, 13] = 1.0 - 2.0 * over * (x * x + z * z)
    pose[body, 14] = 2.0 * over * (y * z - w * x)
    pose[body, 15] = 2.0 * over * (x * z - w * y)
    pose[body, 16] = 2.0 * over * (y * z + w * x)
    pose[body, 17] = 1.0 - 2.0 * over * (x * x + y * y)
