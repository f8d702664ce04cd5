"""How creases and trims are made of a drawing's chords: by Newton on both surfaces, as polynomials."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from millprint.mill.creases import (
    ALONG,
    BEYOND,
    CREASE,
    DEGREE,
    EXACT,
    SIDE,
    STEEPEST,
    TRIM,
    TRIMMED,
    Trims,
    beyond_trim,
    crease_nearest,
    crease_place,
    place_on,
)
from millprint.mill.curved_surfaces import Curve
from millprint.mill.kernel_columns import width_of
from millprint.mill.vectors import row
from millprint.run.kernel import array_maker

NODES = chebyshev.chebpts1(DEGREE + 1)
BETWEEN = np.linspace(-1, 1, 25)
# The polynomials of Chebyshev, as coefficients from that of degree 0 on.
POWERS = np.array([np.pad(chebyshev.cheb2poly(each), (0, DEGREE - k)) for k, each in enumerate(np.eye(DEGREE + 1))])


def _through(x: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Coefficients (n, DEGREE + 1), from that of degree 0 on, of polynomials with values (n, DEGREE + 1) at x."""
    return np.linalg.solve(chebyshev.chebvander(x, DEGREE), values.T).T @ POWERS


def _values(coefficients: np.ndarray, x: np.ndarray) -> np.ndarray:
    return np.polynomial.polynomial.polyval(x, coefficients.T)


def endless(curve: Curve) -> Curve:
    """The whole surface of which a curve is a part."""
    return replace(curve, part=None, arc=None, ends=(-math.inf, math.inf))


def _touch(wall: Curve | np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Signed distances (n,) [m] and normals (n, 3) of a surface or a plane (normal, offset) at points (n, 3)."""
    if isinstance(wall, np.ndarray):
        return points @ wall[:3] - wall[3], np.broadcast_to(wall[:3], points.shape)
    return endless(wall).touch(points)[:2]


def _meeting(walls: tuple[Curve | np.ndarray, Curve | np.ndarray], places: np.ndarray, along: np.ndarray) -> np.ndarray:
    """The points (n, 3) of two surfaces in the planes across `along` (n, 3) through places (n, 3): Newton's method."""
    points = places.copy()
    for _ in range(30):
        (off, normals), (other_off, other_normals) = (_touch(wall, points) for wall in walls)
        slopes = np.stack([normals, other_normals, along], axis=1)
        away = np.stack([off, other_off, ((points - places) * along).sum(axis=1)], axis=1)
        step = (np.linalg.pinv(slopes, rcond=1e-7) @ away[..., None])[..., 0]
        points = points - step
        if np.abs(step).max() < 1e-17:
            break
    return points


class Crease(NamedTuple):
    """A piece of a crease over an edge of the drawing.

    rows: see CreaseRows; turn: angle between the walls' normals in its middle [rad], see vessel.Edge; points
    (DEGREE + 3, 3): its ends, and between them places along it [m].
    """

    rows: np.ndarray
    turn: float
    points: np.ndarray

    def slope(self, x: float) -> np.ndarray:
        """Direction (3,) of the piece at x, from its first to its second end."""
        slopes = np.polynomial.polynomial.polyder(self.rows[[CREASE.across, CREASE.beside]].T)
        ways = np.polynomial.polynomial.polyval(x, slopes) * 2 / self.rows[CREASE.sizes, 0]
        return self.rows[CREASE.along, :3] + ways @ self.rows[[CREASE.first, CREASE.second], :3]


def crease_of(
    walls: tuple[Curve | np.ndarray, Curve | np.ndarray], start: np.ndarray, end: np.ndarray, size: float
) -> Crease | None:
    """The piece over the chord from start to end (3,) [m]; None where there is none, or where it is not smooth enough.

    walls: of the edge's facets, a surface or a plane (normal, offset) each; size: of the body [m].
    """
    length = float(np.linalg.norm(end - start))
    along = (end - start) / length
    first = np.cross(np.eye(3)[np.argmin(np.abs(along))], along)
    first /= np.linalg.norm(first)
    second = np.cross(along, first)
    x = np.concatenate([NODES, BETWEEN])
    places = start + (x + 1)[:, None] * (length / 2) * along
    points = _meeting(walls, places, np.broadcast_to(along, places.shape))
    shifts = (points - places) @ np.array([first, second]).T
    if not (np.abs(shifts[[-len(BETWEEN), -1]]).max() < TRIMMED * size and np.abs(shifts).max() < STEEPEST * length):
        return None
    normals = [_touch(wall, points)[1] for wall in walls]
    tangents = np.cross(normals[0], normals[1])
    tangents *= np.sign(tangents @ along)[:, None] / np.linalg.norm(tangents, axis=1, keepdims=True)
    inward = np.cross(normals[0], tangents), np.cross(normals[1], -tangents)
    turns = np.arctan2(-(inward[0] * normals[1]).sum(axis=1), (normals[0] * normals[1]).sum(axis=1))
    rows = np.zeros((CREASE.sizes + 1, DEGREE + 1))
    known = np.column_stack([shifts, *inward]).T
    rows[: CREASE.start] = _through(NODES, known[:, : len(NODES)])
    off = np.abs(_values(rows[: CREASE.start], BETWEEN) - known[:, len(NODES) :]).max(axis=1)
    is_one = (tangents @ along).min() > ALONG and np.ptp(np.sign(turns)) == 0
    if not (is_one and off[:2].max() < EXACT * size and off[2:].max() < BEYOND * length / size):
        return None
    rows[[CREASE.start, CREASE.along, CREASE.first, CREASE.second], :3] = start, along, first, second
    rows[CREASE.sizes, :2] = length, 1.01 * np.linalg.norm(shifts, axis=1).max() + TRIMMED * size
    return Crease(rows, float(turns[len(NODES) + len(BETWEEN) // 2]), np.vstack([start, points[: len(NODES)], end]))


def crease_rows(creases: tuple[Crease, ...]) -> np.ndarray:
    """The rows (n, rows, DEGREE + 1) of some pieces."""
    return np.array([crease.rows for crease in creases]).reshape(-1, CREASE.sizes + 1, DEGREE + 1)


def bowed_side(flat: np.ndarray, size: float) -> tuple[np.ndarray, np.ndarray | None] | None:
    """A side through points (n, 2) [m], its ends first and last: SideColumns, and its bow, None where it is a line.

    None for a side that does not lie over its chord. size: of the body [m].
    """
    side = np.zeros(width_of(SIDE))
    chord = flat[-1] - flat[0]
    length = float(np.linalg.norm(chord))
    du, dv = chord / length
    side[: SIDE.centre_u] = *flat[0], du, dv, length, *flat[-1]
    away = flat - flat[0]
    height = away @ [-dv, du]
    if np.abs(height).max() < TRIMMED * size:
        return side, None
    x = 2 * away[1:-1] @ [du, dv] / length - 1
    if len(x) != DEGREE + 1 or np.diff(x).min() <= 0 or np.abs(x).max() >= 1:
        return None
    (bow,) = _through(x, height[None, 1:-1])
    slopes = np.polynomial.polynomial.polyval(BETWEEN, np.polynomial.polynomial.polyder(bow)) * 2 / length
    if np.abs(_values(bow, np.array([-1.0, 1.0]))).max() > 10 * TRIMMED * size or np.abs(slopes).max() > STEEPEST:
        return None
    side[SIDE.radius] = -1.0
    return side, bow


@array_maker()
def crease_feet(creases: np.ndarray, k: int, points: np.ndarray) -> np.ndarray:
    """The places (n, 3) of piece k that are nearest to points (n, 3), its middle where none is."""
    feet = np.empty((len(points), 3))
    for p in range(len(points)):
        foot, _ = crease_place(creases[k], crease_nearest(creases, k, row(points, p))[1])
        for c in range(3):
            feet[p, c] = foot[c]
    return feet


@array_maker()
def _places_on(curves: np.ndarray, frame: np.ndarray, points: np.ndarray) -> np.ndarray:
    places = np.empty((len(points), 2))
    for p in range(len(points)):
        places[p, 0], places[p, 1] = place_on(curves, frame, 0, row(points, p))
    return places


@array_maker()
def _beyond_trim(curves: np.ndarray, trims: Trims, points: np.ndarray) -> np.ndarray:
    beyond = np.empty(len(points))
    for p in range(len(points)):
        beyond[p] = beyond_trim(curves, trims, 0, row(points, p))
    return beyond


def _angle_between(angles: np.ndarray) -> float:
    """The angle opposite to the middle of the largest gap between angles (n,) [rad]."""
    angles = np.sort(angles % (2 * math.pi))
    gaps = np.diff(np.append(angles, angles[0] + 2 * math.pi))
    return float(angles[np.argmax(gaps)] + gaps.max() / 2 + math.pi)


def trim_of(curve: Curve, border: list[np.ndarray], inside: np.ndarray, size: float) -> Trims | None:
    """The border of a curve; None where its sides do not lie over their chords.

    border: the points (n, 3) along each side of it, ends first and last; inside: points (m, 3) on the wall; size: of
    the body [m].
    """
    rows, frame = curve.row[None], np.zeros((1, width_of(TRIM)))
    first = np.cross(np.eye(3)[np.argmin(np.abs(curve.axis))], curve.axis)
    frame[0, [*TRIM.first]] = first / np.linalg.norm(first)
    away = np.vstack([*border, inside]) - curve.origin
    up = away @ curve.axis
    out = np.linalg.norm(away - np.outer(up, curve.axis), axis=1)
    frame[0, TRIM.radius] = out.mean()
    frame[0, TRIM.tube] = _angle_between(np.arctan2(up, out - curve.major)) if curve.minor is not None else 0.0
    period = 2 * math.pi * frame[0, TRIM.radius]
    sides: list[np.ndarray] = []
    bows: list[np.ndarray] = []
    for points in border:
        flat = _places_on(rows, frame, np.ascontiguousarray(points))
        end = flat[-1, 0]
        flat[:, 0] -= period * np.round((flat[:, 0] - flat[0, 0]) / period)
        made = bowed_side(flat, size)
        if made is None or (curve.minor is not None and np.ptp(flat[:, 1]) > 3 * curve.minor):
            return None
        side, bow = made
        side[SIDE.end_u] = end
        if bow is not None:
            side[SIDE.centre_u] = len(bows)
            bows.append(bow)
        sides.append(side)
    trims = joined_trims([Trims(np.array([0, len(sides)]), np.array(sides), np.array(bows), frame)])
    # Of points on the wall, each is under an even number of sides, or each under an odd one.
    signs = np.sign(_beyond_trim(rows, trims, np.ascontiguousarray(inside)))
    if np.ptp(signs) > 0:
        return None
    trims.frame[0, TRIM.is_inside] = float(signs[0] > 0)
    return trims


def joined_trims(parts: list[Trims]) -> Trims:
    """The borders of some curves after each other."""
    bows = np.cumsum([0, *(len(part.bow) for part in parts)])
    sides = [np.empty((0, width_of(SIDE)))]
    for part, before in zip(parts, bows, strict=False):
        side = part.side.copy()
        side[side[:, SIDE.radius] < 0, SIDE.centre_u] += before
        sides.append(side)
    counts = [np.diff(part.first) for part in parts]
    return Trims(
        np.concatenate([[0], np.cumsum(np.concatenate([np.empty(0, dtype=np.int64), *counts]))]).astype(np.int64),
        np.concatenate(sides),
        np.concatenate([np.empty((0, DEGREE + 1)), *(part.bow.reshape(-1, DEGREE + 1) for part in parts)]),
        np.concatenate([np.empty((0, width_of(TRIM))), *(part.frame for part in parts)]),
    )
