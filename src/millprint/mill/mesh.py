"""Surfaces from files of triangles: checked, also for cutting through themselves, and merged into flat facets.

Tolerances follow from the file's own rounding. A binary STL has 32-bit numbers: a coordinate of 35 mm is rounded by up
to 2 nm. What is written as text has as many digits as its writer gave it.
"""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
import trimesh

from millprint.config.errors import ConfigError
from millprint.config.mill import StlGeometry
from millprint.mill.mesh_file import close_gaps, coordinate_rounding, read_triangles, weld, without_slivers
from millprint.mill.outlines import FlatFacets, half_edges, merge_coplanar, triangle_widths, without_overlap
from millprint.mill.vectors import add_scaled, cross, dot, row, subtract
from millprint.run.kernel import array_maker, inlined


@inlined()
def _corner(points, triangles, t, k):
    return row(points, triangles[t, k % 3])


@inlined()
def _height(points, triangles, normal, t, point):
    """Height of a point over the plane of triangle t."""
    return dot(row(normal, t), subtract(point, _corner(points, triangles, t, 0)))


@inlined()
def _same_side(points, triangles, normal, a, b, tolerance):
    """Place of the corners of b: 1 all on one side of the plane of a, 0 all in it, -1 neither."""
    low, high = 1e300, -1e300
    for k in range(3):
        height = _height(points, triangles, normal, a, _corner(points, triangles, b, k))
        low, high = min(low, height), max(high, height)
    if low > tolerance or high < -tolerance:
        return 1
    return 0 if low >= -tolerance and high <= tolerance else -1


@inlined()
def _overlap_in_plane(points, triangles, a, b, normal, tolerance):
    """Whether two triangles of one plane share an area: no side of either separates them (separating axes)."""
    for side in range(6):
        t = a if side < 3 else b
        along = subtract(_corner(points, triangles, t, side + 1), _corner(points, triangles, t, side))
        axis = cross(along, normal)
        size = math.sqrt(dot(axis, axis))
        low_a, high_a, low_b, high_b = 1e300, -1e300, 1e300, -1e300
        for k in range(3):
            at = dot(axis, _corner(points, triangles, a, k)) / size
            low_a, high_a = min(low_a, at), max(high_a, at)
            at = dot(axis, _corner(points, triangles, b, k)) / size
            low_b, high_b = min(low_b, at), max(high_b, at)
        if min(high_a, high_b) - max(low_a, low_b) <= tolerance:
            return False
    return True


@inlined()
def _pierces(points, triangles, normal, width, start, end, t, tolerance):
    """Whether the segment from start to end passes from one side of triangle t to the other, through it.

    The corners of the triangle are known to the tolerance, and its plane the less the farther away, over its width.
    """
    first = _height(points, triangles, normal, t, start)
    last = _height(points, triangles, normal, t, end)
    if not ((first > tolerance and last < -tolerance) or (first < -tolerance and last > tolerance)):
        return False
    along = subtract(end, start)
    slope = abs(first - last) - tolerance / width[t] * math.sqrt(dot(along, along))
    if min(abs(first), abs(last)) * slope < tolerance * abs(first - last):
        return False
    place = add_scaled(start, first / (first - last), along)
    for k in range(3):
        corner = _corner(points, triangles, t, k)
        along = subtract(_corner(points, triangles, t, k + 1), corner)
        inward = cross(row(normal, t), along)
        # Sides count as part of the triangle: a segment through a side shared by two must not slip between them.
        if dot(inward, subtract(place, corner)) < -1e-3 * tolerance * math.sqrt(dot(along, along)):
            return False
    return True


@inlined()
def _shared_corners(triangles, a, b):
    shared = 0
    for i in range(3):
        for j in range(3):
            if triangles[a, i] == triangles[b, j]:
                shared += 1
    return shared


@inlined()
def _side_pierces(points, triangles, normal, width, a, b, tolerance):
    """Whether a side of a that has no corner in common with b passes through b."""
    for k in range(3):
        u, v = triangles[a, k], triangles[a, (k + 1) % 3]
        touches = False
        for j in range(3):
            touches = touches or triangles[b, j] == u or triangles[b, j] == v
        if not touches and _pierces(points, triangles, normal, width, row(points, u), row(points, v), b, tolerance):
            return True
    return False


@inlined()
def _meet(points, triangles, normal, width, a, b, tolerance):
    of_b = _same_side(points, triangles, normal, a, b, tolerance)
    of_a = _same_side(points, triangles, normal, b, a, tolerance)
    if of_a == 1 or of_b == 1:
        return False
    if of_a == 0 or of_b == 0:
        plane = row(normal, a) if of_b == 0 else row(normal, b)
        return _overlap_in_plane(points, triangles, a, b, plane, tolerance)
    # Two planes meet in one line; triangles with a side in common have it there and meet nowhere else.
    if _shared_corners(triangles, a, b) >= 2:
        return False
    return _side_pierces(points, triangles, normal, width, a, b, tolerance) or _side_pierces(
        points, triangles, normal, width, b, a, tolerance
    )


@array_maker()
def _first_meeting(points, triangles, normal, width, low, high, apart, tolerance):
    for a in range(len(triangles)):
        for b in range(a + 1, len(triangles)):
            if low[b, 0] > high[a, 0]:
                break
            if low[b, 1] > high[a, 1] or low[a, 1] > high[b, 1] or low[b, 2] > high[a, 2] or low[a, 2] > high[b, 2]:
                continue
            if (apart[a] < 0 or apart[a] != apart[b]) and _meet(points, triangles, normal, width, a, b, tolerance):
                return a, b
    return -1, -1


def self_intersection(
    points: np.ndarray, triangles: np.ndarray, tolerance: float, apart: np.ndarray | None = None
) -> tuple[int, int] | None:
    """Two triangles of a surface that cut through or cover each other, or None.

    points: (v, 3) [m]; triangles: (t, 3) rows of `points`, none without area; tolerance: heights up to this [m] count
    as lying in a plane, so that surfaces which merely touch are accepted; apart: (t,) two triangles of one number that
    is not negative are known not to meet. Broad phase: the bounding boxes, swept along the axis on which they are
    shortest.
    """
    boxes = np.ptp(points[triangles], axis=1)
    # The sweep runs along the first axis; a cyclic change of axes keeps every sense of turning.
    axis = int(np.argmin(boxes.mean(axis=0) / np.maximum(np.ptp(points, axis=0), np.finfo(float).tiny)))
    points = np.ascontiguousarray(np.roll(points, -axis, axis=1))
    order = np.argsort(points[triangles].min(axis=1)[:, 0], kind="stable")
    triangles = np.ascontiguousarray(triangles[order])
    apart = np.full(len(order), -1) if apart is None else apart[order]
    corners = points[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    low, high, width = corners.min(axis=1), corners.max(axis=1), triangle_widths(corners)
    a, b = _first_meeting(points, triangles, normal, width, low, high, apart, tolerance)
    return None if a < 0 else (int(order[a]), int(order[b]))


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
        points = numbers * geometry.metres
        _check_size(points, geometry.unit)
        rounding = coordinate_rounding(numbers) * geometry.metres
        equal = FLAT * max(float(np.ptp(points, axis=0).max()), float(np.abs(points).max()))
        # Each corner of a flat quadrilateral is off, so that the fourth is off the plane of three by the four together.
        facets = _checked(points, triangles, (equal, max(equal, 4 * rounding)))
    except ConfigError as error:
        raise ConfigError(f"path = {geometry.path!r}: {error}") from None
    return Surface(facets.loops, rounding)
