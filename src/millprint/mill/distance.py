"""Exact signed distance to the walls of a vessel or of a solid, and its gradient."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from millprint.mill.borders import SAME, borders_of
from millprint.mill.creases import (
    CREASE,
    Rim,
    Trims,
    beyond_trim,
    crease_nearest,
    crease_place,
    crease_vector,
    rim_distance,
    rim_rows,
)
from millprint.mill.curved_surfaces import CURVE, curve_rows, curve_touch
from millprint.mill.drawn_creases import crease_rows
from millprint.mill.outlines import cross
from millprint.mill.vectors import add_scaled, dot, row, scale, subtract
from millprint.mill.vessel import Vessel
from millprint.mill.wall_arrays import all_sides
from millprint.mill.walls import beyond_side
from millprint.run.kernel import array_maker, inlined, inner, merged

# Facets whose box is looked at first.
BLOCK = 32


class Surface(NamedTuple):
    """Facets (f) and their sides (s); a side is a directed edge of a facet's outline.

    facets without a part in the distance are left out: those that only draw a curve, and have no edge on their outline.
    """

    listed: np.ndarray  # numbers of the facets that are looked at, in blocks of BLOCK next to each other
    box: np.ndarray  # (blocks, 2, 3) lower and upper corner of each [m]
    normal: np.ndarray  # (f, 3) inward
    offset: np.ndarray  # (f,)
    axes: np.ndarray  # (f, 2, 3) unit vectors in the plane
    first_side: np.ndarray  # (f + 1,)
    start: np.ndarray  # (s, 3)
    along: np.ndarray  # (s, 3) unit vectors
    length: np.ndarray  # (s,)
    side_normal: np.ndarray  # (s, 3) sum of the two facets' normals
    side_is_drawn: np.ndarray  # (s,) see borders.Borders
    corner_normal: np.ndarray  # (s, 3) angle-weighted normals at the side's start
    corner_is_drawn: np.ndarray  # (s,) whether all sides at the side's start are drawn
    first_outline: np.ndarray  # (f + 1,) the same as first_side, of walls.Walls.side
    outline: np.ndarray  # walls.SideColumns
    slack: np.ndarray  # (f,) how far facets reach beyond their outlines, see borders.Borders [m]
    near: float  # the same of curves: over a border, rounding must leave no gap between two walls [m]
    curve: np.ndarray  # (f,) the curve that a facet is a piece of; -1 for a flat wall
    curves: np.ndarray  # (curves, width) curved_surfaces.CurveColumns
    first_piece: np.ndarray  # (curves + 1,) facets of each curve, where it does not cover all between its borders
    piece: np.ndarray
    trims: Trims
    rims: np.ndarray  # (rims, width) rims.RimColumns, all in which walls meet at an angle
    rim_normal: np.ndarray  # (rims, 2) sum of both walls' normals, (out, up)
    creases: np.ndarray  # (creases, rows, degree + 1) creases.CreaseRows, all of them
    crease_side: np.ndarray  # (creases,) -1 where the wall juts out, 1 in a seam


def _surface(vessel: Vessel) -> Surface:
    borders = borders_of(vessel)
    loops, owner, corner = vessel.outlines.loops, vessel.outlines.corners.owner, vessel.corners
    points, edge = vessel.outlines.points, vessel.edge_of_side
    behind = np.empty(len(points), dtype=np.int64)
    behind[loops.ahead] = np.arange(len(points))
    forth, back = points[loops.ahead] - points, points[behind] - points
    length = np.linalg.norm(forth, axis=1)
    along = forth / length[:, None]
    back /= np.linalg.norm(back, axis=1)[:, None]
    inward = cross(vessel.normals[owner], along)
    angle = np.arctan2((inward * back).sum(axis=1), (along * back).sum(axis=1)) % (2 * np.pi)
    corner_normal = np.zeros_like(vessel.vertices)
    np.add.at(corner_normal, corner, angle[:, None] * vessel.normals[owner])
    first, second = vessel.edge_arrays.facets[edge].T
    # Of a rough border only the drawing is known.
    side_is_drawn = (borders.is_drawn & ~borders.is_rough)[edge]
    corner_is_drawn = (np.bincount(corner, ~side_is_drawn) == 0)[corner]
    first_outline, outline, trims = all_sides([vessel])
    curve = vessel.facet_curves
    has_edge = np.bincount(owner, ~(side_is_drawn & corner_is_drawn)) > 0
    pieces = [
        np.flatnonzero((curve == k) & (k not in borders.trims) & is_open(vessel, k)) for k in range(len(vessel.curves))
    ]
    listed = np.flatnonzero((curve < 0) | has_edge)
    slack = borders.slack + SAME * vessel.size
    listed = listed[np.argsort(_places(vessel.outlines.middles[listed]), kind="stable")]
    blocks = np.arange(0, len(listed), BLOCK)
    low, high = (f.reduceat(points, vessel.outlines.corners.first)[listed] for f in (np.minimum, np.maximum))
    box = (
        np.stack([np.minimum.reduceat(low, blocks), np.maximum.reduceat(high, blocks)], axis=1)
        if len(listed)
        else np.empty((0, 2, 3))
    )
    return Surface(
        listed=listed,
        box=box + (slack.max() + vessel.sagitta) * np.array([[-1], [1]]),
        normal=vessel.normals,
        offset=vessel.offsets,
        axes=vessel.axes,
        first_side=np.append(vessel.outlines.corners.first, len(points)),
        start=points,
        along=along,
        length=length,
        side_normal=vessel.normals[first] + vessel.normals[second],
        side_is_drawn=side_is_drawn,
        corner_normal=corner_normal[corner],
        corner_is_drawn=corner_is_drawn,
        first_outline=first_outline,
        outline=outline,
        slack=slack,
        near=SAME * vessel.size,
        curve=curve,
        curves=curve_rows(vessel.curves),
        first_piece=np.cumsum([0, *map(len, pieces)]),
        piece=np.concatenate([np.empty(0), *pieces]).astype(np.int64),
        trims=trims,
        rims=rim_rows(borders.rims),
        rim_normal=np.array([_normals(rim) for rim in borders.rims]).reshape(-1, 2),
        creases=crease_rows(tuple(borders.creases.values())),
        crease_side=np.array([-np.sign(crease.turn) for crease in borders.creases.values()]),
    )


def _places(points: np.ndarray) -> np.ndarray:
    """Numbers (n,) of points (n, 3) that are close for close points: the bits of their coordinates in turn (Morton)."""
    low, size = points.min(axis=0, initial=np.inf), np.ptp(points) if points.size else 1.0
    cells = ((points - low) / size * 1023).astype(np.int64)
    bits = np.arange(10)
    return ((cells[:, :, None] >> bits & 1) << (3 * bits + np.arange(3)[:, None])).sum(axis=(1, 2))


def _normals(rim: Rim) -> np.ndarray:
    """The sum of the normals of the walls that meet in a rim, (out, up): it points away from both of them."""
    between = rim.inward[0] + rim.inward[1]
    return -np.sign(rim.turn) * between if np.linalg.norm(between) > 1e-9 else rim.inward[0][::-1] * [-1, 1]


def is_open(vessel: Vessel, number: int) -> bool:
    """Whether a curve is not there everywhere between its borders: its facets cover less than that."""
    curve = vessel.curves[number]
    part = math.acos(np.clip(curve.part[0] @ curve.part[1], -1, 1)) if curve.part else 2 * math.pi
    area = vessel.areas[vessel.facet_curves == number].sum()
    if curve.minor is None:
        low, high = curve.ends
        whole = part * (curve.major * (high - low) + math.sin(curve.slope) * (high**2 - low**2) / 2)
    else:
        begin, end = (math.atan2(up, out) for out, up in curve.arc) if curve.arc else (0.0, 2 * math.pi)
        if not curve.major and not curve.arc:
            begin, end = -math.pi / 2, math.pi / 2
        end += 2 * math.pi * (end < begin)
        whole = part * curve.minor * (curve.major * (end - begin) + curve.minor * (math.sin(end) - math.sin(begin)))
    # Of a surface drawn in steps of up to 20 degrees along both ways.
    return bool(area < 0.93 * whole)


@merged()
def _nearest_on_outline(surface, facet, point):
    """Nearest point of a facet's outline: (squared distance, vector from it to the point, normal there).

    Sides that are only drawn are left out: there is no edge.
    """
    best = 1e300
    away_best = (0.0, 0.0, 0.0)
    outward = (0.0, 0.0, 0.0)
    for k in range(surface.first_side[facet], surface.first_side[facet + 1]):
        away = subtract(point, row(surface.start, k))
        along = dot(away, row(surface.along, k))
        # The end of a side is the start of the next one, which knows the corner's normal.
        if along >= surface.length[k]:
            continue
        if surface.corner_is_drawn[k] if along <= 0.0 else surface.side_is_drawn[k]:
            continue
        within = max(along, 0.0)
        away = add_scaled(away, -within, row(surface.along, k))
        squared = dot(away, away)
        if squared < best:
            best = squared
            away_best = away
            outward = row(surface.corner_normal, k) if along <= 0.0 else row(surface.side_normal, k)
    return best, away_best, outward


@merged()
def _is_there(surface, curve, foot, direction):
    """Whether a curve is a wall at a point of it, where its normal has this direction: not in a lifter on a shell.

    One of the facets that the curve is drawn by is there. Over the joint of two the foot may be beyond both, by less
    than it is above them.
    """
    if surface.trims.first[curve] < surface.trims.first[curve + 1]:
        return beyond_trim(surface.curves, surface.trims, curve, foot) <= surface.near
    if surface.first_piece[curve] == surface.first_piece[curve + 1]:
        return True
    for at in range(surface.first_piece[curve], surface.first_piece[curve + 1]):
        facet = surface.piece[at]
        if dot(row(surface.normal, facet), direction) < 0.5:
            continue
        above = abs(dot(row(surface.normal, facet), foot) - surface.offset[facet])
        if (
            beyond_side(surface.axes, surface.first_outline, surface.outline, surface.trims.bow, facet, foot)
            <= above + 1e-12
        ):
            return True
    return False


@inlined()
def _from_box(surface, block, point):
    """Squared distance of a point from the box of a block of facets."""
    squared = 0.0
    for c in range(3):
        out = max(surface.box[block, 0, c] - point[c], point[c] - surface.box[block, 1, c], 0.0)
        squared += out * out
    return squared


@inner()
def _nearest_in_block(surface, block, point, best, away, sign, nearest):
    """The nearest facet or side to a point, of a block or as found before: the one of the lowest number, of equal ones.

    Squared distance, vector from the wall to the point, its sign, and the number of the facet.
    """
    for at in range(block * BLOCK, min((block + 1) * BLOCK, surface.listed.size)):
        facet = surface.listed[at]
        normal = row(surface.normal, facet)
        height = dot(normal, point) - surface.offset[facet]
        is_drawing = surface.curve[facet] >= 0
        if height * height > best and not is_drawing:
            continue
        if (
            not is_drawing
            and beyond_side(surface.axes, surface.first_outline, surface.outline, surface.trims.bow, facet, point)
            <= surface.slack[facet]
        ):
            squared = height * height
            # On the wall itself, the direction is that of its normal.
            offset = scale(height, normal) if height != 0.0 else normal
            side = height
        else:
            # A sharp edge on the outline of a piece of a curve is a wall itself.
            squared, offset, outward = _nearest_on_outline(surface, facet, point)
            side = dot(offset, outward)
            side = side if side > 0 else -1.0
        if squared < best or (squared == best and facet < nearest):
            best, away, nearest = squared, offset, facet
            sign = -1.0 if side >= 0 else 1.0
    return best, away, sign, nearest


@inlined()
def distance_at(surface, point):
    """Signed distance of a point and its gradient; the nearest facet, side, curve or rim decides the sign."""
    nearest, least = np.int64(0), 1e300
    for block in range(surface.box.shape[0]):
        squared = _from_box(surface, block, point)
        if squared < least:
            nearest, least = block, squared
    found = _nearest_in_block(surface, nearest, point, 1e300, (0.0, 0.0, 0.0), 1.0, np.int64(-1))
    for block in range(surface.box.shape[0]):
        if block != nearest and _from_box(surface, block, point) <= found[0] * (1 + 1e-9):
            found = _nearest_in_block(surface, block, point, *found)
    best, away, sign, _ = found
    for curve in range(surface.curves.shape[0]):
        height, normal, past, _ = curve_touch(surface.curves, curve, point)
        foot = add_scaled(point, -height, normal)
        near = surface.near + surface.curves[curve, CURVE.slack]
        if past <= near and height * height < best and _is_there(surface, curve, foot, normal):
            best = height * height
            away = scale(height, normal) if height != 0.0 else normal
            sign = -1.0 if height >= 0 else 1.0
    for rim in range(surface.rims.shape[0]):
        distance, direction, out, up, is_on_arc = rim_distance(surface.rims, rim, point)
        if is_on_arc and distance * distance < best:
            best = distance * distance
            away = scale(distance, direction)
            sign = -1.0 if out * surface.rim_normal[rim, 0] + up * surface.rim_normal[rim, 1] > 0.0 else 1.0
    for crease in range(surface.creases.shape[0]):
        is_on, x = crease_nearest(surface.creases, crease, point)
        if is_on:
            offset = subtract(point, crease_place(surface.creases[crease], x)[0])
            squared = dot(offset, offset)
            if squared < best:
                best, away = squared, offset
                one = crease_vector(surface.creases[crease], CREASE.inward, x)
                outward = dot(offset, one) + dot(offset, crease_vector(surface.creases[crease], CREASE.other, x))
                sign = -1.0 if surface.crease_side[crease] * outward > 0.0 else 1.0
    size = np.sqrt(dot(away, away))
    return sign * np.sqrt(best), (sign * away[0] / size, sign * away[1] / size, sign * away[2] / size)


@array_maker()
def _signed_distance(surface, points):
    count = points.shape[0]
    distance = np.empty(count)
    gradient = np.empty((count, 3))
    for p in range(count):
        distance[p], gradient_p = distance_at(surface, row(points, p))
        for c in range(3):
            gradient[p, c] = gradient_p[c]
    return distance, gradient


class SignedDistance:
    """Signed distance to the walls of a body, in its frame: zero on the wall, negative where the balls are.

    Balls are inside a vessel, and outside a solid.
    """

    def __init__(self, vessel: Vessel) -> None:
        self.surface = _surface(vessel)

    def __call__(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distances (...) [m] and their gradients (..., 3) [-] at points (..., 3) [m]."""
        points = np.asarray(points, dtype=float)
        distance, gradient = _signed_distance(self.surface, np.ascontiguousarray(points.reshape(-1, 3)))
        return distance.reshape(points.shape[:-1]), gradient.reshape(points.shape)


@lru_cache(maxsize=32)
def signed_distance(vessel: Vessel) -> SignedDistance:
    """The signed distance of a body, kept for the bodies used last."""
    return SignedDistance(vessel)
