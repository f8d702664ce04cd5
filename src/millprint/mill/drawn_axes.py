"""Axes about which a drawing may turn: of round outlines of flat facets, of strips, of bands and of whole patches."""

import math
from collections.abc import Iterator

import numpy as np

from millprint.mill.outlines import Ragged, cross, lengths, plane_axes
from millprint.mill.surfaces_about import FEWEST_STEPS
from millprint.mill.turned_shapes import (
    LARGEST_TURN,
    LOOSE,
    SMALLEST_TURN,
    Axis,
    Circle,
    Drawing,
    Swept,
    circles_through,
)

# An axis or a sphere is guessed from this number of facets at most.
AROUND = 12
# Facets of a strip are along its axis to this sine; steps of the normals of a band are alike to this share, and turn by
# this share of a step's square at least.
ALONG, ALIKE, LEAST_BEND = 1e-2, 0.05, 1e-3
# Facets of more corners together do not begin a band.
MANY = 24
# The axis of a patch is fitted this number of times, each time with less weight on what is far off.
REWEIGHTED = 5


def _arc_from(flat: np.ndarray, near: float) -> int:
    """How many of the first points (n, 2) lie on one circle, to within `near` [m]: by doubling, then halving.

    A circle through a few points of a fine outline would be made by their rounding.
    """

    def fits(count: int) -> bool:
        return bool(np.abs(Circle.through(flat[:count]).off(flat[:count])).max() < near)

    good, bad = min(3, len(flat)), len(flat) + 1
    while good < len(flat) and bad > len(flat):
        more = min(2 * good, len(flat))
        good, bad = (more, bad) if fits(more) else (good, more)
    while bad - good > 1 and good < len(flat):
        middle = (good + bad) // 2
        good, bad = (middle, bad) if fits(middle) else (good, middle)
    return good


def _arcs_of_outline(flat: np.ndarray, tolerance: float) -> list[np.ndarray]:
    """Groups of points of an outline (k, 2) that lie on one circle in shallow steps, also where others interrupt it.

    tolerance: what points may be off [m].
    """
    first, second = flat - np.roll(flat, 1, axis=0), np.roll(flat, -1, axis=0) - flat
    turn = np.arctan2(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0], (first * second).sum(axis=1))
    is_shallow = (np.abs(turn) > SMALLEST_TURN) & (np.abs(turn) < 2 * LARGEST_TURN)
    # Begin where no arc can go on.
    start = int(np.argmin(is_shallow))
    flat, is_shallow = np.roll(flat, -start, axis=0), np.roll(is_shallow, -start)
    breaks = np.flatnonzero(np.diff(is_shallow.astype(int), prepend=0, append=0))
    groups: list[np.ndarray] = []
    for begin, end in breaks.reshape(-1, 2).tolist():
        while begin < end:
            stop = begin + _arc_from(flat[begin:end], 2 * tolerance)
            own, begin = flat[begin:stop], stop
            known = (k for k, group in enumerate(groups) if _on_circle_of(group, own, LOOSE * tolerance))
            if (number := next(known, None)) is None:
                groups.append(own)
            else:
                groups[number] = np.concatenate([groups[number], own])
    return [group for group in groups if len(group) >= FEWEST_STEPS]


def _on_circle_of(group: np.ndarray, points: np.ndarray, near: float) -> bool:
    return len(group) >= FEWEST_STEPS and bool(np.abs(Circle.through(group).off(points)).max() < near)


def axes_of_outlines(drawing: Drawing) -> list[Axis]:
    """The axes of the round outlines of flat facets, those of large circles first."""
    found = []
    vessel, near = drawing.vessel, LOOSE * drawing.tolerance
    loops, facet_of = vessel.outlines.loops, vessel.outlines.facets.owner
    for loop in np.flatnonzero(loops.counts > FEWEST_STEPS).tolist():
        facet, own = facet_of[loop], slice(loops.first[loop], loops.first[loop] + loops.counts[loop])
        first, second = vessel.axes[facet]
        for flat in _arcs_of_outline(vessel.outlines.points[own] @ vessel.axes[facet].T, drawing.tolerance):
            circle = Circle.through(flat)
            if np.abs(circle.off(flat)).max() < near:
                normal = vessel.normals[facet]
                origin = circle.r * first + circle.z * second + vessel.offsets[facet] * normal
                found.append((circle.radius, Axis(origin, normal)))
    return [axis for _, axis in sorted(found, key=lambda each: -each[0])]


def axes_of_patches(drawing: Drawing) -> Iterator[Axis]:
    """The axis of each patch of free facets that turns about one as a whole, largest first.

    The normals n of such a wall at x all meet its axis, c . (x x n) + m . n = 0 for its direction c and moment m: the
    least eigenvector of a linear line complex (Pottmann and Randrup 1998). A prism and a sphere have more than one.
    """
    middle, size = drawing.vessel.vertices.mean(axis=0), drawing.vessel.size
    bent = np.zeros(len(drawing.taken), dtype=bool)
    bent[drawing.seams] = True
    for own in sorted(drawing.pieces(np.flatnonzero(bent & ~drawing.taken)), key=len, reverse=True):
        if len(own) < FEWEST_STEPS**2:
            break
        normals = drawing.normals[own]
        lines = np.hstack([cross((drawing.middles[own] - middle) / size, normals), normals])
        weights = drawing.vessel.areas[own] / drawing.vessel.areas[own].mean()
        for _ in range(REWEIGHTED):
            values, vectors = np.linalg.eigh(lines.T @ (weights[:, None] * lines) / weights.sum())
            off = np.abs(lines @ vectors[:, 0])
            weights = drawing.vessel.areas[own] / np.maximum(off, max(float(np.median(off)), 1e-12)) ** 2
        along, moment = vectors[:3, 0], vectors[3:, 0]
        length = np.linalg.norm(along)
        # How far off the axis may be by the scatter of the lines.
        error = size * math.sqrt(max(values[0], 0.0) / (len(own) * max(values[1], 1e-30)))
        if length > 1e-3 and error < LOOSE * drawing.tolerance:
            along = along / length
            yield Axis(middle + size * np.cross(along, moment / length), along)


def axis_of_strip(drawing: Drawing, pair: tuple[int, int]) -> Axis | None:
    """The axis of the cylinder through two facets next to each other, if their neighbours lie on it."""
    normals = drawing.normals[list(pair)]
    along = np.cross(*normals)
    along /= np.linalg.norm(along)
    axis = Axis(np.zeros(3), along)
    sides = np.array([axis.u, axis.v]).T
    circle = Circle.through(drawing.points(pair) @ sides)
    # All over the body such an arc would be a line, within the file's rounding.
    if circle.radius > drawing.vessel.size**2 / (8 * drawing.tolerance):
        return None
    around = drawing.around(pair, AROUND)
    near = [
        facet
        for facet in around
        if abs(drawing.normals[facet] @ along) < ALONG
        and np.abs(circle.off(drawing.points([facet]) @ sides)).max() < LOOSE * drawing.tolerance
    ]
    # Fewer where other walls interrupt the strip.
    if len(near) < (FEWEST_STEPS if len(around) == AROUND else 3):
        return None
    circle = Circle.through(drawing.points(near) @ sides)
    return Axis(circle.r * axis.u + circle.z * axis.v, along)


def axis_of_band(drawing: Drawing, pair: tuple[int, int]) -> Axis | None:
    """The axis about which two facets next to each other and a third one turn, as those of a band around a cone do.

    Their normals are at one angle to it, so that their differences are across it; vertices at one height lie on a
    circle about it.
    """
    first, second = pair
    step = drawing.normals[second] - drawing.normals[first]
    for third in drawing.neighbours[second]:
        following = drawing.normals[third] - drawing.normals[second]
        along = np.cross(step, following)
        length = np.linalg.norm(along)
        alike = abs(np.linalg.norm(following) - np.linalg.norm(step)) < ALIKE * np.linalg.norm(step)
        if third == first or drawing.taken[third] or not alike or length < LEAST_BEND * np.linalg.norm(step) ** 2:
            continue
        axis = Axis(np.zeros(3), along / length)
        points = drawing.points([first, second, third])
        heights = points @ axis.along
        level = np.abs(heights[:, None] - heights) < LOOSE * drawing.tolerance
        ring = points[level[np.argmax(level.sum(axis=1))]]
        if len(ring) < 4:
            continue
        flat = ring @ np.array([axis.u, axis.v]).T
        circle = Circle.through(flat)
        if np.abs(circle.off(flat)).max() < drawing.tolerance and circle.radius < drawing.vessel.size:
            return Axis(circle.r * axis.u + circle.z * axis.v, axis.along)
    return None


def same_axis(axis: Axis, known: list[Axis], near: float, size: float) -> bool:
    """Whether an axis is one of the known ones, within what places may be off [m]."""
    return any(
        np.linalg.norm(np.cross(axis.along, other.along)) * size < LOOSE * near
        and np.linalg.norm(np.cross(axis.origin - other.origin, other.along)) < LOOSE * near
        for other in known
    )


def normals_next_to(drawing: Drawing, swept: list[Swept]) -> list[np.ndarray]:
    """The normals of the flat facets with more than four corners that meet some surfaces: the ends of a prism."""
    is_own = np.zeros(len(drawing.taken), dtype=bool)
    is_own[np.concatenate([each.facets for each in swept])] = True
    others = drawing.across(is_own)
    return list(drawing.normals[others[~drawing.taken[others] & (drawing.corners.counts[others] > 4)]])


def may_turn_at_seams(drawing: Drawing) -> np.ndarray:
    """Whether an axis may begin at each seam (s,), or at one next to it: what `_best_axis` needs at least."""
    free = np.flatnonzero(~drawing.taken)
    first = np.repeat(free, drawing.beside.counts[free])
    second = drawing.beside_facet[drawing.beside.rows(free)]
    kept = ~drawing.taken[second]
    first, second = first[kept], second[kept]
    # Each pair with every neighbour of its second facet.
    pair = np.repeat(np.arange(len(first)), drawing.beside.counts[second])
    third = drawing.beside_facet[drawing.beside.rows(second)]
    kept = ~drawing.taken[third] & (third != first[pair])
    pair, third = pair[kept], third[kept]
    holds = _on_strip(drawing, first, second, pair, third) | _on_band(drawing, first[pair], second[pair], third)
    is_begun = np.zeros(len(drawing.taken), dtype=bool)
    is_begun[first[pair[holds]]] = is_begun[second[pair[holds]]] = True
    return is_begun[drawing.seams].any(axis=1)


def _on_strip(
    drawing: Drawing, first: np.ndarray, second: np.ndarray, pair: np.ndarray, third: np.ndarray
) -> np.ndarray:
    """Whether a third facet lies on the cylinder through a pair of facets: see `axis_of_strip`."""
    along = cross(drawing.normals[first], drawing.normals[second])
    along /= np.maximum(lengths(along), 1e-300)
    axes = plane_axes(along)
    both = np.column_stack([first, second]).ravel()
    own = Ragged(drawing.corners.counts[both].reshape(-1, 2).sum(axis=1))
    points = drawing.vessel.vertices[drawing.flat[drawing.corners.rows(both)]]

    centre, radius = np.empty((len(first), 2)), np.empty(len(first))
    middle = np.add.reduceat(points, own.first) / own.counts[:, None]
    flat = np.vecdot(axes[own.owner], (points - middle[own.owner])[:, None])
    for groups, rows in own.stacks():
        u, v = flat[rows].transpose(2, 1, 0)
        *middles, radius[groups] = circles_through(u, v, np.ones(u.shape))
        centre[groups] = np.column_stack(middles)
    holds = np.abs(np.vecdot(drawing.normals[third], along[pair])) < ALONG
    pair, third = pair[holds], third[holds]
    of_third = Ragged(drawing.corners.counts[third])
    pair = np.repeat(pair, of_third.counts)
    points = drawing.vessel.vertices[drawing.flat[drawing.corners.rows(third)]]
    flat = np.vecdot(axes[pair], (points - middle[pair])[:, None]) - centre[pair]
    off = np.abs(np.hypot(*flat.T) - radius[pair])
    holds[holds] = np.maximum.reduceat(off, of_third.first) < LOOSE * drawing.tolerance if len(third) else False
    return holds


def _on_band(drawing: Drawing, first: np.ndarray, second: np.ndarray, third: np.ndarray) -> np.ndarray:
    """Whether three facets may follow each other in a band about an axis: see `axis_of_band`."""
    step, following = (drawing.normals[b] - drawing.normals[a] for a, b in ((first, second), (second, third)))
    long, along = lengths(step)[:, 0], cross(step, following)
    length = lengths(along)[:, 0]
    holds = (np.abs(lengths(following)[:, 0] - long) < ALIKE * long) & (length >= LEAST_BEND * long**2)
    holds &= drawing.corners.counts[first] + drawing.corners.counts[second] + drawing.corners.counts[third] <= MANY
    kept = np.flatnonzero(holds)
    facets = np.column_stack([first, second, third])[kept]
    own = Ragged(drawing.corners.counts[facets].sum(axis=1))
    vertices = drawing.flat[drawing.corners.rows(facets.ravel())]
    heights = np.vecdot(drawing.vessel.vertices[vertices], (along / length[:, None])[kept][own.owner])
    for groups, rows in own.stacks():
        number, height = vertices[rows], heights[rows]
        level = np.zeros((len(groups), rows.shape[1]), dtype=np.int64)
        is_first = np.ones(rows.shape, dtype=bool)
        for k in range(1, rows.shape[1]):
            is_first[:, k] = (number[:, :k] != number[:, k : k + 1]).all(axis=1)
        for k in range(rows.shape[1]):
            near = np.abs(height - height[:, k : k + 1]) < LOOSE * drawing.tolerance
            level[:, k] = (near & is_first).sum(axis=1)
        holds[kept[groups]] = level.max(axis=1) > 3
    return holds
