"""Curves in which two exact surfaces of a wall meet: rims, which are arcs of circles, and creases.

A drawing has a chord for each piece of such a curve, as around a port in a mantle. The curve itself is known by both
surfaces. Seen from its chord, a piece is a graph over it: at each of DEGREE + 1 places along the chord (Chebyshev's)
the point of both surfaces is found by Newton's method, and the polynomial through these points is the piece. It must
be on both surfaces between them too, to EXACT of the body's size, less than a hundredth of a pressed contact's kick
that a balance of 1e-6 would show. Both walls end at the crease: a flat one by sides that bow over their chords, a
curve by such sides in its own coordinates (angle times radius, way along its line or arc), see `Trims`. A ball touches
a crease that juts in at the places of it that are nearest to the ball, between the normals of both walls.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from millprint.mill.curved_surfaces import CLOSEST, CURVE
from millprint.mill.kernel_columns import Vector, number_columns, span_of, width_of
from millprint.mill.vectors import add_scaled, any_across, cross, dot, row, scale, subtract, vector
from millprint.run.kernel import inlined, inner


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
    reach = math.sqrt(dot(across, across))
    outwards = scale(1.0 / reach, across) if reach > CLOSEST else any_across(axis)
    is_on_arc = True
    if rims[k, RIM.is_part] > 0.0:
        first, last = vector(rims, k, RIM.first), vector(rims, k, RIM.last)
        is_on_arc = dot(cross(first, across), axis) >= 0.0 and dot(cross(across, last), axis) >= 0.0
    out = reach - rims[k, RIM.radius]
    distance = math.sqrt(out * out + up * up) + 1e-300
    direction = add_scaled(scale(out / distance, outwards), up / distance, axis)
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


DEGREE = 11
# What a polynomial may be off the surfaces, and a trim off its border, as shares of the body's size.
EXACT, TRIMMED = 2e-12, 1e-9
# A piece leads away from its chord by no more: cosine and tangent of 37 degrees.
ALONG, STEEPEST = 0.8, 0.75
# By so much of its chord a piece is touched beyond its ends and beyond the normals of its walls: the distance is wrong
# by the square of it only, while rounding leaves no gap.
BEYOND = 1e-6


class CreaseRows(NamedTuple):
    """A piece of a crease: rows of DEGREE + 1 numbers. Polynomials, of x from -1 to 1 along the chord, and vectors."""

    across: int  # polynomial: way from the chord along the vector `first` [m]
    beside: int  # and along `second`
    inward: Vector  # polynomials: unit vector along one wall, away from the crease
    other: Vector  # and along the other one
    start: int  # of the chord [m]; a vector, as what follows
    along: int
    first: int
    second: int
    sizes: int  # length of the chord, the farthest way from it [m]


class TrimColumns(NamedTuple):
    """The coordinates of a trimmed curve: see `place_on`."""

    first: Vector  # unit vector across the axis, of angle 0
    radius: int  # by which angles are multiplied [m]
    tube: int  # angle of a tube's arc that is its 0 [rad]
    is_inside: int  # 1 where a point under no side is in the wall


class Trims(NamedTuple):
    """Borders of curves (k), as sides in the curve's own coordinates.

    first (k + 1,): sides of curve k are first[k] to first[k + 1], none for a curve that ends at circles and rulings;
    side (t, width) of walls.SideColumns; bow (n, DEGREE + 1): the polynomials of sides that bow, also of flat walls;
    frame (k, width) of TrimColumns.
    """

    first: np.ndarray
    side: np.ndarray
    bow: np.ndarray
    frame: np.ndarray


CREASE, TRIM = number_columns(CreaseRows), number_columns(TrimColumns)


class SideColumns(NamedTuple):
    """A side of an outline, in its plane's axes u, v [m]: a line, an arc of less than half a turn, or a bow over it."""

    start_u: int
    start_v: int
    direction_u: int  # of a unit vector
    direction_v: int
    length: int
    end_u: int
    end_v: int
    centre_u: int  # of an arc; of a bow its row in Trims.bow
    centre_v: int
    radius: int  # of an arc; 0 for a line, -1 for a bow
    sense: int  # of an arc: 1 where it goes counter-clockwise about its centre, -1 where it goes clockwise


SIDE = number_columns(SideColumns)


@inlined()
def polynomial(coefficients, k, x):
    """Value at x and slope of a polynomial, row k of its coefficients, from that of degree 0 on."""
    value, slope = 0.0, 0.0
    for n in range(DEGREE, -1, -1):
        slope = slope * x + value
        value = value * x + coefficients[k, n]
    return value, slope


@inlined()
def crease_place(crease, x):
    """Point of a piece (rows, DEGREE + 1) at x, and its slope along the chord."""
    half = 0.5 * crease[CREASE.sizes, 0]
    across, across_slope = polynomial(crease, CREASE.across, x)
    beside, beside_slope = polynomial(crease, CREASE.beside, x)
    along, first, second = row(crease, CREASE.along), row(crease, CREASE.first), row(crease, CREASE.second)
    point = add_scaled(row(crease, CREASE.start), (x + 1.0) * half, along)
    point = add_scaled(add_scaled(point, across, first), beside, second)
    slope = add_scaled(add_scaled(along, across_slope / half, first), beside_slope / half, second)
    return point, slope


@inlined()
def crease_pull(crease, point, x):
    """How far a piece leads on towards a point at x [m]: positive where the nearest place is farther along."""
    place, slope = crease_place(crease, x)
    return dot(subtract(point, place), slope)


@inner()
def crease_nearest(creases, k, point):
    """Where piece k is nearest to a point: (whether it is so on the piece and not at its end, x)."""
    crease = creases[k]
    beyond = BEYOND * crease[CREASE.sizes, 0]
    low, high = -1.0, 1.0
    at_low, at_high = crease_pull(crease, point, low), crease_pull(crease, point, high)
    if not (at_low >= -beyond and at_high <= beyond):
        return False, 0.0
    if at_low <= 0.0:
        return True, low
    if at_high >= 0.0:
        return True, high
    # By secants that keep the place between them (Illinois).
    x, side = 0.0, 0
    for _ in range(60):
        x = (low * at_high - high * at_low) / (at_high - at_low)
        now = crease_pull(crease, point, x)
        if now > 0.0:
            low, at_low = x, now
            at_high *= 0.5 if side > 0 else 1.0
            side = 1
        else:
            high, at_high = x, now
            at_low *= 0.5 if side < 0 else 1.0
            side = -1
        if abs(now) < 1e-15 * crease[CREASE.sizes, 0] or high - low < 1e-15:
            break
    return True, x


@inlined()
def crease_vector(crease, rows, x):
    """The vector of three polynomials at x."""
    return polynomial(crease, rows.x, x)[0], polynomial(crease, rows.y, x)[0], polynomial(crease, rows.z, x)[0]


@inner()
def crease_touch(creases, k, point):
    """Distance of a point from piece k [m], the direction from there to the point, whether it is a contact.

    It is one where the nearest place is on the piece, and both walls lead away from the point there.
    """
    is_over, x = crease_nearest(creases, k, point)
    away = subtract(point, crease_place(creases[k], x)[0])
    distance = math.sqrt(dot(away, away)) + 1e-300
    beyond = BEYOND * creases[k, CREASE.sizes, 0]
    is_over &= dot(away, crease_vector(creases[k], CREASE.inward, x)) < beyond
    is_over &= dot(away, crease_vector(creases[k], CREASE.other, x)) < beyond
    return distance, scale(1.0 / distance, away), is_over


@inlined()
def crease_beyond(creases, k, point):
    """No more than the distance of a point from piece k [m]."""
    away = subtract(point, row(creases[k], CREASE.start))
    along = row(creases[k], CREASE.along)
    within = min(max(dot(away, along), 0.0), creases[k, CREASE.sizes, 0])
    away = add_scaled(away, -within, along)
    return math.sqrt(dot(away, away)) - creases[k, CREASE.sizes, 1]


@inlined()
def past_bow(bow, k, s, y, length, right):
    """Of a bow over a chord: no more than the squared distance of a point from it, and whether it is between both.

    s, y: along the chord and to its left [m]; right: whether the point is to the right of it.
    """
    if s <= 0.0 or s >= length:
        end = s if s <= 0.0 else s - length
        return ALONG * ALONG * (end * end + y * y), False
    height, _ = polynomial(bow, k, 2.0 * s / length - 1.0)
    between = (right and y > height) if height < 0.0 else (not right and y < height)
    return ALONG * ALONG * (y - height) * (y - height), between


@inlined()
def place_on(curves, frame, k, point):
    """Coordinates of a point near curve k: its angle about the axis, from 0 on, and its way along line or arc [m]."""
    axis, first = vector(curves, k, CURVE.axis), vector(frame, k, TRIM.first)
    away = subtract(point, vector(curves, k, CURVE.origin))
    up = dot(away, axis)
    across = add_scaled(away, -up, axis)
    out = math.sqrt(dot(across, across)) - curves[k, CURVE.major]
    angle = math.atan2(dot(cross(axis, first), across), dot(first, across))
    u = frame[k, TRIM.radius] * (angle if angle >= 0.0 else angle + 2.0 * math.pi)
    if curves[k, CURVE.is_torus] == 0.0:
        return u, up * curves[k, CURVE.rise] + out * curves[k, CURVE.spread]
    tube = math.atan2(up, out) - frame[k, TRIM.tube]
    tube -= 2.0 * math.pi * math.floor((tube + math.pi) / (2.0 * math.pi))
    return u, curves[k, CURVE.minor] * tube


@inner()
def beyond_trim(curves, trims, k, foot):
    """Distance of a point on a trimmed curve from its border [m], in the curve's coordinates; negative inside."""
    u, v = place_on(curves, trims.frame, k, foot)
    period = 2.0 * math.pi * trims.frame[k, TRIM.radius]
    nearest = 1e300
    inside = trims.frame[k, TRIM.is_inside] > 0.0
    for n in range(trims.first[k], trims.first[k + 1]):
        du, dv, length = trims.side[n, SIDE.direction_u], trims.side[n, SIDE.direction_v], trims.side[n, SIDE.length]
        start, end = trims.side[n, SIDE.start_u], trims.side[n, SIDE.end_u]
        ru, rv = u - start, v - trims.side[n, SIDE.start_v]
        ru -= period * math.floor(ru / period + 0.5)
        # Even-odd rule with a ray along v, by the vertices' own numbers, see walls.beyond_side.
        spans = ((u >= start) != (u >= end)) != (abs(end - start) > 0.5 * period)
        across = ru * dv - rv * du
        inside ^= spans & (across * du > 0.0)
        along = ru * du + rv * dv
        if trims.side[n, SIDE.radius] < 0.0:
            right = across > 0.0 or (across == 0.0 and du < 0.0)
            squared, between = past_bow(trims.bow, int(trims.side[n, SIDE.centre_u]), along, -across, length, right)
            nearest = min(nearest, squared)
            inside ^= between
        else:
            within = min(max(along, 0.0), length)
            away_u, away_v = ru - within * du, rv - within * dv
            nearest = min(nearest, away_u * away_u + away_v * away_v)
    distance = math.sqrt(nearest)
    return -distance if inside else distance
