"""The walls of a vessel as flat arrays, and what a ball touches of them.

A ball touches the local minima of its distance to the wall: the inside of a facet, a convex edge, or a corner. In a
seam it touches both facets, on a convex edge one edge. Where a ball is pressed into a seam, the foot of one facet can
leave that facet before its overlap has gone; each facet therefore reaches a little across its seams (`reach` of a
side), far enough that no contact is cut off before its overlap exceeds the bound at which a run fails.

A vessel and the inserts in it are bodies, each in a frame of its own. Features are numbered: the facets of all bodies
first, then the convex edges, then the corners.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from millprint.columns import Vector, number_columns
from millprint.kernel import array_maker, inlined, inner, kernel
from millprint.mill.pose import angular_velocity_of, rotation_of, velocity_of
from millprint.mill.vectors import add, add_scaled, cross, dot, rotate, rotate_back, row, subtract
from millprint.mill.vessel import Edge, Vessel, ahead


class PlaneColumns(NamedTuple):
    """The plane of a facet."""

    normal: Vector  # unit vector towards the balls
    offset: int  # normal . x on the facet [m]


class SideColumns(NamedTuple):
    """A side of a facet, in the axes u, v of its plane [m]."""

    start_u: int
    start_v: int
    direction_u: int  # of a unit vector
    direction_v: int
    length: int
    reach: int  # across the side
    end_u: int
    end_v: int


class Surfaces(NamedTuple):
    """Kinds of surface, each with a contact law of its own."""

    rough: int  # a wall as the contact set has it
    smooth: int  # without friction


# The most cells of the grids, of 8 bytes each: where they would be more, as in a vessel of 20 L with balls of 5 mm,
# they are wider. They only find what may be near a ball, so that a run does not depend on their size.
CELLS_MAX = 1 << 24

PLANE, SIDE, SURFACE = number_columns(PlaneColumns), number_columns(SideColumns), number_columns(Surfaces)


class Walls(NamedTuple):
    """Flat arrays of the bodies' facets (f), their sides (s), convex edges (e), corners (c), and grids of cells."""

    plane: np.ndarray  # (f, 4) see PlaneColumns
    axes: np.ndarray  # (f, 2, 3) unit vectors in the plane
    first_side: np.ndarray  # (f + 1,) sides of facet i are first_side[i] to first_side[i + 1]
    facet_reach: np.ndarray  # (f,) the largest reach of its sides [m]
    side: np.ndarray  # (s, 8) see SideColumns
    edge: np.ndarray  # (e, 5, 3) start, direction, inward of one facet, inward of the other, (length, 0, 0)
    corner: np.ndarray  # (c, 3)
    first_direction: np.ndarray  # (c + 1,)
    direction: np.ndarray  # (d, 3) edges that leave the corners
    body: np.ndarray  # (f + e + c,) the body that a feature belongs to
    surface: np.ndarray  # (f + e + c,) see Surfaces; edges and corners are rough
    grid_origin: np.ndarray  # (b, 3) [m]
    grid_shape: np.ndarray  # (b, 3)
    grid_pitch: float  # [m]
    grid_first: np.ndarray  # (b,) number of a body's first cell
    cell_first: np.ndarray  # (cells + 1,)
    cell_feature: np.ndarray  # features that a ball with its centre in the cell may touch
    cell_sure: np.ndarray  # 1 where the foot of any such ball lies on the facet


def _reach(edge: Edge, radius: float, overlap: float) -> float:
    """How far a facet extends behind a seam [m]: to where the overlap with the other facet is at its bound."""
    turn = abs(edge.turn)
    if edge.turn > 1e-9:
        return 0.0
    if turn < 1e-9:
        return radius
    return float(np.clip((overlap - radius * (1 - math.cos(turn))) / math.sin(turn), 0.0, radius))


def _sides(vessel: Vessel, radius: float, overlap: float) -> tuple[np.ndarray, np.ndarray]:
    """Number of sides of each facet (f,), and the sides (s, 8) in the facets' own axes (see `Walls.side`)."""
    counts, sides = [], []
    for facet in vessel.facets:
        axes = np.array(facet.axes).T
        for loop in facet.loops:
            flat = loop @ axes
            for start, end, edge in zip(flat, ahead(flat), vessel.edges_along(loop), strict=True):
                length = float(np.linalg.norm(end - start))
                reach = _reach(edge, radius, overlap)
                sides.append([*start, *(end - start) / length, length, reach, *end])
        counts.append(sum(map(len, facet.loops)))
    return np.array(counts), np.array(sides)


def _edge_rows(vessel: Vessel) -> np.ndarray:
    rows = np.zeros((len(vessel.convex_edges), 5, 3))
    for row_of, edge in zip(rows, vessel.convex_edges, strict=True):
        length = np.linalg.norm(edge.end - edge.start)
        row_of[:] = edge.start, (edge.end - edge.start) / length, *edge.inward, (length, 0, 0)
    return rows


def _grids(bodies: Sequence[Vessel], reach_out: float, pitch: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Origin (b, 3) and shape (b, 3) of every body's grid, and the number of its first cell (b + 1,).

    A ball's centre is inside the vessel; it can touch an insert from outside the insert's box.
    """
    origins, shapes = [], []
    for number, body in enumerate(bodies):
        low, high = body.bounds
        if number:
            low, high = low - reach_out, high + reach_out
        origins.append(low)
        shapes.append(np.ceil((high - low) / pitch).astype(np.int64))
    return np.array(origins), np.array(shapes), np.cumsum([0, *(int(shape.prod()) for shape in shapes)])


def _body_numbers(bodies: Sequence[Vessel]) -> np.ndarray:
    """The body of every feature: all facets, then all convex edges, then all corners."""
    groups = [[len(getattr(body, kind)) for body in bodies] for kind in ("facets", "convex_edges", "corners")]
    return np.concatenate([np.repeat(np.arange(len(bodies)), counts) for counts in groups])


def _surfaces(bodies: Sequence[Vessel]) -> np.ndarray:
    """The surface of every feature (f + e + c,): only facets can be smooth."""
    surface = np.full(len(_body_numbers(bodies)), SURFACE.rough)
    smooth = np.concatenate([body.is_smooth for body in bodies])
    surface[: len(smooth)][smooth] = SURFACE.smooth
    return surface


def _boxes(bodies: Sequence[Vessel]) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corners (f + e + c, 3) of boxes that hold every feature [m]."""
    outlines = [np.concatenate(facet.loops) for body in bodies for facet in body.facets]
    outlines += [np.array([edge.start, edge.end]) for body in bodies for edge in body.convex_edges]
    outlines += [np.array([corner.point]) for body in bodies for corner in body.corners]
    return np.array([each.min(axis=0) for each in outlines]), np.array([each.max(axis=0) for each in outlines])


def build_walls(bodies: Sequence[Vessel], radius: float, margin: float, overlap: float, pitch: float) -> Walls:
    """Flat arrays of bodies, the vessel first, for balls of at most `radius`, and grids that find what is near a ball.

    margin: how far a ball may move before the lists are rebuilt [m]; overlap: bound on any overlap [m];
    pitch: size of the grids' cells [m], if these are not more than CELLS_MAX.

    Nothing writes into the arrays, so simulations of a job in the same bodies share them.
    """
    boxes = sum(float(np.prod(np.ptp(body.bounds, axis=0))) for body in bodies)
    return _build_walls(tuple(bodies), radius, margin, overlap, max(pitch, math.cbrt(boxes / CELLS_MAX)))


@lru_cache(maxsize=2)
def _build_walls(bodies: tuple[Vessel, ...], radius: float, margin: float, overlap: float, pitch: float) -> Walls:
    counts, sides = zip(*(_sides(body, radius, overlap) for body in bodies), strict=True)
    side, first_side = np.concatenate(sides), np.cumsum([0, *np.concatenate(counts)])
    facets = [facet for body in bodies for facet in body.facets]
    corners = [corner for body in bodies for corner in body.corners]
    origin, shape, grid_first = _grids(bodies, radius + margin, pitch)
    walls = Walls(
        plane=np.array([[*facet.normal, facet.offset] for facet in facets]),
        axes=np.array([facet.axes for facet in facets]),
        first_side=first_side,
        facet_reach=np.maximum.reduceat(side[:, SIDE.reach], first_side[:-1]),
        side=side,
        edge=np.concatenate([_edge_rows(body) for body in bodies]),
        corner=np.array([corner.point for corner in corners]).reshape(-1, 3),
        first_direction=np.cumsum([0, *(len(corner.directions) for corner in corners)]),
        direction=np.concatenate([np.empty((0, 3)), *(corner.directions for corner in corners)]),
        body=_body_numbers(bodies),
        surface=_surfaces(bodies),
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
    low, high = _boxes(bodies)
    around = np.full((len(low), 1), (1 + 1e-9) * (radius + 2 * reach))
    around[: len(facets), 0] += walls.facet_reach
    features, sure = fill_cells(walls, radius, reach, low - around, high + around)
    return walls._replace(cell_feature=features, cell_sure=sure)


@inlined()
def body_of(walls, feature):
    """The body that a feature belongs to."""
    return walls.body[feature] if walls.grid_first.size > 1 else 0


@inlined()
def direction_to_laboratory(motions, body, direction):
    """A direction of a body's frame in the laboratory: R d."""
    return rotate(rotation_of(motions, body), direction) if motions.turns[body] else direction


@inlined()
def direction_to_body(motions, body, direction):
    """A direction of the laboratory in a body's frame: R^T d."""
    return rotate_back(rotation_of(motions, body), direction) if motions.turns[body] else direction


@inlined()
def to_body(motions, body, point):
    """A point of the laboratory in the frame of a body: R^T (x - X)."""
    return direction_to_body(motions, body, subtract(point, row(motions.pose, body)))


@inlined()
def wall_velocity(motions, body, point):
    """Velocity [m/s] of a body at a point of the laboratory: V + omega x (point - X)."""
    velocity = velocity_of(motions, body)
    if motions.turns[body]:
        arm = subtract(point, row(motions.pose, body))
        velocity = add(velocity, cross(angular_velocity_of(motions, body), arm))
    return velocity


@inlined()
def plane_distance(walls, feature, point):
    """Distance of `point` (body frame) from a facet's plane [m]; 0 for an edge or a corner."""
    if feature >= walls.plane.shape[0]:
        return 0.0
    return dot(row(walls.plane, feature), point) - walls.plane[feature, PLANE.offset]


@kernel()
def beyond_side(axes, first_side, side, facet, point, margin):
    """Where the foot of `point` lies on a facet's plane: (distance outside its outline [m], negative inside; reach).

    The reach is that of the nearest side, or the smallest of all sides that could become the nearest within `margin`.
    """
    u, v = dot(row(axes[facet], 0), point), dot(row(axes[facet], 1), point)
    nearest = 1e300
    reach = 0.0
    inside = False
    for k in range(first_side[facet], first_side[facet + 1]):
        du, dv, length = side[k, SIDE.direction_u], side[k, SIDE.direction_v], side[k, SIDE.length]
        ru, rv = u - side[k, SIDE.start_u], v - side[k, SIDE.start_v]
        along = min(max(ru * du + rv * dv, 0.0), length)
        away_u, away_v = ru - along * du, rv - along * dv
        squared = away_u * away_u + away_v * away_v
        if squared < nearest:
            nearest = squared
            reach = side[k, SIDE.reach]
        # Even-odd rule with a ray along u: it works for outlines with holes and inward corners. Compared with the
        # vertices' own numbers, or rounding would count the corner between two sides twice or not at all.
        if (v >= side[k, SIDE.start_v]) != (v >= side[k, SIDE.end_v]) and (ru * dv - rv * du) * dv < 0:
            inside = not inside
    distance = math.sqrt(nearest)
    if margin > 0.0:
        limit = (distance + 2 * margin) * (distance + 2 * margin)
        for k in range(first_side[facet], first_side[facet + 1]):
            ru, rv = u - side[k, SIDE.start_u], v - side[k, SIDE.start_v]
            along = min(max(ru * side[k, SIDE.direction_u] + rv * side[k, SIDE.direction_v], 0.0), side[k, SIDE.length])
            away_u, away_v = ru - along * side[k, SIDE.direction_u], rv - along * side[k, SIDE.direction_v]
            if away_u * away_u + away_v * away_v <= limit:
                reach = min(reach, side[k, SIDE.reach])
    return (-distance if inside else distance), reach


@inlined()
def touch(walls, feature, surely_over, point, limit):
    """Distance from `point` (body frame) to a feature that a ball of radius `limit` there touches, and the direction.

    surely_over: nonzero where the foot is known to lie on the facet. Returns (distance, unit vector from the wall to
    the ball); the distance is -1 where nothing is touched.
    """
    facets = walls.plane.shape[0]
    nothing = (-1.0, (0.0, 0.0, 0.0))
    if feature < facets:
        normal = row(walls.plane, feature)
        distance = plane_distance(walls, feature, point)
        if distance >= limit or distance <= 0.0:
            return nothing
        if not surely_over:
            beyond, reach = beyond_side(walls.axes, walls.first_side, walls.side, feature, point, 0.0)
            if beyond > reach:
                return nothing
        return distance, normal
    if feature < facets + walls.edge.shape[0]:
        edge = walls.edge[feature - facets]
        away = subtract(point, row(edge, 0))
        along = dot(away, row(edge, 1))
        if along <= 0.0 or along >= edge[4, 0]:
            return nothing
        away = add_scaled(away, -along, row(edge, 1))
        # A minimum of the distance only if both facets lead away from the ball; on the border the facet has it.
        if dot(away, row(edge, 2)) >= 0.0 or dot(away, row(edge, 3)) >= 0.0:
            return nothing
    else:
        corner = feature - facets - walls.edge.shape[0]
        away = subtract(point, row(walls.corner, corner))
        for k in range(walls.first_direction[corner], walls.first_direction[corner + 1]):
            if dot(away, row(walls.direction, k)) > 0.0:
                return nothing
    distance = math.sqrt(dot(away, away))
    if distance >= limit or distance == 0.0:
        return nothing
    return distance, (away[0] / distance, away[1] / distance, away[2] / distance)


@inner()
def near(walls, feature, point, radius, margin):
    """Whether a ball there may touch a feature before it has moved by `margin`: 0 no, 1 maybe, 2 over the facet.

    2 says that the foot stays on the facet or within its reach, whatever the ball does within the margin.
    """
    facets = walls.plane.shape[0]
    reach_out = radius + margin
    if feature < facets:
        distance = plane_distance(walls, feature, point)
        if distance > reach_out or distance < -margin:
            return 0
        beyond, reach = beyond_side(walls.axes, walls.first_side, walls.side, feature, point, margin)
        if beyond > margin + walls.facet_reach[feature]:
            return 0
        return 2 if beyond < -margin or beyond + margin < reach else 1
    if feature < facets + walls.edge.shape[0]:
        edge = walls.edge[feature - facets]
        away = subtract(point, row(edge, 0))
        along = min(max(dot(away, row(edge, 1)), 0.0), edge[4, 0])
        away = add_scaled(away, -along, row(edge, 1))
    else:
        away = subtract(point, row(walls.corner, feature - facets - walls.edge.shape[0]))
    return 1 if dot(away, away) < reach_out * reach_out else 0


@inlined()
def cell_of(walls, body, point):
    """Index of the cell of a body's grid that holds `point` (body frame); -1 outside the grid."""
    shape = row(walls.grid_shape, body)
    away = subtract(point, row(walls.grid_origin, body))
    x, y, z = (
        math.floor(away[0] / walls.grid_pitch),
        math.floor(away[1] / walls.grid_pitch),
        math.floor(away[2] / walls.grid_pitch),
    )
    if x < 0 or y < 0 or z < 0 or x >= shape[0] or y >= shape[1] or z >= shape[2]:
        return -1
    return walls.grid_first[body] + int((x * shape[1] + y) * shape[2] + z)


@inlined()
def cells_between(walls, body, axis, low, high):
    """First and last plus one of a grid's cells, along an axis, whose middles lie between two numbers [m]."""
    origin, cells = walls.grid_origin[body, axis], walls.grid_shape[body, axis]
    first = math.floor((low - origin) / walls.grid_pitch - 0.5)
    last = math.ceil((high - origin) / walls.grid_pitch - 0.5)
    return int(min(max(first, 0.0), cells)), int(min(max(last + 1, 0.0), cells))


@inner()
def visit_cells(walls, radius, margin, low, high, feature, features, sure):
    """Count a feature in the cells near it or, where there is room in `features`, write it there from the back."""
    body = walls.body[feature]
    shape = row(walls.grid_shape, body)
    x_from, x_to = cells_between(walls, body, 0, low[feature, 0], high[feature, 0])
    y_from, y_to = cells_between(walls, body, 1, low[feature, 1], high[feature, 1])
    z_from, z_to = cells_between(walls, body, 2, low[feature, 2], high[feature, 2])
    for x in range(x_from, x_to):
        for y in range(y_from, y_to):
            for z in range(z_from, z_to):
                middle = add_scaled(row(walls.grid_origin, body), walls.grid_pitch, (x + 0.5, y + 0.5, z + 0.5))
                closeness = near(walls, feature, middle, radius, margin)
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
