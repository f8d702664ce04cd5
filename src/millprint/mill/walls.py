"""What a ball touches of the walls of a vessel, from flat arrays (mill.wall_arrays makes them).

A ball touches the local minima of its distance to the wall: the inside of a facet, a convex edge, or a corner. Where
two of them meet in a seam that is no more than a joint of facets, only the nearer one carries the contact: `joint_of`
says which features are pieces of one wall there (mill.wall_features), and dem.contact_events chooses and passes
contacts on.

A vessel and the inserts in it are bodies, each in a frame of its own. Features are numbered: the facets of all bodies
first, then the convex lines, the corners, the curves (mill.curved_surfaces), of which some facets are only a drawing,
the convex rims (mill.creases), and the convex creases (mill.creases).
"""

import math
from typing import NamedTuple

import numpy as np

from millprint.mill.creases import SIDE, Trims, beyond_trim, crease_beyond, crease_touch, past_bow, rim_touch
from millprint.mill.curved_surfaces import CURVE, curve_touch
from millprint.mill.kernel_columns import Vector, number_columns
from millprint.mill.motion import angular_velocity_of, rotation_of, velocity_of
from millprint.mill.vectors import add, add_scaled, cross, dot, rotate, rotate_back, row, subtract
from millprint.run.kernel import inlined, inner, kernel


class PlaneColumns(NamedTuple):
    """The plane of a facet."""

    normal: Vector  # unit vector towards the balls
    offset: int  # normal . x on the facet [m]


class Surfaces(NamedTuple):
    """Kinds of surface, each with a contact law of its own."""

    rough: int  # a wall as the contact set has it
    smooth: int  # without friction


# A foot so little outside of a facet, over the radius, is still on it: rounding leaves no gap between two facets.
ON_SIDE = 1e-9

PLANE, SURFACE = number_columns(PlaneColumns), number_columns(Surfaces)


class Walls(NamedTuple):
    """Flat arrays of the bodies' facets (f), their sides (s), lines (e), corners (c), curves (k), rims and so on.

    The features are facets, lines, corners, curves, rims and creases, in this order.
    """

    plane: np.ndarray  # (f, 4) see PlaneColumns
    axes: np.ndarray  # (f, 2, 3) unit vectors in the plane
    first_side: np.ndarray  # (f + 1,) sides of facet i are first_side[i] to first_side[i + 1]
    side: np.ndarray  # (s, width) creases.SideColumns
    slack: np.ndarray  # (f,) how far a facet reaches beyond its outline [m], see borders.Borders
    edge: np.ndarray  # (e, 5, 3) start, direction, inward of one facet, inward of the other, (length, 0, 0)
    corner: np.ndarray  # (c, 3)
    first_direction: np.ndarray  # (c + 1,)
    direction: np.ndarray  # (d, 3) edges that leave the corners
    body: np.ndarray  # (features,) the body that a feature belongs to
    surface: np.ndarray  # (features,) see Surfaces; edges and corners are rough
    curves: np.ndarray  # (k, width) curved_surfaces.CurveColumns
    rims: np.ndarray  # (rims, width) rims.RimColumns
    creases: np.ndarray  # (creases, rows, creases.DEGREE + 1) creases.CreaseRows
    # Where curves end that have other borders than circles and rulings: creases.Trims, whose bows flat walls have too.
    first_trim: np.ndarray
    trim_side: np.ndarray
    bow: np.ndarray
    trim_frame: np.ndarray
    is_drawing: np.ndarray  # (features,) 1 where a feature only shows a curve, see wall_features.Features
    patch: np.ndarray  # (features,) the patch that a feature belongs to, numbered through all bodies
    first_neighbour: np.ndarray  # (features + 1,) those of feature i are first_neighbour[i] to first_neighbour[i + 1]
    neighbour: np.ndarray  # features of a patch that meet each one in a vertex, ascending
    joint: np.ndarray  # how they meet, see wall_features.Joints
    grid_origin: np.ndarray  # (b, 3) [m]
    grid_shape: np.ndarray  # (b, 3)
    grid_pitch: float  # [m]
    grid_first: np.ndarray  # (b,) number of a body's first cell
    cell_first: np.ndarray  # (cells + 1,)
    cell_feature: np.ndarray  # features that a ball with its centre in the cell may touch
    cell_sure: np.ndarray  # 1 where the foot of any such ball lies on the facet


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


@inlined()
def past_arc(side, k, u, v, right):
    """Of an arc over a side: squared distance of a point (u, v) from it, and whether it lies between arc and chord.

    right: whether the point is to the right of the chord. The distance is that of the circle where the point's nearest
    place on it is on the arc, else that of the nearer end.
    """
    sense, radius = side[k, SIDE.sense], side[k, SIDE.radius]
    out_u, out_v = u - side[k, SIDE.centre_u], v - side[k, SIDE.centre_v]
    begin_u, begin_v = side[k, SIDE.start_u] - side[k, SIDE.centre_u], side[k, SIDE.start_v] - side[k, SIDE.centre_v]
    end_u, end_v = side[k, SIDE.end_u] - side[k, SIDE.centre_u], side[k, SIDE.end_v] - side[k, SIDE.centre_v]
    reach = math.sqrt(out_u * out_u + out_v * out_v)
    after = sense * (begin_u * out_v - begin_v * out_u) >= 0.0
    before = sense * (out_u * end_v - out_v * end_u) >= 0.0
    nearest = (reach - radius) * (reach - radius)
    if not (after and before):
        from_begin = (out_u - begin_u) * (out_u - begin_u) + (out_v - begin_v) * (out_v - begin_v)
        from_end = (out_u - end_u) * (out_u - end_u) + (out_v - end_v) * (out_v - end_v)
        nearest = min(from_begin, from_end)
    return nearest, (right == (sense > 0.0)) and reach < radius


@kernel()
def beyond_side(axes, first_side, side, bow, facet, point):
    """Distance of the foot of `point` on a facet's plane from its outline [m]; negative inside."""
    u, v = dot(row(axes[facet], 0), point), dot(row(axes[facet], 1), point)
    nearest = 1e300
    inside = False
    for k in range(first_side[facet], first_side[facet + 1]):
        du, dv, length = side[k, SIDE.direction_u], side[k, SIDE.direction_v], side[k, SIDE.length]
        ru, rv = u - side[k, SIDE.start_u], v - side[k, SIDE.start_v]
        along = min(max(ru * du + rv * dv, 0.0), length)
        away_u, away_v = ru - along * du, rv - along * dv
        # Even-odd rule with a ray along u: it works for outlines with holes and inward corners. Compared with the
        # vertices' own numbers, or rounding would count the corner between two sides twice or not at all.
        spans = (v >= side[k, SIDE.start_v]) != (v >= side[k, SIDE.end_v])
        across = ru * dv - rv * du
        inside ^= spans & (across * dv < 0)
        if side[k, SIDE.radius] > 0.0:
            # On the chord itself, the point is on the side that the rule above takes it for.
            right = across > 0.0 or (across == 0.0 and dv > 0.0)
            squared, between = past_arc(side, k, u, v, right)
            nearest = min(nearest, squared)
            inside ^= between
        elif side[k, SIDE.radius] < 0.0:
            right = across > 0.0 or (across == 0.0 and dv > 0.0)
            squared, between = past_bow(bow, int(side[k, SIDE.centre_u]), ru * du + rv * dv, -across, length, right)
            nearest = min(nearest, squared)
            inside ^= between
        else:
            nearest = min(nearest, away_u * away_u + away_v * away_v)
    distance = math.sqrt(nearest)
    return -distance if inside else distance


@inlined()
def touch(walls, feature, surely_over, point, limit):
    """Distance from `point` (body frame) to a feature that a ball of radius `limit` there touches, and the direction.

    surely_over: nonzero where the foot is known to lie on the facet. Returns (distance, unit vector from the wall to
    the ball); the distance is -1 where nothing is touched.
    """
    facets, edges = walls.plane.shape[0], walls.edge.shape[0]
    nothing = (-1.0, (0.0, 0.0, 0.0))
    if walls.is_drawing[feature]:
        return nothing
    if feature < facets:
        normal = row(walls.plane, feature)
        distance = plane_distance(walls, feature, point)
        if distance >= limit or distance <= 0.0:
            return nothing
        if not surely_over:
            beyond = beyond_side(walls.axes, walls.first_side, walls.side, walls.bow, feature, point)
            if beyond > ON_SIDE * limit + walls.slack[feature]:
                return nothing
        return distance, normal
    if feature >= facets + edges + walls.corner.shape[0]:
        k = curve_of(walls, feature)
        if k >= walls.curves.shape[0]:
            k -= walls.curves.shape[0]
            if k < walls.rims.shape[0]:
                distance, normal, is_over = rim_touch(walls.rims, k, point)
            else:
                distance, normal, is_over = crease_touch(walls.creases, k - walls.rims.shape[0], point)
            if distance >= limit or not is_over:
                return nothing
            return distance, normal
        distance, normal, past, _ = curve_touch(walls.curves, k, point)
        if distance >= limit or distance <= 0.0 or past > ON_SIDE * limit + walls.curves[k, CURVE.slack]:
            return nothing
        if walls.first_trim[k] < walls.first_trim[k + 1]:
            foot = add_scaled(point, -distance, normal)
            trims = Trims(walls.first_trim, walls.trim_side, walls.bow, walls.trim_frame)
            if beyond_trim(walls.curves, trims, k, foot) > ON_SIDE * limit + walls.curves[k, CURVE.slack]:
                return nothing
        return distance, normal
    if feature < facets + edges:
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
        corner = feature - facets - edges
        away = subtract(point, row(walls.corner, corner))
        for k in range(walls.first_direction[corner], walls.first_direction[corner + 1]):
            if dot(away, row(walls.direction, k)) > 0.0:
                return nothing
    distance = math.sqrt(dot(away, away))
    if distance >= limit or distance == 0.0:
        return nothing
    return distance, (away[0] / distance, away[1] / distance, away[2] / distance)


@inlined()
def curve_of(walls, feature):
    """The curve that a feature is, if it is one; rims and creases have numbers after those of all curves."""
    return feature - walls.plane.shape[0] - walls.edge.shape[0] - walls.corner.shape[0]


@inner()
def joint_of(walls, feature, other):
    """How two features of one patch meet (features.Joints); -1 for those that do not meet in a vertex."""
    for at in range(walls.first_neighbour[feature], walls.first_neighbour[feature + 1]):
        if walls.neighbour[at] == other:
            return walls.joint[at]
    return -1


@inlined()
def closeness_of(walls, feature, point, radius, margin):
    """Whether a ball there may touch a feature before it has moved by `margin`: 0 no, 1 maybe, 2 over the facet.

    2 says that the foot stays on the facet, whatever the ball does within the margin.
    """
    facets, edges = walls.plane.shape[0], walls.edge.shape[0]
    reach_out = radius + margin
    if walls.is_drawing[feature]:
        return 0
    if feature < facets:
        distance = plane_distance(walls, feature, point)
        if distance > reach_out or distance < -margin:
            return 0
        beyond = beyond_side(walls.axes, walls.first_side, walls.side, walls.bow, feature, point)
        if beyond > margin + ON_SIDE * radius + walls.slack[feature]:
            return 0
        return 2 if beyond < -margin else 1
    if feature >= facets + edges + walls.corner.shape[0]:
        k = curve_of(walls, feature)
        if k >= walls.curves.shape[0]:
            k -= walls.curves.shape[0]
            if k >= walls.rims.shape[0]:
                return 1 if crease_beyond(walls.creases, k - walls.rims.shape[0], point) < reach_out else 0
            return 1 if rim_touch(walls.rims, k, point)[0] < reach_out else 0
        distance, _, past, _ = curve_touch(walls.curves, k, point)
        is_over = past <= margin + ON_SIDE * radius + walls.curves[k, CURVE.slack]
        return 1 if -margin <= distance <= reach_out and is_over else 0
    if feature < facets + edges:
        edge = walls.edge[feature - facets]
        away = subtract(point, row(edge, 0))
        along = min(max(dot(away, row(edge, 1)), 0.0), edge[4, 0])
        away = add_scaled(away, -along, row(edge, 1))
    else:
        away = subtract(point, row(walls.corner, feature - facets - edges))
    return 1 if dot(away, away) < reach_out * reach_out else 0


@inlined()
def bounding_plane(walls, feature, point, margin):
    """A plane (normal, offset) to which a ball near `point` (body frame) is at most as far as to the feature.

    It holds until the ball has moved by `margin` [m]. For lines, corners, rims, creases and the inside of tight curves
    it is nowhere far: normal and offset are 0.
    """
    facets = walls.plane.shape[0]
    if feature < facets:
        return row(walls.plane, feature), walls.plane[feature, PLANE.offset]
    k = curve_of(walls, feature)
    if 0 <= k < walls.curves.shape[0]:
        distance, normal, _, bend = curve_touch(walls.curves, k, point)
        # Nearer to the middle of the bend by the margin, a wall bends more.
        if bend * margin < 0.5:
            sag = margin * margin * max(bend, 0.0)
            return normal, dot(normal, point) - distance + sag
    return (0.0, 0.0, 0.0), 0.0


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
