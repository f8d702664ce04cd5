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
from collections.abc import Callable, Iterable, Iterator
from itertools import chain

import numpy as np

from millprint.mill.curved_surfaces import Curve
from millprint.mill.drawn_axes import (
    AROUND,
    axes_of_outlines,
    axes_of_patches,
    axis_of_band,
    axis_of_strip,
    may_turn_at_seams,
    normals_next_to,
    same_axis,
)
from millprint.mill.exact_walls import curves_of, whole_patches
from millprint.mill.half_plane import EVEN, NEARLY, SAG, HalfPlane
from millprint.mill.surfaces_about import (
    FIRST_FAILURES,
    MOST_FAILURES,
    is_round,
    surface_begins,
    surfaces_about,
)
from millprint.mill.tangency import make_tangent
from millprint.mill.turned_shapes import (
    LARGEST_TURN,
    LOOSE,
    MOST_CORNERS,
    Axis,
    Circle,
    Drawing,
    Line,
    Swept,
    nearest_sphere,
)
from millprint.mill.vessel import Vessel
from millprint.mill.wall_words import round_facets

# Vertices of a surface from which its axis is fitted, at most, how many surfaces, and how often.
ENOUGH, MOST_PIECES, AGAIN = 2000, 12, 4
# Lines that differ by less, as angles and as shares of the vessel's size, may be one in strips.
STRIPS = 2e-3


def _spheres(drawing: Drawing, far: float = 2 * EVEN**2) -> list[Swept]:
    """Spheres without a known axis; a disc on one may be its floor.

    far: how far below them a facet may be, over the median of their facets: one farther may be a wall of its own.
    """
    found, failures = [], 0
    is_small = drawing.corners.counts <= MOST_CORNERS // 2
    for pair in drawing.seams.tolist():
        if failures > MOST_FAILURES:
            break
        if drawing.taken[pair[0]] or drawing.taken[pair[1]]:
            continue
        facets, slack = np.array(drawing.around(pair, AROUND)), LOOSE
        for slack in (LOOSE, 2.0, 1.0, 1.0):
            if len(facets) < 8:
                break
            middle, radius = nearest_sphere(drawing.points(facets))
            begin = drawing.vessel.vertices[drawing.vertices_of[pair[0]]]
            worst = np.abs(np.linalg.norm(begin - middle, axis=1) - radius).max()
            if radius > drawing.vessel.size or worst > slack * drawing.tolerance:
                facets = facets[:0]
                break
            off = np.linalg.norm(drawing.vessel.vertices - middle, axis=1) - radius
            sunk = radius - np.linalg.norm(drawing.middles - middle, axis=1)
            worst_of = np.maximum.reduceat(np.abs(off)[drawing.flat], drawing.corners.first)
            deepest = max(4 * drawing.tolerance, min(2 * SAG * radius, far * float(np.median(sunk[facets]))))
            holds = is_small & (worst_of <= slack * drawing.tolerance) & (sunk <= deepest + drawing.tolerance)
            facets = drawing.grown(pair, holds)
        if len(facets) < 16 or not is_round(drawing, facets, middle):
            failures += 1
            continue
        drawing.taken[facets] = True
        found.append(Swept(Axis(middle, np.array([0.0, 0.0, 1.0])), Circle(0.0, 0.0, radius), facets))
    return found


def _axis_of_border(drawing: Drawing, dome: Swept, others: np.ndarray) -> list[Axis]:
    """The axis through a dome's middle across the circle in which it meets other facets, if that is one."""
    own, beside = (np.unique(drawing.flat[drawing.corners.rows(facets)]) for facets in (dome.facets, others))
    border = drawing.vessel.vertices[np.intersect1d(own, beside)]
    away = border - border.mean(axis=0)
    normal = np.linalg.svd(away, full_matrices=False)[2][-1]
    is_circle = len(border) * LARGEST_TURN > 2 * math.pi and np.abs(away @ normal).max() <= drawing.tolerance
    return [Axis(dome.axis.origin, normal)] if is_circle else []


def _joined(swept: list[Swept], size: float) -> list[Swept]:
    """Surfaces about one axis, those that nearly are one line together: about one a little off, it lies in strips."""
    lines = sorted((each for each in swept if isinstance(each.shape, Line)), key=lambda each: -len(each.facets))
    found: list[Swept] = []
    for each in lines:
        assert isinstance(each.shape, Line)
        for other in found:
            assert isinstance(other.shape, Line)
            turn = math.remainder(each.shape.angle - other.shape.angle, 2 * math.pi)
            if abs(turn) < STRIPS and abs(each.shape.offset - other.shape.offset) < STRIPS * size:
                other.facets = np.append(other.facets, each.facets)
                break
        else:
            found.append(Swept(each.axis, each.shape, each.facets))
    return [each for each in swept if not isinstance(each.shape, Line)] + found


def _refined(drawing: Drawing, axis: Axis, swept: list[Swept], known: list[np.ndarray]) -> Axis:
    """The axis about which surfaces are nearest to their vertices; `axis` where there is none.

    Spheres about one middle allow any direction, and keep it. known: directions (3,), see `_fitted`.
    """
    middles = [each.shape.z for each in swept if isinstance(each.shape, Circle) and each.shape.r == 0.0]
    if len(middles) == len(swept) and np.ptp(middles) < LOOSE * drawing.tolerance:
        largest = max(swept, key=lambda each: len(each.facets))
        return Axis(nearest_sphere(drawing.points(largest.facets))[0], axis.along)
    joined = _joined(swept, drawing.vessel.size)
    better = _fitted(drawing, axis, joined, known)
    if better is None and len(joined) < len(swept):
        better = _fitted(drawing, axis, swept, known)
    return better or axis


def _fitted(drawing: Drawing, axis: Axis, swept: list[Swept], known: list[np.ndarray]) -> Axis | None:
    """The axis nearest to a first one about which vertices lie on their surfaces, or None.

    One along a side of the frame, or along one of some known directions (3,), if the vertices allow it.
    """
    from scipy.optimize import least_squares  # takes long to import, and few mills need it

    # The largest, and some of their vertices, from all over them.
    swept = sorted(swept, key=lambda each: -len(each.facets))[:MOST_PIECES]
    rows = [points[:: 1 + len(points) // ENOUGH] for points in (drawing.points(each.facets) for each in swept)]

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
    worst = np.abs(off(best)).max()
    if worst > 1:
        return None
    # What the file's rounding may hide, and not what a fit may be off.
    allowed = min(1.0, max(drawing.snap / drawing.tolerance, 2 * worst))
    side = np.argmax(np.abs(best.along))
    exact = np.eye(3)[side] * np.sign(best.along[side])
    for along in (exact, *known):
        if np.linalg.norm(np.cross(best.along, along)) > NEARLY:
            continue
        level = Axis(best.origin, along * np.sign(along @ best.along))

        def placed(shift: np.ndarray, level: Axis = level) -> Axis:
            return Axis(level.origin + drawing.vessel.size * (shift[0] * level.u + shift[1] * level.v), level.along)

        again = placed(least_squares(lambda s, to=placed: off(to(s)), np.zeros(2), method="lm", diff_step=1e-7).x)
        if np.abs(off(again)).max() <= allowed:
            return again
    return best


def _best_axis(drawing: Drawing, pair: tuple[int, int]) -> Axis | None:
    """Of the axes about which facets at a seam may turn, the one whose surfaces have the most facets.

    A wall that is bent both ways is nearly one about an axis across it too, for a few facets.
    """
    seams = [pair, *((first, other) for first in pair for other in drawing.neighbours[first] if other not in pair)]
    best, most = None, 0
    tried: list[Axis] = []
    for seam in seams[:9]:
        for axis_of in (axis_of_strip, axis_of_band):
            axis = None if drawing.taken[list(seam)].any() else axis_of(drawing, seam)
            if axis is None or same_axis(axis, tried, drawing.tolerance, drawing.vessel.size):
                continue
            if not surface_begins(drawing, axis, seam):
                continue
            swept = surfaces_about(drawing, HalfPlane(drawing, axis))
            count = _count(swept)
            _mark(drawing, swept, taken=False)
            tried.append(axis)
            if count > most:
                best, most = axis, count
            if most > (~drawing.taken).sum() / 2:
                return best
    return best


def _count(surfaces: list[Swept]) -> int:
    """The facets of some surfaces."""
    return sum(len(each.facets) for each in surfaces)


def _mark(drawing: Drawing, surfaces: list[Swept], taken: bool) -> None:
    """Let the facets of some surfaces be taken, or free."""
    for each in surfaces:
        drawing.taken[each.facets] = taken


def find_surfaces(drawing: Drawing, first: Iterable[Axis] = ()) -> list[Swept]:
    """The surfaces of a drawing; their facets are taken. first: axes that are tried before others."""
    found: list[Swept] = []
    known: list[Axis] = []

    def take(axis: Axis) -> None:
        if same_axis(axis, known, drawing.tolerance, drawing.vessel.size):
            return
        swept = surfaces_about(drawing, HalfPlane(drawing, axis))
        if swept:
            # Again about the better axis, which reaches farther, as long as it does.
            for _ in range(AGAIN):
                along = [*(other.along for other in known), *normals_next_to(drawing, swept)]
                axis = _refined(drawing, axis, swept, along)
                _mark(drawing, swept, taken=False)
                again = surfaces_about(drawing, HalfPlane(drawing, axis))
                _mark(drawing, again, taken=False)
                more = _count(again) - _count(swept)
                swept = again if more >= 0 else swept
                if more <= 0:
                    break
            _mark(drawing, swept, taken=True)
            known.append(swept[0].axis)
            found.extend(swept)

    # Whole spheres; a part of one may turn about the axis of the walls that it meets.
    is_dome, axes = np.zeros(len(drawing.taken), dtype=bool), list(first)
    for dome in _spheres(drawing):
        is_own = np.zeros(len(drawing.taken), dtype=bool)
        is_own[dome.facets] = True
        if len(others := drawing.across(is_own)):
            is_dome |= is_own
            axes += _axis_of_border(drawing, dome, others)
        else:
            found.append(dome)
    drawing.taken &= ~is_dome
    for axis in axes:
        take(axis)
    in_vain = 0
    for axis in axes_of_outlines(drawing):
        before = len(known)
        take(axis)
        is_known = same_axis(axis, known, LOOSE * drawing.tolerance, drawing.vessel.size)
        in_vain = 0 if len(known) > before or is_known else in_vain + 1
        if in_vain > FIRST_FAILURES:
            break
    failures = 0
    may_turn = may_turn_at_seams(drawing) & ~is_dome[drawing.seams].all(axis=1)
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
    found += _spheres(drawing, math.inf)
    return found


def _fits(points: np.ndarray, normals: np.ndarray) -> Iterator[tuple[str, Callable[[np.ndarray], np.ndarray]]]:
    """Words for a sphere and a cylinder or cone near points (n, 3) and normals (f, 3), and what points are off them.

    A cone's axis is across the differences of its normals. About it |p - c|^2 is a square of the height h, so that the
    middle c follows from |p|^2 = 2 c . p + q0 + q1 h + q2 h^2 by linear least squares.
    """
    middle, radius = nearest_sphere(points)
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


def _with_surfaces(drawing: Drawing, surfaces: list[Swept]) -> Vessel:
    """The vessel of a drawing with those of some surfaces whose patches are exact as a whole."""
    planes = make_tangent(drawing, surfaces)
    curves: list[Curve] = []
    on_curve = np.full(len(drawing.taken), -1)
    for swept in surfaces:
        for curve, facets in curves_of(drawing, swept):
            on_curve[facets] = len(curves)
            curves.append(curve)
    return whole_patches(drawing.vessel, curves, on_curve, planes, drawing.tolerance)


def _largest_axes(surfaces: list[Swept]) -> list[Axis]:
    """The axes of some surfaces, those with the most facets first."""
    axes = {id(each.axis): each.axis for each in surfaces}
    counts = {key: _count([each for each in surfaces if id(each.axis) == key]) for key in axes}
    return [axes[key] for key in sorted(axes, key=lambda key: -counts[key])]


def recognise(vessel: Vessel, rounding: float) -> Vessel:
    """A vessel of flat facets with the exact surfaces that they draw; rounding: of the file's coordinates [m].

    The axes of a few facets know a simple jar, of many patches. In a fine mesh there may be too much rounding in a few
    facets, and a wrong surface takes those of a right one. So where a wall that looks round stays flat, it is looked
    for again, with the axes of whole patches first, and then those that had the most facets.
    """
    drawing = Drawing(vessel, rounding)
    surfaces = find_surfaces(drawing)
    exact = _with_surfaces(drawing, surfaces)
    if not (count := (round_facets(exact) > 0).sum()):
        return exact
    drawing = Drawing(vessel, rounding)
    again = find_surfaces(drawing, chain(axes_of_patches(drawing), _largest_axes(surfaces)))
    second = _with_surfaces(drawing, again)
    best = second if (round_facets(second) > 0).sum() < count else exact
    size = round_facets(best)
    if not best.report and size.any():
        best.report = tuple(filter(None, [nearly_found(drawing, best.placed_from[size == size.max()])]))
    return best
