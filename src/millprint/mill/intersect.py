"""Whether a surface of triangles cuts through itself: bounding boxes in a sweep, then pairs of triangles."""

import math

import numpy as np

from millprint.mill.merge import triangle_widths
from millprint.mill.vectors import add_scaled, cross, dot, row, subtract
from millprint.run.kernel import array_maker, inlined


@inlined()
def _corner(points, triangles, t, k):
    return row(points, triangles[t, k % 3])


@inlined()
def _height(points, triangles, normal, t, point):
    """Height of a point over the plane of triangle t."""
    return dot(row(normal, t), subtract(point, _corner(points, triangles, t, 0)))


@inlined()
def _same_side(points, triangles, normal, a, b, tolerance):
    """Place of the corners of b: 1 all on one side of the plane of a, 0 all in it, -1 neither."""
    low, high = 1e300, -1e300
    for k in range(3):
        height = _height(points, triangles, normal, a, _corner(points, triangles, b, k))
        low, high = min(low, height), max(high, height)
    if low > tolerance or high < -tolerance:
        return 1
    return 0 if low >= -tolerance and high <= tolerance else -1


@inlined()
def _overlap_in_plane(points, triangles, a, b, normal, tolerance):
    """Whether two triangles of one plane share an area: no side of either separates them (separating axes)."""
    for side in range(6):
        t = a if side < 3 else b
        along = subtract(_corner(points, triangles, t, side + 1), _corner(points, triangles, t, side))
        axis = cross(along, normal)
        size = math.sqrt(dot(axis, axis))
        low_a, high_a, low_b, high_b = 1e300, -1e300, 1e300, -1e300
        for k in range(3):
            at = dot(axis, _corner(points, triangles, a, k)) / size
            low_a, high_a = min(low_a, at), max(high_a, at)
            at = dot(axis, _corner(points, triangles, b, k)) / size
            low_b, high_b = min(low_b, at), max(high_b, at)
        if min(high_a, high_b) - max(low_a, low_b) <= tolerance:
            return False
    return True


@inlined()
def _pierces(points, triangles, normal, width, start, end, t, tolerance):
    """Whether the segment from start to end passes from one side of triangle t to the other, through it.

    The corners of the triangle are known to the tolerance, and its plane the less the farther away, over its width.
    """
    first = _height(points, triangles, normal, t, start)
    last = _height(points, triangles, normal, t, end)
    if not ((first > tolerance and last < -tolerance) or (first < -tolerance and last > tolerance)):
        return False
    along = subtract(end, start)
    slope = abs(first - last) - tolerance / width[t] * math.sqrt(dot(along, along))
    if min(abs(first), abs(last)) * slope < tolerance * abs(first - last):
        return False
    place = add_scaled(start, first / (first - last), along)
    for k in range(3):
        corner = _corner(points, triangles, t, k)
        along = subtract(_corner(points, triangles, t, k + 1), corner)
        inward = cross(row(normal, t), along)
        # Sides count as part of the triangle: a segment through a side shared by two must not slip between them.
        if dot(inward, subtract(place, corner)) < -1e-3 * tolerance * math.sqrt(dot(along, along)):
            return False
    return True


@inlined()
def _shared_corners(triangles, a, b):
    shared = 0
    for i in range(3):
        for j in range(3):
            if triangles[a, i] == triangles[b, j]:
                shared += 1
    return shared


@inlined()
def _side_pierces(points, triangles, normal, width, a, b, tolerance):
    """Whether a side of a that has no corner in common with b passes through b."""
    for k in range(3):
        u, v = triangles[a, k], triangles[a, (k + 1) % 3]
        touches = False
        for j in range(3):
            touches = touches or triangles[b, j] == u or triangles[b, j] == v
        if not touches and _pierces(points, triangles, normal, width, row(points, u), row(points, v), b, tolerance):
            return True
    return False


@inlined()
def _meet(points, triangles, normal, width, a, b, tolerance):
    of_b = _same_side(points, triangles, normal, a, b, tolerance)
    of_a = _same_side(points, triangles, normal, b, a, tolerance)
    if of_a == 1 or of_b == 1:
        return False
    if of_a == 0 or of_b == 0:
        plane = row(normal, a) if of_b == 0 else row(normal, b)
        return _overlap_in_plane(points, triangles, a, b, plane, tolerance)
    # Two planes meet in one line; triangles with a side in common have it there and meet nowhere else.
    if _shared_corners(triangles, a, b) >= 2:
        return False
    return _side_pierces(points, triangles, normal, width, a, b, tolerance) or _side_pierces(
        points, triangles, normal, width, b, a, tolerance
    )


@array_maker()
def _first_meeting(points, triangles, normal, width, low, high, apart, tolerance):
    for a in range(len(triangles)):
        for b in range(a + 1, len(triangles)):
            if low[b, 0] > high[a, 0]:
                break
            if low[b, 1] > high[a, 1] or low[a, 1] > high[b, 1] or low[b, 2] > high[a, 2] or low[a, 2] > high[b, 2]:
                continue
            if (apart[a] < 0 or apart[a] != apart[b]) and _meet(points, triangles, normal, width, a, b, tolerance):
                return a, b
    return -1, -1


def self_intersection(
    points: np.ndarray, triangles: np.ndarray, tolerance: float, apart: np.ndarray | None = None
) -> tuple[int, int] | None:
    """Two triangles of a surface that cut through or cover each other, or None.

    points: (v, 3) [m]; triangles: (t, 3) rows of `points`, none without area; tolerance: heights up to this [m] count
    as lying in a plane, so that surfaces which merely touch are accepted; apart: (t,) two triangles of one number that
    is not negative are known not to meet. Broad phase: the bounding boxes, swept along the axis on which they are
    shortest.
    """
    boxes = np.ptp(points[triangles], axis=1)
    # The sweep runs along the first axis; a cyclic change of axes keeps every sense of turning.
    axis = int(np.argmin(boxes.mean(axis=0) / np.maximum(np.ptp(points, axis=0), np.finfo(float).tiny)))
    points = np.ascontiguousarray(np.roll(points, -axis, axis=1))
    order = np.argsort(points[triangles].min(axis=1)[:, 0], kind="stable")
    triangles = np.ascontiguousarray(triangles[order])
    apart = np.full(len(order), -1) if apart is None else apart[order]
    corners = points[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    low, high, width = corners.min(axis=1), corners.max(axis=1), triangle_widths(corners)
    a, b = _first_meeting(points, triangles, normal, width, low, high, apart, tolerance)
    return None if a < 0 else (int(order[a]), int(order[b]))
