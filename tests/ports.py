"""Round mantles with a port or a boss, drawn as meshes whose vertices lie on the exact surfaces. Lengths in mm.

A mantle, a cylinder or cone about z, has a hole where a prism along a direction meets it, and the prism's wall leads
from there to a flat lid: outwards to that of a port, or inwards to the top of a boss.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely
from scipy.optimize import brentq
from scipy.spatial import cKDTree


class Ported(NamedTuple):
    """A mantle of `radius` at z = 0, whose radius grows by `slope` a mm, up to `height`, and its port.

    The port's axis goes through `at` along `way` (from the mantle's axis outwards), and ends at a lid `reach` from
    there. Points of its cross section are given by their share of its circumference.
    """

    radius: float
    slope: float
    height: float
    at: tuple[float, float, float]
    way: tuple[float, float, float]
    reach: float
    section: str  # "round", or "square"
    size: float  # radius, or half a side
    turn: float = 0.3  # of a square about the port's axis [rad]

    @property
    def frame(self) -> np.ndarray:
        """Two directions across the port, and its own (3, 3)."""
        way = np.array(self.way) / np.linalg.norm(self.way)
        first = np.cross([0, 0, 1.0], way)
        first /= np.linalg.norm(first)
        return np.array([first, np.cross(way, first), way])

    def outline(self, share: np.ndarray) -> np.ndarray:
        """Points (n, 2) of the cross section."""
        share = np.asarray(share) % 1
        if self.section == "round":
            return self.size * np.column_stack([np.cos(2 * np.pi * share), np.sin(2 * np.pi * share)])
        corners = self.size * np.array([[1, -1], [1, 1], [-1, 1], [-1, -1], [1, -1.0]])
        side = np.minimum((4 * share).astype(int), 3)
        at = corners[side] + (4 * share - side)[:, None] * (corners[side + 1] - corners[side])
        return at @ np.array([[np.cos(self.turn), np.sin(self.turn)], [-np.sin(self.turn), np.cos(self.turn)]])

    def lifted(self, share: np.ndarray, way: np.ndarray | float) -> np.ndarray:
        """Points (n, 3) of the port's wall."""
        return (
            self.outline(share) @ self.frame[:2] + np.outer(np.broadcast_to(way, len(share)), self.frame[2]) + self.at
        )

    def edge(self, share: np.ndarray) -> np.ndarray:
        """Points (n, 3) where the port's wall meets the mantle: x^2 + y^2 = (radius + slope z)^2, the farther one."""
        start, way = self.lifted(share, 0.0), self.frame[2]
        r = self.radius + self.slope * start[:, 2]
        a = way[0] ** 2 + way[1] ** 2 - (self.slope * way[2]) ** 2
        b = start[:, :2] @ way[:2] - r * self.slope * way[2]
        c = (start[:, :2] ** 2).sum(axis=1) - r**2
        return self.lifted(share, (np.sqrt(b**2 - a * c) - b) / a)

    @property
    def is_boss(self) -> bool:
        """Whether the port's wall leads inwards."""
        return self.reach < ((self.edge(np.linspace(0, 1, 9)) - self.at) @ self.frame[2]).min()

    def _is_under(self, flat: np.ndarray) -> np.ndarray:
        """Which points (n, 2) across the port are within its cross section."""
        if self.section == "round":
            return np.hypot(*flat.T) < self.size
        return (np.abs(flat @ self._sides) < self.size).all(axis=1)

    @property
    def _sides(self) -> np.ndarray:
        """Normals (2, 2), as columns, of two sides of a square."""
        return np.array([[np.cos(self.turn), -np.sin(self.turn)], [np.sin(self.turn), np.cos(self.turn)]])

    def is_inside(self, points: np.ndarray) -> np.ndarray:
        """Which points (n, 3) are in the hollow."""
        local = (points - self.at) @ self.frame.T
        r = np.hypot(points[:, 0], points[:, 1])
        main = (r < self.radius + self.slope * points[:, 2]) & (points[:, 2] > 0) & (points[:, 2] < self.height)
        port = self._is_under(local[:, :2]) & (local[:, 2] > 0)
        return (
            main & ~(port & (local[:, 2] > self.reach)) if self.is_boss else main | (port & (local[:, 2] < self.reach))
        )

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Distances (n,) of points (n, 3) in the hollow from its wall.

        That is the nearest foot on a piece, or place on an edge. Edges are taken as 40,000 chords each.
        """
        local = (points - self.at) @ self.frame.T
        r = np.hypot(points[:, 0], points[:, 1])
        lean = np.hypot(1, self.slope)
        gap = (self.radius + self.slope * points[:, 2] - r) / lean
        out = np.column_stack([points[:, :2] / r[:, None], np.full(len(r), -self.slope)]) / lean
        feet = [(points + gap[:, None] * out, np.abs(gap), "mantle")]
        if self.section == "round":
            rho = np.hypot(local[:, 0], local[:, 1])
            at = np.column_stack([local[:, :2] * (self.size / rho)[:, None], local[:, 2]])
            feet.append((at @ self.frame + self.at, np.abs(rho - self.size), "wall"))
        else:
            for normal, sense in ((n, s) for n in self._sides.T for s in (-1, 1)):
                off = local[:, :2] @ normal - sense * self.size
                at = local - np.column_stack([np.outer(off, normal), np.zeros(len(off))])
                feet.append((at @ self.frame + self.at, np.abs(off), "wall"))
        at = np.column_stack([local[:, :2], np.full(len(local), self.reach)])
        feet.append((at @ self.frame + self.at, np.abs(local[:, 2] - self.reach), "lid"))
        best = np.minimum(points[:, 2], self.height - points[:, 2])
        best = np.where((best > 0) & (r < self.radius + self.slope * points[:, 2]), best, np.inf)
        sign = -1 if self.is_boss else 1
        for at, distance, piece in feet:
            own = (at - self.at) @ self.frame.T
            under = self._is_under(own[:, :2] * (1 - 1e-9)) & (own[:, 2] > 0)
            past = sign * (np.hypot(at[:, 0], at[:, 1]) - self.radius - self.slope * at[:, 2]) > 0
            there = {"mantle": ~under, "wall": under & past & (sign * (self.reach - own[:, 2]) > 0), "lid": under}[
                piece
            ]
            best = np.where(there, np.minimum(best, distance), best)
        share = np.linspace(0, 1, 40001)
        lines = [self.edge(share), self.lifted(share, self.reach)]
        if self.section == "square":
            quarter = np.arange(4) / 4
            lines += [
                np.linspace(*ends, 4001)
                for ends in zip(self.edge(quarter), self.lifted(quarter, self.reach), strict=True)
            ]
        for line in lines:
            _, nearest = cKDTree(line).query(points)
            for first in (np.maximum(nearest - 1, 0), np.minimum(nearest, len(line) - 2)):
                side, away = line[first + 1] - line[first], points - line[first]
                along = np.clip((away * side).sum(axis=1) / (side**2).sum(axis=1), 0, 1)
                best = np.minimum(best, np.linalg.norm(away - along[:, None] * side, axis=1))
        return best


def _angle(points: np.ndarray) -> np.ndarray:
    return np.arctan2(points[:, 1], points[:, 0])


def triangles(part: Ported, around: int, along: int) -> np.ndarray:
    """Corners (t, 3, 3) of a mesh, normals out: `around` columns of the mantle, `along` steps of the port."""
    columns = np.linspace(-np.pi, np.pi, around + 1)
    share = np.arange(along) / along
    angles = _angle(part.edge(share))
    found = [share]
    for k in range(along):
        low, high = sorted((angles[k], angles[(k + 1) % along]))
        for column in columns[(columns > low + 1e-9) & (columns < high - 1e-9)]:
            cut = brentq(
                lambda s, to=column: _angle(part.edge([s]))[0] - to, share[k], share[k] + 1 / along, xtol=1e-15
            )
            found.append(np.array([cut]))
    share = np.sort(np.concatenate(found))
    edge = part.edge(share)
    flat = np.column_stack([_angle(edge), edge[:, 2]])
    near = np.abs(flat[:, :1] - columns)
    flat[:, 0] = np.where(near.min(axis=1) < 1e-9, columns[near.argmin(axis=1)], flat[:, 0])
    hole = shapely.Polygon(flat)
    corners = []
    for low, high in pairwise(columns):
        strip = shapely.box(low, 0, high, part.height).difference(hole)
        corners.append(shapely.get_coordinates(shapely.constrained_delaunay_triangles(strip)).reshape(-1, 4, 2)[:, :3])
    flats = np.concatenate(corners)
    sides = flats[:, 1:] - flats[:, :1]
    away = sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]
    flats[away < 0] = flats[away < 0][:, ::-1]
    r = part.radius + part.slope * flats[..., 1]
    mantle = np.stack([r * np.cos(flats[..., 0]), r * np.sin(flats[..., 0]), flats[..., 1]], axis=-1)
    _, nearest = cKDTree(edge).query(mantle)
    off = np.abs(edge[nearest] - mantle).max(axis=-1, keepdims=True)
    mantle = np.where(off < 1e-6, edge[nearest], mantle)  # the same points to the last bit
    lid = part.lifted(share, part.reach)
    after = np.roll(np.arange(len(share)), -1)
    wall = np.concatenate([np.stack([edge, edge[after], lid], 1), np.stack([edge[after], lid[after], lid], 1)])
    middle = np.array(part.at) + part.reach * part.frame[2]
    top = np.stack([np.broadcast_to(middle, lid.shape), lid, lid[after]], axis=1)
    ends = []
    for z, sense in ((0.0, -1), (part.height, 1)):
        r = part.radius + part.slope * z
        ring = np.column_stack([r * np.cos(columns[:-1]), r * np.sin(columns[:-1]), np.full(around, z)])
        ends.append(np.stack([np.broadcast_to([0, 0, z], ring.shape), ring, np.roll(ring, -1, axis=0)], 1)[:, ::sense])
    return np.concatenate([mantle, wall, top, *ends])


def places(part: Ported, radius: float, count: int, rng: np.random.Generator, gaps: tuple[float, float]) -> np.ndarray:
    """Centres (n, 3) of balls near the edge of a port, with gaps to the wall within shares of the radius."""
    found = np.empty((0, 3))
    while len(found) < count:
        towards = rng.normal(size=(4000, 3))
        towards *= (radius * rng.choice([1.0, 1.2, 1.45, 2.0], 4000) / np.linalg.norm(towards, axis=1))[:, None]
        points = part.edge(rng.random(4000)) + towards * rng.uniform(1 + gaps[0], 1 + gaps[1], (4000, 1))
        points = points[part.is_inside(points)]
        gap = part.distance(points) / radius - 1
        found = np.concatenate([found, points[(gap > gaps[0]) & (gap < gaps[1])]])
    return found[:count]
