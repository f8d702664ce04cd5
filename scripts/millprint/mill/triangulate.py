"""Facets cut into triangles, for meshes, pictures and STL files."""

import numpy as np

from millprint.errors import ConfigError
from millprint.mill.ears import clip_ears
from millprint.mill.vessel import Facet, Vessel

# A turn by less is no corner [rad]: a fan would have triangles of no area there.
STRAIGHT = 1e-6


def _inside(points: np.ndarray, loops: list[np.ndarray]) -> np.ndarray:
    """Even-odd rule: which points (n, 2) lie inside the outlines (k, 2)."""
    inside = np.zeros(len(points), dtype=bool)
    for loop in loops:
        for (u0, v0), (u1, v1) in zip(loop, np.roll(loop, -1, axis=0), strict=True):
            crosses = (v0 > points[:, 1]) != (v1 > points[:, 1])
            with np.errstate(divide="ignore", invalid="ignore"):
                at = u0 + (points[:, 1] - v0) / (v1 - v0) * (u1 - u0)
            inside ^= crosses & (points[:, 0] < at)
    return inside


def _cover(points: np.ndarray, triangles: np.ndarray, loops: list[np.ndarray], area: float) -> bool:
    """Whether triangles (t, 3) fill the outlines, with every side of them: then they fit to the neighbours'."""
    if abs(np.abs(_twice(points, triangles)).sum() / 2 - area) > 1e-9 * area:
        return False
    sides = {frozenset(pair) for row in triangles.tolist() for pair in zip(row, row[1:] + row[:1], strict=True)}
    first = np.cumsum([0, *(len(loop) for loop in loops)])
    return all(
        frozenset((first[n] + k, first[n] + (k + 1) % len(loop))) in sides
        for n, loop in enumerate(loops)
        for k in range(len(loop))
    )


def _twice(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    return (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]


def _is_convex(loop: np.ndarray) -> bool:
    """Whether a counter-clockwise outline (k, 2) turns left at every vertex, and once around in all."""
    side = np.roll(loop, -1, axis=0) - loop
    after = np.roll(side, -1, axis=0)
    turn = np.arctan2(side[:, 0] * after[:, 1] - side[:, 1] * after[:, 0], (side * after).sum(axis=1))
    return bool((turn > STRAIGHT).all() and abs(turn.sum() - 2 * np.pi) < 1e-6)


def triangulate_facet(facet: Facet) -> np.ndarray:
    """Triangles (t, 3) as rows of the facet's vertices, its loops one after the other, counter-clockwise inward.

    A fan where the outline is convex, as that of most walls is; Delaunay's triangles where they keep to the outlines,
    or else ears. Raises ConfigError for an outline that crosses itself.
    """
    axes = np.array(facet.axes).T
    loops = [loop @ axes for loop in facet.loops]
    if len(loops) == 1 and _is_convex(loops[0]):
        last = np.arange(2, len(loops[0]))
        return np.column_stack([np.zeros_like(last), last - 1, last])
    # Takes long to import, and few jars need it.
    from scipy.spatial import Delaunay

    points = np.concatenate(loops)
    triangles = Delaunay(points).simplices
    triangles = triangles[_inside(points[triangles].mean(axis=1), loops)]
    if not _cover(points, triangles, loops, facet.area):
        triangles = clip_ears(loops)
        if triangles is None or not _cover(points, triangles, loops, facet.area):
            where = f"the facet at {facet.loops[0][0] * 1e3} mm"
            raise ConfigError(f"{where} has an outline that cannot be cut into triangles: it crosses itself")
    return np.where((_twice(points, triangles) < 0)[:, None], triangles[:, ::-1], triangles)


def triangulate(vessel: Vessel) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (v, 3) [m] and triangles (t, 3) of a vessel's walls, normals inward, each vertex once."""
    vertices: list[np.ndarray] = []
    triangles: list[np.ndarray] = []
    number: dict[tuple[int, ...], int] = {}
    for facet in vessel.facets:
        rows = []
        for point in np.concatenate(facet.loops):
            key = vessel.key(point)
            if key not in number:
                number[key] = len(vertices)
                vertices.append(point)
            rows.append(number[key])
        triangles.append(np.array(rows)[triangulate_facet(facet)])
    return np.array(vertices), np.concatenate(triangles)
