"""The pose of a body as one row of numbers, and how kernels read and write it."""

from typing import NamedTuple

from millprint.mill.kernel_columns import Vector, number_columns
from millprint.mill.vectors import put_vector, vector
from millprint.run.kernel import inlined


class RotationColumns(NamedTuple):
    """A rotation matrix from the body's frame to the laboratory, row by row."""

    first_row: Vector
    second_row: Vector
    third_row: Vector


class PoseColumns(NamedTuple):
    """Where the body's frame is, how fast it moves, and how it is turned."""

    position: Vector  # of its origin [m]
    velocity: Vector  # of its origin [m/s]
    angular_velocity: Vector  # [rad/s]
    rotation: RotationColumns


POSE = number_columns(PoseColumns)


@inlined()
def velocity_of(motions, body):
    """Velocity of a body's origin [m/s]."""
    return vector(motions.pose, body, POSE.velocity)


@inlined()
def angular_velocity_of(motions, body):
    """Angular velocity of a body [rad/s]."""
    return vector(motions.pose, body, POSE.angular_velocity)


@inlined()
def rotation_of(motions, body):
    """Rotation of a body to the laboratory, a tuple of three rows."""
    pose, rows = motions.pose, POSE.rotation
    return vector(pose, body, rows.first_row), vector(pose, body, rows.second_row), vector(pose, body, rows.third_row)


@inlined()
def write_rotation(pose, body, rotation):
    """Write a rotation, a tuple of three rows."""
    put_vector(pose, body, POSE.rotation.first_row, rotation[0])
    put_vector(pose, body, POSE.rotation.second_row, rotation[1])
    put_vector(pose, body, POSE.rotation.third_row, rotation[2])
