"""The patches of a wall: facets that make one smooth surface, on which a contact travels.

Facets belong to one patch where they meet in a seam that turns by less than SMOOTH_TURN, or in a convex edge: on a
convex edge the contact's normal turns without a jump, however sharp the edge is. Patches are parted by sharp seams
only. So a patch of a round jar is its mantle, whatever the number of facets, or all of the jar where fillets join
mantle and floor; a lifter is a patch, and so is the shell between two lifters.

In a seam a ball is at two local minima of its distance at once, one on each facet. It is pressed in by `delta` of its
radius R at the nearer one; its foot on the other facet passes the seam while it still overlaps, unless
R (1 - cos turn) > delta. So where the turn is larger than that of the largest overlap, both contacts begin and end
without a jump, and are both there; where it is smaller, two contacts would be cut off while they are pressed, and
would make one wall twice as stiff and damped as it is: there only the nearer one is a contact (dem.contact_events). Its
potential is that of the exact distance, so that it makes and loses no energy.
"""

import math
from typing import NamedTuple

import numpy as np

from millprint.mill.vessel import Edge, Vessel

# A seam of a smaller turn is a joint of facets [rad]: 37 degrees, for overlaps of a fifth of the radius, the largest
# that a run may allow (config.sweep.OVERLAP_LIMIT).
SMOOTH_TURN = math.acos(0.8)


class Patches(NamedTuple):
    """Of the facets, the convex edges, the corners and the curves of a body, in this order."""

    patches: int  # number of them
    patch: tuple[np.ndarray, ...]  # number of each feature's patch
    vertices: tuple[list[np.ndarray], ...]  # numbers of its vertices, ascending
    is_drawing: tuple[np.ndarray, ...]  # whether it only shows a curve and is not a wall itself


def is_joint(vessel: Vessel, edge: Edge) -> bool:
    """Whether an edge is where a curve is cut into facets, or goes over into the next wall: then nothing is there."""
    first, second = (vessel.facet_curves[facet] for facet in edge.facets)
    return max(first, second) >= 0 and (first == second or abs(edge.turn) < SMOOTH_TURN)


def outline_slack(vessel: Vessel) -> np.ndarray:
    """How far each flat facet (f,) reaches beyond its outline [m]: up to the curve of which that draws the border.

    There both walls are listed, and the nearer one is touched.
    """
    slack = np.zeros(len(vessel.facets))
    for edge in vessel.edges:
        curves = [int(vessel.facet_curves[facet]) for facet in edge.facets]
        if not is_joint(vessel, edge) or min(curves) >= 0:
            continue
        flat, curve = edge.facets[int(np.argmin(curves))], vessel.curves[max(curves)]
        _, _, past = curve.touch((edge.start + edge.end)[None] / 2)
        slack[flat] = max(slack[flat], past[0])
    return slack


def _facet_patches(vessel: Vessel) -> np.ndarray:
    """The patch of each facet (f,), numbered in the order of their first facets."""
    neighbours: list[list[int]] = [[] for _ in vessel.facets]
    for edge in vessel.edges:
        if edge.turn > -SMOOTH_TURN or is_joint(vessel, edge):
            first, second = edge.facets
            neighbours[first].append(second)
            neighbours[second].append(first)
    patch = np.full(len(vessel.facets), -1)
    count = 0
    for seed in range(len(patch)):
        if patch[seed] >= 0:
            continue
        patch[seed], front = count, [seed]
        while front:
            beside = [facet for facet in neighbours[front.pop()] if patch[facet] < 0]
            patch[beside] = count
            front += dict.fromkeys(beside)
        count += 1
    return patch


def find_patches(vessel: Vessel) -> Patches:
    """The patches of a body, and the vertices by which its features are neighbours."""
    number = {key: k for k, key in enumerate(vessel.keys(vessel.vertices))}

    def numbers(points: np.ndarray) -> np.ndarray:
        return np.unique([number[key] for key in vessel.keys(points)])

    of_facet = _facet_patches(vessel)
    of_edge = np.array([of_facet[edge.facets[0]] for edge in vessel.convex_edges], dtype=np.int64)
    edge_vertices = [numbers(np.array([edge.start, edge.end])) for edge in vessel.convex_edges]
    # A corner belongs to the patch of any convex edge that ends in it.
    of_vertex = {vertex: patch for ends, patch in zip(edge_vertices, of_edge, strict=True) for vertex in ends}
    corner_vertices = [numbers(corner.point[None]) for corner in vessel.corners]
    of_corner = np.array([of_vertex[ends[0]] for ends in corner_vertices], dtype=np.int64)
    facet_vertices = [numbers(np.concatenate(facet.loops)) for facet in vessel.facets]
    of_curve, curve_vertices = [], []
    for curve in range(len(vessel.curves)):
        pieces = np.flatnonzero(vessel.facet_curves == curve)
        of_curve.append(of_facet[pieces[0]])
        curve_vertices.append(np.unique(np.concatenate([facet_vertices[piece] for piece in pieces])))
    joints = np.array([is_joint(vessel, edge) for edge in vessel.convex_edges], dtype=bool)
    sharp = {end for ends, joint in zip(edge_vertices, joints, strict=True) if not joint for end in ends}
    return Patches(
        int(of_facet.max()) + 1,
        (of_facet, of_edge, of_corner, np.array(of_curve, dtype=np.int64)),
        (facet_vertices, edge_vertices, corner_vertices, curve_vertices),
        (
            vessel.facet_curves >= 0,
            joints,
            np.array([ends[0] not in sharp for ends in corner_vertices], dtype=bool),
            np.zeros(len(vessel.curves), dtype=bool),
        ),
    )
