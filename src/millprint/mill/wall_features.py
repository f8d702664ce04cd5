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
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from millprint.mill.borders import SMOOTH_TURN, Borders, borders_of
from millprint.mill.rims import Rim
from millprint.mill.vessel import CONVEX, Edge, Vessel


class Corner(NamedTuple):
    """A vertex that a ball can touch: its place [m] and the unit directions (k, 3) of the borders that leave it."""

    point: np.ndarray
    directions: np.ndarray


class Features(NamedTuple):
    """The features of a body are its facets, `lines`, `corners`, curves and `rims`, numbered in this order.

    lines: convex edges, with the exact directions along their walls. patches: number of patches; patch (n,): that of
    each feature; is_drawing (n,): whether it only shows a curve and is not a wall itself; first_neighbour (n + 1,) and
    neighbour: the features of its patch that meet each one in a vertex, ascending; joint: how they meet, of Joints.
    """

    lines: tuple[Edge, ...]
    corners: tuple[Corner, ...]
    rims: tuple[Rim, ...]
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
    first, second = np.array([edge.facets for edge in vessel.edges])[joined].T
    count = len(vessel.facets)
    _, patch = connected_components(coo_array((np.ones(len(first)), (first, second)), (count, count)), directed=False)
    _, firsts, inverse = np.unique(patch, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(firsts))[inverse]


def _exact(edge: Edge, number: int, borders: Borders) -> Edge:
    """An edge with the exact turn and directions of its walls."""
    if number not in borders.inward:
        return edge
    return Edge(edge.start, edge.end, edge.ends, edge.facets, borders.inward[number], float(borders.turn[number]))


def _directions(vessel: Vessel, borders: Borders) -> dict[int, list[np.ndarray]]:
    """The unit directions of the borders that leave each vertex where a convex one ends."""
    lines = [n for n in np.flatnonzero(borders.turn > CONVEX).tolist() if not borders.is_drawn[n]]
    wanted = {end for number in lines for end in vessel.edges[number].ends}
    for rim, own in zip(borders.rims, borders.rim_ends, strict=True):
        wanted |= set(own.tolist()) if rim.turn > CONVEX else set()
    found: dict[int, list[np.ndarray]] = {}
    for number, edge in enumerate(vessel.edges):
        arc = borders.arcs.get(number)
        for end, point, other in ((0, edge.start, edge.end), (1, edge.end, edge.start)):
            if edge.ends[end] not in wanted:
                continue
            directions = found.setdefault(edge.ends[end], [])
            along = other - point
            if arc:
                tangent = np.cross(arc.axis, point - arc.centre)
                along = tangent if tangent @ along > 0 else -tangent
            if arc or not borders.is_drawn[number]:
                directions.append(along / np.linalg.norm(along))
    return found


def _neighbours(vertices: list[np.ndarray], patch: np.ndarray, is_drawing: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Features.first_neighbour and neighbour, from the numbers of the vertices of each feature."""
    count = len(vertices)
    rows = np.repeat(np.arange(count), [len(own) for own in vertices])
    columns = np.concatenate(vertices)
    kept = ~is_drawing[rows]
    rows, columns = rows[kept], columns[kept]
    touch = coo_array((np.ones(len(rows), dtype=np.int32), (rows, columns)), (count, int(columns.max()) + 1)).tocsr()
    first, second = (touch @ touch.T).nonzero()
    own = (patch[first] == patch[second]) & (first != second)
    order = np.lexsort((second[own], first[own]))
    counts = np.bincount(first[own], minlength=count)
    return np.concatenate([[0], np.cumsum(counts)]), second[own][order].astype(np.int64)


def find_features(vessel: Vessel) -> Features:
    """The features of a body."""
    borders = borders_of(vessel)
    of_facet = facet_patches(vessel, borders.turn)
    numbers = [n for n in np.flatnonzero(borders.turn > CONVEX).tolist() if not borders.is_drawn[n]]
    lines = tuple(_exact(vessel.edges[number], number, borders) for number in numbers)
    ends = _directions(vessel, borders)
    corners = tuple(Corner(vessel.vertices[end], np.array(directions)) for end, directions in ends.items())
    convex = [k for k, rim in enumerate(borders.rims) if rim.turn > CONVEX]

    vertices = [np.unique(np.concatenate(own)) for own in vessel.loops]
    of_vertex = np.empty(len(vessel.vertices), dtype=np.int64)
    for own, patch in zip(vertices, of_facet, strict=True):
        of_vertex[own] = patch
    # A border belongs to the patch of both its walls, and a corner to that of any convex border that ends in it.
    for edge in lines:
        of_vertex[list(edge.ends)] = of_facet[edge.facets[0]]
    of_rim = []
    for k in convex:
        patch = of_facet[borders.rim_facets[k]]
        of_vertex[borders.rim_ends[k]] = patch
        of_rim.append(patch)
    of_curve, curve_vertices = [], []
    for curve in range(len(vessel.curves)):
        pieces = np.flatnonzero(vessel.facet_curves == curve)
        of_curve.append(of_facet[pieces[0]])
        curve_vertices.append(np.unique(np.concatenate([vertices[piece] for piece in pieces])))
    patch = np.array([*of_facet, *(of_facet[e.facets[0]] for e in lines), *of_vertex[list(ends)], *of_curve, *of_rim])
    is_drawing = np.zeros(len(patch), dtype=bool)
    is_drawing[: len(of_facet)] = vessel.facet_curves >= 0
    vertices += [np.unique(edge.ends) for edge in lines] + [np.array([end]) for end in ends] + curve_vertices
    vertices += [borders.rim_vertices[k] for k in convex]
    rims = tuple(borders.rims[k] for k in convex)
    first, neighbour = _neighbours(vertices, patch, is_drawing)
    joint = _joints(vessel, vertices, first, neighbour, len(of_facet) + len(lines) + len(ends))
    return Features(lines, corners, rims, int(of_facet.max()) + 1, patch, is_drawing, first, neighbour, joint)


def _joints(
    vessel: Vessel, vertices: list[np.ndarray], first: np.ndarray, neighbour: np.ndarray, curves_from: int
) -> np.ndarray:
    """Features.joint: between a curve and another wall, by the largest angle of their normals where they meet."""
    curves = range(curves_from, curves_from + len(vessel.curves))
    joint = np.full(len(neighbour), JOINT.by_direction)

    def normals(feature: int, points: np.ndarray) -> np.ndarray:
        if feature in curves:
            return vessel.curves[feature - curves_from].touch(points)[1]
        return np.broadcast_to(vessel.facets[feature].normal, points.shape)

    owner = np.repeat(np.arange(len(first) - 1), np.diff(first))
    for at, (own, other) in enumerate(zip(owner.tolist(), neighbour.tolist(), strict=True)):
        walls = [feature in curves or feature < len(vessel.facets) for feature in (own, other)]
        if all(walls) and (own in curves or other in curves):
            points = vessel.vertices[np.intersect1d(vertices[own], vertices[other])]
            cosine = (normals(own, points) * normals(other, points)).sum(axis=1).min()
            joint[at] = JOINT.smooth if cosine >= math.cos(SMOOTH_TURN) else JOINT.sharp
    return joint


@lru_cache(maxsize=64)
def features_of(vessel: Vessel) -> Features:
    """The features of a body, kept for the bodies used last."""
    return find_features(vessel)
