"""Where the walls of a body meet: exact lines and circles, on which both walls agree.

An edge of the drawing is one of these:

- a joint, where one surface is cut into facets, or goes over smoothly into the next one: nothing is there;
- a line, of two flat walls or along the rulings of cylinders and cones;
- a piece of a circle about the axis that both surfaces share, drawn as a chord: a rim (mill.creases). A flat wall ends
  at the circle and not at the chord;
- a piece of another curve in which both surfaces meet, drawn as a chord too: a crease (mill.creases);
- rough: it is none of these, so that only the drawing is known. In a sharp seam that does no harm, since a ball parts
  from such a border by its own radius; elsewhere the wall would have a step there.
"""

import math
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from millprint.mill.creases import Rim, Trims
from millprint.mill.curved_surfaces import Curve
from millprint.mill.drawn_creases import NODES, Crease, crease_of, trim_of
from millprint.mill.outlines import ahead, cross
from millprint.mill.vessel import CONVEX, Edge, Vessel

# A seam of a smaller turn is a joint of facets [rad]: 37 degrees, for overlaps of a fifth of the radius, the largest
# that a run may allow (config.sweep.OVERLAP_LIMIT); see mill.patches.
SMOOTH_TURN = math.acos(0.8)
# Surfaces whose normals differ by no more are tangent to each other [rad].
TANGENT = 1e-4
# What directions, and places as a share of the body's size, may differ by where they are the same.
SAME = 1e-7
# An arc of an outline turns by no more [rad], so that it is on one side of its chord.
LONGEST_ARC = 2.2
# An arc that misses no more of a turn is a whole circle [rad].
ROUNDING = 1e-6


class Arc(NamedTuple):
    """The circle (mill.rims.Rim) that an edge of the drawing is a chord of: its centre (3,), axis (3,) and radius."""

    centre: np.ndarray
    axis: np.ndarray
    radius: float


@dataclass
class Borders:
    """What the edges of a body's drawing are, in the order of `Vessel.edges`.

    turn: angle between the exact walls [rad], see vessel.Edge; is_drawn: whether no line is there; is_rough; arcs: the
    circles of which edges are chords; slack (f,) and curve_slack: how far flat facets and curves reach beyond their
    borders [m], where these are rough, or tangent within rounding: both walls are listed there, and the nearer one is
    touched; rims: all arcs in which two walls meet at an angle, convex ones first; rim_vertices: numbers of the
    vertices that draw each; rim_ends: those where it ends; rim_facets: a facet next to each; inward: the exact
    directions along both walls at straight edges, see vessel.Edge; creases: the pieces of creases of which edges are
    chords; trims: the borders of trimmed curves, by their numbers.
    """

    turn: np.ndarray
    is_drawn: np.ndarray
    is_rough: np.ndarray
    arcs: dict[int, Arc]
    slack: np.ndarray
    curve_slack: np.ndarray
    rims: tuple[Rim, ...] = ()
    rim_vertices: tuple[np.ndarray, ...] = ()
    rim_ends: tuple[np.ndarray, ...] = ()
    rim_facets: tuple[int, ...] = ()
    inward: dict[int, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    creases: dict[int, Crease] = field(default_factory=dict)
    trims: dict[int, Trims] = field(default_factory=dict)


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)


def _on_axis(point: np.ndarray, curve: Curve, near: float) -> bool:
    return bool(np.linalg.norm(cross(point - curve.origin, curve.axis)) < near)


def shared_axis(first: Curve, second: Curve | np.ndarray, near: float) -> tuple[np.ndarray, np.ndarray] | None:
    """A point on the axis about which two surfaces both turn and its direction, or None.

    second: a surface, or the normal (3,) of a plane; near: what places may differ by [m].
    """
    if isinstance(second, np.ndarray):
        axis = second if first.kind == "sphere" else first.axis
        return (first.origin, axis) if np.linalg.norm(cross(axis, second)) < SAME else None
    if first.kind == second.kind == "sphere":
        return first.origin, _unit(second.origin - first.origin)
    if "sphere" in (first.kind, second.kind):
        ball, other = (first, second) if first.kind == "sphere" else (second, first)
        return (other.origin, other.axis) if _on_axis(ball.origin, other, near) else None
    same = np.linalg.norm(cross(first.axis, second.axis)) < SAME and _on_axis(second.origin, first, near)
    return (first.origin, first.axis) if same else None


def _are_along(first: Curve | np.ndarray, second: Curve | np.ndarray) -> bool:
    """Whether two surfaces, a cylinder and a plane (its normal) or another cylinder, are along one direction."""
    cylinders = [each for each in (first, second) if isinstance(each, Curve)]
    if any(each.kind != "cylinder" for each in cylinders):
        return False
    normals = [each for each in (first, second) if not isinstance(each, Curve)]
    axis = cylinders[0].axis
    return all(np.linalg.norm(cross(each.axis, axis)) < SAME for each in cylinders) and all(
        abs(normal @ axis) < SAME for normal in normals
    )


def _is_ruling(curve: Curve, point: np.ndarray, along: np.ndarray) -> bool:
    """Whether a direction at a point of a surface is that of the straight line in it there."""
    if curve.minor is not None:
        return False
    away = point - curve.origin
    outwards = _unit(away - (away @ curve.axis) * curve.axis)
    line = math.cos(curve.slope) * curve.axis + math.sin(curve.slope) * outwards
    return bool(np.linalg.norm(cross(line, along)) < 1e-5)


class _Walls:
    """The exact walls next to the edges of a drawing."""

    def __init__(self, vessel: Vessel) -> None:
        self.vessel, self.near = vessel, SAME * vessel.size
        self.axes: dict[tuple[int, ...], tuple[np.ndarray, np.ndarray] | None] = {}

    def piece(self, facet: int) -> Curve | np.ndarray:
        """The surface that a facet draws, or its normal where it is flat."""
        number = self.vessel.facet_curves[facet]
        return self.vessel.curves[number] if number >= 0 else self.vessel.facets[facet].normal

    def pair(self, edge: Edge) -> tuple[Curve | np.ndarray, Curve | np.ndarray]:
        """The surfaces next to an edge, or planes (normal, offset)."""
        first, second = (
            piece if isinstance(piece, Curve) else np.array([*piece, self.vessel.offsets[facet]])
            for facet, piece in zip(edge.facets, map(self.piece, edge.facets), strict=True)
        )
        return first, second

    def normal(self, facet: int, point: np.ndarray) -> np.ndarray:
        """The exact normal at a point."""
        piece = self.piece(facet)
        return piece if isinstance(piece, np.ndarray) else piece.touch(point[None])[1][0]

    def meeting(self, edge: Edge, tangent: np.ndarray) -> tuple[float, tuple[np.ndarray, np.ndarray]]:
        """The exact turn at an edge, and the directions along both walls, where the border runs along `tangent`."""
        normals = [self.normal(facet, edge.start) for facet in edge.facets]
        inward = cross(normals[0], tangent), cross(normals[1], -tangent)
        turn = math.atan2(-float(inward[0] @ normals[1]), float(normals[0] @ normals[1]))
        return turn, (_unit(inward[0]), _unit(inward[1]))

    def circle(self, edge: Edge) -> tuple[np.ndarray, np.ndarray] | None:
        """Axis of the circle that an edge is a chord of (a point and a direction), None for another border."""
        # The many edges between two curves, or a curve and a flat facet, have one answer.
        key = tuple(number if (number := self.vessel.facet_curves[facet]) >= 0 else ~facet for facet in edge.facets)
        if key not in self.axes:
            pieces = [self.piece(facet) for facet in edge.facets]
            first, second = pieces if isinstance(pieces[0], Curve) else pieces[::-1]
            found = shared_axis(first, second, self.near)  # type: ignore[arg-type]
            # Either direction is one circle.
            self.axes[key] = found and (found[0], found[1] * np.sign(found[1][np.argmax(np.abs(found[1]))]))
        return self.axes[key]


def _merged(spans: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Parts of a turn that some pieces cover, those that touch joined [rad]; pieces begin in [0, 2 pi)."""
    spans = sorted(spans)
    merged = [spans[0]]
    for begin, end in spans[1:]:
        if begin - merged[-1][1] <= ROUNDING:
            merged[-1] = merged[-1][0], max(end, merged[-1][1])
        else:
            merged.append((begin, end))
    if len(merged) > 1 and merged[0][0] + 2 * math.pi - merged[-1][1] <= ROUNDING:
        begin, end = merged.pop()
        merged[0] = begin - 2 * math.pi, merged[0][1]
    return merged


def _halves(begin: float, end: float) -> list[tuple[float, float] | None]:
    """An arc in pieces of up to half a turn; None for a whole circle."""
    if end - begin > 2 * math.pi - ROUNDING:
        return [None]
    cuts = np.linspace(begin, end, math.ceil((end - begin) / math.pi - ROUNDING) + 1).tolist()
    return list(pairwise(cuts))


@dataclass
class _Chords:
    """Edges that are chords of one circle, with its height over `origin` and radius at each of their ends."""

    origin: np.ndarray
    axis: np.ndarray
    inward: tuple[np.ndarray, np.ndarray]
    turn: float
    first: np.ndarray
    edges: list[int] = field(default_factory=list)
    spans: list[tuple[float, float]] = field(default_factory=list)
    places: list[tuple[float, float]] = field(default_factory=list)


class _Circles:
    """The chords of a drawing, gathered by their circles."""

    def __init__(self, near: float) -> None:
        self.near = near
        self.of_key: dict[tuple, _Chords] = {}

    def add(self, number: int, edge: Edge, circle: tuple[np.ndarray, np.ndarray], walls: _Walls) -> float:
        """Take an edge; returns the turn of the walls there."""
        origin, axis = circle
        away = [point - origin for point in (edge.start, edge.end)]
        heights = [float(each @ axis) for each in away]
        across = [each - height * axis for each, height in zip(away, heights, strict=True)]
        radii = [float(np.linalg.norm(each)) for each in across]
        outwards = across[0] / radii[0]
        tangent = cross(axis, outwards)
        forward = float((edge.end - edge.start) @ tangent) > 0
        turn, inward = walls.meeting(edge, tangent if forward else -tangent)
        flat = [np.array([float(each @ outwards), float(each @ axis)]) for each in inward]
        # Both orders of the two walls are one circle.
        flat.sort(key=lambda each: np.round(each, 3).tolist())
        # On a lattice of its own size, a number may fall on either side of a border: the neighbours are asked too.
        key = self._key(origin, axis, heights[0], radii[0], flat)
        chords = self.of_key.setdefault(key, _Chords(origin, axis, (flat[0], flat[1]), turn, outwards))
        other = cross(axis, chords.first)
        begin, end = (
            math.atan2(float(each @ other), float(each @ chords.first)) for each in across[:: 1 if forward else -1]
        )
        width = (end - begin) % (2 * math.pi)
        chords.edges.append(number)
        chords.spans.append((begin % (2 * math.pi), begin % (2 * math.pi) + width))
        shift = float((origin - chords.origin) @ axis)
        chords.places += [(height + shift, radius) for height, radius in zip(heights, radii, strict=True)]
        return turn

    def _key(self, origin: np.ndarray, axis: np.ndarray, height: float, radius: float, flat: list[np.ndarray]) -> tuple:
        lattice = 100 * self.near
        sizes = [*(origin + height * axis), radius]
        rounded = [*np.floor(np.array(sizes) / lattice + 0.5), *np.round(100 * np.concatenate(flat))]
        plain = tuple(int(each) for each in rounded)
        for known, chords in self.of_key.items():
            if max(abs(a - b) for a, b in zip(known, plain, strict=True)) <= 1 and abs(axis @ chords.axis) > 1 - SAME:
                return known
        return plain


def _circle_of(chords: _Chords) -> Arc:
    height, radius = np.mean(chords.places, axis=0)
    return Arc(chords.origin + height * chords.axis, chords.axis, float(radius))


def _rims_of(chords: _Chords, vessel: Vessel) -> list[tuple[Rim, np.ndarray, np.ndarray, int]]:
    """The arcs of a circle; the vertices that draw each, those at its ends, and a facet next to it."""
    arc, other = _circle_of(chords), cross(chords.axis, chords.first)
    vertices = np.unique(vessel.edge_arrays.ends[chords.edges])
    facet = int(vessel.edge_arrays.facets[chords.edges[0], 0])
    away = vessel.vertices[vertices] - arc.centre
    angles = np.arctan2(away @ other, away @ chords.first)

    def direction(angle: float) -> np.ndarray:
        return math.cos(angle) * chords.first + math.sin(angle) * other

    found = []
    for begin, end in _merged(chords.spans):
        own = vertices[(angles - begin + ROUNDING) % (2 * math.pi) <= end - begin + 2 * ROUNDING]
        is_end = [np.isclose((angles - cut + math.pi) % (2 * math.pi), math.pi, atol=ROUNDING) for cut in (begin, end)]
        for half in _halves(begin, end):
            part = half and (direction(half[0]), direction(half[1]))
            ends = vertices[is_end[0] | is_end[1]] if part else vertices[:0]
            found.append((Rim(arc.centre, arc.axis, arc.radius, part, chords.inward, chords.turn), own, ends, facet))
    return found


def _tips(vessel: Vessel, number: int) -> list[tuple[Rim, np.ndarray, np.ndarray, int]]:
    """The same as `_rims_of` of the points in which a curve all round its axis ends there: circles of no radius."""
    curve, near = vessel.curves[number], SAME * vessel.size
    if curve.part or curve.is_trimmed or curve.kind in ("cylinder", "sphere"):
        return []
    places = [(math.inf, 0.0, 0.0, 0.0)]
    if curve.minor is None:
        line = math.sin(curve.slope), math.cos(curve.slope)
        places = [(curve.major + end * line[0], end * line[1], sense * line[0], sense * line[1])
                  for end, sense in zip(curve.ends, (1, -1), strict=True)]  # fmt: skip
    elif curve.arc:
        places = [(curve.major + curve.minor * out, curve.minor * up, -sense * up, sense * out)
                  for (out, up), sense in zip(curve.arc, (1, -1), strict=True)]  # fmt: skip
    found = []
    for r, z, *inward in places:
        if abs(r) < near and abs(inward[1]) > TANGENT:
            point = curve.origin + z * curve.axis
            nearest = np.linalg.norm(vessel.vertices - point, axis=1).argmin()
            beside = vessel.outlines.corners.owner[vessel.corners == nearest]
            facet = beside[vessel.facet_curves[beside] == number][0]
            # It juts in where the balls are on the far side of it from the wall.
            leans = -inward[1] * float(vessel.normals[facet] @ curve.axis)
            turn = math.copysign(2 * math.asin(min(1.0, abs(inward[1]))), leans)
            rim = Rim(point, curve.axis, 0.0, None, (np.array(inward), np.array(inward)), turn)
            found.append((rim, np.array([nearest]), np.empty(0, dtype=np.int64), int(facet)))
    return found


def find_borders(vessel: Vessel) -> Borders:
    """What the edges of a body's drawing are, see Borders."""
    turn = vessel.edge_arrays.turn.copy()
    curves = vessel.facet_curves[vessel.edge_arrays.facets]
    on_curve = (curves >= 0).any(axis=1)
    whole = list(range(len(vessel.curves)))
    for second, curve in enumerate(vessel.curves):
        # Parts of less than half a turn of one surface.
        whole[second] = next(k for k in range(second + 1) if vessel.curves[k].is_part_of(curve))
    surface = np.array([*whole, -1])[curves]
    is_drawn = on_curve & (surface[:, 0] == surface[:, 1])
    turn[is_drawn] = 0.0
    borders = Borders(
        turn, is_drawn, np.zeros(len(turn), dtype=bool), {},
        np.zeros(len(vessel.normals)), np.zeros(len(vessel.curves)),
    )  # fmt: skip
    walls = _Walls(vessel)
    circles = _Circles(walls.near)
    borders_at = np.flatnonzero(on_curve & ~is_drawn)
    for number, edge in zip(borders_at.tolist(), vessel.edges_of(borders_at), strict=True):
        circle = walls.circle(edge)
        if circle is not None:
            turn[number] = circles.add(number, edge, circle, walls)
            is_drawn[number] = True
        else:
            along = _unit(edge.end - edge.start)
            turn[number], borders.inward[number] = walls.meeting(edge, along)
            pieces = [walls.piece(facet) for facet in edge.facets]
            middle = (edge.start + edge.end) / 2
            is_line = _are_along(*pieces) or all(
                isinstance(piece, np.ndarray) or _is_ruling(piece, middle, along) for piece in pieces
            )
            if not is_line and abs(turn[number]) > TANGENT:
                crease = crease_of(walls.pair(edge), edge.start, edge.end, vessel.size)
                borders.is_rough[number] = crease is None
                if crease:
                    borders.creases[number], turn[number] = crease, crease.turn
            is_drawn[number] = not is_line or abs(turn[number]) <= TANGENT
        _add_slack(borders, vessel, number, edge)
    # A wall that reaches beyond a convex border would be felt where nothing is.
    for number in np.flatnonzero(turn > TANGENT).tolist():
        borders.curve_slack[[piece for piece in curves[number].tolist() if piece >= 0]] = 0.0
    for chords in circles.of_key.values():
        arc = _circle_of(chords)
        borders.arcs |= dict.fromkeys(chords.edges, arc)
    rims = [
        found for chords in circles.of_key.values() if abs(chords.turn) > TANGENT for found in _rims_of(chords, vessel)
    ]
    _find_trims(vessel, borders)
    rims += [tip for number in range(len(vessel.curves)) for tip in _tips(vessel, number)]
    rims.sort(key=lambda found: found[0].turn <= CONVEX)
    if rims:
        borders.rims, borders.rim_vertices, borders.rim_ends, borders.rim_facets = zip(*rims, strict=True)
    return borders


def _add_slack(borders: Borders, vessel: Vessel, number: int, edge: Edge) -> None:
    """Let both walls at an edge reach beyond it: by what a tangent border may be off, or by the sag of a rough one."""
    turn = float(borders.turn[number])
    if abs(turn) <= TANGENT:
        slack = vessel.size * abs(turn)
    elif borders.is_rough[number]:
        middle = (edge.start + edge.end)[None] / 2
        pieces = [vessel.facet_curves[facet] for facet in edge.facets]
        sag = sum(abs(float(vessel.curves[piece].touch(middle)[0][0])) for piece in pieces if piece >= 0)
        slack = 2 * sag / max(abs(math.sin(turn)), 0.1)
    else:
        return
    for facet in edge.facets:
        piece = vessel.facet_curves[facet]
        slacks, at = (borders.slack, facet) if piece < 0 else (borders.curve_slack, piece)
        slacks[at] = max(slacks[at], slack)


def rough_facets(vessel: Vessel, borders: Borders) -> set[int]:
    """Facets next to a border on which two walls do not agree, where a ball passes from one to the other.

    Further: those of a curve that ought to be trimmed and cannot be.
    """
    is_open = borders.is_rough & (borders.turn > -SMOOTH_TURN)
    untrimmed = [k for k, curve in enumerate(vessel.curves) if curve.is_trimmed and k not in borders.trims]
    return {
        *vessel.edge_arrays.facets[is_open].ravel().tolist(),
        *np.flatnonzero(np.isin(vessel.facet_curves, untrimmed)).tolist(),
    }


def _points_along(borders: Borders, edge: Edge, number: int) -> np.ndarray:
    """Points (n, 3) along an edge as it is exactly, its ends first and last."""
    if number in borders.creases:
        return borders.creases[number].points
    ends = np.array([edge.start, edge.end])
    arc = borders.arcs.get(number)
    if arc is None:
        return ends
    away = edge.start - arc.centre + (NODES[:, None] + 1) / 2 * (edge.end - edge.start)
    return np.vstack([ends[:1], arc.centre + arc.radius * away / np.linalg.norm(away, axis=1)[:, None], ends[1:]])


def _edges_around(vessel: Vessel, number: int) -> np.ndarray:
    """The edges at which a curve ends."""
    return np.flatnonzero((vessel.facet_curves[vessel.edge_arrays.facets] == number).sum(axis=1) == 1)


def _find_trims(vessel: Vessel, borders: Borders) -> None:
    for number, curve in enumerate(vessel.curves):
        if not curve.is_trimmed:
            continue
        around = _edges_around(vessel, number)
        sides = [_points_along(borders, edge, k) for edge, k in zip(vessel.edges_of(around), around, strict=True)]
        middles = vessel.outlines.middles[vessel.facet_curves == number]
        trims = trim_of(curve, sides, middles, vessel.size)
        if trims:
            borders.trims[number] = trims


def must_be_trimmed(vessel: Vessel, borders: Borders) -> list[int]:
    """The curves that are not trimmed, but end elsewhere than at their parts, arcs and ends."""
    found = []
    of_edge = vessel.facet_curves[vessel.edge_arrays.facets]
    for number, curve in enumerate(vessel.curves):
        parts = [k for k, other in enumerate(vessel.curves) if other.is_part_of(curve)]
        around = _edges_around(vessel, number)
        around = around[~np.isin(of_edge[around], parts).all(axis=1)]
        if curve.is_trimmed or not len(around):
            continue
        ends = np.stack([vessel.edge_arrays.start[around], vessel.edge_arrays.end[around]], axis=1) - curve.origin
        up = ends @ curve.axis
        across = ends - up[..., None] * curve.axis
        out = np.linalg.norm(across, axis=-1) - curve.major
        off = [np.abs(cross(across, each) @ curve.axis) for each in curve.part or ()]
        if curve.minor is None:
            along = up * math.cos(curve.slope) + out * math.sin(curve.slope)
            off += [np.abs(along - end) for end in curve.ends]
        else:
            off += [np.abs(out * each[1] - up * each[0]) for each in curve.arc or ()]
        is_crease = np.isin(around, list(borders.creases))
        # Where walls are nearly tangent, the place of their border is less certain.
        near = np.where(np.abs(borders.turn[around]) <= 1e2 * TANGENT, 1e4, 1e2) * SAME * vessel.size
        if is_crease.any() or not off or not (np.array(off).max(axis=-1) < near).any(axis=0).all():
            found.append(number)
    return found


class Side(NamedTuple):
    """A side of an outline: rows of the outline's vertices where it begins and ends, its circle or crease if any."""

    begin: int
    end: int
    arc: Arc | None
    crease: Crease | None


def outline_sides(vessel: Vessel, facet: int, loop: int) -> list[Side]:
    """The sides of an outline of a facet, a number among its loops.

    Chords of one circle that follow each other are one arc, of up to LONGEST_ARC. A facet that only draws a curve stays
    as it is drawn.
    """
    borders, is_flat = borders_of(vessel), vessel.facet_curves[facet] < 0
    numbers, points = vessel.loops[facet][loop], vessel.facets[facet].loops[loop]
    pairs = zip(numbers.tolist(), ahead(numbers).tolist(), strict=True)
    edges = [vessel.edge_at[frozenset(pair)] for pair in pairs]
    arcs = [borders.arcs.get(edge) if is_flat else None for edge in edges]
    count = len(arcs)
    # Begin where one circle ends.
    first = next((k for k in range(count) if arcs[k] is not arcs[k - 1]), 0)
    sides: list[Side] = []
    turned = 0.0
    for k in (*range(first, count), *range(first)):
        arc, end = arcs[k], (k + 1) % count
        chord = np.linalg.norm(points[end] - points[k])
        angle = 2 * math.asin(min(1.0, float(chord) / (2 * arc.radius))) if arc else 0.0
        if arc and sides and sides[-1].arc is arc and sides[-1].end == k and turned + angle <= LONGEST_ARC:
            sides[-1], turned = sides[-1]._replace(end=end), turned + angle
        else:
            turned = angle
            sides.append(Side(k, end, arc, borders.creases.get(edges[k])))
    return sides


@lru_cache(maxsize=64)
def borders_of(vessel: Vessel) -> Borders:
    """The borders of a body, kept for the bodies used last."""
    return find_borders(vessel)
