"""Merges coplanar triangles into flat facets with outlines, so that a ball meets one wall instead of many."""

from typing import NamedTuple

import numpy as np

# A triangle belongs to a facet if its corners are this close to the facet's plane, as a share of the surface's size:
# sixteen times the rounding of the 32-bit numbers of a binary STL.
FLAT = 1e-6
# The normals of the two differ by no more than this angle [rad], if the triangle is wide enough to have a sure normal.
NORMAL_ANGLE = 5e-3


class HalfEdges(NamedTuple):
    """Sides of triangles (3 t): side h runs from corner h % 3 of triangle h // 3 to its next corner."""

    start: np.ndarray  # (3 t,) vertex
    end: np.ndarray  # (3 t,)
    twin: np.ndarray  # (3 t,) the same side in the other triangle, in the opposite direction; -1 if there is none


def half_edges(triangles: np.ndarray) -> HalfEdges:
    """The sides of triangles (t, 3) and their twins, for a surface that has each side once in each direction."""
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    count = np.int64(triangles.max() + 1)
    forward, backward = start * count + end, end * count + start
    order = np.argsort(forward, kind="stable")
    at = np.minimum(np.searchsorted(forward, backward, sorter=order), len(order) - 1)
    twin = np.where(forward[order[at]] == backward, order[at], -1)
    return HalfEdges(start, end, twin)


def _next(side: int) -> int:
    return side - 2 if side % 3 == 2 else side + 1


class _Flatness:
    """Which triangles lie in a plane."""

    def __init__(self, points: np.ndarray, triangles: np.ndarray, tolerance: float) -> None:
        self.corners, self.tolerance = points[triangles], tolerance
        sides = np.roll(self.corners, -1, axis=1) - self.corners
        self.area_vector = np.cross(sides[:, 0], sides[:, 1]) / 2
        self.area = np.linalg.norm(self.area_vector, axis=1)
        self.normal = self.area_vector / self.area[:, None]
        width = 2 * self.area / np.linalg.norm(sides, axis=2).max(axis=1)
        self.is_sliver = width < 20 * tolerance

    def within(self, normal: np.ndarray, offset: float, which: np.ndarray) -> np.ndarray:
        """Which of some triangles (numbers, n) lie in the plane normal . x = offset, facing its way."""
        near = (np.abs(self.corners[which] @ normal - offset) <= self.tolerance).all(axis=1)
        facing = self.normal[which] @ normal
        return near & ((facing >= np.cos(NORMAL_ANGLE)) | (self.is_sliver[which] & (facing > 0)))

    def offset(self, normal: np.ndarray, which: np.ndarray) -> float:
        """Mean offset along a normal of some triangles' corners [m]."""
        return float((self.corners[which] @ normal).mean())


def _grow(
    seed: int, normal: np.ndarray, offset: float, flatness: _Flatness, twin: np.ndarray, free: np.ndarray
) -> np.ndarray:
    """Free triangles of a plane that are connected with `seed` through sides, in ascending order."""
    found = front = np.array([seed])
    seen = {seed}
    while len(front):
        beside = twin.reshape(-1, 3)[front].ravel() // 3
        new = np.array([t for t in dict.fromkeys(beside.tolist()) if t not in seen and free[t]], dtype=np.int64)
        seen.update(new.tolist())
        front = new[flatness.within(normal, offset, new)]
        found = np.concatenate([found, front])
    return np.sort(found)


def _regions(flatness: _Flatness, twin: np.ndarray) -> np.ndarray:
    """Number of the flat region of each triangle (t,); regions grow from the largest triangles first."""
    region = np.full(len(flatness.area), -1)
    regions = 0
    for seed in np.argsort(-flatness.area, kind="stable"):
        if region[seed] >= 0:
            continue
        normal, members = flatness.normal[seed], np.array([seed])
        # The plane of one triangle may be off at the far end of a wide facet: fit it to all found, and search again.
        for _ in range(3):
            grown = _grow(int(seed), normal, flatness.offset(normal, members), flatness, twin, region < 0)
            if np.array_equal(grown, members):
                break
            members = grown
            normal = flatness.area_vector[members].sum(axis=0)
            normal /= np.linalg.norm(normal)
        region[members] = regions
        regions += 1
    return region


def _outlines(edges: HalfEdges, region: np.ndarray) -> list[list[list[int]]]:
    """Loops of vertices around each region, their interior on the left."""
    of_side = np.repeat(region, 3)
    is_border = of_side != of_side[edges.twin]
    loops: list[list[list[int]]] = [[] for _ in range(region.max() + 1)]
    done = ~is_border
    for first in np.flatnonzero(is_border):
        if done[first]:
            continue
        loop, side = [], int(first)
        while not done[side]:
            done[side] = True
            loop.append(int(edges.start[side]))
            # On to the next border: around the vertex, through the triangles of the region.
            side = _next(side)
            while not is_border[side]:
                side = _next(int(edges.twin[side]))
        loops[region[first // 3]].append(loop)
    return loops


def _straight_vertices(points: np.ndarray, loops: list[list[list[int]]], tolerance: float) -> set[int]:
    """Vertices in the middle of a straight side between the same two facets, which are not corners."""
    visits: dict[int, int] = {}
    neighbours: dict[int, tuple[int, int]] = {}
    for facet in loops:
        for loop in facet:
            for k, vertex in enumerate(loop):
                visits[vertex] = visits.get(vertex, 0) + 1
                neighbours[vertex] = loop[k - 1], loop[(k + 1) % len(loop)]
    straight = set()
    for vertex, count in visits.items():
        before, after = (points[other] for other in neighbours[vertex])
        chord, away = after - before, points[vertex] - before
        length = np.linalg.norm(chord)
        inside = 0 < away @ chord < length**2
        if count == 2 and inside and np.linalg.norm(np.cross(chord, away)) <= tolerance * length:
            straight.add(vertex)
    return straight


def merge_coplanar(points: np.ndarray, triangles: np.ndarray, size: float) -> list[list[np.ndarray]]:
    """Facets of a closed surface, each a list of loops (k, 3) [m] that run around it, normals as the triangles'.

    points: (v, 3) [m]; triangles: (t, 3); size: what the tolerances FLAT and NORMAL_ANGLE refer to [m]. The first loop
    is the outer one, counter-clockwise about the normal.
    """
    edges = half_edges(triangles)
    region = _regions(_Flatness(points, triangles, FLAT * size), edges.twin)
    outlines = _outlines(edges, region)
    straight = _straight_vertices(points, outlines, FLAT * size)
    facets = []
    for loops in outlines:
        kept = [[vertex for vertex in loop if vertex not in straight] for loop in loops]
        corners = [points[loop] for loop in kept]
        corners.sort(key=lambda loop: -np.linalg.norm(np.cross(loop, np.roll(loop, -1, axis=0)).sum(axis=0)))
        facets.append(corners)
    return facets
