"""A vessel: flat facets in the body frame, with the edges and corners that balls can touch."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from millprint.config.errors import ConfigError
from millprint.config.mill import GeometrySection, MillConfig
from millprint.mill.curved_surfaces import Curve
from millprint.mill.outlines import (
    Facet,
    Outlines,
    are_convex,
    convex_fan,
    cross,
    enclosed_volume,
    facets_of,
    plane_axes,
    triangulate_facet,
)
from millprint.mill.shapes import SHAPES

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
# More facets take minutes and gigabytes before the first step.
MOST_FACETS = 200_000


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


class Edges(NamedTuple):
    """All edges of a body as arrays of what each Edge has; inward is of the first and of the second facet (e, 3)."""

    start: np.ndarray
    end: np.ndarray
    ends: np.ndarray
    facets: np.ndarray
    inward: tuple[np.ndarray, np.ndarray]
    turn: np.ndarray


class Vessel:
    """A closed vessel in the body frame; the normals of its walls point inward, to where the balls are.

    Facets draw it. Those on an exact surface (`curves`, mill.curved_surfaces) are only a picture of it; the others are
    flat walls, whose borders may be arcs (mill.borders). A solid body inside a vessel is the same with `solid`: its
    normals point out of it, and its volume is negative.

    facets: or their outlines. smooth_axis: "x", "y" or "z", the axis whose end facets have no friction, or None.
    on_curves: for each of `facets` the one of `curves` that it draws, -1 for a flat wall; left out, that is found.
    report: what was nearly recognised, in words. facet_curves (f,): the same for the vessel's own facets, which are
    sorted; placed_from (f,): the numbers of these among the given ones. Raises ConfigError where the facets do not
    close: every edge must belong to two facets, in opposite senses.
    """

    def __init__(
        self,
        facets: Sequence[Facet] | Outlines,
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
        given = facets if isinstance(facets, Outlines) else Outlines.of(facet.loops for facet in facets)
        self.size = float(np.ptp(given.points, axis=0).max())
        # A power of two, so that a shape and its double are the same on their lattices.
        pitch = LATTICE * 2.0 ** math.floor(math.log2(self.size))
        placed = given.on_lattice(pitch)
        firsts = placed.points[placed.loops.first[placed.facets.first]]
        order = np.lexsort((*placed.planes()[0].T[::-1], *firsts.T[::-1]))
        self.placed_from = order
        self.outlines = placed.taken(order)
        self.normals, self.offsets = self.outlines.planes()
        self.vertices, self.corners, rank = self._number_vertices()
        self.edge_arrays = self._find_edges(rank)
        on_curve = self._find_pieces(curves) if on_curves is None else np.asarray(on_curves)[order]
        # Only those that have facets: a sphere's ends leave no mantle between them.
        used = sorted(set(on_curve.tolist()) - {-1})
        self.curves = tuple(curves[number] for number in used)
        self.facet_curves = np.array([used.index(number) if number >= 0 else -1 for number in on_curve.tolist()])
        if (self.volume_m3 >= 0) if solid else (self.volume_m3 <= 0):
            raise ConfigError(f"{name}: the facets are inside out (volume {self.volume_m3 * 1e6:.3g} mL)")

    @cached_property
    def facets(self) -> tuple[Facet, ...]:
        """The flat pieces of wall, ordered by their places."""
        return tuple(facets_of(self.outlines))

    @cached_property
    def loops(self) -> list[list[np.ndarray]]:
        """For each facet the numbers of its vertices along each of its outlines."""
        return self.outlines.lists(self.corners)

    @cached_property
    def edges(self) -> tuple[Edge, ...]:
        """The lines where two facets meet."""
        return self.edges_of(np.arange(len(self.edge_arrays.turn)))

    def edges_of(self, numbers: np.ndarray) -> tuple[Edge, ...]:
        """Some edges by their numbers."""
        start, end, ends, facets, inward, turn = self.edge_arrays
        pairs = map(tuple, ends[numbers].tolist()), map(tuple, facets[numbers].tolist())
        inwards = zip(inward[0][numbers], inward[1][numbers], strict=True)
        return tuple(map(Edge, start[numbers], end[numbers], *pairs, inwards, turn[numbers].tolist()))

    @cached_property
    def axes(self) -> np.ndarray:
        """Facet.axes (f, 2, 3) of each facet."""
        return plane_axes(self.normals)

    @cached_property
    def areas(self) -> np.ndarray:
        """Facet.area (f,) of each facet [m2]."""
        return np.vecdot(self.outlines.areas, self.normals)

    def _number_vertices(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Every vertex (v, 3) [m], once; the vertices' numbers (n,) along all outlines; and each one's rank.

        Vertices are ranked by their places, as they would be in any order of the facets.
        """
        points = self.outlines.points
        lattice = np.round(points / (WELD * self.size)).astype(np.int64)
        order = np.lexsort(lattice.T[::-1])
        is_new = np.append(True, (np.diff(lattice[order], axis=0) != 0).any(axis=1))
        rank, first = np.empty(len(points), dtype=np.int64), order[is_new]
        rank[order] = np.cumsum(is_new) - 1
        by_number = np.argsort(first)
        number = np.argsort(by_number)
        return points[first[by_number]], number[rank], by_number

    def _find_edges(self, rank: np.ndarray) -> Edges:
        """The edges between facets, also `edge_of_side`; rank: of each vertex by its place."""
        begin, follows = self.corners, self.outlines.loops.ahead
        forth, back = begin * len(rank) + begin[follows], begin[follows] * len(rank) + begin
        order = np.argsort(forth, kind="stable")
        points, facet = self.outlines.points * 1e3, self.outlines.corners.owner
        twice = order[1:][np.diff(forth[order]) == 0]
        if len(twice):
            raise ConfigError(f"{self.name}: two facets run along the edge at {points[twice.min()]} mm in one sense")
        twin = order[np.minimum(np.searchsorted(forth, back, sorter=order), len(order) - 1)]
        is_open = forth[twin] != back
        if is_open.any():
            at = np.argmax(is_open)
            raise ConfigError(
                f"{self.name}: the vessel is open at the edge from {points[at]} to {points[follows[at]]} mm"
            )
        side = np.flatnonzero(rank[begin] < rank[begin[follows]])
        self.edge_of_side = np.empty(len(begin), dtype=np.int64)
        self.edge_of_side[side] = self.edge_of_side[twin[side]] = np.arange(len(side))
        start, end = self.outlines.points[side], self.outlines.points[follows[side]]
        facets = np.column_stack([facet[side], facet[twin[side]]])
        of_first, of_second = self.normals[facets].transpose(1, 0, 2)
        along = end - start
        along /= np.linalg.norm(along, axis=1)[:, None]
        inward = cross(of_first, along), cross(of_second, -along)
        sine, cosine = -(inward[0] * of_second).sum(axis=1), (of_first * of_second).sum(axis=1)
        ends = np.column_stack([begin[side], begin[follows[side]]])
        return Edges(start, end, ends, facets, inward, np.arctan2(sine, cosine))

    @cached_property
    def is_smooth(self) -> np.ndarray:
        """Which facets (f,) have no friction: those across `smooth_axis`."""
        if self.smooth_axis is None:
            return np.zeros(len(self.normals), dtype=bool)
        return np.abs(self.normals[:, "xyz".index(self.smooth_axis)]) > 1 - 1e-9

    def _find_pieces(self, curves: Sequence[Curve]) -> np.ndarray:
        """For each facet (f,) the curve that it draws, -1 for a flat wall."""
        found = np.full(len(self.normals), -1)
        for number, curve in enumerate(curves):
            distance, _, past = curve.touch(self.outlines.points)
            off = np.maximum.reduceat(np.maximum(np.abs(distance), past), self.outlines.corners.first)
            sunk, direction, past = curve.touch(self.outlines.middles)
            on_it = np.maximum(off, past) <= ON_CURVE * self.size
            # A flat wall that joins a curve smoothly lies on its tangents: it is flat all the same.
            is_bent = np.abs(sunk) > 1e-9 * self.size
            found[on_it & is_bent & (np.vecdot(direction, self.normals) > np.cos(CURVE_ANGLE))] = number
        return found

    @cached_property
    def volume_m3(self) -> float:
        """Inner volume [m3]; negative for a solid, which takes it from the balls.

        What lies between a facet and its curve is integrated with the middles of the sides of the triangles from an
        outline's vertices to its first one, which is exact for a parabola. A triangle on the other side of the outline
        counts less than nothing.
        """
        volume = enclosed_volume(self.outlines)
        points, loops, owner = self.outlines.points, self.outlines.loops, self.outlines.corners.owner
        first, follows = points[loops.first[loops.owner]], points[loops.ahead]
        weights = np.vecdot(cross(points - first, follows - first), self.normals[owner]) / 6
        for number, curve in enumerate(self.curves):
            own = np.flatnonzero((self.facet_curves == number)[owner])
            sides = (first[own] + points[own]) / 2, (points[own] + follows[own]) / 2, (follows[own] + first[own]) / 2
            volume += float(sum(weights[own] @ curve.touch(middles)[0] for middles in sides))
        return volume

    @cached_property
    def edge_at(self) -> dict[frozenset[int], int]:
        """The number of the edge between two vertices."""
        return {frozenset(ends): number for number, ends in enumerate(self.edge_arrays.ends.tolist())}

    @cached_property
    def sagitta(self) -> float:
        """How far the exact walls are from the drawing at most [m]."""
        middles = [self.outlines.middles[self.facet_curves == number] for number in range(len(self.curves))]
        return max(
            (float(np.abs(c.touch(own)[0]).max()) for c, own in zip(self.curves, middles, strict=True)), default=0.0
        )

    @cached_property
    def is_convex(self) -> bool:
        """Whether no wall juts into the vessel."""
        return bool((self.edge_arrays.turn <= CONVEX).all())

    @cached_property
    def bounds(self) -> np.ndarray:
        """Lower and upper corner (2, 3) of the bounding box [m]."""
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    def triangles(self) -> tuple[np.ndarray, np.ndarray]:
        """Vertices (v, 3) [m], each once, and triangles (t, 3) of the walls as they are drawn, normals inward.

        Raises ConfigError for an outline that crosses itself.
        """
        return self.vertices, self.corners[triangulate_facets(self)]


def triangulate_facets(vessel: Vessel) -> np.ndarray:
    """Triangles (t, 3) as rows of `Vessel.corners`, counter-clockwise inward, facet after facet.

    Raises ConfigError for an outline that crosses itself.
    """
    found, owners = [], []
    corners = vessel.outlines.corners
    for facets, rows in corners.stacks():
        flat = vessel.outlines.points[rows] @ vessel.axes[facets].transpose(0, 2, 1)
        fan = convex_fan(rows.shape[1])
        is_fan = (vessel.outlines.facets.counts[facets] == 1) & are_convex(flat)
        found.append(rows[is_fan][:, fan].reshape(-1, 3))
        owners.append(np.repeat(facets[is_fan], len(fan)))
        for facet in facets[~is_fan].tolist():
            own = corners.first[facet] + triangulate_facet(vessel.facets[facet])
            found.append(own)
            owners.append(np.full(len(own), facet))
    return np.concatenate(found)[np.argsort(np.concatenate(owners), kind="stable")]


def shape_curves(geometry: GeometrySection, solid: bool) -> list[Curve]:
    """The cylinders and tori of which the facets of a shape are pieces; none where its facets are the wall itself."""
    shape = SHAPES[geometry.kind]
    curves = [] if geometry.faceted else shape.curves(geometry)
    return [curve.turned_out for curve in curves] if shape.from_inside == solid else curves


def drawn_shape(geometry: GeometrySection, place: str, solid: bool) -> tuple[Outlines, float]:
    """The outlines of the facets of a shape, their normals towards the balls: into a hollow, or out of a solid.

    Further: the rounding of their vertices in a file [m].

    place: the YAML file and key, for refusals. Raises ConfigError for a file of triangles that is refused or for too
    many facets.
    """
    shape = SHAPES[geometry.kind]
    try:
        outlines, rounding = shape.facets(geometry) if shape.is_mesh else (shape.facets(geometry), 0.0)
    except ConfigError as error:
        raise ConfigError(f"{place}.{error}") from None
    if len(outlines) > MOST_FACETS:
        raise ConfigError(
            f"{place}: {len(outlines):,} flat facets; a simulation takes at most {MOST_FACETS:,}: give it fewer, or "
            "export the surface with a coarser tessellation"
        )
    if shape.from_inside == solid:
        outlines = [[loop[::-1] for loop in loops] for loops in outlines]
    return Outlines.of(outlines), rounding


@lru_cache(maxsize=64)
def _vessel_of(geometry: GeometrySection, place: str, solid: bool, _file: tuple[str, int] | None) -> Vessel:
    """`shape_vessel`; _file: of triangles, with the time of writing [ns], on which the walls depend too."""
    facets, rounding = drawn_shape(geometry, place, solid)
    vessel = Vessel(facets, place, solid, geometry.smooth_axis, shape_curves(geometry, solid))
    if not SHAPES[geometry.kind].is_mesh or geometry.faceted:
        return vessel
    # Imports this module.
    from millprint.mill.recognition import recognise

    return recognise(vessel, rounding)


def shape_vessel(geometry: GeometrySection, place: str, solid: bool) -> Vessel:
    """The walls of a shape, as of `drawn_shape`. The same object for the same shape: simulations of a job share it."""
    path = getattr(geometry, "path", None)
    found = Path(path).resolve() if path and Path(path).exists() else None
    file = (str(found), found.stat().st_mtime_ns) if found else None
    return _vessel_of(geometry, place, solid, file)


def build_vessel(mill: MillConfig) -> Vessel:
    """The vessel of a mill, in its body frame, z up. Raises ConfigError."""
    return shape_vessel(mill.geometry, f"config/mills/{mill.name}.yaml: geometry", solid=False)
