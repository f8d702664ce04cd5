"""The pose of a body as one row of numbers, and how kernels read and write it."""

from millprint.kernel import inlined
from millprint.mill.vectors import put, row

# First columns: position [m], velocity [m/s], angular velocity [rad/s], and the rotation (3, 3) from the body frame to
# the laboratory, row by row; POSE columns in all.
POSITION, VELOCITY, ANGULAR_VELOCITY, ROTATION, POSE = 0, 3, 6, 9, 18


@inlined()
def velocity_of(motions, body):
    """Velocity of a body's origin [m/s]."""
    return row(motions.pose, body, VELOCITY)


@inlined()
def angular_velocity_of(motions, body):
    """Angular velocity of a body [rad/s]."""
    return row(motions.pose, body, ANGULAR_VELOCITY)


@inlined()
def rotation_of(motions, body):
    """Rotation of a body to the laboratory, a tuple of three rows."""
    pose = motions.pose
    return row(pose, body, ROTATION), row(pose, body, ROTATION + 3), row(pose, body, ROTATION + 6)


@inlined()
def write_rotation(pose, body, rotation):
    """Write a rotation, a tuple of three rows."""
    put(pose, body, ROTATION, rotation[0])
    put(pose, body, ROTATION + 3, rotation[1])
    put(pose, body, ROTATION + 6, rotation[2])
