"""Flat facets with outlines: merged from triangles, as arrays, and cut into triangles again."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import shapely

from millprint.config.errors import ConfigError
from millprint.run.kernel import array_maker

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
def _plane_through(corners: np.ndarray, members: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, float]:
    """Unit normal and offset of the plane nearest to the corners of some triangles, by least squares.

    normal: about that of the plane. Where corners are on a line, or few, it stays as it is.
    """
    normal = normal / np.sqrt((normal * normal).sum())
    first = np.zeros(3)
    first[np.argmin(np.abs(normal))] = 1.0
    first = first - (first * normal).sum() * normal
    first /= np.sqrt((first * first).sum())
    second = np.cross(normal, first)
    middle, count = np.zeros(3), 3 * members.size
    for member in members:
        for k in range(3):
            middle += corners[member, k] / count
    # Heights h over the plane are a x + b y there.
    xx, xy, yy, xh, yh = 0.0, 0.0, 0.0, 0.0, 0.0
    for member in members:
        for k in range(3):
            away = corners[member, k] - middle
            x, y, h = (away * first).sum(), (away * second).sum(), (away * normal).sum()
            xx, xy, yy, xh, yh = xx + x * x, xy + x * y, yy + y * y, xh + x * h, yh + y * h
    spread = xx * yy - xy * xy
    if members.size > 1 and spread > 1e-9 * (xx + yy) ** 2:
        normal = normal - ((yy * xh - xy * yh) * first + (xx * yh - xy * xh) * second) / spread
        normal /= np.sqrt((normal * normal).sum())
    return normal, (middle * normal).sum()


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
        # Then without those farther off than rounding puts corners, as the next step of a rounding is from a strip.
        near = tolerance
        for _ in range(ROUNDS):
            before = found
            normal, offset = _plane_through(corners, members[:found], normal)
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
                    if height <= near and (area_vector[other] * normal).sum() >= least_facing[other]:
                        members[found] = other
                        found += 1
                at += 1
            if found == before and near < tolerance:
                break
            if found == before:
                near = tolerance / 2
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
    """Which places (n,) of loops have a vertex in the middle of a straight side between the same two facets.

    On a fine circle each vertex may be near the chord of its neighbours, and far from that of those that are left: the
    farthest ones stay (Ramer 1972, Douglas and Peucker 1973).
    """
    rows = np.arange(len(loops))
    lasts = np.append(begins[1:], len(loops)) - 1
    before, after = rows - 1, rows + 1
    before[begins], after[lasts] = lasts, begins
    chord, away = points[loops[after]] - points[loops[before]], points[loops] - points[loops[before]]
    length, along = np.linalg.norm(chord, axis=1), (away * chord).sum(axis=1)
    is_between = (along > 0) & (along < length**2) & (np.bincount(loops)[loops] == 2)
    straight = is_between & (np.linalg.norm(np.cross(chord, away), axis=1) <= tolerance * length)
    straight = np.isin(loops, loops[straight])
    # Of a loop without a corner, the vertex of the lowest number: both of its facets know it.
    straight[np.isin(loops, np.minimum.reduceat(loops, begins)[np.logical_and.reduceat(straight, begins)])] = False
    while len(inner := np.flatnonzero(straight)):
        before, after = _kept_around(straight, begins, lasts)
        chord = points[loops[after[inner]]] - points[loops[before[inner]]]
        away = points[loops[inner]] - points[loops[before[inner]]]
        share = np.vecdot(away, chord) / np.maximum(np.vecdot(chord, chord), np.finfo(float).tiny)
        off = np.linalg.norm(away - np.clip(share, 0, 1)[:, None] * chord, axis=1)
        order = np.lexsort((off, before[inner]))
        farthest = order[np.append(np.diff(before[inner][order]) != 0, True)]
        farthest = farthest[off[farthest] > tolerance]
        if not len(farthest):
            break
        straight[np.isin(loops, loops[inner[farthest]])] = False
    return straight


def _kept_around(straight: np.ndarray, begins: np.ndarray, lasts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For each place (n,) of loops the last one before it, and the first one after it, that is not straight."""
    rows, end = np.arange(len(straight)), len(straight)
    of_loop = np.searchsorted(begins, rows, side="right") - 1
    low, high = np.where(straight, -1, rows), np.where(straight, end, rows)
    before, after = np.maximum.accumulate(low), np.minimum.accumulate(high[::-1])[::-1]
    before = np.where(before < begins[of_loop], np.maximum.reduceat(low, begins)[of_loop], before)
    after = np.where(after > lasts[of_loop], np.minimum.reduceat(high, begins)[of_loop], after)
    return before, after


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


def cross(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """The cross product of vectors (3,) or rows (n, 3), numpy's own to the last bit.

    Without numpy's care for other axes, which takes longer than the product: a box of mills has thousands of edges.
    """
    (ax, ay, az), (bx, by, bz) = first.T, second.T
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]).T.copy()


def ahead(loop: np.ndarray) -> np.ndarray:
    """An outline (k, ...) that begins one row later: np.roll(loop, -1, axis=0) in a fraction of the time."""
    return np.concatenate((loop[1:], loop[:1]))


@dataclass(frozen=True)
class Facet:
    """A flat piece of wall: `normal . x = offset`, with the unit normal pointing into the vessel.

    loops: outlines as (k, 3) vertices [m], the first counter-clockwise about `normal`, further ones (holes) clockwise.
    """

    normal: np.ndarray
    offset: float
    loops: tuple[np.ndarray, ...]

    @cached_property
    def area(self) -> float:
        """Area [m2], holes left out."""
        return float(Outlines.of([self.loops]).areas[0] @ self.normal)

    @cached_property
    def axes(self) -> tuple[np.ndarray, np.ndarray]:
        """Two unit vectors in the plane that make a right-handed triad with the normal."""
        return tuple(plane_axes(self.normal[None])[0])


def plane_axes(normals: np.ndarray) -> np.ndarray:
    """Facet.axes (n, 2, 3) of normals (n, 3)."""
    first = cross(np.eye(3)[np.argmin(np.abs(normals), axis=1)], normals)
    first /= lengths(first)
    return np.stack([first, cross(normals, first)], axis=1)


def lengths(vectors: np.ndarray) -> np.ndarray:
    """The lengths (..., 1) of vectors (..., 3), the same to the last bit as numpy gives one by one."""
    return np.sqrt(np.vecdot(vectors, vectors))[..., None]


class Ragged:
    """Rows of one array in groups of different numbers, one after the other: the vertices of outlines, or of facets."""

    def __init__(self, counts: Iterable[int]) -> None:
        self.counts = np.fromiter(counts, dtype=np.int64)
        self.first = np.cumsum(self.counts) - self.counts

    @cached_property
    def owner(self) -> np.ndarray:
        """The group (n,) of each row."""
        return np.repeat(np.arange(len(self.counts)), self.counts)

    @cached_property
    def ahead(self) -> np.ndarray:
        """For each row (n,) the one that follows in its group, around its end."""
        following = np.arange(1, len(self.owner) + 1)
        following[self.first + self.counts - 1] = self.first
        return following

    def stacks(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Groups (m,) of one number k of rows, and their rows (m, k)."""
        for count in np.unique(self.counts).tolist():
            groups = np.flatnonzero(self.counts == count)
            yield groups, self.first[groups, None] + np.arange(count)

    def rows(self, groups: np.ndarray) -> np.ndarray:
        """The rows of some groups, one after the other."""
        counts = self.counts[groups]
        return np.arange(counts.sum()) + np.repeat(self.first[groups] - np.cumsum(counts) + counts, counts)

    def sums(self, values: np.ndarray) -> np.ndarray:
        """Sums (g, ...) of values (n, ...) over each group, the same to the last bit as numpy gives one by one."""
        total = np.empty((len(self.counts), *values.shape[1:]))
        for groups, rows in self.stacks():
            total[groups] = values[rows].sum(axis=1)
        return total

    def split(self, values: np.ndarray) -> list[np.ndarray]:
        """The values (n, ...) of each group."""
        ends = (self.first + self.counts).tolist()
        return [values[begin:end] for begin, end in zip(self.first.tolist(), ends, strict=True)]


# Where vertices of a facet are farther off its plane than this, a file has rounded them [m].
FLAT = 1e-9


class Outlines:
    """The outlines of many facets as flat arrays.

    points (n, 3) [m]; loops: their rows in outlines; facets: outlines in facets; corners: their rows in facets.
    """

    def __init__(self, points: np.ndarray, loops: Ragged, facets: Ragged) -> None:
        self.points, self.loops, self.facets = points, loops, facets
        self.corners = Ragged(np.add.reduceat(loops.counts, facets.first))

    @classmethod
    def of(cls, outlines: Iterable[Sequence[np.ndarray]]) -> "Outlines":
        """The outlines (k, 3) of each facet."""
        outlines = list(outlines)
        loops = [loop for facet in outlines for loop in facet]
        points = np.concatenate(loops, dtype=float)
        return cls(points, Ragged(map(len, loops)), Ragged(map(len, outlines)))

    @cached_property
    def areas(self) -> np.ndarray:
        """The area vectors (f, 3) [m2], along the normals of the outlines' sense."""
        return self.facets.sums(self.loops.sums(cross(self.points, self.points[self.loops.ahead]))) / 2

    @cached_property
    def middles(self) -> np.ndarray:
        """The means (f, 3) of the facets' vertices [m]."""
        return self.corners.sums(self.points) / self.corners.counts[:, None]

    def lists(self, values: np.ndarray) -> list[list[np.ndarray]]:
        """Values (n, ...) along each outline of each facet."""
        loops = self.loops.split(values)
        return [loops[k : k + n] for k, n in zip(self.facets.first.tolist(), self.facets.counts.tolist(), strict=True)]

    def on_lattice(self, pitch: float) -> "Outlines":
        """The outlines with vertices on a lattice of a pitch [m], each from its smallest vertex on, holes in order."""
        # The sum turns a negative zero into a positive one.
        points = np.round(self.points / pitch) * pitch + 0.0
        begins = np.lexsort((*points.T[::-1], self.loops.owner))[self.loops.first]
        within = np.arange(len(points)) - self.loops.first[self.loops.owner]
        shift = (begins - self.loops.first)[self.loops.owner]
        points = points[self.loops.first[self.loops.owner] + (within + shift) % self.loops.counts[self.loops.owner]]
        is_hole = np.arange(len(self.loops.counts)) != self.facets.first[self.facets.owner]
        starts = points[self.loops.first]
        return self._taken(points, np.lexsort((*starts.T[::-1] * is_hole, is_hole, self.facets.owner)), self.facets)

    def _taken(self, points: np.ndarray, loops: np.ndarray, facets: Ragged) -> "Outlines":
        return Outlines(points[self.loops.rows(loops)], Ragged(self.loops.counts[loops]), facets)

    def taken(self, facets: np.ndarray) -> "Outlines":
        """The outlines of some facets."""
        return self._taken(self.points, self.facets.rows(facets), Ragged(self.facets.counts[facets]))

    def planes(self) -> tuple[np.ndarray, np.ndarray]:
        """Unit normals (f, 3) and offsets (f,) [m] of the facets."""
        normals = self.areas / lengths(self.areas)
        away = self.points - self.middles[self.corners.owner]
        off = np.maximum.reduceat(np.abs(np.vecdot(away, normals[self.corners.owner])), self.corners.first)
        # By the area of a narrow facet, rounding makes its plane lean: then the nearest plane, by least squares.
        for k in np.flatnonzero((off > FLAT) & (self.corners.counts > 3)).tolist():
            own = away[self.corners.first[k] : self.corners.first[k] + self.corners.counts[k]]
            nearest = np.linalg.svd(own, full_matrices=False)[2][-1]
            if np.abs(own @ nearest).max() < off[k]:
                normals[k] = nearest * np.sign(nearest @ normals[k])
        return normals, np.vecdot(self.middles, normals)


def facets_of(outlines: Iterable[Sequence[np.ndarray]] | Outlines) -> list[Facet]:
    """The facets of given outlines; the normal of each follows from their sense (Newell's rule)."""
    own = outlines if isinstance(outlines, Outlines) else Outlines.of(outlines)
    normals, offsets = own.planes()
    return list(map(Facet, normals, offsets.tolist(), map(tuple, own.lists(own.points))))


def enclosed_volume(outlines: Iterable[Sequence[np.ndarray]] | Outlines) -> float:
    """Volume [m3] within closed flat facets, each given by its outlines, whose normals point into it.

    By the divergence theorem, of x / 3: each side of an outline makes a tetrahedron of itself, the outline's first
    vertex and the origin, of volume first . (start x end) / 6.
    """
    own = outlines if isinstance(outlines, Outlines) else Outlines.of(outlines)
    firsts = own.points[own.loops.first[own.loops.owner]]
    return -float(np.sum(firsts * cross(own.points, own.points[own.loops.ahead]))) / 6


def triangulate_facet(facet: Facet) -> np.ndarray:
    """Triangles (t, 3) as rows of a facet's vertices, its loops one after the other, counter-clockwise inward.

    Raises ConfigError for an outline that crosses itself.
    """
    axes = np.array(facet.axes).T
    triangles = triangulate_polygon([loop @ axes for loop in facet.loops], facet.area)
    if triangles is None:
        where = f"the facet at {facet.loops[0][0] * 1e3} mm"
        raise ConfigError(f"{where} has an outline that cannot be cut into triangles: it crosses itself")
    return triangles
