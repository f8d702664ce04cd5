"""Joins the triangles of a file to a surface: equal points, gaps and slivers that only rounding has made."""

import numpy as np
import trimesh
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from millprint.mill.merge import HalfEdges, half_edges, triangle_widths

# Slivers are taken out again and again, as one may leave another; more rounds than this do not help.
ROUNDS = 20


def _joined(points: np.ndarray, triangles: np.ndarray, pairs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles with pairs of points (n, 2) made one, also chains; what has no third corner is dropped."""
    group = trimesh.graph.connected_component_labels(pairs, node_count=len(points))
    _, first = np.unique(group, return_index=True)
    triangles = group[triangles]
    a, b, c = triangles.T
    used, triangles = np.unique(triangles[(a != b) & (b != c) & (c != a)], return_inverse=True)
    return points[first[used]], triangles.reshape(-1, 3)


def weld(points: np.ndarray, triangles: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Merge points closer than a tolerance [m], also chains of such points.

    points (v, 3) [m]; triangles (t, 3), rows of points. Returns the merged points that a triangle uses, in ascending
    order, and the triangles as rows of them, without those that are left with fewer than three corners.
    """
    order = np.lexsort(points.T[::-1])
    is_new = np.append(True, (np.diff(points[order], axis=0) != 0).any(axis=1))
    number = np.empty(len(order), dtype=np.int64)
    number[order] = np.cumsum(is_new) - 1
    points, triangles = points[order[is_new]], number[triangles]
    return _joined(points, triangles, cKDTree(points).query_pairs(tolerance, output_type="ndarray"))


def close_gaps(points: np.ndarray, triangles: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Merge points on open edges that are closer than a tolerance [m]: one point that was rounded in two ways."""
    edges = half_edges(triangles)
    is_open = edges.twin < 0
    rim = np.unique(np.concatenate([edges.start[is_open], edges.end[is_open]]))
    if not len(rim):
        return points, triangles
    return _joined(points, triangles, rim[cKDTree(points[rim]).query_pairs(tolerance, output_type="ndarray")])


def _apart(pairs: np.ndarray) -> np.ndarray:
    """Which pairs (n, 2) have no number in common with an earlier one: all that can be changed at a time."""
    _, first = np.unique(pairs, return_index=True)
    is_first = np.isin(np.arange(pairs.size), first)
    return np.logical_and(is_first[::2], is_first[1::2])


def _contractible(edges: HalfEdges, ends: np.ndarray) -> np.ndarray:
    """Those of some sides (n, 2) whose ends may be one point: only two points are neighbours of both."""
    count = int(edges.start.max()) + 1
    beside = csr_array((np.ones(len(edges.start), dtype=np.int64), (edges.start, edges.end)), (count, count))
    return ends[(beside[ends[:, 0]] * beside[ends[:, 1]]).sum(axis=1) == 2]


def without_slivers(points: np.ndarray, triangles: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """A closed surface without triangles that are narrower than a tolerance [m], as far as it stays closed.

    A triangle with a side shorter than the tolerance loses that side. One with a corner in the middle of its longest
    side gives it to the triangle across that side, which is cut in two there.
    """
    for _ in range(ROUNDS):
        corners = points[triangles]
        narrow = np.flatnonzero(triangle_widths(corners) <= tolerance)
        if not len(narrow):
            break
        lengths = np.linalg.norm(np.roll(corners[narrow], -1, axis=1) - corners[narrow], axis=2)
        is_needle, rows = lengths.min(axis=1) <= tolerance, np.arange(len(narrow))
        edges = half_edges(triangles)
        short = (3 * narrow + lengths.argmin(axis=1))[is_needle]
        ends = _contractible(edges, np.column_stack([edges.start[short], edges.end[short]]))
        if len(ends):
            # No chains, as an outline whose sides are all short would be one point; in any order, or one at a time.
            ends = np.random.default_rng(0).permutation(ends)
            points, triangles = _joined(points, triangles, ends[_apart(ends)])
            continue
        longest = lengths.argmax(axis=1)
        twin = edges.twin[3 * narrow + longest]
        pairs = np.column_stack([narrow, twin // 3])[twin >= 0]
        # Each triangle in one exchange at a time.
        chosen = rows[twin >= 0][_apart(pairs)]
        across, side = twin[chosen] // 3, twin[chosen] % 3
        start, end, middle = (triangles[narrow[chosen], (longest[chosen] + k) % 3] for k in range(3))
        far = triangles[across, (side + 2) % 3]
        triangles = triangles.copy()
        triangles[narrow[chosen]] = np.column_stack([middle, start, far])
        triangles[across] = np.column_stack([end, middle, far])
        points, triangles = _joined(points, triangles, np.empty((0, 2), dtype=int))
    return points, triangles
