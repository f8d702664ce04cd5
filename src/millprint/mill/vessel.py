"""A vessel: flat facets in the body frame, with the edges and corners that balls can touch."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np

from millprint.config.errors import ConfigError
from millprint.config.geometry import GeometrySection
from millprint.config.mill import MillConfig
from millprint.mill.curved_surfaces import Curve
from millprint.mill.shapes import shape_kind
from millprint.mill.triangulate import triangulate_polygon

# Vertices closer than this fraction of the vessel's size are one vertex.
WELD = 1e-7
# Vertices lie on a lattice of about this fraction of the vessel's size, so that a shape is the same to the last bit
# wherever it comes from, and with it the motion in it.
LATTICE = 2.0**-40
# A facet is a piece of a cylinder or a torus if its vertices are this close to it, as a share of the vessel's size, and
# its normal is within this angle [rad] of that of the surface behind its middle.
ON_CURVE = 5e-6
CURVE_ANGLE = 0.6
# An edge that turns by more juts into the vessel [rad].
CONVEX = 1e-9
# With more facets, the walls take days of a simulation.
MOST_FACETS = 20_000


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
        loops = tuple(np.asarray(outline, dtype=float) for outline in outlines)
        area = sum(cross(loop, ahead(loop)).sum(axis=0) for loop in loops) / 2
        normal = area / np.linalg.norm(area)
        return cls(normal, float(np.concatenate(loops).mean(axis=0) @ normal), loops)

    @cached_property
    def area(self) -> float:
        """Area [m2], holes left out."""
        return float(sum(cross(loop, ahead(loop)).sum(axis=0) for loop in self.loops) @ self.normal / 2)

    @cached_property
    def axes(self) -> tuple[np.ndarray, np.ndarray]:
        """Two unit vectors in the plane that make a right-handed triad with the normal."""
        helper = np.eye(3)[np.argmin(np.abs(self.normal))]
        first = cross(helper, self.normal)
        first /= np.linalg.norm(first)
        return first, cross(self.normal, first)


def enclosed_volume(outlines: Iterable[Sequence[np.ndarray]]) -> float:
    """Volume [m3] within closed flat facets, each given by its outlines, whose normals point into it.

    By the divergence theorem, of x / 3: each side of an outline makes a tetrahedron of itself, the outline's first
    vertex and the origin, of volume first . (start x end) / 6.
    """
    loops = [loop for facet in outlines for loop in facet]
    starts = np.concatenate(loops)
    ends = np.concatenate([ahead(loop) for loop in loops])
    firsts = np.repeat([loop[0] for loop in loops], [len(loop) for loop in loops], axis=0)
    return -float(np.sum(firsts * cross(starts, ends))) / 6


def _canonical(facet: Facet, pitch: float) -> Facet:
    """The facet with its vertices on a lattice of a pitch [m], each outline beginning with its smallest vertex."""
    loops = []
    for loop in facet.loops:
        # The sum turns a negative zero into a positive one.
        loop = np.round(loop / pitch) * pitch + 0.0
        rows = loop.tolist()
        first = rows.index(min(rows))
        loops.append(np.concatenate((loop[first:], loop[:first])))
    return Facet.from_loops([loops[0], *sorted(loops[1:], key=lambda loop: tuple(loop[0]))])


def _parts(facet: Facet) -> tuple[np.ndarray, np.ndarray]:
    """Middles (n, 3) [m] of the sides of the triangles from a facet's vertices to the first one, and weights [m2].

    A triangle on the other side of the outline has a negative weight.
    """
    middles, weights = [], []
    for loop in facet.loops:
        first, starts, ends = loop[0], loop[1:-1], loop[2:]
        area = cross(starts - first, ends - first) @ facet.normal / 2
        middles += [(first + starts) / 2, (starts + ends) / 2, (ends + first) / 2]
        weights += [area / 3] * 3
    return np.concatenate(middles), np.concatenate(weights)


@dataclass(frozen=True)
class Edge:
    """The line where two facets meet, from `start` to `end` [m].

    ends: numbers of its vertices. inward: unit vectors in the plane of each facet, perpendicular to the edge, pointing
    into the facet. turn: angle between the facets' normals [rad], positive where the wall juts into the vessel (a
    convex edge, which a ball can touch), negative in a seam.
    """

    start: np.ndarray
    end: np.ndarray
    ends: tuple[int, int]
    facets: tuple[int, int]
    inward: tuple[np.ndarray, np.ndarray]
    turn: float


class Vessel:
    """A closed vessel in the body frame; the normals of its walls point inward, to where the balls are.

    Facets draw it. Those on an exact surface (`curves`, mill.curved_surfaces) are only a picture of it; the others are
    flat walls, whose borders may be arcs (mill.borders). A solid body inside a vessel is the same with `solid`: its
    normals point out of it, and its volume is negative.

    smooth_axis: "x", "y" or "z", the axis whose end facets have no friction, or None. on_curves: for each of `facets`
    the one of `curves` that it draws, -1 for a flat wall; left out, that is found. report: what was nearly recognised,
    in words. facet_curves (f,): the same for the vessel's own facets, which are sorted; placed_from (f,): the numbers
    of these among the given ones. Raises ConfigError where the facets do not close: every edge must belong to two
    facets, in opposite senses.
    """

    def __init__(
        self,
        facets: Sequence[Facet],
        name: str = "vessel",
        solid: bool = False,
        smooth_axis: str | None = None,
        curves: Sequence[Curve] = (),
        on_curves: np.ndarray | None = None,
        report: tuple[str, ...] = (),
    ) -> None:
        self.name = name
        self.solid = solid
        self.smooth_axis = smooth_axis
        self.report = report
        self.size = float(np.ptp(np.concatenate([loop for f in facets for loop in f.loops]), axis=0).max())
        # A power of two, so that a shape and its double are the same on their lattices.
        pitch = LATTICE * 2.0 ** math.floor(math.log2(self.size))
        placed = [_canonical(facet, pitch) for facet in facets]
        order = sorted(range(len(placed)), key=lambda k: (*placed[k].loops[0][0], *placed[k].normal))
        self.facets = tuple(placed[k] for k in order)
        self.placed_from = np.array(order)
        self.vertices, self.loops, rank = self._number_vertices()
        self.edges = self._find_edges(rank)
        on_curve = self._find_pieces(curves) if on_curves is None else np.asarray(on_curves)[order]
        # Only those that have facets: a sphere's ends leave no mantle between them.
        used = sorted(set(on_curve.tolist()) - {-1})
        self.curves = tuple(curves[number] for number in used)
        self.facet_curves = np.array([used.index(number) if number >= 0 else -1 for number in on_curve.tolist()])
        if (self.volume_m3 >= 0) if solid else (self.volume_m3 <= 0):
            raise ConfigError(f"{name}: the facets are inside out (volume {self.volume_m3 * 1e6:.3g} mL)")

    def _number_vertices(self) -> tuple[np.ndarray, list[list[np.ndarray]], list[int]]:
        """Every vertex (v, 3) [m], once; for each facet the vertices' numbers along its outlines; and each one's rank.

        Vertices are ranked by their places, as they would be in any order of the facets.
        """
        points = np.concatenate([loop for facet in self.facets for loop in facet.loops])
        lattice = np.round(points / (WELD * self.size)).astype(np.int64)
        _, first, rank = np.unique(lattice, axis=0, return_index=True, return_inverse=True)
        by_number = np.argsort(first)
        number = np.argsort(by_number)
        counts = [len(loop) for facet in self.facets for loop in facet.loops]
        along = iter(np.split(number[rank.reshape(-1)], np.cumsum(counts)[:-1]))
        numbers = [[next(along) for _ in facet.loops] for facet in self.facets]
        return points[first[by_number]], numbers, by_number.tolist()

    def _find_edges(self, rank: list[int]) -> tuple[Edge, ...]:
        sides: dict[tuple[int, int], tuple[int, np.ndarray, np.ndarray]] = {}
        for index, facet in enumerate(self.facets):
            for loop, numbers in zip(facet.loops, self.loops[index], strict=True):
                ends = ahead(loop)
                pairs = zip(numbers.tolist(), ahead(numbers).tolist(), strict=True)
                for start, end, side in zip(loop, ends, pairs, strict=True):
                    if side in sides:
                        raise ConfigError(
                            f"{self.name}: two facets run along the edge at {start * 1e3} mm in one sense"
                        )
                    sides[side] = (index, start, end)
        found = []
        for side, (first, start, end) in sides.items():
            if side[::-1] not in sides:
                raise ConfigError(f"{self.name}: the vessel is open at the edge from {start * 1e3} to {end * 1e3} mm")
            if rank[side[0]] < rank[side[1]]:
                found.append((side, first, sides[side[::-1]][0], start, end))
        return self._edges(found)

    def _edges(self, found: list[tuple[tuple[int, int], int, int, np.ndarray, np.ndarray]]) -> tuple[Edge, ...]:
        """Edges of their vertices, facets and ends."""
        ends, first, second, start, end = zip(*found, strict=True)
        starts, stops = np.array(start), np.array(end)
        normals = np.array([facet.normal for facet in self.facets])
        of_first, of_second = normals[list(first)], normals[list(second)]
        along = stops - starts
        along /= np.linalg.norm(along, axis=1)[:, None]
        inward = cross(of_first, along), cross(of_second, -along)
        sine, cosine = -(inward[0] * of_second).sum(axis=1), (of_first * of_second).sum(axis=1)
        turns = np.arctan2(sine, cosine).tolist()
        pairs = zip(first, second, strict=True), zip(*inward, strict=True)
        return tuple(map(Edge, start, end, ends, *pairs, turns))

    @cached_property
    def is_smooth(self) -> np.ndarray:
        """Which facets (f,) have no friction: those across `smooth_axis`."""
        if self.smooth_axis is None:
            return np.zeros(len(self.facets), dtype=bool)
        along = "xyz".index(self.smooth_axis)
        return np.array([abs(facet.normal[along]) > 1 - 1e-9 for facet in self.facets])

    def _find_pieces(self, curves: Sequence[Curve]) -> np.ndarray:
        """For each facet (f,) the curve that it draws, -1 for a flat wall."""
        found = np.full(len(self.facets), -1)
        for number, curve in enumerate(curves):
            for index, facet in enumerate(self.facets):
                points = np.concatenate(facet.loops)
                distance, direction, past = curve.touch(np.vstack([points, points.mean(axis=0)]))
                on_it = max(np.abs(distance[:-1]).max(), past.max()) <= ON_CURVE * self.size
                # A flat wall that joins a curve smoothly lies on its tangents: it is flat all the same.
                is_bent = abs(distance[-1]) > 1e-9 * self.size
                if on_it and is_bent and direction[-1] @ facet.normal > np.cos(CURVE_ANGLE):
                    found[index] = number
        return found

    @cached_property
    def volume_m3(self) -> float:
        """Inner volume [m3]; negative for a solid, which takes it from the balls.

        What lies between a facet and its curve is integrated with the middles of the sides of triangles, which is exact
        for a parabola.
        """
        volume = enclosed_volume(facet.loops for facet in self.facets)
        for index in np.flatnonzero(self.facet_curves >= 0):
            middles, weights = _parts(self.facets[index])
            volume += float(weights @ self.curves[self.facet_curves[index]].touch(middles)[0])
        return volume

    @cached_property
    def edge_at(self) -> dict[frozenset[int], int]:
        """The number of the edge between two vertices."""
        return {frozenset(edge.ends): number for number, edge in enumerate(self.edges)}

    @cached_property
    def sagitta(self) -> float:
        """How far the exact walls are from the drawing at most [m]."""
        found = 0.0
        for index in np.flatnonzero(self.facet_curves >= 0):
            middle = np.concatenate(self.facets[index].loops).mean(axis=0)
            found = max(found, abs(float(self.curves[self.facet_curves[index]].touch(middle[None])[0][0])))
        return found

    @cached_property
    def is_convex(self) -> bool:
        """Whether no wall juts into the vessel."""
        return all(edge.turn <= CONVEX for edge in self.edges)

    @cached_property
    def bounds(self) -> np.ndarray:
        """Lower and upper corner (2, 3) of the bounding box [m]."""
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    def triangles(self) -> tuple[np.ndarray, np.ndarray]:
        """Vertices (v, 3) [m], each once, and triangles (t, 3) of the walls as they are drawn, normals inward.

        Raises ConfigError for an outline that crosses itself.
        """
        triangles = [
            np.concatenate(numbers)[triangulate_facet(facet)]
            for facet, numbers in zip(self.facets, self.loops, strict=True)
        ]
        return self.vertices, np.concatenate(triangles)


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


def shape_curves(geometry: GeometrySection, solid: bool) -> list[Curve]:
    """The cylinders and tori of which the facets of a shape are pieces; none where its facets are the wall itself."""
    shape = shape_kind(geometry.kind)
    curves = [] if geometry.faceted else shape.curves(geometry)
    return [curve.turned_out for curve in curves] if shape.from_inside == solid else curves


def shape_facets(geometry: GeometrySection, place: str, solid: bool) -> list[Facet]:
    """The facets of a shape, see `drawn_shape`."""
    return drawn_shape(geometry, place, solid)[0]


def drawn_shape(geometry: GeometrySection, place: str, solid: bool) -> tuple[list[Facet], float]:
    """The facets of a shape, their normals towards the balls: into a hollow, or out of a solid.

    Further: the rounding of their vertices in a file [m].

    place: the YAML file and key, for refusals. Raises ValueError for a kind that is not in the registry of
    `mill.shapes`, and ConfigError for a file of triangles that is refused or for too many facets.
    """
    shape = shape_kind(geometry.kind)
    try:
        outlines, rounding = shape.facets(geometry) if shape.is_mesh else (shape.facets(geometry), 0.0)
    except ConfigError as error:
        raise ConfigError(f"{place}.{error}") from None
    if len(outlines) > MOST_FACETS:
        raise ConfigError(
            f"{place}: {len(outlines)} flat facets; a simulation takes at most {MOST_FACETS}: give it fewer, or "
            "export the surface with a coarser tessellation"
        )
    if shape.from_inside == solid:
        outlines = [[loop[::-1] for loop in loops] for loops in outlines]
    return [Facet.from_loops(loops) for loops in outlines], rounding


@dataclass(frozen=True)
class _Shape:
    """A shape by its values and its file of triangles, with the time of writing [ns]: what its vessel depends on."""

    geometry: GeometrySection = field(compare=False)
    place: str
    solid: bool
    values: str
    file: tuple[str, int] | None


@lru_cache(maxsize=64)
def _vessel_of(shape: _Shape) -> Vessel:
    facets, rounding = drawn_shape(shape.geometry, shape.place, shape.solid)
    curves = shape_curves(shape.geometry, shape.solid)
    vessel = Vessel(facets, shape.place, shape.solid, shape.geometry.smooth_axis, curves)
    if not shape_kind(shape.geometry.kind).is_mesh or shape.geometry.faceted:
        return vessel
    # Imports this module.
    from millprint.mill.recognition import recognise

    return recognise(vessel, rounding)


def shape_vessel(geometry: GeometrySection, place: str, solid: bool) -> Vessel:
    """The walls of a shape, as of `shape_facets`. The same object for the same shape: simulations of a job share it."""
    path = getattr(geometry, "path", None)
    found = Path(path).resolve() if path and Path(path).exists() else None
    file = (str(found), found.stat().st_mtime_ns) if found else None
    return _vessel_of(_Shape(geometry, place, solid, geometry.model_dump_json(), file))


def build_vessel(mill: MillConfig) -> Vessel:
    """The vessel of a mill, in its body frame, z up. Raises ConfigError."""
    return shape_vessel(mill.geometry, f"config/mills/{mill.name}.yaml: geometry", solid=False)
