"""Merges coplanar triangles into flat facets with outlines, so that a ball meets one wall instead of many."""

from typing import NamedTuple

import numpy as np
import shapely

from millprint.run.kernel import array_maker

# The normals of a facet and of a triangle in it differ by no more than this angle [rad], and what the tolerance makes
# of the triangle's width.
NORMAL_ANGLE = 5e-3
# Facets of more triangles are looked at as a whole, and not pair by pair.
MANY_TRIANGLES = 16
# A facet that reaches far from its first triangle is found in steps; more rounds than this do not help.
ROUNDS = 20


class HalfEdges(NamedTuple):
    """Sides of triangles (3 t): side h runs from corner h % 3 of triangle h // 3 to its next corner."""

    start: np.ndarray  # (3 t,) vertex
    end: np.ndarray  # (3 t,)
    twin: np.ndarray  # (3 t,) the same side in the other triangle, in the opposite direction; -1 if there is none


class FlatFacets(NamedTuple):
    """The facets of a surface, each a list of loops (k, 3) [m] that run around it, and the facet of each triangle."""

    loops: list[list[np.ndarray]]
    of_triangle: np.ndarray  # (t,)


def half_edges(triangles: np.ndarray) -> HalfEdges:
    """The sides of triangles (t, 3) and their twins, for a surface that has each side once in each direction."""
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    count = np.int64(triangles.max() + 1)
    forward, backward = start * count + end, end * count + start
    order = np.argsort(forward, kind="stable")
    at = np.minimum(np.searchsorted(forward, backward, sorter=order), len(order) - 1)
    twin = np.where(forward[order[at]] == backward, order[at], -1)
    return HalfEdges(start, end, twin)


def _next(side: np.ndarray) -> np.ndarray:
    """The side that follows in the same triangle."""
    return side - side % 3 + (side + 1) % 3


def triangle_widths(corners: np.ndarray) -> np.ndarray:
    """The least height (t,) of triangles (t, 3, 3)."""
    sides = np.roll(corners, -1, axis=1) - corners
    twice_area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    return twice_area / np.maximum(np.linalg.norm(sides, axis=2).max(axis=1), np.finfo(float).tiny)


@array_maker()
def _regions(
    corners: np.ndarray,
    area_vector: np.ndarray,
    least_facing: np.ndarray,
    beside: np.ndarray,
    order: np.ndarray,
    tolerance: float,
) -> np.ndarray:
    """Number of the flat region of each triangle (t,); regions grow through sides, from the largest triangles first.

    A triangle belongs to a plane if its corners are within the tolerance and its area along the plane's normal is at
    least `least_facing`.
    """
    region, seen = np.full(order.size, -1), np.full(order.size, -1)
    members = np.empty(order.size, dtype=np.int64)
    regions, search = 0, 0
    for seed in order:
        if region[seed] >= 0:
            continue
        members[0], found, normal = seed, 1, area_vector[seed]
        # The plane of one triangle may be off at the far end of a wide facet: fit it to all found, and search again.
        for _ in range(ROUNDS):
            before = found
            normal = normal / np.sqrt((normal * normal).sum())
            offset = 0.0
            for member in members[:found]:
                for k in range(3):
                    offset += (corners[member, k] * normal).sum() / (3 * found)
            search += 1
            members[0], found, at = seed, 1, 0
            seen[seed] = search
            while at < found:
                for side in range(3):
                    other = beside[members[at], side]
                    if seen[other] == search or region[other] >= 0:
                        continue
                    seen[other] = search
                    height = 0.0
                    for k in range(3):
                        height = max(height, abs((corners[other, k] * normal).sum() - offset))
                    if height <= tolerance and (area_vector[other] * normal).sum() >= least_facing[other]:
                        members[found] = other
                        found += 1
                at += 1
            if found == before:
                break
            normal = np.zeros(3)
            for member in members[:found]:
                normal += area_vector[member]
        region[members[:found]] = regions
        regions += 1
    return region


def _flat_regions(points: np.ndarray, triangles: np.ndarray, twin: np.ndarray, tolerance: float) -> np.ndarray:
    corners = points[triangles]
    area_vector = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    area = np.linalg.norm(area_vector, axis=1)
    widths = triangle_widths(corners)
    # A triangle that is no wider than the tolerance has any normal: rounding may have turned it over.
    angle = np.where(widths > tolerance, NORMAL_ANGLE + 2 * tolerance / np.maximum(widths, tolerance), np.pi)
    order = np.argsort(-area, kind="stable")
    return _regions(corners, area_vector, area * np.cos(angle), twin.reshape(-1, 3) // 3, order, tolerance)


def _outlines(edges: HalfEdges, region: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sides (n,) around each region, loop after loop, the interior on their left; where each loop begins (l,)."""
    of_side = np.repeat(region, 3)
    is_border = of_side != of_side[edges.twin]
    border = np.flatnonzero(is_border)
    # On to the next border: around the vertex, through the triangles of the region.
    following = _next(border)
    while len(inside := np.flatnonzero(~is_border[following])):
        following[inside] = _next(edges.twin[following[inside]])
    after = np.full(len(of_side), -1)
    after[border] = following
    onward = after.tolist()
    sides: list[int] = []
    begins: list[int] = []
    for first in border.tolist():
        if onward[first] < 0:
            continue
        begins.append(len(sides))
        side = first
        while onward[side] >= 0:
            sides.append(side)
            onward[side], side = -1, onward[side]
    return np.array(sides), np.array(begins)


def _is_straight(points: np.ndarray, loops: np.ndarray, begins: np.ndarray, tolerance: float) -> np.ndarray:
    """Which places (n,) of loops have a vertex in the middle of a straight side between the same two facets."""
    rows = np.arange(len(loops))
    lasts = np.append(begins[1:], len(loops)) - 1
    before, after = rows - 1, rows + 1
    before[begins], after[lasts] = lasts, begins
    chord, away = points[loops[after]] - points[loops[before]], points[loops] - points[loops[before]]
    length, along = np.linalg.norm(chord, axis=1), (away * chord).sum(axis=1)
    is_between = (along > 0) & (along < length**2) & (np.bincount(loops)[loops] == 2)
    straight = is_between & (np.linalg.norm(np.cross(chord, away), axis=1) <= tolerance * length)
    return np.isin(loops, loops[straight])


def _area_vector(loop: np.ndarray) -> np.ndarray:
    return np.cross(loop, np.roll(loop, -1, axis=0)).sum(axis=0) / 2


def merge_coplanar(points: np.ndarray, triangles: np.ndarray, tolerance: float) -> FlatFacets:
    """Facets of a closed surface, normals as the triangles'.

    points: (v, 3) [m]; triangles: (t, 3); tolerance: how far the corners of a triangle may be off its facet's plane
    [m]. The first loop of a facet is the outer one, counter-clockwise about the normal.
    """
    edges = half_edges(triangles)
    region = _flat_regions(points, triangles, edges.twin, tolerance)
    sides, begins = _outlines(edges, region)
    loops = edges.start[sides]
    kept = ~_is_straight(points, loops, begins, tolerance)
    corners = np.split(points[loops[kept]], np.cumsum(np.add.reduceat(kept, begins, dtype=np.int64))[:-1])
    facets: list[list[np.ndarray]] = [[] for _ in range(region.max() + 1)]
    for facet, loop in zip(region[sides[begins] // 3].tolist(), corners, strict=True):
        facets[facet].append(loop)
    for found in facets:
        if len(found) > 1:
            found.sort(key=lambda loop: -np.linalg.norm(_area_vector(loop)))
    return FlatFacets(facets, region)


def without_overlap(facets: FlatFacets) -> np.ndarray:
    """The facet of each triangle (t,), where it is known that the facet's triangles do not overlap; otherwise -1.

    They turn alike about one normal, so that each covers a point of the plane as often as the outline winds around it.
    An outline that is a valid polygon winds once around what is inside. Only facets of many triangles are looked at.
    """
    is_simple = np.zeros(len(facets.loops), dtype=bool)
    for number in np.flatnonzero(np.bincount(facets.of_triangle) > MANY_TRIANGLES):
        outer, *holes = facets.loops[number]
        plane = np.argsort(np.abs(_area_vector(outer)))[:2]
        is_simple[number] = shapely.Polygon(outer[:, plane], [hole[:, plane] for hole in holes]).is_valid
    return np.where(is_simple[facets.of_triangle], facets.of_triangle, -1)
