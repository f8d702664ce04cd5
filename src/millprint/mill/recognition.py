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

from millprint.mill.borders import borders_of, rough_facets
from millprint.mill.curved_surfaces import Curve
from millprint.mill.tangency import make_tangent
from millprint.mill.turned_shapes import LARGEST_TURN, LOOSE, SMALLEST_TURN, Axis, Circle, Drawing, Line, Swept
from millprint.mill.vessel import Facet, Vessel
from millprint.mill.wall_features import facet_patches

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
# What angles of half and whole turns may be off [rad].
WHOLE = 1e-3


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
    facets = np.array(seed)
    for slack in (LOOSE, 2.0, 1.0, 1.0):
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
            return []
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
    # Three columns of a wall that is bent both ways seem to turn about an axis across it too.
    return across > FEWEST_STEPS and around > FEWEST_STEPS


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
            if (len(rings) < 3) == (kind is Circle) or np.ptp(own, axis=0).max() < LOOSE * drawing.tolerance:
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

    One along a side of the frame, or along one of some known directions (3,), if the vertices allow it.
    """
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


def _span(angles: np.ndarray) -> tuple[float, float]:
    """Where the largest gap between angles (n,) ends and begins again [rad]."""
    angles = np.sort(angles % (2 * math.pi))
    gaps = np.diff(np.append(angles, angles[0] + 2 * math.pi))
    widest = int(np.argmax(gaps))
    begin = angles[(widest + 1) % len(angles)]
    return float(begin), float(begin + 2 * math.pi - gaps[widest])


def _curves(drawing: Drawing, swept: Swept) -> list[tuple[Curve, np.ndarray]]:
    """A surface as curves of up to half a turn, or of a whole one, and the facets of each."""
    axis, shape = swept.axis, swept.shape
    points = drawing.points(swept.facets)
    flat, angles = axis.meridian(points), axis.angles(points)
    middles = np.array([drawing.vessel.vertices[drawing.vertices_of[facet]].mean(axis=0) for facet in swept.facets])
    of_facet = axis.angles(middles)
    off_axis = flat[:, 0] > LOOSE * drawing.tolerance
    begin, end = _span(angles[off_axis])
    # Facets lie in every gap between vertices if the surface goes all the way round.
    is_whole = bool(((of_facet - end) % (2 * math.pi) < (begin - end) % (2 * math.pi)).any())
    out = middles - axis.origin
    heights = out @ axis.along
    out -= np.outer(heights, axis.along)
    radii = np.linalg.norm(out, axis=1)
    out /= np.maximum(radii, 1e-12)[:, None]
    if isinstance(shape, Line):
        normal = np.array([math.cos(shape.angle), math.sin(shape.angle)])
        slope = -shape.angle
        # The height of the circle of reference: the middle of the line.
        along = flat @ [math.sin(slope), math.cos(slope)]
        middle = (along.min() + along.max()) / 2
        start = shape.offset * normal + middle * np.array([math.sin(slope), math.cos(slope)])
        ends = (float(along.min() - middle), float(along.max() - middle))
        if abs(math.sin(slope)) * max(abs(ends[0]), abs(ends[1])) < drawing.tolerance / 8:
            slope = 0.0
        outwards = normal[0] * out + normal[1] * axis.along
        curve = Curve(axis.origin + start[1] * axis.along, axis.along, float(start[0]), ends=ends, slope=slope)
    else:
        around = np.arctan2(flat[:, 1] - shape.z, flat[:, 0] - shape.r)
        low, high = _span(around) if len(around) > 1 else (0.0, 0.0)
        arc: tuple[tuple[float, float], tuple[float, float]] | None
        arc = ((math.cos(low), math.sin(low)), (math.cos(high), math.sin(high)))
        if shape.r == 0.0:
            # An arc about a point of the axis reaches to the axis where a vertex, or a facet, is on it.
            arc = _sphere_arc(flat - [0.0, shape.z], drawing.tolerance, shape.radius)
        elif 2 * math.pi - (high - low) < 3 * LARGEST_TURN:
            arc = None
        outwards = (radii - shape.r)[:, None] * out + np.outer(heights - shape.z, axis.along)
        curve = Curve(axis.origin + shape.z * axis.along, axis.along, shape.r, shape.radius, arc=arc)
    hollow = bool((drawing.normals[swept.facets] * outwards).sum() < 0)
    curve = Curve(**{**curve.__dict__, "hollow": hollow})
    if is_whole:
        return [(curve, swept.facets)]
    count = max(1, math.ceil((end - begin) / math.pi - WHOLE))
    cuts = np.linspace(begin, end, count + 1)
    # At vertices, which both parts share.
    around = begin + (angles[off_axis] - begin) % (2 * math.pi)
    cuts[1:-1] = [around[np.argmin(np.abs(around - cut))] for cut in cuts[1:-1]]
    which = np.clip(np.searchsorted(cuts, begin + (of_facet - begin) % (2 * math.pi)) - 1, 0, count - 1)
    parts = []
    for k in range(count):
        sides = tuple(math.cos(angle) * axis.u + math.sin(angle) * axis.v for angle in cuts[k : k + 2])
        parts.append((Curve(**{**curve.__dict__, "part": sides}), swept.facets[which == k]))
    return [(curve, facets) for curve, facets in parts if len(facets)]


def _sphere_arc(
    flat: np.ndarray, tolerance: float, radius: float
) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """The arc of a sphere about the origin of the half plane, None for a whole sphere."""
    around = np.arctan2(flat[:, 1], flat[:, 0])
    low, high = float(around.min()), float(around.max())
    # A pole has no ring of its own where no vertex is there: the ring nearest to it is as near as one step.
    low = -math.pi / 2 if low < -math.pi / 2 + LARGEST_TURN else low
    high = math.pi / 2 if high > math.pi / 2 - LARGEST_TURN else high
    if high - low > math.pi - 1e-9:
        return None
    return (math.cos(low), math.sin(low)), (math.cos(high), math.sin(high))


def _moved_vertices(
    vessel: Vessel, curves: list[Curve], on_curve: np.ndarray, planes: dict[int, np.ndarray]
) -> np.ndarray:
    """The vertices (v, 3) where the surfaces meet on which they lie: by steps of least length (Newton)."""
    beside: list[set[int]] = [set() for _ in vessel.vertices]
    # The outline of a flat wall that was put level moves with it.
    moving = {-1 - facet for facet in planes}
    for facet, loops in enumerate(vessel.loops):
        number = int(on_curve[facet]) if on_curve[facet] >= 0 else -1 - facet
        if number < 0 and facet not in planes:
            planes.setdefault(facet, np.array([*vessel.facets[facet].normal, vessel.facets[facet].offset]))
        for vertex in np.concatenate(loops).tolist():
            beside[vertex].add(number)
    groups: dict[frozenset[int], list[int]] = {}
    for vertex, own in enumerate(beside):
        if any(number >= 0 or number in moving for number in own):
            groups.setdefault(frozenset(own), []).append(vertex)
    moved = vessel.vertices.copy()
    for surfaces, vertices in groups.items():
        points = moved[vertices]
        # Where surfaces are tangent, a step halves the error only.
        for _ in range(40):
            off, slopes = [], []
            for number in surfaces:
                if number >= 0:
                    distance, direction, _ = curves[number].touch(points)
                else:
                    plane = planes[-1 - number]
                    distance = points @ plane[:3] - plane[3]
                    direction = np.broadcast_to(plane[:3], points.shape)
                off.append(distance)
                slopes.append(direction)
            away = np.stack(off, axis=1)
            if np.abs(away).max() < 1e-17:
                break
            points = points - (np.linalg.pinv(np.stack(slopes, axis=1), rcond=1e-7) @ away[..., None])[..., 0]
        moved[vertices] = points
    return moved


def _level_planes(vessel: Vessel, curves: list[Curve], on_curve: np.ndarray, tolerance: float) -> dict[int, np.ndarray]:
    """Planes (normal, offset) of the flat facets that meet curves, across or along their axes where they nearly are."""
    planes: dict[int, np.ndarray] = {}
    for edge in vessel.edges:
        for flat, other in (edge.facets, edge.facets[::-1]):
            if on_curve[flat] >= 0 or on_curve[other] < 0 or flat in planes:
                continue
            facet, axis = vessel.facets[flat], curves[on_curve[other]].axis
            points = np.concatenate(facet.loops)
            cosine = float(facet.normal @ axis)
            across = facet.normal - cosine * axis
            if abs(cosine) > 0.99:
                normal = math.copysign(1.0, cosine) * axis
            elif abs(cosine) < 0.01:
                normal = across / np.linalg.norm(across)
            else:
                continue
            if np.ptp(points @ normal) < 2 * tolerance:
                planes[flat] = np.array([*normal, float((points @ normal).mean())])
    return planes


def _trimmed(curve: Curve, points: np.ndarray) -> Curve:
    """A curve between borders that vertices (n, 3) on it draw."""
    away = points - curve.origin
    up = away @ curve.axis
    out = np.linalg.norm(away - np.outer(up, curve.axis), axis=1)
    changes: dict = {}
    if curve.part:
        first, across = curve.part[0], np.cross(curve.axis, curve.part[0])
        width = math.atan2(curve.part[1] @ across, curve.part[1] @ first) % (2 * math.pi)
        off_axis = away[out > 1e-9 * np.abs(points).max()]
        angles = np.arctan2(off_axis @ across, off_axis @ first) - width / 2
        angles = (angles + math.pi) % (2 * math.pi) - math.pi + width / 2
        changes["part"] = tuple(
            math.cos(each) * first + math.sin(each) * across for each in (angles.min(), angles.max())
        )
    if curve.minor is None:
        along = (out - curve.major) * math.sin(curve.slope) + up * math.cos(curve.slope)
        changes["ends"] = float(along.min()), float(along.max())
    elif curve.arc:
        around = np.arctan2(up, out - curve.major)
        middle = math.atan2(curve.arc[0][1] + curve.arc[1][1], curve.arc[0][0] + curve.arc[1][0])
        if curve.arc[0][0] * curve.arc[1][1] - curve.arc[0][1] * curve.arc[1][0] < 0:
            middle += math.pi
        around = (around - middle + math.pi) % (2 * math.pi) - math.pi
        pole = [math.pi / 2 * sign for sign in (-1, 1)]
        low, high = float(around.min()) + middle, float(around.max()) + middle
        if not curve.major:
            low = pole[0] if abs(curve.arc[0][0]) < 1e-9 else low
            high = pole[1] if abs(curve.arc[1][0]) < 1e-9 else high
        changes["arc"] = (math.cos(low), math.sin(low)), (math.cos(high), math.sin(high))
    return Curve(**{**curve.__dict__, **changes})


def recognise(vessel: Vessel, rounding: float) -> Vessel:
    """A vessel of flat facets with the exact surfaces that they draw; rounding: of the file's coordinates [m]."""
    drawing = Drawing(vessel, rounding)
    surfaces = find_surfaces(drawing)
    planes = make_tangent(drawing, surfaces)
    curves: list[Curve] = []
    on_curve = np.full(len(vessel.facets), -1)
    for swept in surfaces:
        for curve, facets in _curves(drawing, swept):
            on_curve[facets] = len(curves)
            curves.append(curve)
    return _whole_patches(vessel, curves, on_curve, planes, drawing.tolerance)


def _whole_patches(
    vessel: Vessel, curves: list[Curve], on_curve: np.ndarray, set_planes: dict[int, np.ndarray], tolerance: float
) -> Vessel:
    """The vessel with those curves whose patches are exact everywhere."""
    report: list[str] = []
    while (on_curve >= 0).any():
        planes = _level_planes(vessel, curves, on_curve, tolerance) | set_planes
        moved = _moved_vertices(vessel, curves, on_curve, planes)
        trimmed = [
            _trimmed(curve, moved[np.unique(np.concatenate([np.concatenate(vessel.loops[f]) for f in own]))])
            if len(own := np.flatnonzero(on_curve == number))
            else curve
            for number, curve in enumerate(curves)
        ]
        facets = [Facet.from_loops([moved[loop] for loop in loops]) for loops in vessel.loops]
        exact = Vessel(facets, vessel.name, vessel.solid, vessel.smooth_axis, trimmed, on_curve, tuple(report))
        borders = borders_of(exact)
        rough = rough_facets(exact, borders)
        if not rough:
            return exact
        patch = facet_patches(exact, borders)
        spoilt = np.isin(patch, patch[list(rough)])
        at = np.concatenate(exact.facets[next(iter(rough))].loops).mean(axis=0) * 1e3
        report.append(
            f"{spoilt.sum()} facets stay flat, since a round wall ends at drawn ones near "
            f"({at[0]:.4g}, {at[1]:.4g}, {at[2]:.4g}) mm"
        )
        # The facets of the exact vessel are in an order of their own.
        lost = exact.placed_from[spoilt]
        on_curve = on_curve.copy()
        on_curve[lost] = -1
    return Vessel(vessel.facets, vessel.name, vessel.solid, vessel.smooth_axis, report=tuple(report))
