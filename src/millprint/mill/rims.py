"""Rims: arcs of circles in which two exact surfaces of a wall meet, and which balls touch where the wall juts out."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from millprint.mill.kernel_columns import Vector, number_columns, span_of, width_of
from millprint.mill.vectors import add_scaled, cross, dot, scale, subtract, vector
from millprint.run.kernel import inlined

# Closer to its axis [m], a point has no direction to a circle.
CLOSEST = 1e-12


class RimColumns(NamedTuple):
    """An arc of a circle, in a row of walls.Walls.rims."""

    centre: Vector  # [m]
    axis: Vector  # unit vector
    first: Vector  # unit vectors across the axis, between which the arc lies, turning about it
    last: Vector
    radius: int  # [m]
    is_part: int  # 1 where the arc is less than a turn
    inward_out: int  # along one of the walls that meet here, away from the rim: its part away from the axis
    inward_up: int  # and its part along the axis
    other_out: int  # the same of the other wall
    other_up: int


RIM = number_columns(RimColumns)


@inlined()
def rim_distance(rims, k, point):
    """Distance of a point from the circle of rim k [m], and the direction from there to the point.

    Further: the vector from there to the point, away from the axis and along it [m], and whether it starts on the arc.
    """
    axis, away = vector(rims, k, RIM.axis), subtract(point, vector(rims, k, RIM.centre))
    up = dot(away, axis)
    across = add_scaled(away, -up, axis)
    reach = math.sqrt(dot(across, across)) + CLOSEST
    is_on_arc = True
    if rims[k, RIM.is_part] > 0.0:
        first, last = vector(rims, k, RIM.first), vector(rims, k, RIM.last)
        is_on_arc = dot(cross(first, across), axis) >= 0.0 and dot(cross(across, last), axis) >= 0.0
    out = reach - rims[k, RIM.radius]
    distance = math.sqrt(out * out + up * up) + 1e-300
    direction = add_scaled(scale(out / (distance * reach), across), up / distance, axis)
    return distance, direction, out, up, is_on_arc


@inlined()
def rim_touch(rims, k, point):
    """Distance of a point from the circle of rim k [m], the direction from there to the point, whether it is a contact.

    It is one where the nearest point of the circle is on the arc, and both walls lead away from the point there.
    """
    distance, direction, out, up, is_over = rim_distance(rims, k, point)
    is_over &= out * rims[k, RIM.inward_out] + up * rims[k, RIM.inward_up] < 0.0
    is_over &= out * rims[k, RIM.other_out] + up * rims[k, RIM.other_up] < 0.0
    return distance, direction, is_over


@dataclass(frozen=True)
class Rim:
    """An arc of a circle of a radius [m] about centre (3,) [m] and axis (3,), a unit vector.

    part: unit vectors (3,) across the axis between which the arc lies, up to half a turn from the first to the second,
    None for a whole circle; inward: for both walls the unit vector (out, up) along it, away from the rim; turn: angle
    between the walls' normals [rad], positive where the wall juts out, see vessel.Edge.
    """

    centre: np.ndarray
    axis: np.ndarray
    radius: float
    part: tuple[np.ndarray, np.ndarray] | None
    inward: tuple[np.ndarray, np.ndarray]
    turn: float

    @property
    def row(self) -> np.ndarray:
        """The numbers of RimColumns."""
        numbers = np.zeros(width_of(RIM))
        numbers[span_of(RIM.centre)], numbers[span_of(RIM.axis)] = self.centre, self.axis
        if self.part:
            numbers[span_of(RIM.first)], numbers[span_of(RIM.last)] = self.part
        numbers[RIM.radius], numbers[RIM.is_part] = self.radius, self.part is not None
        numbers[[RIM.inward_out, RIM.inward_up]], numbers[[RIM.other_out, RIM.other_up]] = self.inward
        return numbers


def nearest_on_circle(row: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The points (n, 3) of the circle of a rim, in RimColumns, that are nearest to points (n, 3)."""
    centre, axis = row[span_of(RIM.centre)], row[span_of(RIM.axis)]
    across = points - centre
    across = across - np.outer(across @ axis, axis)
    return centre + row[RIM.radius] * across / np.linalg.norm(across, axis=1, keepdims=True)


def rim_rows(rims: tuple[Rim, ...]) -> np.ndarray:
    """The rows (n, width) of some rims."""
    return np.array([rim.row for rim in rims]).reshape(-1, width_of(RIM))
