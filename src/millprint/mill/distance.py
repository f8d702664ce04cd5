"""Exact signed distance to the walls of a vessel or of a solid, and its gradient."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from millprint.mill.curved_surfaces import curve_rows, curve_touch
from millprint.mill.patches import is_joint, outline_slack
from millprint.mill.vectors import add_scaled, dot, row, scale, subtract
from millprint.mill.vessel import Vessel, ahead, cross
from millprint.mill.wall_arrays import facet_sides
from millprint.mill.walls import beyond_side
from millprint.run.kernel import array_maker, inlined


class Surface(NamedTuple):
    """Facets (f) and their sides (s); a side is a directed edge of a facet's outline."""

    normal: np.ndarray  # (f, 3) inward
    offset: np.ndarray  # (f,)
    axes: np.ndarray  # (f, 2, 3) unit vectors in the plane
    first_side: np.ndarray  # (f + 1,)
    start: np.ndarray  # (s, 3)
    along: np.ndarray  # (s, 3) unit vectors
    length: np.ndarray  # (s,)
    side: np.ndarray  # (s, 7) walls.SideColumns
    side_normal: np.ndarray  # (s, 3) sum of the two facets' normals
    side_is_joint: np.ndarray  # (s,) see patches.is_joint
    corner_normal: np.ndarray  # (s, 3) angle-weighted normals at the side's start
    corner_is_joint: np.ndarray  # (s,) whether all sides at the side's start are joints
    slack: np.ndarray  # (f,) see patches.outline_slack [m]
    curve: np.ndarray  # (f,) the curve that a facet is a piece of; -1 for a flat wall
    curves: np.ndarray  # (curves, width) curves.CurveColumns


def _surface(vessel: Vessel) -> Surface:
    first, rows = [0], []
    corner_sum: dict[tuple[int, ...], np.ndarray] = {}
    all_joints: dict[tuple[int, ...], bool] = {}
    for facet in vessel.facets:
        for loop in facet.loops:
            forth, back = ahead(loop) - loop, np.concatenate((loop[-1:], loop[:-1])) - loop
            length = np.linalg.norm(forth, axis=1)
            along = forth / length[:, None]
            back = back / np.linalg.norm(back, axis=1)[:, None]
            inward = cross(facet.normal, along)
            angle = np.arctan2((inward * back).sum(axis=1), (along * back).sum(axis=1)) % (2 * np.pi)
            for k, (key, edge) in enumerate(zip(vessel.keys(loop), vessel.edges_along(loop), strict=True)):
                side_normal = sum(vessel.facets[index].normal for index in edge.facets)
                corner_sum[key] = corner_sum.get(key, 0) + angle[k] * facet.normal
                joint = is_joint(vessel, edge)
                all_joints[key] = all_joints.get(key, True) and joint
                rows.append((loop[k], along[k], length[k], side_normal, joint, key))
        first.append(len(rows))
    *sides, keys = zip(*rows, strict=True)
    start, along, length, side_normal, side_is_joint = map(np.array, sides)
    return Surface(
        normal=np.array([facet.normal for facet in vessel.facets]),
        offset=np.array([facet.offset for facet in vessel.facets]),
        axes=np.array([facet.axes for facet in vessel.facets]),
        first_side=np.array(first),
        start=start,
        along=along,
        length=length,
        side=facet_sides(vessel)[1],
        side_normal=side_normal,
        side_is_joint=side_is_joint,
        corner_normal=np.array([corner_sum[key] for key in keys]),
        corner_is_joint=np.array([all_joints[key] for key in keys]),
        slack=outline_slack(vessel),
        curve=vessel.facet_curves,
        curves=curve_rows(vessel.curves),
    )


@inlined()
def _nearest_on_outline(surface, facet, point):
    """Nearest point of a facet's outline: (squared distance, vector from it to the point, normal there).

    Joints of curves are left out: there is no edge.
    """
    best = 1e300
    away_best = (0.0, 0.0, 0.0)
    outward = (0.0, 0.0, 0.0)
    for k in range(surface.first_side[facet], surface.first_side[facet + 1]):
        away = subtract(point, row(surface.start, k))
        along = dot(away, row(surface.along, k))
        # The end of a side is the start of the next one, which knows the corner's normal.
        if along >= surface.length[k]:
            continue
        if surface.corner_is_joint[k] if along <= 0.0 else surface.side_is_joint[k]:
            continue
        within = max(along, 0.0)
        away = add_scaled(away, -within, row(surface.along, k))
        squared = dot(away, away)
        if squared < best:
            best = squared
            away_best = away
            outward = row(surface.corner_normal, k) if along <= 0.0 else row(surface.side_normal, k)
    return best, away_best, outward


@inlined()
def _is_there(surface, curve, foot, direction):
    """Whether a curve is a wall at a point of it, where its normal has this direction: not in a lifter on a shell.

    One of the facets that the curve is drawn by is there. Over the joint of two the foot may be beyond both, by less
    than it is above them.
    """
    for facet in range(surface.offset.size):
        if surface.curve[facet] != curve or dot(row(surface.normal, facet), direction) < 0.5:
            continue
        above = abs(dot(row(surface.normal, facet), foot) - surface.offset[facet])
        if beyond_side(surface.axes, surface.first_side, surface.side, facet, foot) <= above + 1e-12:
            return True
    return False


@inlined()
def distance_at(surface, point):
    """Signed distance of a point and its gradient; the nearest facet or side decides the sign."""
    best = 1e300
    away = (0.0, 0.0, 0.0)
    sign = 1.0
    for facet in range(surface.offset.size):
        normal = row(surface.normal, facet)
        height = dot(normal, point) - surface.offset[facet]
        is_drawing = surface.curve[facet] >= 0
        if height * height >= best and not is_drawing:
            continue
        if (
            not is_drawing
            and beyond_side(surface.axes, surface.first_side, surface.side, facet, point) <= surface.slack[facet]
        ):
            best = height * height
            # On the wall itself, the direction is that of its normal.
            away = scale(height, normal) if height != 0.0 else normal
            sign = -1.0 if height >= 0 else 1.0
        else:
            # A sharp edge on the outline of a piece of a curve is a wall itself.
            squared, offset, outward = _nearest_on_outline(surface, facet, point)
            if squared < best:
                best = squared
                away = offset
                sign = -1.0 if dot(offset, outward) > 0 else 1.0
    for curve in range(surface.curves.shape[0]):
        height, normal, past, _ = curve_touch(surface.curves, curve, point)
        foot = add_scaled(point, -height, normal)
        if past <= 1e-12 and height * height < best and _is_there(surface, curve, foot, normal):
            best = height * height
            away = scale(height, normal) if height != 0.0 else normal
            sign = -1.0 if height >= 0 else 1.0
    size = np.sqrt(dot(away, away))
    return sign * np.sqrt(best), (sign * away[0] / size, sign * away[1] / size, sign * away[2] / size)


@array_maker()
def _signed_distance(surface, points):
    count = points.shape[0]
    distance = np.empty(count)
    gradient = np.empty((count, 3))
    for p in range(count):
        distance[p], gradient_p = distance_at(surface, row(points, p))
        for c in range(3):
            gradient[p, c] = gradient_p[c]
    return distance, gradient


class SignedDistance:
    """Signed distance to the walls of a body, in its frame: zero on the wall, negative where the balls are.

    Balls are inside a vessel, and outside a solid.
    """

    def __init__(self, vessel: Vessel) -> None:
        self.surface = _surface(vessel)

    def __call__(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances (...) [m] and their gradients (..., 3) [-] at points (..., 3) [m]."""
        points = np.asarray(points, dtype=float)
        distance, gradient = _signed_distance(self.surface, np.ascontiguousarray(points.reshape(-1, 3)))
        return distance.reshape(points.shape[:-1]), gradient.reshape(points.shape)


@lru_cache(maxsize=32)
def signed_distance(vessel: Vessel) -> SignedDistance:
    """The signed distance of a body, kept for the bodies used last."""
    return SignedDistance(vessel)
