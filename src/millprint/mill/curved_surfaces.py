"""Exact cylinders, cones, spheres and tori: surfaces that a line or an arc sweeps as it turns about an axis.

Facets draw such a surface; how far a ball is from it, and in which direction, is that of the surface itself. So a round
wall is round, however many facets draw it. A line sweeps a cone, or a cylinder if it is parallel to the axis; an arc
sweeps a torus, or a sphere if its middle lies on the axis.

A surface of less than a turn, or with less than a whole tube, goes on beyond its borders along its tangents, as the
walls that join it smoothly do: there both give the same distance, and a ball passes from one to the other without a
jump.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from millprint.mill.kernel_columns import Vector, number_columns, span_of, width_of
from millprint.mill.vectors import add_scaled, any_across, cross, dot, row, scale, subtract, vector
from millprint.run.kernel import array_maker, inlined

# Closer to its axis or to the middle of its tube [m], a point has any direction to the wall, of length 1: a ball in the
# tip of a cone comes that near, and a shorter one would be a deeper overlap.
CLOSEST = 1e-12
# A part of a turn up to half of it, and a larger one.
PART, WIDE = 1.0, 2.0


class CurveColumns(NamedTuple):
    """A cylinder, cone, sphere or torus, in a row of walls.Walls.curves."""

    origin: Vector  # on the axis; of a torus its middle [m]
    axis: Vector  # unit vector
    first: Vector  # unit vectors across the axis, between which the surface lies, turning about it
    last: Vector
    begin_out: int  # unit vectors (out, up) in the plane through the axis, between which a tube's arc lies
    begin_up: int
    end_out: int
    end_up: int
    low: int  # ends of a cone along its line, from the circle at the origin [m]
    high: int
    major: int  # radius of a cone at the origin, or of the circle on which a torus's tube has its middle [m]
    minor: int  # radius of the tube [m]
    side: int  # 1 if the balls are on the side of the axis, or of the tube's middle; -1 if they are outside
    is_torus: int
    is_part: int  # PART or WIDE where the surface is less than a turn, 0 for a whole one
    is_arc: int  # the same of a torus's tube
    rise: int  # of a unit vector along a cone's line: its part along the axis; 1 for a cylinder
    spread: int  # and away from the axis; 0 for a cylinder
    slack: int  # how far the surface reaches beyond its borders [m], see borders.Borders


CURVE = number_columns(CurveColumns)


@inlined()
def out_of_axis(curves, k, out):
    """Distance from the axis, the direction away from it, and how far a vector across the axis is past the borders [m].

    Beyond the borders of a surface of less than a turn, distance and direction are those along the nearer border, so
    that what is at one distance from the axis is a plane there. It is negative on the other side of the axis.
    """
    if curves[k, CURVE.is_part] > 0.0:
        axis = vector(curves, k, CURVE.axis)
        first, last = vector(curves, k, CURVE.first), vector(curves, k, CURVE.last)
        before, after = dot(cross(first, out), axis), dot(cross(out, last), axis)
        if (before < 0.0 or after < 0.0) if curves[k, CURVE.is_part] == PART else (before < 0.0 and after < 0.0):
            along_first, along_last = dot(out, first), dot(out, last)
            if along_first > along_last:
                return along_first, first, abs(dot(cross(first, out), axis))
            return along_last, last, abs(dot(cross(last, out), axis))
    length = math.sqrt(dot(out, out))
    return length, (scale(1.0 / length, out) if length > CLOSEST else any_across(vector(curves, k, CURVE.axis))), 0.0


@inlined()
def out_of_tube(curves, k, out, up):
    """The same for a tube's middle, in the plane through the axis, with the direction as (out, up)."""
    if curves[k, CURVE.is_arc] > 0.0:
        begin = curves[k, CURVE.begin_out], curves[k, CURVE.begin_up]
        end = curves[k, CURVE.end_out], curves[k, CURVE.end_up]
        before, after = begin[0] * up - begin[1] * out, out * end[1] - up * end[0]
        if (before < 0.0 or after < 0.0) if curves[k, CURVE.is_arc] == PART else (before < 0.0 and after < 0.0):
            along_begin, along_end = out * begin[0] + up * begin[1], out * end[0] + up * end[1]
            if along_begin > along_end:
                return along_begin, begin, abs(before)
            return along_end, end, abs(after)
    length = math.sqrt(out * out + up * up)
    return length, ((out / length, up / length) if length > CLOSEST else (1.0, 0.0)), 0.0


@inlined()
def curve_touch(curves, k, point):
    """Of a point and the wall of curve k: (signed distance, direction, how far past the borders, bend).

    The distance is positive where balls are [m], and the direction is that to the ball. bend: the sum of the wall's
    curvatures towards the point as seen from there [1/m], by which the distance falls short of that to the tangent
    plane: a move by d along the wall takes at most d^2 bend / 2. It is not positive where all of the wall bends away.
    """
    axis, side = vector(curves, k, CURVE.axis), curves[k, CURVE.side]
    away = subtract(point, vector(curves, k, CURVE.origin))
    up = dot(away, axis)
    reach, outwards, past = out_of_axis(curves, k, add_scaled(away, -up, axis))
    bend = side / max(abs(reach), CLOSEST)
    if curves[k, CURVE.is_torus] == 0.0:
        rise, spread, inset = curves[k, CURVE.rise], curves[k, CURVE.spread], curves[k, CURVE.major] - reach
        along = up * rise - inset * spread
        past = max(past, curves[k, CURVE.low] - along, along - curves[k, CURVE.high])
        direction = scale(-side, add_scaled(scale(rise, outwards), -spread, axis))
        return side * (inset * rise + up * spread), direction, past, bend * rise
    reach, (out, along), past_tube = out_of_tube(curves, k, reach - curves[k, CURVE.major], up)
    # A neck bends towards its axis, and away along it.
    bend = max(bend * out, 0.0) + max(side / max(abs(reach), CLOSEST), 0.0)
    direction = scale(-side, add_scaled(scale(out, outwards), along, axis))
    return side * (curves[k, CURVE.minor] - reach), direction, max(past, past_tube), bend


@array_maker()
def touch_points(curves, k, points):
    """Signed distances (n,), directions (n, 3) and ways past the borders (n,) of points (n, 3)."""
    distance, direction, past = np.empty(len(points)), np.empty((len(points), 3)), np.empty(len(points))
    for p in range(len(points)):
        distance[p], towards, past[p], _ = curve_touch(curves, k, row(points, p))
        for c in range(3):
            direction[p, c] = towards[c]
    return distance, direction, past


@dataclass(frozen=True)
class Curve:
    """A cylinder or a cone, or with `minor` a torus or a sphere, in the frame of a body.

    origin (3,) [m], on the axis; axis (3,), a unit vector; major, minor: radii [m], see CurveColumns; hollow: the balls
    are on the side of the axis, or of the tube's middle; part: unit vectors (3,) across the axis between which the
    surface lies, less than a turn from the first to the second; arc: unit vectors (out, up) likewise for the tube;
    ends: of a cone along its line, from the circle at the origin [m]; slope: angle between that line and the axis
    [rad], positive where the radius grows along the axis; 0 for a cylinder; slack [m], see borders.Borders; is_trimmed:
    whether it is a whole surface that ends at the border of its facets (mill.creases), not at parts, arcs and ends.
    """

    origin: np.ndarray
    axis: np.ndarray
    major: float
    minor: float | None = None
    hollow: bool = True
    part: tuple[np.ndarray, np.ndarray] | None = None
    arc: tuple[tuple[float, float], tuple[float, float]] | None = None
    ends: tuple[float, float] = (-math.inf, math.inf)
    slope: float = 0.0
    slack: float = 0.0
    is_trimmed: bool = False

    @property
    def kind(self) -> str:
        """The name of the surface."""
        if self.minor is None:
            return "cone" if self.slope else "cylinder"
        return "torus" if self.major else "sphere"

    def is_part_of(self, other: "Curve") -> bool:
        """Whether both are parts of one surface."""
        same = all(getattr(self, name) == getattr(other, name) for name in ("major", "minor", "slope", "hollow"))
        return same and bool((self.origin == other.origin).all() and (self.axis == other.axis).all())

    def moved(self, rotation: np.ndarray, shift: np.ndarray) -> "Curve":
        """The surface turned by a matrix (3, 3), then shifted (3,) [m]."""
        part = self.part and (rotation @ self.part[0], rotation @ self.part[1])
        return replace(self, origin=rotation @ self.origin + shift, axis=rotation @ self.axis, part=part)

    @property
    def turned_out(self) -> "Curve":
        """The same surface with the balls on its other side."""
        return replace(self, hollow=not self.hollow)

    @property
    def row(self) -> np.ndarray:
        """The numbers of CurveColumns."""
        numbers = np.zeros(width_of(CURVE))
        numbers[span_of(CURVE.origin)], numbers[span_of(CURVE.axis)] = self.origin, self.axis
        if self.part:
            numbers[span_of(CURVE.first)], numbers[span_of(CURVE.last)] = self.part
        if self.arc:
            numbers[[CURVE.begin_out, CURVE.begin_up]], numbers[[CURVE.end_out, CURVE.end_up]] = self.arc
        numbers[CURVE.low], numbers[CURVE.high] = self.ends
        numbers[CURVE.major], numbers[CURVE.minor] = self.major, self.minor or 0.0
        numbers[CURVE.side] = 1.0 if self.hollow else -1.0
        numbers[CURVE.is_torus] = self.minor is not None
        if self.part:
            numbers[CURVE.is_part] = WIDE if np.cross(*self.part) @ self.axis < -CLOSEST else PART
        if self.arc:
            (out, up), (end_out, end_up) = self.arc
            numbers[CURVE.is_arc] = WIDE if out * end_up - up * end_out < -CLOSEST else PART
        numbers[CURVE.rise], numbers[CURVE.spread] = math.cos(self.slope), math.sin(self.slope)
        numbers[CURVE.slack] = self.slack
        return numbers

    def touch(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of points (n, 3): see `curve_touch`, signed distances (n,), directions (n, 3), ways past the borders (n,)."""
        return touch_points(self.row[None], 0, np.ascontiguousarray(points, dtype=float))


def curve_rows(curves: tuple[Curve, ...]) -> np.ndarray:
    """The rows (n, width) of some curves."""
    return np.array([curve.row for curve in curves]).reshape(-1, width_of(CURVE))
