"""Plane outlines with holes cut into triangles, for meshes, pictures and STL files."""

import numpy as np

# A smaller turn is not a corner [rad]: a fan would have triangles of no area there.
STRAIGHT = 1e-6


def _twice(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    return (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]


def are_convex(loops: np.ndarray) -> np.ndarray:
    """Whether counter-clockwise outlines (m, k, 2) turn left at every vertex, and once around in all."""
    side = np.roll(loops, -1, axis=1) - loops
    after = np.roll(side, -1, axis=1)
    turn = np.arctan2(side[..., 0] * after[..., 1] - side[..., 1] * after[..., 0], (side * after).sum(axis=-1))
    return (turn > STRAIGHT).all(axis=1) & (np.abs(turn.sum(axis=1) - 2 * np.pi) < 1e-6)


def convex_fan(count: int) -> np.ndarray:
    """The triangles (count - 2, 3) of a convex outline of a number of vertices."""
    last = np.arange(2, count)
    return np.column_stack([np.zeros_like(last), last - 1, last])


def triangulate_polygon(loops: list[np.ndarray], area: float) -> np.ndarray | None:
    """Triangles (t, 3) of an outline with holes, rows of the vertices of its loops in turn, counter-clockwise.

    loops: (k, 2) each, the outer one counter-clockwise first, then holes clockwise; area: what they enclose. Every side
    of a loop is the side of a triangle, so that triangles of neighbours meet: a fan where the outline is convex, as
    that of most walls is; else constrained Delaunay triangles. None for an outline that crosses itself.
    """
    if len(loops) == 1 and are_convex(loops[0][None])[0]:
        return convex_fan(len(loops[0]))
    # Takes long to import, and few jars need it.
    from shapely import GEOSException, Polygon, constrained_delaunay_triangles, get_coordinates

    points = np.concatenate(loops)
    try:
        corners = get_coordinates(constrained_delaunay_triangles(Polygon(loops[0], loops[1:])))
    except GEOSException:
        return None
    row = {tuple(point): k for k, point in enumerate(points.tolist())}
    # The outline of a triangle ends where it begins.
    triangles = np.array([row[tuple(corner)] for corner in corners.tolist()]).reshape(-1, 4)[:, :3]
    twice = _twice(points, triangles)
    if abs(np.abs(twice).sum() / 2 - area) > 1e-9 * area:
        return None
    return np.where((twice < 0)[:, None], triangles[:, ::-1], triangles)
