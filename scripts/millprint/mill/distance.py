"""Exact signed distance to the walls of a vessel or of a solid, and its gradient."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from millprint.kernel import array_maker, inlined
from millprint.mill.vectors import add_scaled, dot, row, scale, subtract
from millprint.mill.vessel import Vessel, ahead, cross


class Surface(NamedTuple):
    """Facets (f) and their sides (s); a side is a directed edge of a facet's outline."""

    normal: np.ndarray  # (f, 3) inward
    offset: np.ndarray  # (f,)
    axes: np.ndarray  # (f, 2, 3) unit vectors in the plane
    first_side: np.ndarray  # (f + 1,)
    start: np.ndarray  # (s, 3)
    along: np.ndarray  # (s, 3) unit vectors
    length: np.ndarray  # (s,)
    flat: np.ndarray  # (s, 4) start u, v and end u, v along the axes
    side_normal: np.ndarray  # (s, 3) sum of the two facets' normals
    corner_normal: np.ndarray  # (s, 3) angle-weighted normals at the side's start


def _surface(vessel: Vessel) -> Surface:
    first, rows = [0], []
    corner_sum: dict[tuple[int, ...], np.ndarray] = {}
    for facet in vessel.facets:
        for loop in facet.loops:
            forth, back = ahead(loop) - loop, np.concatenate((loop[-1:], loop[:-1])) - loop
            length = np.linalg.norm(forth, axis=1)
            along = forth / length[:, None]
            flat = loop @ np.array(facet.axes).T
            flat = np.hstack([flat, ahead(flat)])
            back = back / np.linalg.norm(back, axis=1)[:, None]
            inward = cross(facet.normal, along)
            angle = np.arctan2((inward * back).sum(axis=1), (along * back).sum(axis=1)) % (2 * np.pi)
            for k, (key, edge) in enumerate(zip(vessel.keys(loop), vessel.edges_along(loop), strict=True)):
                side_normal = sum(vessel.facets[index].normal for index in edge.facets)
                corner_sum[key] = corner_sum.get(key, 0) + angle[k] * facet.normal
                rows.append((loop[k], along[k], length[k], flat[k], side_normal, key))
        first.append(len(rows))
    *sides, keys = zip(*rows, strict=True)
    planes = zip(*((facet.normal, facet.offset, facet.axes) for facet in vessel.facets), strict=True)
    columns = (*planes, first, *sides, [corner_sum[key] for key in keys])
    return Surface(*map(np.array, columns))


@inlined()
def _nearest_on_outline(surface, facet, point):
    """Nearest point of a facet's outline: (squared distance, vector from it to the point, inside or not)."""
    best = 1e300
    away_best = (0.0, 0.0, 0.0)
    outward = (0.0, 0.0, 0.0)
    for k in range(surface.first_side[facet], surface.first_side[facet + 1]):
        away = subtract(point, row(surface.start, k))
        along = dot(away, row(surface.along, k))
        # The end of a side is the start of the next one, which knows the corner's normal.
        if along >= surface.length[k]:
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
def _over_facet(surface, facet, point):
    """Whether the foot of `point` lies on a facet: even-odd rule with a ray along u (see walls.beyond_side)."""
    axes = surface.axes[facet]
    u, v = dot(row(axes, 0), point), dot(row(axes, 1), point)
    inside = False
    for k in range(surface.first_side[facet], surface.first_side[facet + 1]):
        u0, v0, u1, v1 = surface.flat[k, 0], surface.flat[k, 1], surface.flat[k, 2], surface.flat[k, 3]
        if (v >= v0) != (v >= v1) and ((u - u0) * (v1 - v0) - (v - v0) * (u1 - u0)) * (v1 - v0) < 0:
            inside = not inside
    return inside


@inlined()
def distance_at(surface, point):
    """Signed distance of a point and its gradient; the nearest facet or side decides the sign."""
    best = 1e300
    away = (0.0, 0.0, 0.0)
    sign = 1.0
    for facet in range(surface.offset.size):
        height = dot(row(surface.normal, facet), point) - surface.offset[facet]
        if height * height >= best:
            continue
        if _over_facet(surface, facet, point):
            best = height * height
            normal = row(surface.normal, facet)
            away = scale(height, normal)
            sign = -1.0 if height >= 0 else 1.0
            if height == 0.0:
                away = normal
                best = 0.0
        else:
            squared, offset, outward = _nearest_on_outline(surface, facet, point)
            if squared < best:
                best = squared
                away = offset
                sign = -1.0 if dot(offset, outward) > 0 else 1.0
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
