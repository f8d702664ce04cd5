"""Surfaces from files of triangles (STL, PLY, OBJ): checked, and merged into flat facets.

Tolerances follow from the file's own rounding. A binary STL has 32-bit numbers: a coordinate of 35 mm is rounded by up
to 2 nm. What is written as text has as many digits as its writer gave it.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import trimesh

from millprint.config.errors import ConfigError
from millprint.config.geometry import StlGeometry
from millprint.mill.coordinate_rounding import coordinate_rounding
from millprint.mill.intersect import self_intersection
from millprint.mill.merge import FlatFacets, half_edges, merge_coplanar, triangle_widths, without_overlap
from millprint.mill.mesh_file import read_triangles
from millprint.mill.weld import close_gaps, weld, without_slivers

METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "inch": 0.0254}
SMALLEST_M, LARGEST_M = 3e-3, 3.0
# Files of more triangles take minutes to check, and their curves have more facets than a simulation can take.
MOST_TRIANGLES = 500_000
# Points are one, and triangles flat, to this share of the surface's size: sixteen times the rounding of 32-bit numbers.
FLAT = 1e-6


class Surface(NamedTuple):
    """The surface of a body from a file.

    facets: outlines (k, 3) [m] of each flat facet, counter-clockwise seen from outside the body; rounding: the largest
    error that the file's rounding gives a coordinate [m].
    """

    facets: list[list[np.ndarray]]
    rounding: float


def _mm(point: np.ndarray) -> str:
    return "(" + ", ".join(f"{value * 1e3:.4g}" for value in point) + ") mm"


def _read_file(geometry: StlGeometry) -> tuple[np.ndarray, np.ndarray]:
    """The points in the file's unit and the triangles, nothing merged."""
    root = Path.cwd().resolve()
    path = (root / geometry.path).resolve()
    if not path.is_relative_to(root):
        raise ConfigError(f"leads out of the project, to {path}; copy the file into it")
    if not path.is_file():
        raise ConfigError("no such file")
    points, triangles = read_triangles(path.read_bytes())
    if len(triangles) < 4:
        raise ConfigError(f"{len(triangles)} triangles; a closed surface has at least 4")
    if len(triangles) > MOST_TRIANGLES:
        raise ConfigError(f"{len(triangles)} triangles, at most {MOST_TRIANGLES}: export it less finely")
    if not np.isfinite(points).all():
        raise ConfigError("has coordinates that are not finite numbers")
    return points, triangles


def _check_size(points: np.ndarray, unit: str) -> None:
    smallest, *_, largest = sorted(np.ptp(points, axis=0))
    if smallest <= 0:
        raise ConfigError("all points lie in one plane; a closed surface encloses a volume")
    if not SMALLEST_M <= largest <= LARGEST_M:
        raise ConfigError(
            f"is {largest:.3g} m large if its unit is {unit}; a mill has {SMALLEST_M * 1e3:g} mm to {LARGEST_M:g} m: "
            "correct `unit`"
        )


def _check_widths(points: np.ndarray, triangles: np.ndarray, facet: np.ndarray, is_narrow: np.ndarray) -> None:
    """Raise ConfigError for narrow triangles that lie in no facet (t,) of others, and have no plane of their own."""
    narrow = np.flatnonzero(np.isin(facet, facet[~is_narrow], invert=True))
    if len(narrow):
        raise ConfigError(
            f"{len(narrow)} degenerate triangles without area, the first at {_mm(points[triangles[narrow[0], 0]])}; "
            "remove them with the export's or a mesh program's repair"
        )


ONE_BODY = "give one closed surface: only the hollow, without its lid"
INSERTS = "a body in the hollow gets a file of its own, one of `inserts` (without `motion` it moves with the vessel)"
# A piece in or next to another with a larger share of its volume is a hollow, and not a baffle or a lid [-].
LARGE = 0.25


def _components(edges: np.ndarray, count: int) -> np.ndarray:
    """The number of the connected component of each of `count` nodes, from edges (n, 2)."""
    return trimesh.graph.connected_component_labels(edges, node_count=count)


def _check_closed(points: np.ndarray, triangles: np.ndarray) -> None:
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    low, high = np.minimum(start, end), np.maximum(start, end)
    _, first, of_side, uses = np.unique(
        low * len(points) + high, return_index=True, return_inverse=True, return_counts=True
    )

    def edge(is_wrong: np.ndarray) -> str:
        side = first[np.argmax(is_wrong)]
        return f"the edge from {_mm(points[low[side]])} to {_mm(points[high[side]])}"

    if (is_open := uses == 1).any():
        raise ConfigError(f"open: {edge(is_open)} belongs to one triangle ({is_open.sum()} such edges)")
    if (crowded := uses > 2).any():
        sides = np.argsort(of_side, kind="stable")
        begins = np.searchsorted(of_side[sides], np.flatnonzero(uses == 2))
        is_one = _components(np.column_stack([sides[begins], sides[begins + 1]]) // 3, len(triangles)).max() == 0
        what = "" if is_one else f": there bodies touch; {ONE_BODY}"
        raise ConfigError(
            f"not manifold: {edge(crowded)} belongs to more than two triangles ({crowded.sum()} such edges){what}"
        )
    sense = np.bincount(of_side, np.where(start < end, 1, -1))
    if sense.any():
        raise ConfigError(f"the triangles at {edge(sense != 0)} are not oriented alike")
    _check_pieces(points, triangles)
    twin = half_edges(triangles).twin
    # Corners of triangles that are side by side around a vertex; a vertex with two such fans is where two parts touch.
    fan = _components(np.column_stack([np.arange(len(twin)), twin - twin % 3 + (twin + 1) % 3]), len(twin))
    fans_of_vertex = np.bincount(start[np.unique(fan, return_index=True)[1]])
    if fans_of_vertex.max() > 1:
        place = _mm(points[np.argmax(fans_of_vertex)])
        raise ConfigError(f"not manifold: two parts of the surface touch in the point {place}")


def _volumes(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Six times the signed volume (t,) [m3] between each triangle and the middle of the surface."""
    a, b, c = (points[triangles] - points.mean(axis=0)).transpose(1, 0, 2)
    return (a * np.cross(b, c)).sum(axis=1)


def _check_pieces(points: np.ndarray, triangles: np.ndarray) -> None:
    twin = half_edges(triangles).twin
    piece = _components(np.column_stack([np.arange(len(twin)), twin]) // 3, len(triangles))
    volumes = np.bincount(piece, _volumes(points, triangles)) / 6
    if len(volumes) == 1:
        return
    order = np.argsort(piece, kind="stable")
    corners, begins = points[triangles[order]], np.searchsorted(piece[order], np.arange(len(volumes)))
    low = np.minimum.reduceat(corners.min(axis=1), begins)
    high = np.maximum.reduceat(corners.max(axis=1), begins)
    outer = int(np.argmax((high - low).prod(axis=1)))
    is_inner = (low > low[outer]).all(axis=1) & (high < high[outer]).all(axis=1)
    sizes = ", ".join(f"{volume * 1e6:.4g}" for volume in np.abs(volumes[:5])) + ", ..." * (len(volumes) > 5)
    pieces = f"{len(volumes)} separate pieces of {sizes} mL"
    inner, (second, first) = volumes[is_inner], np.sort(np.abs(volumes))[-2:]
    if len(inner) and ((inner * volumes[outer] < 0).any() or second > LARGE * first):
        raise ConfigError(
            f"{pieces}: a vessel that is drawn as its own wall, with an outer and an inner surface; give only the "
            f"hollow ({np.abs(inner).sum() * 1e6:.4g} mL, its normals into the wall), not the wall around it"
        )
    if len(inner):
        raise ConfigError(f"{pieces}, one in the other: {INSERTS}")
    if second > LARGE * first:
        raise ConfigError(f"{pieces}: two hollows are two mills; give one of them")
    raise ConfigError(f"{pieces}: a lid or another body next to the hollow; {ONE_BODY}; {INSERTS}")


def _checked(points: np.ndarray, triangles: np.ndarray, tolerances: tuple[float, float]) -> FlatFacets:
    """The facets of a surface that is one closed body; tolerances: of equal points, and of what is flat [m]."""
    equal, flat = tolerances
    points, triangles = weld(points, triangles, equal)
    points, triangles = close_gaps(points, triangles, flat)
    points, triangles = without_slivers(points, triangles, flat)
    _check_closed(points, triangles)
    if _volumes(points, triangles).sum() <= 0:
        raise ConfigError(
            "inside out: the normals point into the body that the surface encloses; they must point out of it (for a "
            "vessel: from the hollow into the wall); flip all normals"
        )
    facets = merge_coplanar(points, triangles, flat)
    is_narrow = triangle_widths(points[triangles]) <= flat
    _check_widths(points, triangles, facets.of_triangle, is_narrow)
    wide = triangles[~is_narrow]
    meeting = self_intersection(points, wide, flat, without_overlap(facets)[~is_narrow])
    if meeting:
        first, second = points[wide[list(meeting)]].mean(axis=1)
        raise ConfigError(
            f"cuts through itself: the triangles at {_mm(first)} and {_mm(second)} intersect; a profile or an outline "
            "crosses itself, bodies overlap, or a face of more than three corners is bent"
        )
    return facets


def read_surface(geometry: StlGeometry) -> Surface:
    """The surface of a body from a file.

    Raises ConfigError, beginning with the key `path`, for a file that is cut or of another kind, and for a surface that
    is open, not manifold, inside out, in several pieces, cuts through itself or is of a size that no mill has.
    """
    try:
        numbers, triangles = _read_file(geometry)
        metres = METRES[geometry.unit] * geometry.scale
        points = numbers * metres
        _check_size(points, geometry.unit)
        rounding = coordinate_rounding(numbers) * metres
        equal = FLAT * max(float(np.ptp(points, axis=0).max()), float(np.abs(points).max()))
        # Each corner of a flat quadrilateral is off, so that the fourth is off the plane of three by the four together.
        facets = _checked(points, triangles, (equal, max(equal, 4 * rounding)))
    except ConfigError as error:
        raise ConfigError(f"path = {geometry.path!r}: {error}") from None
    return Surface(facets.loops, rounding)
