"""The walls of a vessel as flat arrays, and a grid of cells that finds what is near a ball."""

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from millprint.mill.borders import borders_of, outline_sides
from millprint.mill.creases import DEGREE, SIDE, TRIM, Trims, rim_rows
from millprint.mill.curved_surfaces import CURVE, curve_rows
from millprint.mill.drawn_creases import bowed_side, crease_rows, joined_trims
from millprint.mill.kernel_columns import width_of
from millprint.mill.outlines import Ragged, lengths
from millprint.mill.vectors import add_scaled, row
from millprint.mill.vessel import Vessel
from millprint.mill.wall_features import features_of
from millprint.mill.walls import SURFACE, Walls, closeness_of
from millprint.run.kernel import array_maker, inlined, inner

# The most cells of the grids, of 8 bytes each: where they would be more, as in a vessel of 20 L with balls of 5 mm,
# they are wider. They only find what may be near a ball, so that a run does not depend on their size.
CELLS_MAX = 1 << 24


@lru_cache(maxsize=64)
def facet_sides(vessel: Vessel) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Number of sides of each facet (f,), the sides (s, width) in the facets' own axes (creases.SideColumns), and bows.

    Further: the polynomials (n, DEGREE + 1) of sides that bow, of which these have the rows.
    """
    loops, facets = vessel.outlines.loops, vessel.outlines.facets
    flat = np.empty((len(vessel.corners), 2))
    for own, rows in loops.stacks():
        flat[rows] = vessel.outlines.points[rows] @ vessel.axes[facets.owner[own]].transpose(0, 2, 1)
    has_arc = np.zeros(len(vessel.edge_arrays.turn), dtype=bool)
    has_arc[[*borders_of(vessel).arcs, *borders_of(vessel).creases]] = True
    is_round = np.logical_or.reduceat(has_arc[vessel.edge_of_side], loops.first)
    is_round &= vessel.facet_curves[facets.owner] < 0
    counts, arcs = loops.counts.copy(), {}
    bows: list[np.ndarray] = []
    for loop in np.flatnonzero(is_round).tolist():
        facet = int(facets.owner[loop])
        along = slice(loops.first[loop], loops.first[loop] + loops.counts[loop])
        arcs[loop] = _round_sides(vessel, facet, loop - int(facets.first[facet]), flat[along], bows)
        counts[loop] = len(arcs[loop])
    found = Ragged(counts)
    sides = np.zeros((len(found.owner), width_of(SIDE)))
    straight = np.flatnonzero(~is_round)
    starts, ends = flat[loops.rows(straight)], flat[loops.ahead[loops.rows(straight)]]
    sides[found.rows(straight), : SIDE.centre_u] = _straight_sides(starts, ends)
    for loop, own in arcs.items():
        sides[found.first[loop] : found.first[loop] + len(own)] = own
    return np.add.reduceat(counts, facets.first), sides, np.array(bows).reshape(-1, DEGREE + 1)


def all_sides(bodies: Sequence[Vessel]) -> tuple[np.ndarray, np.ndarray, Trims]:
    """Walls.first_side, side and trims."""
    counts, parts = [], []
    for body in bodies:
        count, sides, bows = facet_sides(body)
        counts.append(count)
        parts.append(Trims(np.array([0, len(sides)]), sides, bows, np.empty((0, width_of(TRIM)))))
    nothing = Trims(np.zeros(2, dtype=np.int64), parts[0].side[:0], parts[0].bow[:0], np.zeros((1, width_of(TRIM))))
    parts += [borders_of(body).trims.get(number, nothing) for body in bodies for number in range(len(body.curves))]
    joined, flat = joined_trims(parts), len(bodies)
    of_facets = joined.first[flat]
    trims = joined._replace(first=joined.first[flat:] - of_facets, side=joined.side[of_facets:])
    return np.cumsum([0, *np.concatenate(counts)]), joined.side[:of_facets], trims


def _straight_sides(starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """SideColumns of lines between points (n, 2) [m]."""
    length = np.linalg.norm(ends - starts, axis=1)[:, None]
    return np.hstack([starts, (ends - starts) / length, length, ends])


def _round_sides(vessel: Vessel, facet: int, loop: int, flat: np.ndarray, bows: list[np.ndarray]) -> np.ndarray:
    """The sides (n, width) of an outline with arcs, whose vertices are at (k, 2) in the facet's own axes [m].

    bows: takes the polynomials of those sides that bow.
    """
    outline, axes = outline_sides(vessel, facet, loop), vessel.axes[facet].T
    rows = np.zeros((len(outline), width_of(SIDE)))
    rows[:, : SIDE.centre_u] = _straight_sides(flat[[side.begin for side in outline]], flat[[s.end for s in outline]])
    for row_of, side in zip(rows, outline, strict=True):
        if side.arc:
            row_of[[SIDE.centre_u, SIDE.centre_v]] = middle = side.arc.centre @ axes
            row_of[SIDE.radius] = side.arc.radius
            # The chord of an arc of less than half a turn has its middle on the left where that turns left.
            begin, end = row_of[[SIDE.start_u, SIDE.start_v]] - middle, row_of[[SIDE.end_u, SIDE.end_v]] - middle
            row_of[SIDE.sense] = np.sign(begin[0] * end[1] - begin[1] * end[0])
        elif side.crease:
            points = side.crease.points @ axes
            near = np.abs(points[[0, -1]] - flat[side.begin]).sum(axis=1)
            made = bowed_side(points if near[0] < near[1] else points[::-1], vessel.size)
            if made and made[1] is not None:
                row_of[SIDE.radius], row_of[SIDE.centre_u] = -1.0, len(bows)
                bows.append(made[1])
    return rows


def _edge_rows(vessel: Vessel) -> np.ndarray:
    lines = features_of(vessel).lines
    rows = np.zeros((len(lines), 5, 3))
    if lines:
        rows[:, 0] = [edge.start for edge in lines]
        rows[:, 1] = np.array([edge.end for edge in lines]) - rows[:, 0]
        rows[:, 4, :1] = lengths(rows[:, 1])
        rows[:, 1] /= rows[:, 4, :1]
        rows[:, 2:4] = [edge.inward for edge in lines]
    return rows


def _grids(bodies: Sequence[Vessel], reach_out: float, pitch: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Origin (b, 3) and shape (b, 3) of every body's grid, and the number of its first cell (b + 1,).

    A ball's centre is inside the vessel; it can touch an insert from outside the insert's box.
    """
    origins, shapes = [], []
    for number, body in enumerate(bodies):
        low, high = body.bounds + np.array([[-1], [1]]) * (body.sagitta + (reach_out if number else 0.0))
        origins.append(low)
        shapes.append(np.ceil((high - low) / pitch).astype(np.int64))
    return np.array(origins), np.array(shapes), np.cumsum([0, *(int(shape.prod()) for shape in shapes)])


def _counts(body: Vessel) -> list[int]:
    """Numbers of facets, lines, corners, curves, rims and creases."""
    own = features_of(body)
    return [len(each) for each in (body.normals, own.lines, own.corners, body.curves, own.rims, own.creases)]


def _joined(bodies: Sequence[Vessel], of_bodies: Sequence[np.ndarray]) -> np.ndarray:
    """What belongs to the features of each body, in the order of the walls' features: those of one kind together."""
    cuts = [np.cumsum([0, *_counts(body)]).tolist() for body in bodies]
    own = list(zip(of_bodies, cuts, strict=True))
    return np.concatenate([values[cut[kind] : cut[kind + 1]] for kind in range(6) for values, cut in own])


def _surfaces(bodies: Sequence[Vessel], features: int) -> np.ndarray:
    """The surface of every feature: only facets can be smooth."""
    surface = np.full(features, SURFACE.rough)
    smooth = np.concatenate([body.is_smooth for body in bodies])
    surface[: len(smooth)][smooth] = SURFACE.smooth
    return surface


def _patches(bodies: Sequence[Vessel]) -> np.ndarray:
    """Walls.patch: the patches of one body after the other."""
    found = [features_of(body) for body in bodies]
    first = np.cumsum([0, *(each.patches for each in found)])
    return _joined(bodies, [each.patch + begin for each, begin in zip(found, first, strict=False)])


def _neighbours(bodies: Sequence[Vessel]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Walls.first_neighbour, neighbour and joint."""
    counts = [sum(_counts(body)) for body in bodies]
    own = _joined(bodies, [np.arange(count) for count in counts])
    body_of = _joined(bodies, [np.full(count, number) for number, count in enumerate(counts)])
    found = []
    for number, each in enumerate(map(features_of, bodies)):
        at = np.flatnonzero(body_of == number)
        # The number among all features of each of the body's own.
        rank = np.empty(len(at), dtype=np.int64)
        rank[own[at]] = at
        found.append([rank.repeat(np.diff(each.first_neighbour)), rank[each.neighbour], each.joint])
    owner, neighbour, joint = np.concatenate(found, axis=1)
    order = np.lexsort((neighbour, owner))
    return np.cumsum([0, *np.bincount(owner, minlength=len(own))]), neighbour[order], joint[order]


def _boxes(body: Vessel) -> np.ndarray:
    """Lower and upper corner (features, 2, 3) of boxes that hold every feature [m]: of a curve, that of its body."""
    found, corners = features_of(body), body.outlines.corners
    ends = np.array([(edge.start, edge.end) for edge in found.lines]).reshape(-1, 2, 3)
    points = np.array([corner.point for corner in found.corners]).reshape(-1, 3)
    low = [np.minimum.reduceat(body.outlines.points, corners.first), ends.min(axis=1), points]
    high = [np.maximum.reduceat(body.outlines.points, corners.first), ends.max(axis=1), points]
    boxes = np.stack(
        [
            np.concatenate([*low, *[body.bounds[:1]] * len(body.curves)]) - body.sagitta,
            np.concatenate([*high, *[body.bounds[1:]] * len(body.curves)]) + body.sagitta,
        ],
        axis=1,
    )
    rims = np.array([(rim.centre - rim.radius, rim.centre + rim.radius) for rim in found.rims]).reshape(-1, 2, 3)
    chords = np.array([crease.points for crease in found.creases]).reshape(-1, DEGREE + 3, 3)
    creases = np.stack([chords.min(axis=1), chords.max(axis=1)], axis=1)
    return np.concatenate([boxes, rims, creases])


def build_walls(bodies: Sequence[Vessel], radius: float, margin: float, pitch: float) -> Walls:
    """Flat arrays of bodies, the vessel first, for balls of at most `radius`, and grids that find what is near a ball.

    margin: how far a ball may move before the lists are rebuilt [m]; pitch: size of the grids' cells [m], if these are
    not more than CELLS_MAX.

    Nothing writes into the arrays, so simulations of a job in the same bodies share them.
    """
    boxes = sum(float(np.prod(np.ptp(body.bounds, axis=0))) for body in bodies)
    return _build_walls(tuple(bodies), radius, margin, max(pitch, math.cbrt(boxes / CELLS_MAX)))


@lru_cache(maxsize=2)
def _build_walls(bodies: tuple[Vessel, ...], radius: float, margin: float, pitch: float) -> Walls:
    first_side, side, trims = all_sides(bodies)
    corners = [corner for body in bodies for corner in features_of(body).corners]
    origin, shape, grid_first = _grids(bodies, radius + margin, pitch)
    body_numbers = _joined(bodies, [np.full(sum(_counts(body)), number) for number, body in enumerate(bodies)])
    curves = np.concatenate([curve_rows(body.curves) for body in bodies])
    curves[:, CURVE.slack] = np.concatenate([borders_of(body).curve_slack for body in bodies])
    first_neighbour, neighbour, joint = _neighbours(bodies)
    walls = Walls(
        plane=np.concatenate([np.column_stack([body.normals, body.offsets]) for body in bodies]),
        axes=np.concatenate([body.axes for body in bodies]),
        first_side=first_side,
        side=side,
        slack=np.concatenate([borders_of(body).slack for body in bodies]),
        edge=np.concatenate([_edge_rows(body) for body in bodies]),
        corner=np.array([corner.point for corner in corners]).reshape(-1, 3),
        first_direction=np.cumsum([0, *(len(corner.directions) for corner in corners)]),
        direction=np.concatenate([np.empty((0, 3)), *(corner.directions for corner in corners)]),
        body=body_numbers,
        surface=_surfaces(bodies, len(body_numbers)),
        curves=curves,
        rims=np.concatenate([rim_rows(features_of(body).rims) for body in bodies]),
        creases=np.concatenate([crease_rows(features_of(body).creases) for body in bodies]),
        first_trim=trims.first,
        trim_side=trims.side,
        bow=trims.bow,
        trim_frame=trims.frame,
        is_drawing=_joined(bodies, [features_of(body).is_drawing for body in bodies]).astype(np.uint8),
        patch=_patches(bodies),
        first_neighbour=first_neighbour,
        neighbour=neighbour,
        joint=joint,
        grid_origin=origin,
        grid_shape=shape,
        grid_pitch=float(pitch),
        grid_first=grid_first[:-1],
        cell_first=np.zeros(grid_first[-1] + 1, dtype=np.int64),
        cell_feature=np.empty(0, dtype=np.int64),
        cell_sure=np.empty(0, dtype=np.uint8),
    )
    # Nothing of a cell is farther from its middle than half its diagonal.
    reach = margin + pitch * math.sqrt(3) / 2
    low, high = _joined(bodies, list(map(_boxes, bodies))).transpose(1, 0, 2)
    around = (1 + 1e-9) * (radius + 2 * reach) + max(walls.slack.max(), walls.curves[:, CURVE.slack].max(initial=0.0))
    features, sure = fill_cells(walls, radius, reach, low - around, high + around)
    return walls._replace(cell_feature=features, cell_sure=sure)


@inlined()
def cells_between(origin, cells, pitch, low, high):
    """First and last plus one of a grid's cells, along an axis, whose middles lie between two numbers [m]."""
    first = math.floor((low - origin) / pitch - 0.5)
    last = math.ceil((high - origin) / pitch - 0.5)
    return int(min(max(first, 0.0), cells)), int(min(max(last + 1, 0.0), cells))


@inner()
def visit_cells(walls, radius, margin, low, high, feature, features, sure):
    """Count a feature in the cells near it or, where there is room in `features`, write it there from the back."""
    if walls.is_drawing[feature]:
        return
    body = walls.body[feature]
    origin, shape, pitch = row(walls.grid_origin, body), row(walls.grid_shape, body), walls.grid_pitch
    x_from, x_to = cells_between(origin[0], shape[0], pitch, low[feature, 0], high[feature, 0])
    y_from, y_to = cells_between(origin[1], shape[1], pitch, low[feature, 1], high[feature, 1])
    z_from, z_to = cells_between(origin[2], shape[2], pitch, low[feature, 2], high[feature, 2])
    for x in range(x_from, x_to):
        for y in range(y_from, y_to):
            for z in range(z_from, z_to):
                middle = add_scaled(origin, pitch, (x + 0.5, y + 0.5, z + 0.5))
                closeness = closeness_of(walls, feature, middle, radius, margin)
                if closeness == 0:
                    continue
                cell = walls.grid_first[body] + (x * shape[1] + y) * shape[2] + z
                if features.size == 0:
                    walls.cell_first[cell] += 1
                else:
                    walls.cell_first[cell] -= 1
                    features[walls.cell_first[cell]] = feature
                    sure[walls.cell_first[cell]] = closeness - 1


@array_maker()
def fill_cells(walls, radius, margin, low, high):
    """List for every cell the features near its middle; fills walls.cell_first; returns features and sureness.

    low, high: corners (features, 3) of boxes outside of which nothing is near a feature [m].
    """
    walls.cell_first[:] = 0
    features, sure = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.uint8)
    for feature in range(walls.body.size):
        visit_cells(walls, radius, margin, low, high, feature, features, sure)
    # Counts become ends; filling from the back turns ends into beginnings.
    for cell in range(1, walls.cell_first.size):
        walls.cell_first[cell] += walls.cell_first[cell - 1]
    count = walls.cell_first[-1]
    features, sure = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.uint8)
    for feature in range(walls.body.size - 1, -1, -1):
        visit_cells(walls, radius, margin, low, high, feature, features, sure)
    return features, sure
