"""Exact walls of surfaces that were found in a drawing: curves between their borders, and vertices where they meet."""

import math
from dataclasses import replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from millprint.config.errors import ConfigError
from millprint.mill.borders import borders_of, must_be_trimmed, rough_facets
from millprint.mill.curved_surfaces import Curve
from millprint.mill.drawn_creases import endless
from millprint.mill.outlines import Outlines, Ragged, lengths
from millprint.mill.turned_shapes import LARGEST_TURN, LOOSE, Drawing, Line, Swept
from millprint.mill.vessel import WELD, Vessel
from millprint.mill.wall_features import facet_patches

# What angles of half and whole turns may be off [rad].
WHOLE = 1e-3


def _span(angles: np.ndarray) -> tuple[float, float]:
    """Where the largest gap between angles (n,) ends and begins again [rad]."""
    angles = np.sort(angles % (2 * math.pi))
    gaps = np.diff(np.append(angles, angles[0] + 2 * math.pi))
    widest = int(np.argmax(gaps))
    begin = angles[(widest + 1) % len(angles)]
    return float(begin), float(begin + 2 * math.pi - gaps[widest])


def _is_crossed(drawing: Drawing, swept: Swept, gap: float) -> bool:
    """Whether a facet of a surface lies across an angle about its axis [rad], where no vertex is."""
    corners = drawing.vessel.vertices[drawing.flat[drawing.corners.rows(swept.facets)]]
    away = (swept.axis.angles(corners) - gap + math.pi) % (2 * math.pi) - math.pi
    near = (swept.axis.meridian(corners)[:, 0] > LOOSE * drawing.tolerance) & (np.abs(away) < math.pi / 2)
    first = Ragged(drawing.corners.counts[swept.facets]).first
    before, after = (np.logical_or.reduceat(near & side, first) for side in (away < 0, away > 0))
    return bool((before & after).any())


def curves_of(drawing: Drawing, swept: Swept) -> list[tuple[Curve, np.ndarray]]:
    """A surface as curves of up to half a turn, or of a whole one, and the facets of each."""
    axis, shape = swept.axis, swept.shape
    points = drawing.points(swept.facets)
    flat, angles = axis.meridian(points), axis.angles(points)
    middles = drawing.middles[swept.facets]
    of_facet = axis.angles(middles)
    off_axis = flat[:, 0] > LOOSE * drawing.tolerance
    begin, end = _span(angles[off_axis])
    is_whole = _is_crossed(drawing, swept, (begin + end) / 2 + math.pi)
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
        else:
            # An end that is nearly on the axis is a tip.
            tip = -float(start[0]) / math.sin(slope)
            is_near = [abs((end - tip) * math.sin(slope)) < LOOSE * drawing.tolerance for end in ends]
            ends = (tip if is_near[0] else ends[0], tip if is_near[1] else ends[1])
        outwards = normal[0] * out + normal[1] * axis.along
        curve = Curve(axis.origin + start[1] * axis.along, axis.along, float(start[0]), ends=ends, slope=slope)
    else:
        around = np.arctan2(flat[:, 1] - shape.z, flat[:, 0] - shape.r)
        low, high = _span(around) if len(around) > 1 else (0.0, 0.0)
        arc: tuple[tuple[float, float], tuple[float, float]] | None
        arc = ((math.cos(low), math.sin(low)), (math.cos(high), math.sin(high)))
        if shape.r == 0.0:
            arc = _sphere_arc(flat[:, 1] - shape.z, shape.radius, _crossings(drawing, swept) - shape.z)
        elif 2 * math.pi - (high - low) < 3 * LARGEST_TURN:
            arc = None
        outwards = (radii - shape.r)[:, None] * out + np.outer(heights - shape.z, axis.along)
        curve = Curve(axis.origin + shape.z * axis.along, axis.along, shape.r, shape.radius, arc=arc)
    hollow = bool((drawing.normals[swept.facets] * outwards).sum() < 0)
    curve = replace(curve, hollow=hollow)
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
        first, last = (math.cos(angle) * axis.u + math.sin(angle) * axis.v for angle in cuts[k : k + 2])
        parts.append((replace(curve, part=(first, last)), swept.facets[which == k]))
    return [(curve, facets) for curve, facets in parts if len(facets)]


def _crossings(drawing: Drawing, swept: Swept) -> np.ndarray:
    """Heights (n,) of the vertices and facets of a surface that are on its axis: these go round it, or a side does."""
    rows = drawing.corners.rows(swept.facets)
    begin, end = (
        drawing.vessel.vertices[drawing.flat[each]] for each in (rows, drawing.vessel.outlines.loops.ahead[rows])
    )
    turn = (swept.axis.angles(end) - swept.axis.angles(begin) + math.pi) % (2 * math.pi) - math.pi
    first = Ragged(drawing.corners.counts[swept.facets]).first
    # A side through the axis turns by half a turn, one way or the other.
    is_on_axis = np.logical_or.reduceat(np.abs(turn) > math.pi - 1e-9, first)
    is_on_axis |= np.abs(np.add.reduceat(turn, first)) > math.pi
    flat, middles = swept.axis.meridian(begin), swept.axis.meridian(drawing.middles[swept.facets])
    return np.append(flat[flat[:, 0] < LOOSE * drawing.tolerance, 1], middles[is_on_axis, 1])


def _sphere_arc(
    heights: np.ndarray, radius: float, on_axis: np.ndarray
) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """The arc of a sphere between heights over its middle; to a pole where it is on the axis there; None if whole."""
    low, high = np.arcsin(np.clip([heights.min() / radius, heights.max() / radius], -1, 1)).tolist()
    low = -math.pi / 2 if on_axis.min(initial=0.0) < 0 else low
    high = math.pi / 2 if on_axis.max(initial=0.0) > 0 else high
    if high - low > math.pi - 1e-9:
        return None
    return (math.cos(low), math.sin(low)), (math.cos(high), math.sin(high))


def _moved_vertices(
    vessel: Vessel, curves: list[Curve], on_curve: np.ndarray, planes: dict[int, np.ndarray]
) -> np.ndarray:
    """The vertices (v, 3) where the surfaces meet on which they lie: by steps of least length (Newton).

    Of whole surfaces: beyond its borders, a curve goes on along its tangents, and meets a tangent wall anywhere.
    """
    whole = [replace(curve, part=None, arc=None) for curve in curves]
    owner = vessel.outlines.corners.owner
    # The outline of a flat wall that was put level moves with it.
    is_moving = on_curve >= 0
    is_moving[list(planes)] = True
    is_wanted = np.zeros(len(vessel.vertices), dtype=bool)
    is_wanted[vessel.corners[is_moving[owner]]] = True
    surface_of = np.where(on_curve >= 0, on_curve, -1 - np.arange(len(on_curve)))
    own = is_wanted[vessel.corners]
    vertex, surface = vessel.corners[own], surface_of[owner[own]]
    order = np.lexsort((surface, vertex))
    groups: dict[tuple[int, ...], list[int]] = {}
    surfaces_of = Ragged(np.bincount(vertex)[is_wanted[: vertex.max(initial=-1) + 1]]).split(surface[order])
    for at, beside in zip(np.flatnonzero(is_wanted).tolist(), surfaces_of, strict=True):
        groups.setdefault(tuple(dict.fromkeys(beside.tolist())), []).append(at)
    moved = vessel.vertices.copy()
    for surfaces, vertices in groups.items():
        points = moved[vertices]
        now = math.inf
        # Where surfaces are tangent, a step halves the error only; where too many meet, an error stays.
        for step in range(40):
            off, slopes = [], []
            for number in surfaces:
                if number >= 0:
                    distance, direction, _ = whole[number].touch(points)
                else:
                    normal, offset = vessel.normals[-1 - number], vessel.offsets[-1 - number]
                    if -1 - number in planes:
                        normal, offset = planes[-1 - number][:3], planes[-1 - number][3]
                    distance = points @ normal - offset
                    direction = np.broadcast_to(normal, points.shape)
                off.append(distance)
                slopes.append(direction)
            away = np.stack(off, axis=1)
            before, now = now, np.abs(away).max()
            if now < 1e-17 or (step > 2 and now > 0.9 * before):
                break
            points = points - (np.linalg.pinv(np.stack(slopes, axis=1), rcond=1e-7) @ away[..., None])[..., 0]
        moved[vertices] = points
    return moved


def _level_planes(vessel: Vessel, curves: list[Curve], on_curve: np.ndarray, tolerance: float) -> dict[int, np.ndarray]:
    """Planes (normal, offset) of the flat facets that meet curves, across or along their axes where they nearly are."""
    planes: dict[int, np.ndarray] = {}
    sides = vessel.edge_arrays.facets
    for facets in sides[(on_curve[sides] >= 0).any(axis=1) & (on_curve[sides] < 0).any(axis=1)].tolist():
        for flat, other in (facets, facets[::-1]):
            if on_curve[flat] >= 0 or on_curve[other] < 0 or flat in planes:
                continue
            own, axis = vessel.normals[flat], curves[on_curve[other]].axis
            points = vessel.vertices[np.concatenate(vessel.loops[flat])]
            cosine = float(own @ axis)
            across = own - cosine * axis
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
    if curve.is_trimmed:
        return curve
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
        tip = -curve.major / math.sin(curve.slope) if curve.slope else math.nan
        found = float(along.min()), float(along.max())
        changes["ends"] = tuple(old if old == tip else end for old, end in zip(curve.ends, found, strict=True))
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
    return replace(curve, **changes)


def _are_one(vessel: Vessel, moved: np.ndarray, pairs: np.ndarray, tolerance: float) -> np.ndarray:
    """Which pairs (2, n) of vertices are in one place once they are moved (v, 3).

    Of two that were both put on a border from across it, rounding is left between them, which may point back along it.
    """
    drawn, now = (lengths(points[pairs[1]] - points[pairs[0]])[:, 0] for points in (vessel.vertices, moved))
    return (now < WELD * vessel.size) | ((now < tolerance) & (drawn > 4 * tolerance))


def _sides(vessel: Vessel) -> np.ndarray:
    """The vertices (2, n) at which each side of the outlines begins and ends."""
    return np.array([vessel.corners, vessel.corners[vessel.outlines.loops.ahead]])


def _without_collapsed(vessel: Vessel, moved: np.ndarray, tolerance: float) -> tuple[Outlines, np.ndarray]:
    """The outlines through moved vertices (v, 3) of the facets that are still some, and the numbers of these.

    The vertices of a facet that is hardly wider than the file's rounding may all be put on one border. Its neighbours
    meet there once those that are in one place by now are one.
    """
    begin, sides = vessel.corners, _sides(vessel)
    is_short = _are_one(vessel, moved, sides, tolerance)
    if not is_short.any():
        kept = np.arange(len(vessel.normals))
        return Outlines(moved[begin], vessel.outlines.loops, vessel.outlines.facets), kept
    # Two may come to one place without a side between them, where a diagonal of the drawing crossed the border.
    near = cKDTree(moved).query_pairs(tolerance, output_type="ndarray").T
    pairs = np.hstack([sides[:, is_short], near[:, _are_one(vessel, moved, near, tolerance)]])
    graph = coo_array((np.ones(len(pairs.T)), pairs), (len(moved),) * 2)
    _, number = connected_components(graph, directed=False)
    _, first = np.unique(number, return_index=True)
    outlines = vessel.outlines.lists(number[begin])
    loops = [[way for loop in facet if (way := _around(loop.tolist()))] for facet in outlines]
    kept = np.flatnonzero([len(facet) > 0 for facet in loops])
    return Outlines.of([moved[first[loop]] for loop in loops[facet]] for facet in kept.tolist()), kept


def _around(loop: list[int]) -> list[int]:
    """An outline without sides from a vertex to itself, and without those that go to another and straight back."""
    way: list[int] = []
    for vertex in loop:
        if vertex in way[-1:]:
            continue
        if vertex in way[-2:-1]:
            way.pop()
        else:
            way.append(vertex)
    while len(way) > 2 and (way[-1] in way[:2] or way[-2] == way[0]):
        way = way[:-1] if way[-1] == way[0] else way[1:-1] if way[-1] == way[1] else way[:-2]
    return way if len(way) > 2 else []


def _made_whole(vessel: Vessel, free: list[int], curves: list[Curve], on_curve: np.ndarray) -> np.ndarray:
    """Let curves of a vessel be whole surfaces that end at their facets; returns on_curve with their parts joined."""
    given = np.full(len(on_curve), -1)
    given[vessel.placed_from] = vessel.facet_curves
    pairs = vessel.facet_curves[vessel.edge_arrays.facets]
    joined = [a != b and min(a, b) >= 0 and vessel.curves[a].is_part_of(vessel.curves[b]) for a, b in pairs.tolist()]
    count = len(vessel.curves)
    _, group = connected_components(coo_array((np.ones(sum(joined)), pairs[joined].T), (count, count)), directed=False)
    on_curve = on_curve.copy()
    for each in np.unique(group[free]).tolist():
        own = np.isin(given, np.flatnonzero(group == each))
        number = int(on_curve[own].min())
        curves[number] = replace(endless(curves[number]), is_trimmed=True)
        if curves[number].kind == "sphere":
            # Its border is nearly a circle about its own middle: it has no other axis.
            middles = vessel.outlines.middles[np.isin(vessel.facet_curves, np.flatnonzero(group == each))]
            way = (middles - curves[number].origin).sum(axis=0)
            if np.linalg.norm(way) > 1e-3 * vessel.size:
                curves[number] = replace(curves[number], axis=way / np.linalg.norm(way))
        on_curve[own] = number
    return on_curve


def whole_patches(
    vessel: Vessel, curves: list[Curve], on_curve: np.ndarray, set_planes: dict[int, np.ndarray], tolerance: float
) -> Vessel:
    """The vessel with those curves whose patches are exact everywhere."""
    report: list[str] = []

    def without(spoilt: np.ndarray, at: np.ndarray, why: str = "a round wall ends at drawn ones") -> np.ndarray:
        """on_curve without the facets (f,) of patches that are spoilt near a place (3,)."""
        report.append(
            f"{spoilt.sum()} facets stay flat, since {why} near "
            f"({at[0] * 1e3:.4g}, {at[1] * 1e3:.4g}, {at[2] * 1e3:.4g}) mm"
        )
        return np.where(spoilt, -1, on_curve)

    drawn_patch = facet_patches(vessel, vessel.edge_arrays.turn)
    as_drawn: set[int] = set()
    while (on_curve >= 0).any():
        planes = _level_planes(vessel, curves, on_curve, tolerance) | set_planes
        planes = {facet: plane for facet, plane in planes.items() if facet not in as_drawn}
        moved = _moved_vertices(vessel, curves, on_curve, planes)
        # Walls that are off by the tolerance, and tangent, meet within this; others are not those of the drawing.
        away = np.linalg.norm(moved - vessel.vertices, axis=1)
        if not away.max() <= math.sqrt(tolerance * vessel.size):
            worst = np.nanargmax(np.where(np.isfinite(away), away, np.inf))
            beside = vessel.outlines.corners.owner[vessel.corners == worst]
            spoilt = np.isin(drawn_patch, drawn_patch[beside]) & (on_curve >= 0)
            if spoilt.any():
                on_curve = without(spoilt, vessel.vertices[worst])
            else:
                # A flat wall that was made tangent to one that is flat by now.
                as_drawn.update(beside.tolist())
            continue
        trimmed = [
            _trimmed(curve, moved[np.unique(vessel.corners[vessel.outlines.corners.rows(own)])])
            if len(own := np.flatnonzero(on_curve == number))
            else curve
            for number, curve in enumerate(curves)
        ]
        facets, kept = _without_collapsed(vessel, moved, tolerance)
        try:
            exact = Vessel(
                facets, vessel.name, vessel.solid, vessel.smooth_axis, trimmed, on_curve[kept], tuple(report)
            )
        except ConfigError:
            # The drawing is closed; as narrow as the file's rounding, its facets may fold where they are put on a wall.
            folded = vessel.outlines.corners.owner[_are_one(vessel, moved, _sides(vessel), tolerance)]
            spoilt = np.isin(drawn_patch, drawn_patch[folded]) & (on_curve >= 0)
            if not spoilt.any():
                raise
            on_curve = without(
                spoilt, vessel.outlines.middles[folded[0]], "facets as narrow as the file's rounding fold"
            )
            continue
        exact.placed_from = kept[exact.placed_from]
        borders = borders_of(exact)
        if free := must_be_trimmed(exact, borders):
            on_curve = _made_whole(exact, free, curves, on_curve)
            continue
        rough = rough_facets(exact, borders)
        if not rough:
            return exact
        patch = facet_patches(exact, borders.turn)
        # The facets of the exact vessel are in an order of their own.
        spoilt = np.zeros(len(on_curve), dtype=bool)
        spoilt[exact.placed_from] = np.isin(patch, patch[list(rough)])
        on_curve = without(spoilt, exact.outlines.middles[next(iter(rough))])
    return Vessel(vessel.outlines, vessel.name, vessel.solid, vessel.smooth_axis, report=tuple(report))
