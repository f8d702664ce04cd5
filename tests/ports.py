"""Round mantles with a port or a boss, as meshes: their edges are polygons with vertices on the exact surfaces. Lengths in mm.

A mantle, a cylinder or cone about z, has a hole where a prism along a direction meets it, and the prism's wall leads
from there to a flat lid: outwards to that of a port, or inwards to the top of a boss.
"""

from typing import NamedTuple

import numpy as np
import shapely
from scipy.optimize import brentq


class Ported(NamedTuple):
    """A mantle of `radius` at z = 0, whose radius grows by `slope` a mm, up to `height`, and its port.

    The port's axis goes through `at` along `way` (from the mantle's axis outwards), and ends at a lid `reach` from
    there; `outline`: points (n, 2) of its cross section by a share (n,) of its circumference, from 0 to 1.
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
        return self.outline(share) @ self.frame[:2] + np.outer(np.broadcast_to(way, len(share)), self.frame[2]) + self.at

    def edge(self, share: np.ndarray) -> np.ndarray:
        """Points (n, 3) where the port's wall meets the mantle."""

        def beyond(way: float, one: float) -> float:
            x, y, z = self.lifted(np.array([one]), way)[0]
            return float(np.hypot(x, y) - self.radius - self.slope * z)

        return np.array([self.lifted(np.array([s]), brentq(beyond, 0, 5 * self.radius, args=(s,), xtol=1e-15))[0] for s in share])


def _angle(points: np.ndarray) -> np.ndarray:
    return np.arctan2(points[:, 1], points[:, 0])


def triangles(part: Ported, around: int, along: int, window: tuple[float, float] | None = None) -> np.ndarray:
    """Corners (t, 3, 3) of the mesh, normals out of the hollow: `around` columns of the mantle, `along` steps of the port.

    window: only the mantle between two angles, without its ends [rad].
    """
    columns = np.linspace(*(window or (-np.pi, np.pi)), around + 1)
    share = np.arange(along) / along
    angles = _angle(part.edge(share))
    found = [share]
    for k in range(along):
        low, high = sorted((angles[k], angles[(k + 1) % along]))
        for column in columns[(columns > low + 1e-9) & (columns < high - 1e-9)]:
            cut = brentq(lambda s, to=column: _angle(part.edge([s]))[0] - to, share[k], share[k] + 1 / along, xtol=1e-15)
            found.append(np.array([cut]))
    share = np.sort(np.concatenate(found))
    edge = part.edge(share)
    flat = np.column_stack([_angle(edge), edge[:, 2]])
    near = np.abs(flat[:, :1] - columns)
    flat[:, 0] = np.where(near.min(axis=1) < 1e-9, columns[near.argmin(axis=1)], flat[:, 0])
    hole = shapely.Polygon(flat)
    corners = []
    for low, high in zip(columns[:-1], columns[1:], strict=True):
        strip = shapely.box(low, 0, high, part.height).difference(hole)
        corners.append(shapely.get_coordinates(shapely.constrained_delaunay_triangles(strip)).reshape(-1, 4, 2)[:, :3])
    flats = np.concatenate(corners)
    away = np.cross(flats[:, 1] - flats[:, 0], flats[:, 2] - flats[:, 0])
    flats[away < 0] = flats[away < 0][:, ::-1]
    r = part.radius + part.slope * flats[..., 1]
    mantle = np.stack([r * np.cos(flats[..., 0]), r * np.sin(flats[..., 0]), flats[..., 1]], axis=-1)
    # The same points to the last bit.
    at = np.abs(mantle[..., None, :] - edge).max(axis=-1) if len(edge) * len(mantle) < 3e6 else None
    if at is not None:
        mantle = np.where((at.min(axis=-1) < 1e-6)[..., None], edge[at.argmin(axis=-1)], mantle)
    lid = part.lifted(share, part.reach)
    after = np.roll(np.arange(len(share)), -1)
    wall = np.concatenate([np.stack([edge, edge[after], lid], 1), np.stack([edge[after], lid[after], lid], 1)])
    middle = np.array(part.at) + part.reach * part.frame[2]
    top = np.stack([np.broadcast_to(middle, lid.shape), lid, lid[after]], axis=1)
    if window:
        return np.concatenate([mantle, wall, top])
    ends = []
    for z, sense in ((0.0, -1), (part.height, 1)):
        r = part.radius + part.slope * z
        ring = np.column_stack([r * np.cos(columns[:-1]), r * np.sin(columns[:-1]), np.full(around, z)])
        ends.append(np.stack([np.broadcast_to([0, 0, z], ring.shape), ring, np.roll(ring, -1, axis=0)], 1)[:, ::sense])
    return np.concatenate([mantle, wall, top, *ends])
