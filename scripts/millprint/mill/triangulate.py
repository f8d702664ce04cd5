"""Facets cut into triangles, for meshes, pictures and STL files."""

import numpy as np
from scipy.spatial import Delaunay

from millprint.errors import ConfigError


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


def triangulate_facet(facet) -> np.ndarray:
    """Triangles (t, 3) as rows of the facet's vertices, its loops one after the other, counter-clockwise inward.

    Raises ConfigError for an outline that a Delaunay triangulation of its vertices does not respect.
    """
    axes = np.array(facet.axes).T
    loops = [loop @ axes for loop in facet.loops]
    points = np.concatenate(loops)
    triangles = Delaunay(points).simplices
    corners = points[triangles]
    triangles = triangles[_inside(corners.mean(axis=1), loops)]
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    if abs(np.abs(twice).sum() / 2 - facet.area) > 1e-9 * facet.area:
        raise ConfigError(f"the facet at {facet.loops[0][0] * 1e3} mm has an outline that cannot be cut into triangles")
    return np.where((twice < 0)[:, None], triangles[:, ::-1], triangles)


def triangulate(vessel) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (v, 3) [m] and triangles (t, 3) of a vessel's walls, normals inward, each vertex once."""
    vertices, triangles, number = [], [], {}
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
