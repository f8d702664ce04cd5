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


@numba.njit
def _nearest_of(corners, point):
    """The point of a triangle (3, 3) that is nearest to a point (3,)."""
    sides = np.empty((3, 3))
    for k in range(3):
        sides[k] = corners[(k + 1) % 3] - corners[k]
    normal = np.cross(sides[0], sides[1])
    best, nearest, is_over = np.inf, point, True
    for k in range(3):
        away = point - corners[k]
        is_over &= np.dot(np.cross(sides[k], away), normal) >= 0
        share = min(max(np.dot(away, sides[k]) / np.dot(sides[k], sides[k]), 0.0), 1.0)
        place = corners[k] + share * sides[k]
        squared = np.dot(point - place, point - place)
        if squared < best:
            best, nearest = squared, place
    if is_over:
        nearest = point - np.dot(point - corners[0], normal) / np.dot(normal, normal) * normal
    return nearest


@numba.njit
def nearest_on_triangles(triangles: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The points (n, 3) of triangles (t, 3, 3) nearest to points (n, 3), each with each, and winding numbers (n,).

    These are the triangles' solid angles over 4 pi: 1 inside, 0 outside (Van Oosterom and Strackee 1983).
    """
    nearest, winding = np.empty_like(points), np.zeros(len(points))
    for p in range(len(points)):
        best = np.inf
        for t in range(len(triangles)):
            a, b, c = triangles[t, 0] - points[p], triangles[t, 1] - points[p], triangles[t, 2] - points[p]
            la, lb, lc = np.linalg.norm(a), np.linalg.norm(b), np.linalg.norm(c)
            down = la * lb * lc + np.dot(a, b) * lc + np.dot(b, c) * la + np.dot(c, a) * lb
            winding[p] += np.arctan2(np.dot(a, np.cross(b, c)), down) / (2 * np.pi)
            place = _nearest_of(triangles[t], points[p])
            squared = np.dot(points[p] - place, points[p] - place)
            if squared < best:
                best, nearest[p] = squared, place
    return nearest, winding


def distance_to_triangles(triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Distances (n,) of points (n, 3) from the nearest of triangles (t, 3, 3)."""
    return np.linalg.norm(points - nearest_on_triangles(triangles, points)[0], axis=1)


def solid_angle(triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The winding numbers of `nearest_on_triangles`."""
    return nearest_on_triangles(triangles, points)[1]
