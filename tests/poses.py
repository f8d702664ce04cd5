"""Velocities of a body, as the kernels of a simulation compute them."""

import numpy as np
from numpy.typing import ArrayLike

from millprint.mill.kernel_columns import span_of
from millprint.mill.motion import POSE, Motion, stack_motions, write_poses
from millprint.run.kernel import kernel


@kernel()
def poses_at(motions, time):
    write_poses(motions, time)


def _columns(motion: Motion, time_s: ArrayLike, columns: slice) -> np.ndarray:
    motions, rows = stack_motions([motion]), []
    for time in np.ravel(time_s):
        poses_at(motions, time)
        rows.append(motions.pose[0, columns].copy())
    return np.array(rows).reshape(*np.shape(time_s), -1)


def velocity(motion: Motion, time_s: ArrayLike) -> np.ndarray:
    """Velocity (..., 3) [m/s] of the body frame's origin at times (...) [s]."""
    return _columns(motion, time_s, span_of(POSE.velocity))


def angular_velocity(motion: Motion, time_s: ArrayLike) -> np.ndarray:
    """Angular velocity (..., 3) [rad/s] of the body at times (...) [s]."""
    return _columns(motion, time_s, span_of(POSE.angular_velocity))
