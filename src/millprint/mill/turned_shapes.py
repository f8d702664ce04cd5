"""Lines and arcs in the half plane about an axis, and the drawing in which the surfaces that they sweep are found."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

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


@dataclass(eq=False)
class Axis:
    """An axis: a point on it (3,) [m] and its direction (3,)."""

    origin: np.ndarray
    along: np.ndarray

    def __post_init__(self) -> None:
        helper = np.eye(3)[np.argmin(np.abs(self.along))]
        self.u = np.cross(helper, self.along)
        self.u /= np.linalg.norm(self.u)
        self.v = np.cross(self.along, self.u)

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
        middle = flat.mean(axis=0)
        _, _, axes = np.linalg.svd(flat - middle, full_matrices=False)
        normal = axes[-1] if axes[-1][0] >= 0 else -axes[-1]
        return cls(math.atan2(normal[1], normal[0]), float(normal @ middle))

    def off(self, flat: np.ndarray) -> np.ndarray:
        """Distances (n,) of points (n, 2) [m]."""
        return flat @ [math.cos(self.angle), math.sin(self.angle)] - self.offset


@dataclass
class Circle:
    """In the half plane about an axis: a circle of a radius about (r, z) [m]."""

    r: float
    z: float
    radius: float

    @classmethod
    def through(cls, flat: np.ndarray) -> "Circle":
        """The circle nearest to points (n, 2), by linear least squares (Kasa 1976)."""
        shift = flat.mean(axis=0)
        local = flat - shift
        columns = np.column_stack([2 * local, np.ones(len(local))])
        solution, *_ = np.linalg.lstsq(columns, (local**2).sum(axis=1), rcond=None)
        radius = math.sqrt(max(solution[2] + solution[:2] @ solution[:2], 0.0))
        middle = solution[:2] + shift
        return cls(float(middle[0]), float(middle[1]), radius)

    def off(self, flat: np.ndarray) -> np.ndarray:
        """Distances (n,) of points (n, 2) [m]."""
        return np.hypot(flat[:, 0] - self.r, flat[:, 1] - self.z) - self.radius

    def along(self, flat: np.ndarray) -> np.ndarray:
        """Ways (n,) along the circle to points (n, 2) [m]."""
        return self.radius * np.arctan2(flat[:, 1] - self.z, flat[:, 0] - self.r)


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
        self.normals = np.array([facet.normal for facet in vessel.facets])
        own = [np.concatenate(loops) for loops in vessel.loops]
        self.vertices_of = own
        self.first = np.cumsum([0, *map(len, own)])[:-1]
        self.flat = np.concatenate(own)
        self.middles = np.add.reduceat(vessel.vertices[self.flat], self.first) / np.array([[len(each)] for each in own])
        self.taken = np.zeros(len(own), dtype=bool)
        self.neighbours: list[list[int]] = [[] for _ in own]
        shallow = [edge for edge in vessel.edges if abs(edge.turn) < LARGEST_TURN]
        for edge in shallow:
            first, second = edge.facets
            self.neighbours[first].append(second)
            self.neighbours[second].append(first)
        bent = [edge for edge in shallow if abs(edge.turn) > SMALLEST_TURN]
        # Long ones first: those of a mantle, before those across a rounded end.
        bent.sort(key=lambda edge: -float(np.linalg.norm(edge.end - edge.start)))
        self.seams = [edge.facets for edge in bent]

    def worst(self, off: np.ndarray) -> np.ndarray:
        """For each facet (f,) the largest of what its vertices (v,) are off."""
        return np.maximum.reduceat(np.abs(off)[self.flat], self.first)

    def spread(self, flat: np.ndarray) -> np.ndarray:
        """For each facet (f,) how far its vertices lie apart along one axis at most, of points (v, 2)."""
        own = flat[self.flat]
        return np.ptp([np.maximum.reduceat(own, self.first), np.minimum.reduceat(own, self.first)], axis=0).max(axis=1)

    def points(self, facets: Iterable[int]) -> np.ndarray:
        """The vertices (n, 3) of some facets, each once."""
        return self.vessel.vertices[np.unique(np.concatenate([self.vertices_of[facet] for facet in facets]))]

    def around(self, seed: Iterable[int], count: int) -> list[int]:
        """Up to `count` free facets that are nearest to a seed by shallow edges."""
        found = list(seed)
        for facet in found:
            found += [n for n in self.neighbours[facet] if n not in found and not self.taken[n]]
            if len(found) >= count:
                break
        return found[:count]

    def grown(self, seed: Iterable[int], holds: np.ndarray) -> np.ndarray:
        """Free facets that are connected with a seed by shallow edges and that hold (f,); ascending."""
        front = [facet for facet in seed if holds[facet]]
        found = set(front)
        while front:
            for facet in self.neighbours[front.pop()]:
                if facet not in found and holds[facet] and not self.taken[facet]:
                    found.add(facet)
                    front.append(facet)
        return np.array(sorted(found), dtype=np.int64)
