"""Cylinders, cones, spheres and tori found again in a mesh, of which a program for drawing had made facets.

Such programs put the vertices of the triangles on the surface itself, to the digits of the file. So vertices decide,
and not the directions of triangles, which may be slanted. Axes come from round outlines of flat facets and from facets
that meet along a line; about each axis, the vertices are points of a half plane (distance from the axis, height), and a
surface is a line or an arc there. Spheres are also found without an axis. What is found is fitted, made tangent where
it is so within the file's rounding (mill.tangency), and the vertices are put where the exact surfaces meet.

A patch (mill.wall_features) is exact as a whole, or flat as a whole: where a recognised surface would end at drawn
facets, and not in a line or circle, a ball would meet a step there, so that the whole patch stays as it is drawn.
"""

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from millprint.mill.curved_surfaces import Curve
from millprint.mill.exact_walls import curves_of, whole_patches
from millprint.mill.tangency import make_tangent
from millprint.mill.turned_shapes import (
    LARGEST_TURN,
    LOOSE,
    SMALLEST_TURN,
    Axis,
    Circle,
    Drawing,
    Line,
    Swept,
    circles_through,
)
from millprint.mill.vessel import Ragged, Vessel, cross, lengths, plane_axes
from millprint.mill.wall_words import round_facets

# Four points may lie on one circle by chance of symmetry; this number of steps around or across does not.
FEWEST_STEPS = 5
# The circle of a longer outline is fitted again as it doubles.
FEW_POINTS = 8
# How far the middle of a facet is below its surface, over the radii, where it is drawn in steps of LARGEST_TURN.
SAG = 1.3 * (1 - math.cos(LARGEST_TURN / 2))
# Seeds that lead nowhere, after which the search about one axis, or for one kind, ends; the first ones in a row.
MOST_FAILURES, FIRST_FAILURES = 300, 20
# An axis or a sphere is guessed from this number of facets at most.
AROUND = 12
# So many of the next facets lie on a surface where it begins, if nothing interrupts it.
NEAR, FEWEST_NEAR = 100, 6
# To name a place of a lattice by one number.
PRIMES = 73856093, 19349663
# The largest radius of a wall, over the size of the body.
LARGEST_RADIUS = 200
# Directions that differ by less may be one, if the vertices allow it [rad].
NEARLY = 0.02
# Facets of a strip are along its axis to this sine; steps of the normals of a band are alike to this share, and turn by
# this share of a step's square at least.
ALONG, ALIKE, LEAST_BEND = 1e-2, 0.05, 1e-3
# Facets of more corners together do not begin a band.
MANY = 24


def _arcs_of_outline(flat: np.ndarray, near: float) -> list[np.ndarray]:
    """Groups of points of an outline (k, 2) that lie on one circle in shallow steps, also where others interrupt it.

    near: what points may be off [m].
    """
    before, after = np.roll(flat, 1, axis=0), np.roll(flat, -1, axis=0)
    first, second = flat - before, after - flat
    turn = np.arctan2(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0], (first * second).sum(axis=1))
    groups: list[list[int]] = []
    circles: list[Circle] = []
    for k in np.flatnonzero((np.abs(turn) > SMALLEST_TURN) & (np.abs(turn) < 2 * LARGEST_TURN)).tolist():
        own = np.array([before[k], flat[k], after[k]])
        known = next((n for n, circle in enumerate(circles) if np.abs(circle.off(own)).max() < near), None)
        if known is None:
            groups.append([k])
            circles.append(Circle.through(own))
        else:
            groups[known].append(k)
            # Fitted again as it grows, and not at each point of a long outline.
            size = len(groups[known])
            if size > 2 and (size < FEW_POINTS or size & (size - 1) == 0):
                circles[known] = Circle.through(flat[groups[known]])
    return [flat[group] for group in groups if len(group) >= FEWEST_STEPS]


def _axes_of_outlines(drawing: Drawing) -> list[Axis]:
    """The axes of the round outlines of flat facets, those of large circles first."""
    found = []
    vessel, near = drawing.vessel, LOOSE * drawing.tolerance
    loops, facet_of = vessel.outlines.loops, vessel.outlines.facets.owner
    for loop in np.flatnonzero(loops.counts > FEWEST_STEPS).tolist():
        facet, own = facet_of[loop], slice(loops.first[loop], loops.first[loop] + loops.counts[loop])
        first, second = vessel.axes[facet]
        for flat in _arcs_of_outline(vessel.outlines.points[own] @ vessel.axes[facet].T, near):
            circle = Circle.through(flat)
            if np.abs(circle.off(flat)).max() < near:
                normal = vessel.normals[facet]
                origin = circle.r * first + circle.z * second + vessel.offsets[facet] * normal
                found.append((circle.radius, Axis(origin, normal)))
    return [axis for _, axis in sorted(found, key=lambda each: -each[0])]


def _axis_of_strip(drawing: Drawing, pair: tuple[int, int]) -> Axis | None:
    """The axis of the cylinder through two facets next to each other, if their neighbours lie on it."""
    normals = drawing.normals[list(pair)]
    along = np.cross(*normals)
    along /= np.linalg.norm(along)
    axis = Axis(np.zeros(3), along)
    sides = np.array([axis.u, axis.v]).T
    circle = Circle.through(drawing.points(pair) @ sides)
    if circle.radius > LARGEST_RADIUS * drawing.vessel.size:
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


def _axis_of_band(drawing: Drawing, pair: tuple[int, int]) -> Axis | None:
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


class _HalfPlane:
    """Facets of a drawing, all or some, in the half plane about an axis.

    vertices: the numbers of their vertices; flat: these in the half plane; corners: the rows of `flat` at the facets'
    corners; middles and facing (f, 2): the facets' middles and normals; is_ring (f,): whether all vertices are one.
    """

    def __init__(self, drawing: Drawing, axis: Axis, facets: np.ndarray | None = None) -> None:
        self.axis, self.facets, self.of_facet = axis, np.arange(len(drawing.taken)), drawing.corners
        self.vertices, self.corners = np.arange(len(drawing.vessel.vertices)), drawing.flat
        if facets is not None:
            self.facets, self.of_facet = facets, Ragged(drawing.corners.counts[facets])
            self.vertices, self.corners = np.unique(drawing.flat[drawing.corners.rows(facets)], return_inverse=True)
        points = drawing.middles[self.facets]
        self.flat, self.middles = axis.meridian(drawing.vessel.vertices[self.vertices]), axis.meridian(points)
        self.near = LOOSE * drawing.tolerance
        self.is_ring = np.maximum(*(self.largest(each) + self.largest(-each) for each in self.flat.T)) < self.near
        outwards = points - axis.origin - np.outer(self.middles[:, 1], axis.along)
        outwards /= np.maximum(self.middles[:, :1], 1e-12)
        normals = drawing.normals[self.facets]
        self.facing = np.column_stack([np.vecdot(normals, outwards), normals @ axis.along])

    def largest(self, values: np.ndarray) -> np.ndarray:
        """For each facet (f,) the largest of what its vertices (v,) have."""
        return np.maximum.reduceat(values[self.corners], self.of_facet.first)

    def fit(
        self, drawing: Drawing, seed: Sequence[int], kind: type[Line] | type[Circle]
    ) -> tuple[Line | Circle, np.ndarray] | None:
        """The line or arc through the vertices of two rows of `facets`, and all rows on it; None if these are not."""
        free = ~drawing.taken[self.facets] & ~self.is_ring
        # The first slack may take a wall that turns by little against this one, and spoil the fit.
        for slacks in ((LOOSE, 2.0, 1.0, 1.0), (1.0, 1.0, 1.0)):
            rows = np.asarray(seed)
            for slack in slacks:
                own = self.flat[np.unique(self.corners[self.of_facet.rows(rows)])]
                shape = kind.through(own)
                if isinstance(shape, Circle) and abs(shape.r) < self.near:
                    shape.r = 0.0
                    shape.z, shape.radius = _on_axis_circle(own)
                # A floor has its outline, a ring, on the fillet that it joins.
                sag = self.middles[:, 0] + (shape.radius if isinstance(shape, Circle) else 0.0)
                holds = free & (self.largest(np.abs(shape.off(self.flat))) <= slack * drawing.tolerance)
                holds &= np.abs(shape.off(self.middles)) <= SAG * sag + drawing.tolerance
                facing = np.vecdot(self.facing, _slopes(shape, self.middles))
                holds &= facing * facing[seed[0]] > 0.5
                if not holds[list(seed)].any():
                    break
                rows = np.flatnonzero(holds)
            else:
                return shape, rows
        return None

    def rings(self, drawing: Drawing) -> tuple[np.ndarray, np.ndarray]:
        """How many different places the vertices at each seam (s,) have; and a number for these.

        None where a facet is taken or does not face the axis, where all places are one, or where more than two are on
        no circle. Two where they are on a line that is longer than an arc may be that looks straight: a mantle with a
        port has vertices at many heights. Seams between the same rings have one number.
        """
        counts, names = np.zeros(len(drawing.seams), dtype=np.int64), np.zeros(len(drawing.seams), dtype=np.int64)
        apart = 4 * drawing.tolerance
        # A plane through points about an axis faces it from between them.
        points = drawing.middles - self.axis.origin
        around = cross(np.broadcast_to(self.axis.along, points.shape), points)
        around /= np.maximum(lengths(around), 1e-12)
        away = drawing.vessel.vertices[self.corners] - drawing.middles[drawing.corners.owner]
        aside = np.abs(np.vecdot(away, around[drawing.corners.owner]))
        width = np.maximum.reduceat(aside, drawing.corners.first) / np.maximum(self.middles[:, 0], 1e-12)
        is_free = ~drawing.taken & (np.abs(np.vecdot(drawing.normals, around)) < width + NEARLY)
        is_open = is_free[drawing.seams].all(axis=1)
        for every, all_vertices in drawing.seam_vertices:
            seams, vertices = every[is_open[every]], all_vertices[:, is_open[every]]
            r, z = self.flat[:, 0][vertices], self.flat[:, 1][vertices]
            is_new = np.ones(vertices.shape, dtype=bool)
            for k in range(1, len(vertices)):
                for known in range(k):
                    is_same = (np.abs(r[known] - r[k]) <= apart) & (np.abs(z[known] - z[k]) <= apart)
                    is_new[k] &= ~(is_same & is_new[known])
            middle_r, middle_z, radius = circles_through(r, z, is_new)
            off = np.abs(np.hypot(r - middle_r, z - middle_z) - radius).max(axis=0)
            number = is_new.sum(axis=0)
            is_one = np.maximum(np.ptp(r, axis=0), np.ptp(z, axis=0)) < self.near
            extent = np.hypot(np.ptp(r, axis=0), np.ptp(z, axis=0))
            along = np.array([r - r.mean(axis=0), z - z.mean(axis=0)])
            a, b, c = (along[0] ** 2).sum(axis=0), (along[0] * along[1]).sum(axis=0), (along[1] ** 2).sum(axis=0)
            is_line = np.sqrt(np.maximum(a + c - np.hypot(a - c, 2 * b), 0) / 2) <= drawing.tolerance
            is_line &= extent > math.sqrt(8 * drawing.vessel.size * drawing.tolerance)
            number = np.where(is_line, np.minimum(number, 2), number)
            counts[seams] = np.where(~is_one & ((number < 3) | (off <= 2 * drawing.tolerance)), number, 0)
            row, column = (np.round(each / apart).astype(np.int64) for each in (r, z))
            names[seams] = (((row * PRIMES[0]) ^ (column * PRIMES[1])) * is_new).sum(axis=0)
        return counts, names


def _fitted(drawing: Drawing, plane: _HalfPlane, seed: Sequence[int], kind: type[Line] | type[Circle]) -> list[Swept]:
    """The surface about an axis that begins with two facets, each of whose vertices lies on it.

    Its pieces, where other walls interrupt it; nothing where there is too little of it.
    """
    found = plane.fit(drawing, seed, kind) if _begins(drawing, plane.axis, seed, (kind,)) else None
    if found is None or not _is_enough(drawing, Swept(plane.axis, *found)):
        return []
    return [Swept(plane.axis, found[0], piece) for piece in drawing.pieces(found[1])]


def _begins(
    drawing: Drawing, axis: Axis, seam: Sequence[int], kinds: Sequence[type[Line] | type[Circle]] = (Circle, Line)
) -> bool:
    """Whether a surface about an axis begins at a seam, as far as the facets near it show."""
    plane = _HalfPlane(drawing, axis, np.array(drawing.around(seam, NEAR)))
    found = [plane.fit(drawing, (0, 1), kind) for kind in kinds]
    # Where other walls interrupt a surface, there are few of it.
    least = FEWEST_NEAR if len(plane.facets) == NEAR else 1
    return any(fit is not None and len(fit[1]) >= least for fit in found)


def _slopes(shape: Line | Circle, flat: np.ndarray) -> np.ndarray:
    """Unit normals (n, 2) of a line or circle at points (n, 2) near it."""
    if isinstance(shape, Line):
        return np.broadcast_to([math.cos(shape.angle), math.sin(shape.angle)], flat.shape)
    away = flat - [shape.r, shape.z]
    return away / np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-12)


def _on_axis_circle(flat: np.ndarray) -> tuple[float, float]:
    """Height of the middle on the axis, and radius, of the circle nearest to points (n, 2)."""
    middle = flat[:, 1].mean()
    local = flat[:, 1] - middle
    columns = np.column_stack([2 * local, np.ones(len(local))])
    solution, *_ = np.linalg.lstsq(columns, (flat[:, 0] ** 2 + local**2), rcond=None)
    return float(solution[0] + middle), math.sqrt(max(solution[1] + solution[0] ** 2, 0.0))


def _steps(drawing: Drawing, swept: Swept) -> tuple[int, int]:
    """How many different places the vertices of a surface have around the axis, and along its line or arc."""
    points = drawing.points(swept.facets)
    flat, angles = swept.axis.meridian(points), swept.axis.angles(points)
    off_axis = flat[:, 0] > LOOSE * drawing.tolerance
    around = _count(angles[off_axis] * flat[off_axis, 0].max(initial=0.0), 4 * drawing.tolerance)
    shape = swept.shape
    along = flat @ [-math.sin(shape.angle), math.cos(shape.angle)] if isinstance(shape, Line) else shape.along(flat)
    return around, _count(along, 4 * drawing.tolerance)


def _count(values: np.ndarray, apart: float) -> int:
    """How many different ones there are of some values (n,) that are the same if they are not farther apart."""
    return 1 + int((np.diff(np.sort(values)) > apart).sum()) if len(values) else 0


def _is_enough(drawing: Drawing, swept: Swept) -> bool:
    around, across = _steps(drawing, swept)
    if isinstance(swept.shape, Line):
        # A plane across the axis is flat by itself.
        return around > FEWEST_STEPS and abs(math.cos(swept.shape.angle)) > 1e-4
    # A mantle with a port has vertices at many heights, which are also on an arc of a huge radius.
    flat = swept.axis.meridian(drawing.points(swept.facets))
    if np.abs(Line.through(flat).off(flat)).max() <= drawing.tolerance:
        return False
    # Three columns of a wall that is bent both ways seem to turn about an axis across it too, and one row of facets
    # about any axis that is slanted.
    return across > FEWEST_STEPS and around > FEWEST_STEPS and len(swept.facets) >= FEWEST_STEPS**2


def _about(drawing: Drawing, plane: _HalfPlane) -> list[Swept]:
    """The surfaces about an axis: arcs first, since each of their steps is a line too; their facets are taken."""
    found: list[Swept] = []
    counts, names = plane.rings(drawing)
    for kind, fits in ((Circle, counts > 2), (Line, (counts == 1) | (counts == 2))):
        # All pairs between the same rings fail alike; an axis about which nothing begins soon is none.
        failed: set[int] = set()
        seams = np.flatnonzero(fits & ~drawing.taken[drawing.seams].any(axis=1))
        for pair, name in zip(drawing.seams[seams].tolist(), names[seams].tolist(), strict=True):
            if len(failed) > (MOST_FAILURES if found else FIRST_FAILURES):
                break
            if name in failed or drawing.taken[pair[0]] or drawing.taken[pair[1]]:
                continue
            own = plane.flat[np.concatenate([drawing.vertices_of[facet] for facet in pair])]
            pieces = []
            if np.abs(kind.through(_different(own, drawing.tolerance)).off(own)).max() <= drawing.tolerance:
                pieces = _fitted(drawing, plane, pair, kind)
            if not pieces:
                failed.add(name)
            for piece in pieces:
                drawing.taken[piece.facets] = True
                found.append(piece)
    return found


def _different(flat: np.ndarray, tolerance: float) -> np.ndarray:
    """The different ones of a few points (n, 2), within a tolerance."""
    kept: list[np.ndarray] = []
    for point in flat:
        if all(np.abs(point - other).max() > 4 * tolerance for other in kept):
            kept.append(point)
    return np.array(kept)


def _sphere(points: np.ndarray) -> tuple[np.ndarray, float]:
    """Middle and radius of the sphere nearest to points (n, 3), by linear least squares."""
    shift = points.mean(axis=0)
    local = points - shift
    columns = np.column_stack([2 * local, np.ones(len(local))])
    solution, *_ = np.linalg.lstsq(columns, (local**2).sum(axis=1), rcond=None)
    return solution[:3] + shift, math.sqrt(max(solution[3] + solution[:3] @ solution[:3], 0.0))


def _spheres(drawing: Drawing) -> list[Swept]:
    """Spheres without a known axis."""
    found, failures = [], 0
    for pair in drawing.seams.tolist():
        if failures > MOST_FAILURES:
            break
        if drawing.taken[pair[0]] or drawing.taken[pair[1]]:
            continue
        facets, slack = np.array(drawing.around(pair, AROUND)), LOOSE
        for slack in (LOOSE, 2.0, 1.0, 1.0):
            if len(facets) < 8:
                break
            middle, radius = _sphere(drawing.points(facets))
            begin = drawing.vessel.vertices[drawing.vertices_of[pair[0]]]
            worst = np.abs(np.linalg.norm(begin - middle, axis=1) - radius).max()
            if radius > drawing.vessel.size or worst > slack * drawing.tolerance:
                facets = facets[:0]
                break
            off = np.linalg.norm(drawing.vessel.vertices - middle, axis=1) - radius
            sunk = radius - np.linalg.norm(drawing.middles - middle, axis=1)
            worst_of = np.maximum.reduceat(np.abs(off)[drawing.flat], drawing.corners.first)
            holds = (worst_of <= slack * drawing.tolerance) & (sunk <= 2 * SAG * radius + drawing.tolerance)
            facets = drawing.grown(pair, holds)
        if len(facets) < 16 or not _is_round(drawing, facets, middle):
            failures += 1
            continue
        drawing.taken[facets] = True
        found.append(Swept(Axis(middle, np.array([0.0, 0.0, 1.0])), Circle(0.0, 0.0, radius), facets))
    return found


def _is_round(drawing: Drawing, facets: np.ndarray, middle: np.ndarray) -> bool:
    """Whether vertices on a sphere lie on more than two parallel circles of it: any two have a sphere through them."""
    out = drawing.points(facets) - middle
    _, _, directions = np.linalg.svd(out - out.mean(axis=0), full_matrices=False)
    return min(_count(out @ each, LOOSE * drawing.tolerance) for each in directions) > FEWEST_STEPS


def _same_axis(axis: Axis, known: list[Axis], near: float, size: float) -> bool:
    """Whether an axis is one of the known ones, within what places may be off [m]."""
    return any(
        np.linalg.norm(np.cross(axis.along, other.along)) * size < LOOSE * near
        and np.linalg.norm(np.cross(axis.origin - other.origin, other.along)) < LOOSE * near
        for other in known
    )


def _refined(drawing: Drawing, axis: Axis, swept: list[Swept], known: list[np.ndarray]) -> Axis:
    """The axis about which surfaces are nearest to their vertices.

    One along a side of the frame, or along one of some known directions (3,), if the vertices allow it. Spheres about
    one middle allow any direction, and keep it.
    """
    middles = [each.shape.z for each in swept if isinstance(each.shape, Circle) and each.shape.r == 0.0]
    if len(middles) == len(swept) and np.ptp(middles) < LOOSE * drawing.tolerance:
        return Axis(_sphere(drawing.points(max(swept, key=lambda each: len(each.facets)).facets))[0], axis.along)
    from scipy.optimize import least_squares  # takes long to import, and few mills need it

    rows = [drawing.points(each.facets)[:2000] for each in swept]

    def moved(shift: np.ndarray) -> Axis:
        along = axis.along + shift[0] * axis.u + shift[1] * axis.v
        origin = axis.origin + drawing.vessel.size * (shift[2] * axis.u + shift[3] * axis.v)
        return Axis(origin, along / np.linalg.norm(along))

    def off(now: Axis) -> np.ndarray:
        """How far vertices are from surfaces about an axis, from cylinders where these may be; in tolerances."""
        found = []
        for each, points in zip(swept, rows, strict=True):
            flat = now.meridian(points)
            shape = type(each.shape).through(flat)
            level = Line(0.0, float(flat[:, 0].mean()))
            if isinstance(shape, Line) and np.abs(level.off(flat)).max() <= 2 * drawing.tolerance:
                shape = level
            found.append(shape.off(flat) / drawing.tolerance)
        return np.concatenate(found)

    best = moved(least_squares(lambda shift: off(moved(shift)), np.zeros(4), method="lm", diff_step=1e-7).x)
    if np.abs(off(best)).max() > 1:
        return axis
    side = np.argmax(np.abs(best.along))
    exact = np.eye(3)[side] * np.sign(best.along[side])
    for along in (exact, *known):
        if np.linalg.norm(np.cross(best.along, along)) > NEARLY:
            continue
        level = Axis(best.origin, along * np.sign(along @ best.along))

        def placed(shift: np.ndarray, level: Axis = level) -> Axis:
            return Axis(level.origin + drawing.vessel.size * (shift[0] * level.u + shift[1] * level.v), level.along)

        again = placed(least_squares(lambda s, to=placed: off(to(s)), np.zeros(2), method="lm", diff_step=1e-7).x)
        if np.abs(off(again)).max() <= 1:
            return again
    return best


def _normals_next_to(drawing: Drawing, swept: list[Swept]) -> list[np.ndarray]:
    """The normals of the flat facets with more than four corners that meet some surfaces: the ends of a prism."""
    is_own = np.zeros(len(drawing.taken), dtype=bool)
    is_own[np.concatenate([each.facets for each in swept])] = True
    others = drawing.across(is_own)
    return list(drawing.normals[others[~drawing.taken[others] & (drawing.corners.counts[others] > 4)]])


def _best_axis(drawing: Drawing, pair: tuple[int, int]) -> Axis | None:
    """Of the axes about which facets at a seam may turn, the one whose surfaces have the most facets.

    A wall that is bent both ways is nearly one about an axis across it too, for a few facets.
    """
    seams = [pair, *((first, other) for first in pair for other in drawing.neighbours[first] if other not in pair)]
    best, most = None, 0
    tried: list[Axis] = []
    for seam in seams[:9]:
        for axis_of in (_axis_of_strip, _axis_of_band):
            axis = None if drawing.taken[list(seam)].any() else axis_of(drawing, seam)
            if axis is None or _same_axis(axis, tried, drawing.tolerance, drawing.vessel.size):
                continue
            if not _begins(drawing, axis, seam):
                continue
            swept = _about(drawing, _HalfPlane(drawing, axis))
            count = sum(len(each.facets) for each in swept)
            for each in swept:
                drawing.taken[each.facets] = False
            tried.append(axis)
            if count > most:
                best, most = axis, count
    return best


def find_surfaces(drawing: Drawing) -> list[Swept]:
    """The surfaces of a drawing; their facets are taken."""
    found: list[Swept] = []
    known: list[Axis] = []

    def take(axis: Axis) -> None:
        if _same_axis(axis, known, drawing.tolerance, drawing.vessel.size):
            return
        swept = _about(drawing, _HalfPlane(drawing, axis))
        if swept:
            refined = _refined(
                drawing, axis, swept, [*(other.along for other in known), *_normals_next_to(drawing, swept)]
            )
            # Again about the better axis, which reaches farther.
            for each in swept:
                drawing.taken[each.facets] = False
            swept = _about(drawing, _HalfPlane(drawing, refined)) or swept
            for each in swept:
                drawing.taken[each.facets] = True
            known.append(swept[0].axis)
            found.extend(swept)

    # Whole spheres; a part of one may turn about the axis of the walls that it meets.
    is_dome = np.zeros(len(drawing.taken), dtype=bool)
    for dome in _spheres(drawing):
        is_own = np.zeros(len(drawing.taken), dtype=bool)
        is_own[dome.facets] = True
        if len(drawing.across(is_own)):
            is_dome |= is_own
        else:
            found.append(dome)
    drawing.taken &= ~is_dome
    in_vain = 0
    for axis in _axes_of_outlines(drawing):
        before = len(known)
        take(axis)
        is_known = _same_axis(axis, known, LOOSE * drawing.tolerance, drawing.vessel.size)
        in_vain = 0 if len(known) > before or is_known else in_vain + 1
        if in_vain > FIRST_FAILURES:
            break
    failures = 0
    may_turn = _may_turn(drawing) & ~is_dome[drawing.seams].all(axis=1)
    for pair in drawing.seams[may_turn].tolist():
        if failures > MOST_FAILURES:
            break
        if drawing.taken[pair[0]] or drawing.taken[pair[1]]:
            continue
        before = len(found)
        guess = _best_axis(drawing, pair)
        if guess is not None:
            take(guess)
        failures += len(found) == before
    found += _spheres(drawing)
    return found


def _may_turn(drawing: Drawing) -> np.ndarray:
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
    """Whether a third facet lies on the cylinder through a pair of facets: see `_axis_of_strip`."""
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
    """Whether three facets may follow each other in a band about an axis: see `_axis_of_band`."""
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


def _fits(points: np.ndarray, normals: np.ndarray) -> Iterator[tuple[str, Callable[[np.ndarray], np.ndarray]]]:
    """Words for a sphere and a cylinder or cone near points (n, 3) and normals (f, 3), and what points are off them.

    A cone's axis is across the differences of its normals. About it |p - c|^2 is a square of the height h, so that the
    middle c follows from |p|^2 = 2 c . p + q0 + q1 h + q2 h^2 by linear least squares.
    """
    middle, radius = _sphere(points)
    yield f"a sphere of {radius * 1e3:.4g} mm", lambda p: np.linalg.norm(p - middle, axis=1) - radius
    _, _, across = np.linalg.svd(normals - normals.mean(axis=0), full_matrices=False)
    axis = Axis(points.mean(axis=0), across[-1])
    flat = (points - axis.origin) @ np.array([axis.u, axis.v, axis.along]).T
    columns = np.column_stack([2 * flat[:, :2], np.ones(len(flat)), flat[:, 2], flat[:, 2] ** 2])
    c, *_ = np.linalg.lstsq(columns, (flat[:, :2] ** 2).sum(axis=1), rcond=None)
    axis = Axis(axis.origin + c[0] * axis.u + c[1] * axis.v, axis.along)
    line = Line.through(axis.meridian(points))
    r = axis.meridian(points)[:, 0]
    words = f"a cylinder of {r.mean() * 1e3:.4g} mm"
    if abs(line.angle) * np.ptp(flat[:, 2]) > NEARLY * r.mean():
        words = f"a cone of {r.min() * 1e3:.4g} to {r.max() * 1e3:.4g} mm"
    yield words, lambda p: line.off(axis.meridian(p))


def nearly_found(drawing: Drawing, facets: np.ndarray) -> str | None:
    """What some facets nearly draw, and how far off it they are; None where that is not near.

    Small ones may be of a rounding next to it, and those that are far off may be what is wrong with it.
    """
    areas = drawing.vessel.areas[facets]
    best = None
    for number in range(2):
        own = facets[areas > 0.25 * areas.max()]
        for _ in range(4):
            words, off = list(_fits(drawing.points(own), drawing.normals[own]))[number]
            far = np.abs(off(drawing.vessel.vertices))[drawing.flat]
            worst = np.maximum.reduceat(far, drawing.corners.first)[facets]
            limit = max(drawing.tolerance, 3 * float(np.median(worst[np.isin(facets, own)])))
            own = facets[worst <= limit]
        near = worst[areas > 0.25 * areas.max()]
        # Two rings are on a sphere too.
        if best is None or np.median(near) < 2 * np.median(best[1]):
            best = words, near
    assert best is not None
    words, near = best
    if near.max() > NEARLY * drawing.vessel.size:
        return None
    return (
        f"{words} would fit {(near <= drawing.tolerance).sum()} of {len(near)} facets; vertices are up to "
        f"{near.max() * 1e3:.2g} mm off, the file's rounding allows {drawing.tolerance * 1e3:.2g} mm"
    )


def recognise(vessel: Vessel, rounding: float) -> Vessel:
    """A vessel of flat facets with the exact surfaces that they draw; rounding: of the file's coordinates [m]."""
    drawing = Drawing(vessel, rounding)
    surfaces = find_surfaces(drawing)
    planes = make_tangent(drawing, surfaces)
    curves: list[Curve] = []
    on_curve = np.full(len(vessel.normals), -1)
    for swept in surfaces:
        for curve, facets in curves_of(drawing, swept):
            on_curve[facets] = len(curves)
            curves.append(curve)
    exact = whole_patches(vessel, curves, on_curve, planes, drawing.tolerance)
    size = round_facets(exact)
    if not exact.report and size.any():
        exact.report = tuple(filter(None, [nearly_found(drawing, exact.placed_from[size == size.max()])]))
    return exact
