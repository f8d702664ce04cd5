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

import numpy as np

from millprint.mill.curved_surfaces import Curve
from millprint.mill.exact_walls import curves_of, whole_patches
from millprint.mill.tangency import make_tangent
from millprint.mill.turned_shapes import LARGEST_TURN, LOOSE, SMALLEST_TURN, Axis, Circle, Drawing, Line, Swept
from millprint.mill.vessel import Vessel

# Four points may lie on one circle by chance of symmetry; this number of steps around or across does not.
FEWEST_STEPS = 5
# How far the middle of a facet is below its surface, over the radii, where it is drawn in steps of LARGEST_TURN.
SAG = 1.3 * (1 - math.cos(LARGEST_TURN / 2))
# Seeds that lead nowhere, after which the search about one axis, or for one kind, ends.
MOST_FAILURES = 300
# The largest radius of a wall, over the size of the body.
LARGEST_RADIUS = 200
# Directions that differ by less may be one, if the vertices allow it [rad].
NEARLY = 0.02


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
            circles[known] = Circle.through(flat[groups[known]]) if len(groups[known]) > 2 else circles[known]
    return [flat[group] for group in groups if len(group) >= FEWEST_STEPS]


def _axes_of_outlines(drawing: Drawing) -> list[Axis]:
    """The axes of the round outlines of flat facets, those of large circles first."""
    found = []
    for facet in drawing.vessel.facets:
        first, second = facet.axes
        for loop in facet.loops:
            if len(loop) <= FEWEST_STEPS:
                continue
            for flat in _arcs_of_outline(loop @ np.array([first, second]).T, LOOSE * drawing.tolerance):
                circle = Circle.through(flat)
                if np.abs(circle.off(flat)).max() < LOOSE * drawing.tolerance:
                    origin = circle.r * first + circle.z * second + facet.offset * facet.normal
                    found.append((circle.radius, Axis(origin, facet.normal)))
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
    near = [
        facet
        for facet in drawing.around(pair, 12)
        if abs(drawing.normals[facet] @ along) < 1e-2
        and np.abs(circle.off(drawing.points([facet]) @ sides)).max() < LOOSE * drawing.tolerance
    ]
    if len(near) < 3:
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
        alike = abs(np.linalg.norm(following) - np.linalg.norm(step)) < 0.05 * np.linalg.norm(step)
        if third == first or drawing.taken[third] or not alike or length < 1e-3 * np.linalg.norm(step) ** 2:
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


def _fitted(drawing: Drawing, axis: Axis, seed: tuple[int, int], kind: type[Line] | type[Circle]) -> list[Swept]:
    """The surface about an axis that begins with two facets, each of whose vertices lies on it.

    Its pieces, where other walls interrupt it; nothing where there is too little of it.
    """
    flat, middles = axis.meridian(drawing.vessel.vertices), axis.meridian(drawing.middles)
    facing, is_ring = _facing(drawing, axis, middles), drawing.spread(flat) < LOOSE * drawing.tolerance

    def grown(slacks: tuple[float, ...]) -> tuple[Line | Circle, np.ndarray] | None:
        """The shape and which facets (f,) hold, found in rounds of some slacks [tolerances]; None if the seed is lost."""
        facets = np.array(seed)
        for slack in slacks:
            vertices = np.unique(np.concatenate([drawing.vertices_of[facet] for facet in facets]))
            shape = kind.through(flat[vertices])
            if isinstance(shape, Circle) and abs(shape.r) < LOOSE * drawing.tolerance:
                shape.r = 0.0
                shape.z, shape.radius = _on_axis_circle(flat[vertices])
            # A floor has its outline, a ring, on the fillet that it joins.
            sag = SAG * (middles[:, 0] + (shape.radius if isinstance(shape, Circle) else 0.0)) + drawing.tolerance
            holds = (drawing.worst(shape.off(flat)) <= slack * drawing.tolerance) & (np.abs(shape.off(middles)) <= sag)
            slopes = _slopes(shape, middles)
            side = (facing[seed[0]] * slopes[seed[0]]).sum()
            holds &= ~drawing.taken & ~is_ring & ((facing * slopes).sum(axis=1) * side > 0.5)
            if not holds[list(seed)].any():
                return None
            facets = np.flatnonzero(holds)
        return shape, holds

    # The first slack may take a wall that turns by little against this one, and spoil the fit.
    found = grown((LOOSE, 2.0, 1.0, 1.0)) or grown((1.0, 1.0, 1.0))
    if found is None:
        return []
    shape, holds = found
    facets = np.flatnonzero(holds)
    whole = Swept(axis, shape, facets)
    if not _is_enough(drawing, whole):
        return []
    pieces = []
    left = set(facets.tolist())
    while left:
        piece = drawing.grown([min(left)], holds)
        left -= set(piece.tolist())
        pieces.append(Swept(axis, shape, piece))
    return pieces


def _facing(drawing: Drawing, axis: Axis, middles: np.ndarray) -> np.ndarray:
    """The normals of the facets (f, 2) in the half plane about an axis."""
    away = drawing.middles - axis.origin - np.outer(middles[:, 1], axis.along)
    outwards = away / np.maximum(middles[:, :1], 1e-12)
    return np.column_stack([(drawing.normals * outwards).sum(axis=1), drawing.normals @ axis.along])


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


def _about(drawing: Drawing, axis: Axis) -> list[Swept]:
    """The surfaces about an axis: arcs first, since each of their steps is a line too; their facets are taken."""
    found = []
    vertices = drawing.vessel.vertices
    flat = axis.meridian(vertices)
    for kind in (Circle, Line):
        # All pairs between the same rings fail alike.
        failed: set[tuple[int, ...]] = set()
        for pair in drawing.seams:
            if drawing.taken[list(pair)].any() or len(failed) > MOST_FAILURES:
                continue
            own = flat[np.concatenate([drawing.vertices_of[facet] for facet in pair])]
            rings = _different(own, drawing.tolerance)
            if (len(rings) < 3 and kind is Circle) or np.ptp(own, axis=0).max() < LOOSE * drawing.tolerance:
                continue
            key = tuple(sorted(np.round(rings / (4 * drawing.tolerance)).astype(int).ravel().tolist()))
            if key in failed:
                continue
            pieces = []
            if np.abs(kind.through(rings).off(own)).max() <= drawing.tolerance:
                pieces = _fitted(drawing, axis, pair, kind)
            if not pieces:
                failed.add(key)
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
    for pair in drawing.seams:
        if drawing.taken[list(pair)].any() or failures > MOST_FAILURES:
            continue
        facets, slack = np.array(drawing.around(pair, 12)), LOOSE
        for slack in (LOOSE, 2.0, 1.0, 1.0):
            if len(facets) < 8:
                break
            middle, radius = _sphere(drawing.points(facets))
            off = np.linalg.norm(drawing.vessel.vertices - middle, axis=1) - radius
            if (
                radius > drawing.vessel.size
                or np.abs(off[drawing.vertices_of[pair[0]]]).max() > slack * drawing.tolerance
            ):
                facets = facets[:0]
                break
            sunk = radius - np.linalg.norm(drawing.middles - middle, axis=1)
            holds = (drawing.worst(off) <= slack * drawing.tolerance) & (sunk <= 2 * SAG * radius + drawing.tolerance)
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
    own = set(np.concatenate([each.facets for each in swept]).tolist())
    found: dict[int, np.ndarray] = {}
    for edge in drawing.vessel.edges:
        for inside, other in (edge.facets, edge.facets[::-1]):
            if inside in own and not drawing.taken[other] and len(drawing.vertices_of[other]) > 4:
                found[other] = drawing.normals[other]
    return list(found.values())


def _best_axis(drawing: Drawing, pair: tuple[int, int]) -> Axis | None:
    """Of the axes about which facets at a seam may turn, the one whose surfaces have the most facets.

    A wall that is bent both ways is nearly one about an axis across it too, for a few facets.
    """
    seams = [pair, *((first, other) for first in pair for other in drawing.neighbours[first] if other not in pair)]
    best, most = None, 0
    for seam in seams[:9]:
        for axis_of in (_axis_of_strip, _axis_of_band):
            axis = None if drawing.taken[list(seam)].any() else axis_of(drawing, seam)
            if axis is None:
                continue
            swept = _about(drawing, axis)
            count = sum(len(each.facets) for each in swept)
            for each in swept:
                drawing.taken[each.facets] = False
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
        swept = _about(drawing, axis)
        if swept:
            refined = _refined(
                drawing, axis, swept, [*(other.along for other in known), *_normals_next_to(drawing, swept)]
            )
            # Again about the better axis, which reaches farther.
            for each in swept:
                drawing.taken[each.facets] = False
            swept = _about(drawing, refined) or swept
            for each in swept:
                drawing.taken[each.facets] = True
            known.append(swept[0].axis)
            found.extend(swept)

    for axis in _axes_of_outlines(drawing):
        take(axis)
    failures = 0
    for pair in drawing.seams:
        if drawing.taken[list(pair)].any() or failures > MOST_FAILURES:
            continue
        before = len(found)
        guess = _best_axis(drawing, pair)
        if guess is not None:
            take(guess)
        failures += len(found) == before
    found += _spheres(drawing)
    return found


def recognise(vessel: Vessel, rounding: float) -> Vessel:
    """A vessel of flat facets with the exact surfaces that they draw; rounding: of the file's coordinates [m]."""
    drawing = Drawing(vessel, rounding)
    surfaces = find_surfaces(drawing)
    planes = make_tangent(drawing, surfaces)
    curves: list[Curve] = []
    on_curve = np.full(len(vessel.facets), -1)
    for swept in surfaces:
        for curve, facets in curves_of(drawing, swept):
            on_curve[facets] = len(curves)
            curves.append(curve)
    return whole_patches(vessel, curves, on_curve, planes, drawing.tolerance)
