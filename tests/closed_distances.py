"""What a ball in a hollow of `tests.profiles` touches, in closed form; and distances to any triangles. Lengths in mm.

A ball touches the local minima of the distance from its centre to the wall, the feet. For a turned hollow they are
those in the half plane of the axis and the centre: the distance to the circle of a point (r, z) has its one minimum
there, and its maximum on the far side. For an extruded one they are those in the plane of the outline, and one on each
flat end.

In the plane, a line has a foot where the centre projects onto it. So has an arc, in the direction from its middle to
the centre. A joint has one only where it is convex and the centre lies in the wedge between the two normals. In a
concave joint both neighbours may have one.
"""

import math
from typing import NamedTuple

import numba
import numpy as np

from tests.profiles import Hollow, Piece

# A joint that turns by less is smooth [rad].
SMOOTH = 1e-7
# By so little a foot may be past the end of a piece, of its length: rounding leaves no gap between two pieces.
PAST = 1e-9


class Feet(NamedTuple):
    """Of points (n) and possible feet (m): pieces, then what juts in, then floor and lid of an extruded hollow."""

    distance: np.ndarray  # (n, m) infinite where there is no foot
    direction: np.ndarray  # (n, m, 3) from the wall to the ball
    inside: np.ndarray  # (n,) whether the point is in the hollow
    place: np.ndarray  # (m,) number of a piece, a half more for the joint behind it; nan for a flat end

    @property
    def nearest(self) -> np.ndarray:
        """Distances (n,) to the wall."""
        return self.distance.min(axis=1)

    @property
    def towards(self) -> np.ndarray:
        """Directions (n, 3) from the nearest foot."""
        return self.direction[np.arange(len(self.distance)), self.distance.argmin(axis=1)]


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _of_piece(piece: Piece, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distances (n,) of points (n, 2) from their foot on a piece, infinite without one, and directions (n, 2)."""
    if not piece.sweep:
        along = piece.chord / piece.length
        away = at - piece.start
        share, height = away @ along / piece.length, _cross(along, away)
        direction = np.broadcast_to([-along[1], along[0]], at.shape)
    else:
        sense, first = math.copysign(1.0, piece.sweep), piece.start - piece.centre
        away = at - piece.centre
        reach = np.hypot(*away.T)
        angle = sense * np.arctan2(_cross(first, away), away @ first) + PAST * abs(piece.sweep)
        share = angle % (2 * np.pi) / abs(piece.sweep) - PAST
        height = sense * (piece.radius - reach)
        direction = -sense * away / np.maximum(reach, 1e-300)[:, None]
    there = (share >= -PAST) & (share <= 1 + PAST) & (height > 0)
    return np.where(there, height, np.inf), direction


def _of_joint(corner: np.ndarray, before: np.ndarray, after: np.ndarray, at: np.ndarray):
    """The same for a convex joint between two tangents (2,)."""
    away = at - corner
    distance = np.hypot(*away.T)
    there = (away @ before > -PAST * distance) & (away @ after < PAST * distance)
    return np.where(there, distance, np.inf), away / np.maximum(distance, 1e-300)[:, None]


def _in_plane(hollow: Hollow, at: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[float]]:
    """Distances (n, m), directions (n, m, 2) and `Feet.place` of points (n, 2) of the profile's plane."""
    pieces = hollow.pieces
    found, place = [_of_piece(piece, at) for piece in pieces], list(map(float, range(len(pieces))))
    for first, second, turn in hollow.joints:
        if turn < -SMOOTH:
            found.append(_of_joint(pieces[first].end, pieces[first].along(1.0), pieces[second].along(0.0), at))
            place.append(first + 0.5)
    if hollow.is_turned:
        # Where the profile meets the axis, its mirror image goes on: a tip that juts in is a point to touch.
        begin, end = pieces[0].along(0.0), pieces[-1].along(1.0)
        for corner, towards, is_tip, number in (
            (pieces[0].start, -begin, begin[1] < -SMOOTH, -0.5),
            (pieces[-1].end, end, end[1] < -SMOOTH, len(pieces) - 0.5),
        ):
            if is_tip:
                found.append(_of_joint(corner, towards, -towards, at))
                place.append(number)
    distance, direction = zip(*found, strict=True)
    return np.stack(distance, axis=1), np.stack(direction, axis=1), place


def in_profile(hollow: Hollow, at: np.ndarray) -> np.ndarray:
    """Whether points (n, 2) are inside the profile, by its winding number, a turned one closed along the axis.

    An arc winds about a point as its chord does, and once more where the point is between the two.
    """
    ends = [piece.start for piece in hollow.pieces] + ([hollow.pieces[-1].end] if hollow.is_turned else [])
    away = np.array(ends)[:, None] - at
    following = np.roll(away, -1, axis=0)
    winding = np.arctan2(_cross(away, following), (away * following).sum(axis=2)).sum(axis=0) / (2 * np.pi)
    for piece in hollow.pieces:
        if piece.sweep:
            beside = np.hypot(*(at - piece.centre).T) < piece.radius
            beyond = _cross(piece.chord, at - piece.start) * piece.sweep < 0
            winding = winding + np.where(beside & beyond, math.copysign(1.0, piece.sweep), 0.0)
    return np.rint(winding) == 1


def feet(hollow: Hollow, points: np.ndarray) -> Feet:
    """The feet of ball centres (n, 3)."""
    local = (points - hollow.shift) @ hollow.rotation
    if hollow.is_turned:
        out = np.hypot(local[:, 0], local[:, 1])
        at = np.column_stack([out, local[:, 2]])
        outwards = np.column_stack([local[:, :2] / np.maximum(out, 1e-300)[:, None], np.zeros(len(out))])
        distance, flat, place = _in_plane(hollow, at)
        direction = flat[..., :1] * outwards[:, None] + flat[..., 1:] * [0.0, 0.0, 1.0]
        inside = in_profile(hollow, at)
    else:
        at, level = local[:, :2], local[:, 2]
        distance, flat, place = _in_plane(hollow, at)
        inside = in_profile(hollow, at)
        ends = np.where(inside[:, None], np.column_stack([level, hollow.height - level]), np.inf)
        distance = np.hstack([distance, np.where(ends > 0, ends, np.inf)])
        direction = np.concatenate([flat, np.zeros((*flat.shape[:2], 1))], axis=2)
        up = np.broadcast_to([[[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]], (len(at), 2, 3))
        direction, place = np.concatenate([direction, up], axis=1), [*place, math.nan, math.nan]
        inside = inside & (level > 0) & (level < hollow.height)
    return Feet(distance, direction @ hollow.rotation.T, inside, np.array(place))


# Vectors of three numbers are tuples: numba takes a seventh of the time to compile what it does with them.


@numba.njit
def _along(a, share, b):
    """The point at a share of the way b beyond a."""
    return a[0] + share * b[0], a[1] + share * b[1], a[2] + share * b[2]


@numba.njit
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@numba.njit
def _normal_of(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@numba.njit
def _nearest_of(corners):
    """The point of a triangle of three corners that is nearest to the origin."""
    sides = (_along(corners[1], -1, corners[0]), _along(corners[2], -1, corners[1]), _along(corners[0], -1, corners[2]))
    normal = _normal_of(sides[0], sides[1])
    best, nearest, is_over = np.inf, corners[0], True
    for k in range(3):
        is_over &= _dot(_normal_of(sides[k], corners[k]), normal) <= 0
        share = min(max(-_dot(corners[k], sides[k]) / _dot(sides[k], sides[k]), 0.0), 1.0)
        place = _along(corners[k], share, sides[k])
        squared = _dot(place, place)
        if squared < best:
            best, nearest = squared, place
    if is_over:
        nearest = _along((0.0, 0.0, 0.0), _dot(corners[0], normal) / _dot(normal, normal), normal)
    return nearest


@numba.njit
def nearest_on_triangles(triangles: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The points (n, 3) of triangles (t, 3, 3) nearest to points (n, 3), each with each, and winding numbers (n,).

    These are the triangles' solid angles over 4 pi: 1 inside, 0 outside (Van Oosterom and Strackee 1983).
    """
    nearest, winding = np.empty_like(points), np.zeros(len(points))
    for p in range(len(points)):
        point, best = (points[p, 0], points[p, 1], points[p, 2]), np.inf
        for t in range(len(triangles)):
            corners = triangles[t]
            a = _along((corners[0, 0], corners[0, 1], corners[0, 2]), -1, point)
            b = _along((corners[1, 0], corners[1, 1], corners[1, 2]), -1, point)
            c = _along((corners[2, 0], corners[2, 1], corners[2, 2]), -1, point)
            la, lb, lc = math.sqrt(_dot(a, a)), math.sqrt(_dot(b, b)), math.sqrt(_dot(c, c))
            down = la * lb * lc + _dot(a, b) * lc + _dot(b, c) * la + _dot(c, a) * lb
            winding[p] += math.atan2(_dot(a, _normal_of(b, c)), down) / (2 * math.pi)
            place = _nearest_of((a, b, c))
            squared = _dot(place, place)
            if squared < best:
                best = squared
                nearest[p, 0], nearest[p, 1], nearest[p, 2] = _along(point, 1, place)
    return nearest, winding


def distance_to_triangles(triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Distances (n,) of points (n, 3) from the nearest of triangles (t, 3, 3)."""
    return np.linalg.norm(points - nearest_on_triangles(triangles, points)[0], axis=1)


def solid_angle(triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The winding numbers of `nearest_on_triangles`."""
    return nearest_on_triangles(triangles, points)[1]
