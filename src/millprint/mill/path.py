"""A motion along a smooth periodic curve through a table of points (mill.points): pieces of cubic polynomials.

Place: a periodic cubic spline X(u) of the turn u = t f. Rotation: a periodic cubic spline q(u) of quaternions (w, x, y,
z), normalised when it is used, so that
    R = R(q / |q|),  omega = 2 Im(dq/dt q*) / |q|^2
is exact: a change of the length of q does not turn the body.
"""

import numpy as np

from millprint.mill.pose import POSE, write_rotation
from millprint.mill.vectors import cross, put_vector, scale, subtract
from millprint.run.kernel import inlined


def path_values(breaks: np.ndarray, pieces: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """The curve (..., 7), place [m] and quaternion, at turns (...) since the start."""
    # Takes long to import, and few mills need it.
    from scipy.interpolate import CubicSpline

    return CubicSpline.construct_fast(np.moveaxis(pieces, 0, 1), breaks, extrapolate="periodic")(turns)


def rotation_matrices(quaternion: np.ndarray) -> np.ndarray:
    """Rotation matrices (..., 3, 3) of quaternions (..., 4) of any length, w first."""
    from scipy.spatial.transform import Rotation

    scalar_last = np.roll(quaternion, -1, axis=-1).reshape(-1, 4)
    return Rotation.from_quat(scalar_last).as_matrix().reshape(*quaternion.shape[:-1], 3, 3)


@inlined()
def find_piece(breaks, first, last, turns):
    """The piece that contains `turns`, of those from `first` up to but not `last`; breaks has the start of each."""
    low, high = first, last - 1
    while low < high:
        middle = (low + high + 1) // 2
        if breaks[middle] <= turns:
            low = middle
        else:
            high = middle - 1
    return low


@inlined()
def _component(piece, part, c, turns):
    a, b, k = piece[part, 0, c], piece[part, 1, c], piece[part, 2, c]
    value = ((a * turns + b) * turns + k) * turns + piece[part, 3, c]
    return value, (3.0 * a * turns + 2.0 * b) * turns + k


@inlined()
def write_path(piece, part, turns, frequency, pose, body):
    """Write the pose of a body by one piece of its curve, `turns` after the piece's start; rates in 1/s."""
    for c in range(3):
        value, rate = _component(piece, part, c, turns)
        pose[body, POSE.position.x + c] = value
        pose[body, POSE.velocity.x + c] = frequency * rate


@inlined()
def write_path_rotation(piece, part, turns, frequency, pose, body):
    """Write rotation and angular velocity [rad/s] of a body by one piece of its curve of quaternions."""
    w, dw = _component(piece, part, 3, turns)
    x, dx = _component(piece, part, 4, turns)
    y, dy = _component(piece, part, 5, turns)
    z, dz = _component(piece, part, 6, turns)
    over = 1.0 / (w * w + x * x + y * y + z * z)
    product = cross((dx, dy, dz), (x, y, z))
    half = subtract(subtract(scale(w, (dx, dy, dz)), scale(dw, (x, y, z))), product)
    put_vector(pose, body, POSE.angular_velocity, scale(2.0 * frequency * over, half))
    rotation = (
        (1.0 - 2.0 * over * (y * y + z * z), 2.0 * over * (x * y - w * z), 2.0 * over * (x * z + w * y)),
        (2.0 * over * (x * y + w * z), 1.0 - 2.0 * over * (x * x + z * z), 2.0 * over * (y * z - w * x)),
        (2.0 * over * (x * z - w * y), 2.0 * over * (y * z + w * x), 1.0 - 2.0 * over * (x * x + y * y)),
    )
    write_rotation(pose, body, rotation)
