"""Lines and arcs in the half plane about an axis, and the drawing in which the surfaces that they sweep are found."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from millprint.mill.outlines import Ragged, cross, lengths
from millprint.mill.vessel import Vessel

# Facets that turn by more against each other are not taken for a round wall [rad]: a prism of 18 sides is meant.
LARGEST_TURN = 0.345
SMALLEST_TURN = 1e-6
# What vertices may be off, over the rounding of the file's coordinates, and at least as a share of the body's size.
ROUNDINGS = 4.0
LEAST = 3e-6
SNAP = 1e-9
# A first guess is from a few facets, whose noise it magnifies; what is found is fitted and checked again.
LOOSE = 8.0
# Facets with more corners together belong to no bent surface.
MOST_CORNERS = 24


@dataclass(eq=False)
class Axis:
    """An axis: a point on it (3,) [m] and its direction (3,)."""

    origin: np.ndarray
    along: np.ndarray

    def __post_init__(self) -> None:
        helper = np.eye(3)[np.argmin(np.abs(self.along))]
        self.u = cross(helper, self.along)
        self.u /= np.linalg.norm(self.u)
        self.v = cross(self.along, self.u)

    def meridian(self, points: np.ndarray) -> np.ndarray:
        """(Distance from the axis, height over its origin) (n, 2) of points (n, 3) [m]."""
        away = points - self.origin
        return np.column_stack([np.hypot(away @ self.u, away @ self.v), away @ self.along])

    def angles(self, points: np.ndarray) -> np.ndarray:
        """Angles (n,) about the axis of points (n, 3) [rad]."""
        away = points - self.origin
        return np.arctan2(away @ self.v, away @ self.u)


@dataclass
class Line:
    """In the half plane about an axis: (r, z) . (cos angle, sin angle) = offset [m]."""

    angle: float
    offset: float

    @classmethod
    def through(cls, flat: np.ndarray) -> "Line":
        """The line nearest to points (n, 2)."""
        middle = flat.sum(axis=0) / len(flat)
        x, y = (flat - middle).T
        # The main axis of the scatter; the line's normal is across it, and points away from the axis of turning.
        along = 0.5 * math.atan2(2 * (x @ y), x @ x - y @ y)
        normal = -math.copysign(1.0, along) * np.array([-math.sin(along), math.cos(along)])
        return cls(math.atan2(normal[1], normal[0]), float(normal @ middle))

    def off(self, flat: np.ndarray) -> np.ndarray:
        """Distances (n,) of points (n, 2) [m]."""
        return flat @ [math.cos(self.angle), math.sin(self.angle)] - self.offset

    def along(self, flat: np.ndarray) -> np.ndarray:
        """Ways (n,) along the line to points (n, 2) [m]."""
        return flat @ [-math.sin(self.angle), math.cos(self.angle)]


def nearest_sphere(points: np.ndarray) -> tuple[np.ndarray, float]:
    """Middle (d,) and radius of the circle or sphere nearest to points (n, d), by linear least squares (Kasa 1976)."""
    shift = points.mean(axis=0)
    local = points - shift
    columns = np.column_stack([2 * local, np.ones(len(local))])
    solution, *_ = np.linalg.lstsq(columns, (local**2).sum(axis=1), rcond=None)
    middle = solution[:-1]
    return middle + shift, math.sqrt(max(solution[-1] + middle @ middle, 0.0))


@dataclass
class Circle:
    """In the half plane about an axis: a circle of a radius about (r, z) [m]."""

    r: float
    z: float
    radius: float

    @classmethod
    def through(cls, flat: np.ndarray) -> "Circle":
        """The circle nearest to points (n, 2)."""
        (r, z), radius = nearest_sphere(flat)
        return cls(float(r), float(z), radius)

    def off(self, flat: np.ndarray) -> np.ndarray:
        """Distances (n,) of points (n, 2) [m]."""
        return np.hypot(flat[:, 0] - self.r, flat[:, 1] - self.z) - self.radius

    def along(self, flat: np.ndarray) -> np.ndarray:
        """Ways (n,) along the circle to points (n, 2) [m]."""
        return self.radius * np.arctan2(flat[:, 1] - self.z, flat[:, 0] - self.r)


def circles_through(u: np.ndarray, v: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, ...]:
    """Middles (n,), (n,) and radii (n,) of Circle.through for n sets of points (k, n), (k, n) with weights (k, n).

    By the normal equations, which lose digits; not a number where the points are on a line.
    """
    total = weights.sum(axis=0)
    middle_u, middle_v = (u * weights).sum(axis=0) / total, (v * weights).sum(axis=0) / total
    u, v = u - middle_u, v - middle_v
    squared = u * u + v * v
    uu, uv, vv, uw, vw, w = (
        (each * weights).sum(axis=0) for each in (u * u, u * v, v * v, u * squared, v * squared, squared)
    )
    spread = uu * vv - uv**2
    twice = np.where(spread > 0, 2 * spread, np.nan)
    out_u, out_v = (uw * vv - vw * uv) / twice, (vw * uu - uw * uv) / twice
    return out_u + middle_u, out_v + middle_v, np.sqrt(out_u**2 + out_v**2 + w / total)


@dataclass(eq=False)
class Swept:
    """A surface that a line or an arc sweeps about an axis; facets: those that draw it."""

    axis: Axis
    shape: Line | Circle
    facets: np.ndarray


class Drawing:
    """The facets of a vessel: their vertices, neighbours across shallow edges, and which are taken by a surface."""

    def __init__(self, vessel: Vessel, rounding: float) -> None:
        self.vessel = vessel
        self.tolerance = max(ROUNDINGS * rounding, LEAST * vessel.size)
        # What a surface may move by where it is put level or tangent: not more than the file's own rounding.
        self.snap = max(ROUNDINGS * rounding, SNAP * vessel.size)
        self.normals, self.middles = vessel.normals, vessel.outlines.middles
        self.corners, self.flat = vessel.outlines.corners, vessel.corners
        self.vertices_of = self.corners.split(self.flat)
        self.taken = np.zeros(len(self.normals), dtype=bool)
        edges = vessel.edge_arrays
        shallow = np.flatnonzero(np.abs(edges.turn) < LARGEST_TURN)
        pairs = edges.facets[shallow]
        owner, other = pairs.ravel(), pairs[:, ::-1].ravel()
        order = np.argsort(owner, kind="stable")
        self.beside = Ragged(np.bincount(owner, minlength=len(self.normals)))
        self.beside_facet = other[order]
        self.neighbours = [own.tolist() for own in self.beside.split(self.beside_facet)]
        bent = shallow[np.abs(edges.turn[shallow]) > SMALLEST_TURN]
        # Long ones first: those of a mantle, before those across a rounded end.
        long = lengths(edges.end[bent] - edges.start[bent])[:, 0]
        self.seams = edges.facets[bent[np.argsort(-long, kind="stable")]]
        # The numbers of the vertices (k, n) of both facets at n seams with one number of corners together.
        corners = self.flat[self.corners.rows(self.seams.ravel())]
        both = Ragged(self.corners.counts[self.seams].sum(axis=1))
        self.seam_vertices = [
            (own, corners[rows].T.copy()) for own, rows in both.stacks() if rows.shape[1] <= MOST_CORNERS
        ]

    def across(self, is_own: np.ndarray) -> np.ndarray:
        """The facets that are next to some facets (f,) and not among them, ascending."""
        sides = self.vessel.edge_arrays.facets
        border = is_own[sides[:, 0]] != is_own[sides[:, 1]]
        return np.unique(sides[border][~is_own[sides[border]]])

    def points(self, facets: Iterable[int]) -> np.ndarray:
        """The vertices (n, 3) of some facets, each once."""
        return self.vessel.vertices[np.unique(self.flat[self.corners.rows(np.asarray(facets))])]

    def has_middle_outside(self, facet: int) -> bool:
        """Whether the outline of a facet without holes does not wind around its middle."""
        away = (self.vessel.vertices[self.vertices_of[facet]] - self.middles[facet]) @ self.vessel.axes[facet].T
        angles = np.arctan2(away[:, 1], away[:, 0])
        turns = (np.roll(angles, -1) - angles + math.pi) % (2 * math.pi) - math.pi
        return bool(abs(turns.sum()) < math.pi)

    def around(self, seed: Iterable[int], count: int) -> list[int]:
        """Up to `count` free facets that are nearest to a seed by shallow edges."""
        found = dict.fromkeys(seed)
        for facet in (front := list(seed)):
            new = [n for n in self.neighbours[facet] if n not in found and not self.taken[n]]
            found.update(dict.fromkeys(new))
            front += new
            if len(found) >= count:
                break
        return list(found)[:count]

    def pieces(self, facets: np.ndarray) -> list[np.ndarray]:
        """Some ascending facets in groups that are connected by shallow edges, in the order of their first ones."""
        number = np.full(len(self.normals), -1)
        number[facets] = np.arange(len(facets))
        owner = np.repeat(np.arange(len(facets)), self.beside.counts[facets])
        other = number[self.beside_facet[self.beside.rows(facets)]]
        pairs = np.column_stack([owner, other])[other >= 0].T
        count, piece = connected_components(coo_array((np.ones(len(pairs[0])), pairs), (len(facets),) * 2))
        return Ragged(np.bincount(piece, minlength=count)).split(facets[np.argsort(piece, kind="stable")])

    def grown(self, seed: Iterable[int], holds: np.ndarray) -> np.ndarray:
        """Free facets that are connected with a seed by shallow edges and that hold (f,); ascending."""
        is_left = holds & ~self.taken
        found = [facet for facet in seed if is_left[facet]]
        is_left[found] = False
        for facet in found:
            new = list({n for n in self.neighbours[facet] if is_left[n]})
            is_left[new] = False
            found += new
        return np.sort(np.array(found, dtype=np.int64))
