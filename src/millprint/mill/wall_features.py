"""What of a wall balls can touch: facets, convex lines, corners, curves and rims, and the patches that they make.

Features belong to one patch, a smooth surface on which a contact travels, where they meet in a seam that turns by less
than SMOOTH_TURN, or at a convex border: there the contact's normal turns without a jump, however sharp the border is.
Patches are parted by sharp seams only. So a patch of a round jar is its mantle, or all of the jar where fillets join
mantle and floor; a lifter is a patch, and so is the shell between two lifters.

In a seam a ball is at two local minima of its distance at once, one on each side. It is pressed in by `delta` of its
radius R at the nearer one; its foot on the other side passes the seam while it still overlaps, unless
R (1 - cos turn) > delta. So where the turn is larger than that of the largest overlap, both contacts begin and end
without a jump, and are both there; where it is smaller, two contacts would be cut off while they are pressed, and
would make one wall twice as stiff and damped as it is: there only the nearer one is a contact (dem.contact_events). Its
potential is that of the exact distance, so that it makes and loses no energy.
"""

import math
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from millprint.mill.borders import SMOOTH_TURN, Borders, borders_of
from millprint.mill.creases import Rim
from millprint.mill.drawn_creases import Crease
from millprint.mill.outlines import Ragged, lengths
from millprint.mill.vessel import CONVEX, Edge, Vessel


class Corner(NamedTuple):
    """A vertex that a ball can touch: its place [m] and the unit directions (k, 3) of the borders that leave it."""

    point: np.ndarray
    directions: np.ndarray


class Features(NamedTuple):
    """The features of a body are its facets, `lines`, `corners`, curves, `rims` and `creases`, numbered in this order.

    lines: convex edges, with the exact directions along their walls. patches: number of patches; patch (n,): that of
    each feature; is_drawing (n,): whether it only shows a curve and is not a wall itself; first_neighbour (n + 1,) and
    neighbour: the features of its patch that meet each one in a vertex, ascending; joint: how they meet, of Joints.
    """

    lines: tuple[Edge, ...]
    corners: tuple[Corner, ...]
    rims: tuple[Rim, ...]
    creases: tuple[Crease, ...]
    patches: int
    patch: np.ndarray
    is_drawing: np.ndarray
    first_neighbour: np.ndarray
    neighbour: np.ndarray
    joint: np.ndarray


class Joints(NamedTuple):
    """How two walls meet: the turn of their seam decides whether they are one wall for a ball in it."""

    by_direction: int  # flat walls, and convex borders: as the directions of the contacts differ
    smooth: int
    sharp: int


JOINT = Joints(0, 1, 2)


def facet_patches(vessel: Vessel, turn: np.ndarray) -> np.ndarray:
    """The patch of each facet (f,), numbered in the order of their first facets; turn: of the walls at each edge."""
    joined = turn > -SMOOTH_TURN
    first, second = vessel.edge_arrays.facets[joined].T
    count = len(vessel.normals)
    _, patch = connected_components(coo_array((np.ones(len(first)), (first, second)), (count, count)), directed=False)
    _, firsts, inverse = np.unique(patch, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(firsts))[inverse]


def _lines(vessel: Vessel, borders: Borders) -> tuple[Edge, ...]:
    """The convex edges, with the exact turns and directions of their walls."""
    numbers = np.flatnonzero((borders.turn > CONVEX) & ~borders.is_drawn)
    return tuple(
        replace(edge, inward=borders.inward[number], turn=float(borders.turn[number]))
        if number in borders.inward
        else edge
        for number, edge in zip(numbers.tolist(), vessel.edges_of(numbers), strict=True)
    )


def _corners(vessel: Vessel, borders: Borders, lines: tuple[Edge, ...]) -> tuple[np.ndarray, tuple[Corner, ...]]:
    """The vertices where convex borders end, by their numbers and with the unit directions of all borders there."""
    is_wanted = np.zeros(len(vessel.vertices), dtype=bool)
    is_wanted[[end for edge in lines for end in edge.ends]] = True
    for rim, own in zip(borders.rims, borders.rim_ends, strict=True):
        is_wanted[own] |= rim.turn > CONVEX
    # A crease goes on smoothly where two pieces of it meet, and nothing else does.
    count = np.zeros(len(vessel.vertices), dtype=np.int64)
    for number, crease in borders.creases.items():
        count[vessel.edge_arrays.ends[number]] += 1 if crease.turn > CONVEX else 3
    is_wanted |= count % 2 == 1
    edges = vessel.edge_arrays
    along = np.stack([edges.end - edges.start, edges.start - edges.end], axis=1)
    is_border = ~borders.is_drawn
    for number, arc in borders.arcs.items():
        tangents = np.cross(arc.axis, np.array([edges.start[number], edges.end[number]]) - arc.centre)
        along[number] = tangents * np.sign((tangents * along[number]).sum(axis=1))[:, None]
        is_border[number] = True
    for number, crease in borders.creases.items():
        along[number] = [crease.slope(-1.0), -crease.slope(1.0)]
        is_border[number] = True
    entries = np.flatnonzero(is_wanted[edges.ends.ravel()])
    vertices, first, corner = np.unique(edges.ends.ravel()[entries], return_index=True, return_inverse=True)
    # In the order of the edges.
    rank = np.argsort(np.argsort(first))[corner]
    kept = is_border.repeat(2)[entries]
    order = np.argsort(rank[kept], kind="stable")
    directions = along.reshape(-1, 3)[entries[kept][order]]
    of_corner = Ragged(np.bincount(rank[kept], minlength=len(vertices))).split(directions / lengths(directions))
    numbers = vertices[np.argsort(first)]
    return numbers, tuple(map(Corner, vessel.vertices[numbers], of_corner))


def _neighbours(touch: csr_array, patch: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Features.first_neighbour and neighbour, from the vertices (columns) of each feature (rows)."""
    first, second = (touch @ touch.T).nonzero()
    own = (patch[first] == patch[second]) & (first != second)
    order = np.lexsort((second[own], first[own]))
    counts = np.bincount(first[own], minlength=len(patch))
    return np.concatenate([[0], np.cumsum(counts)]), second[own][order].astype(np.int64)


def find_features(vessel: Vessel) -> Features:
    """The features of a body."""
    borders = borders_of(vessel)
    of_facet, facet = facet_patches(vessel, borders.turn), vessel.outlines.corners.owner
    lines = _lines(vessel, borders)
    ends, corners = _corners(vessel, borders, lines)
    convex = [k for k, rim in enumerate(borders.rims) if rim.turn > CONVEX]
    line_ends = np.array([edge.ends for edge in lines], dtype=np.int64).reshape(-1, 2)
    of_line = of_facet[[edge.facets[0] for edge in lines]]

    of_vertex = np.empty(len(vessel.vertices), dtype=np.int64)
    of_vertex[vessel.corners] = of_facet[facet]
    # A border belongs to the patch of both its walls, and a corner to that of any convex border that ends in it.
    of_vertex[line_ends] = of_line[:, None]
    of_rim = of_facet[[borders.rim_facets[k] for k in convex]]
    creases = [number for number, crease in borders.creases.items() if crease.turn > CONVEX]
    crease_ends = vessel.edge_arrays.ends[creases]
    of_crease = of_facet[vessel.edge_arrays.facets[creases, 0]]
    of_vertex[crease_ends] = of_crease[:, None]
    for k, own in zip(convex, of_rim, strict=True):
        of_vertex[borders.rim_ends[k]] = own
    of_curve = of_facet[[int(np.argmax(vessel.facet_curves == curve)) for curve in range(len(vessel.curves))]]
    patch = np.concatenate([of_facet, of_line, of_vertex[ends], of_curve, of_rim, of_crease])
    is_drawing = np.zeros(len(patch), dtype=bool)
    is_drawing[: len(of_facet)] = vessel.facet_curves >= 0
    # The vertices of each feature: of curves those of their facets.
    curves_from = len(of_facet) + len(lines) + len(ends)
    of_side = np.where(vessel.facet_curves < 0, np.arange(len(of_facet)), curves_from + vessel.facet_curves)[facet]
    of_rims = Ragged([len(borders.rim_vertices[k]) for k in convex]).owner
    rows = [of_side, len(of_facet) + np.arange(len(lines)).repeat(2), len(of_facet) + len(lines) + np.arange(len(ends))]
    columns = [vessel.corners, line_ends.ravel(), ends, *(borders.rim_vertices[k] for k in convex), crease_ends.ravel()]
    rims_from = curves_from + len(vessel.curves)
    rows += [rims_from + of_rims, rims_from + len(convex) + np.arange(len(creases)).repeat(2)]
    places = np.concatenate(rows), np.concatenate(columns)
    touch = coo_array((np.ones(len(places[0]), dtype=np.int32), places), (len(patch), len(vessel.vertices))).tocsr()
    rims = tuple(borders.rims[k] for k in convex)
    first, neighbour = _neighbours(touch, patch)
    joint = _joints(vessel, touch, first, neighbour, curves_from)
    pieces = tuple(borders.creases[number] for number in creases)
    return Features(lines, corners, rims, pieces, int(of_facet.max()) + 1, patch, is_drawing, first, neighbour, joint)


def _joints(vessel: Vessel, touch: csr_array, first: np.ndarray, neighbour: np.ndarray, curves_from: int) -> np.ndarray:
    """Features.joint: between a curve and another wall, by the largest angle of their normals where they meet."""
    joint = np.full(len(neighbour), JOINT.by_direction)

    def normals(feature: int, points: np.ndarray) -> np.ndarray:
        if feature >= curves_from:
            return vessel.curves[feature - curves_from].touch(points)[1]
        return np.broadcast_to(vessel.normals[feature], points.shape)

    vertices_of_creases = set(vessel.edge_arrays.ends[list(borders_of(vessel).creases)].ravel().tolist())
    pairs = np.column_stack([np.repeat(np.arange(len(first) - 1), np.diff(first)), neighbour])
    is_curve = (pairs >= curves_from) & (pairs < curves_from + len(vessel.curves))
    for at in np.flatnonzero((is_curve | (pairs < len(vessel.normals))).all(axis=1) & is_curve.any(axis=1)).tolist():
        own, other = pairs[at].tolist()
        shared = np.intersect1d(touch[[own]].indices, touch[[other]].indices)
        points = vessel.vertices[shared]
        cosine = (normals(own, points) * normals(other, points)).sum(axis=1)
        if cosine.min() >= math.cos(SMOOTH_TURN):
            joint[at] = JOINT.smooth
        # Along a crease the turn changes.
        elif cosine.max() < math.cos(SMOOTH_TURN) or not vertices_of_creases.issuperset(shared.tolist()):
            joint[at] = JOINT.sharp
    return joint


@lru_cache(maxsize=64)
def features_of(vessel: Vessel) -> Features:
    """The features of a body, kept for the bodies used last."""
    return find_features(vessel)
