"""Bodies from files of triangles (STL, PLY, OBJ): read, checked, and merged into flat facets.

A binary STL holds 32-bit numbers: a coordinate of 35 mm is rounded by up to 2 nm, and facets that were flat are so to
that much. PLY and OBJ written as text, and an ASCII STL, hold as many digits as their writer gave them.
"""

from pathlib import Path

import numpy as np
import trimesh
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from millprint.config.geometry import StlGeometry
from millprint.errors import ConfigError
from millprint.mill.intersect import self_intersection
from millprint.mill.merge import FLAT, half_edges, merge_coplanar

METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "inch": 0.0254}
SMALLEST_M, LARGEST_M = 3e-3, 3.0
# Files of more triangles take minutes to check, and their curves more facets than a simulation can do with.
MOST_TRIANGLES = 500_000


def _mm(point: np.ndarray) -> str:
    return "(" + ", ".join(f"{value * 1e3:.4g}" for value in point) + ") mm"


def read_triangles(geometry: StlGeometry, place: str) -> tuple[np.ndarray, np.ndarray]:
    """Corners (v, 3) [m] and triangles (t, 3) as the file has them. Raises ConfigError, starting with `place`."""
    root = Path.cwd().resolve()
    path = (root / geometry.path).resolve()
    if not path.is_relative_to(root):
        raise ConfigError(f"{place}: leads out of the project, to {path}; copy the file into it")
    if not path.is_file():
        raise ConfigError(f"{place}: no such file")
    try:
        mesh = trimesh.load_mesh(path, process=False, skip_materials=True)
        points = np.array(mesh.vertices, dtype=float) * METRES[geometry.unit] * geometry.scale
        triangles = np.array(mesh.faces, dtype=np.int64)
    except Exception as error:  # whatever a reader of broken files may raise
        what = " ".join(str(error).split()) or type(error).__name__
        raise ConfigError(f"{place}: cannot be read as {path.suffix.lower()} ({what})") from None
    if triangles.ndim != 2 or len(triangles) < 4:
        raise ConfigError(f"{place}: {len(triangles)} triangles; a closed surface has at least 4")
    if len(triangles) > MOST_TRIANGLES:
        raise ConfigError(f"{place}: {len(triangles)} triangles, at most {MOST_TRIANGLES}: export it less finely")
    if not np.isfinite(points).all():
        raise ConfigError(f"{place}: has coordinates that are not finite numbers")
    return points, triangles


def _check_size(points: np.ndarray, geometry: StlGeometry, place: str) -> None:
    extent = np.ptp(points, axis=0)
    if extent.min() <= 0:
        raise ConfigError(f"{place}: all points lie in one plane; a closed surface encloses a volume")
    if not SMALLEST_M <= extent.max() <= LARGEST_M:
        raise ConfigError(
            f"{place}: is {extent.max():.3g} m large if its unit is {geometry.unit}; a mill has "
            f"{SMALLEST_M * 1e3:g} mm to {LARGEST_M:g} m: correct `unit`"
        )


def weld(points: np.ndarray, triangles: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Points closer than `tolerance` made one, and the triangles between them."""
    points, number = np.unique(points, axis=0, return_inverse=True)
    triangles = number.reshape(-1)[triangles]
    pairs = cKDTree(points).query_pairs(tolerance, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    _, group = connected_components(graph, directed=False)
    _, first = np.unique(group, return_index=True)
    used, triangles = np.unique(group[triangles], return_inverse=True)
    return points[first[used]], triangles.reshape(-1, 3)


def _check_triangles(points: np.ndarray, triangles: np.ndarray, tolerance: float, place: str) -> None:
    corners = points[triangles]
    sides = np.roll(corners, -1, axis=1) - corners
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    twice = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    flat = np.flatnonzero(twice <= tolerance * longest)
    if len(flat):
        raise ConfigError(
            f"{place}: {len(flat)} degenerate triangles without area, the first at {_mm(corners[flat[0], 0])}; "
            "remove them with the export's or a mesh program's repair"
        )


def _check_closed(points: np.ndarray, triangles: np.ndarray, place: str) -> None:
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    sides = np.sort(np.stack([start, end], axis=1), axis=1)
    sides, of_side, uses = np.unique(sides, axis=0, return_inverse=True, return_counts=True)

    def edge(k: np.intp) -> str:
        return f"the edge from {_mm(points[sides[k, 0]])} to {_mm(points[sides[k, 1]])}"

    for wrong, what, wanted in ((uses == 1, "open", "one triangle"), (uses > 2, "not manifold", "more than two")):
        if wrong.any():
            raise ConfigError(
                f"{place}: {what}: {edge(np.argmax(wrong))} belongs to {wanted} ({wrong.sum()} such edges)"
            )
    sense = np.bincount(of_side.reshape(-1), np.where(start < end, 1, -1))
    if sense.any():
        raise ConfigError(f"{place}: the triangles at {edge(np.argmax(sense != 0))} are not turned alike")
    twin = half_edges(triangles).twin
    # Corners of triangles that are side by side around a vertex; a vertex with two such fans is where two parts touch.
    side = np.arange(len(twin))
    fans = coo_array((np.ones(len(side)), (side, twin - twin % 3 + (twin + 1) % 3)), shape=(len(side), len(side)))
    count, fan = connected_components(fans, directed=False)
    if count > len(points):
        owner = np.zeros(count, dtype=np.int64)
        owner[fan] = start
        vertex = np.argmax(np.bincount(owner))
        raise ConfigError(f"{place}: not manifold: two parts of the surface touch in the point {_mm(points[vertex])}")


def _check_pieces(points: np.ndarray, triangles: np.ndarray, place: str) -> None:
    twin = half_edges(triangles).twin
    side = np.arange(len(twin))
    graph = coo_array((np.ones(len(side)), (side // 3, twin // 3)), shape=(len(triangles), len(triangles)))
    pieces, piece = connected_components(graph, directed=False)
    if pieces == 1:
        return
    boxes = [(points[triangles[piece == k]].min(axis=(0, 1)), points[triangles[piece == k]].max(axis=(0, 1)))
             for k in range(pieces)]  # fmt: skip
    nested = pieces == 2 and any(
        (boxes[a][0] < boxes[b][0]).all() and (boxes[a][1] > boxes[b][1]).all() for a, b in ((0, 1), (1, 0))
    )
    hint = "only the hollow is wanted, not the wall around it" if nested else "one closed surface is wanted"
    raise ConfigError(f"{place}: {pieces} separate pieces; {hint}; bodies inside the vessel are `inserts`")


def read_mesh(geometry: StlGeometry, place: str) -> tuple[np.ndarray, np.ndarray]:
    """Points (v, 3) [m] and triangles (t, 3) of a file's closed surface, normals out of the body that it encloses.

    place: file and key for the refusals. Raises ConfigError for a surface that is open, not manifold, degenerate,
    inside out, in several pieces, cuts through itself or is of a size that no mill has.
    """
    points, triangles = read_triangles(geometry, place)
    _check_size(points, geometry, place)
    # Rounding in a file grows with the coordinates, wherever the body lies.
    tolerance = FLAT * max(float(np.ptp(points, axis=0).max()), float(np.abs(points).max()))
    points, triangles = weld(points, triangles, tolerance)
    _check_triangles(points, triangles, tolerance, place)
    _check_closed(points, triangles, place)
    _check_pieces(points, triangles, place)
    corners = points[triangles] - points.mean(axis=0)
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    if volume <= 0:
        raise ConfigError(
            f"{place}: inside out: the normals point into the body that the surface encloses; they must point out of "
            "it (for a vessel: from the hollow into the wall); flip all normals"
        )
    meeting = self_intersection(points, triangles, tolerance)
    if meeting:
        first, second = (points[triangles[t]].mean(axis=0) for t in meeting)
        raise ConfigError(f"{place}: cuts through itself: the triangles at {_mm(first)} and {_mm(second)} intersect")
    return points, triangles


def mesh_facets(geometry: StlGeometry, place: str) -> list[list[np.ndarray]]:
    """Outlines [m] of the flat facets of a file's surface, counter-clockwise seen from outside the enclosed body."""
    place = f"{place}.path = {geometry.path!r}"
    points, triangles = read_mesh(geometry, place)
    size = max(float(np.ptp(points, axis=0).max()), float(np.abs(points).max()))
    return merge_coplanar(points, triangles, size)
