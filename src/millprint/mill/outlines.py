"""The outlines of flat facets as arrays: loops, normals, areas, and the volume that they enclose."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from millprint.config.errors import ConfigError
from millprint.mill.triangulate import triangulate_polygon


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

    @classmethod
    def from_loops(cls, outlines: Sequence[np.ndarray]) -> "Facet":
        """The facet of given outlines; the normal follows from their sense (Newell's rule)."""
        return facets_of([outlines])[0]

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
        return normals, np.vecdot(self.middles, normals)


def facets_of(outlines: Iterable[Sequence[np.ndarray]] | Outlines) -> list[Facet]:
    """The facets of given outlines, see Facet.from_loops."""
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
