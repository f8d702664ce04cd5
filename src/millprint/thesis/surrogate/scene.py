"""The scene of a roll-out: the walls of a vessel, its motion, and the properties of all balls."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.mill.distance import SignedDistance
from millprint.mill.motion import motion_from_law
from millprint.mill.vessel import build_vessel
from millprint.thesis.surrogate.trajectory import read_attributes

AXES = "xyz"
Distance = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Scene:
    """A vessel that moves without turning, and the balls in it.

    distance: points (n, 3) in the body frame to their signed distances (n,), negative inside, and gradients (n, 3);
    wall_position: times (...) to positions of the body frame (..., 3); bounds_m (2, 3): lower and upper corner of the
    vessel in its frame.
    """

    ball_radius_m: float
    ball_mass_kg: float
    speed_rpm: float
    bounds_m: np.ndarray
    distance: Distance
    wall_position: Callable[[np.ndarray], np.ndarray]
    gravity_m_s2: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, -9.81]))

    def signed_distance(self, position: np.ndarray, wall: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Signed distance (...) and gradient (..., 3) at `position` (..., 3) with the vessel at `wall` (..., 3).

        The vessel only translates, so the gradient is the same in the laboratory frame.
        """
        relative = np.asarray(position - wall, dtype=float)
        points = relative.reshape(-1, 3)
        # A roll-out may run away: positions that are not finite have no distance.
        finite = np.isfinite(points).all(axis=1)
        distance, gradient = np.full(len(points), np.nan), np.full(points.shape, np.nan)
        distance[finite], gradient[finite] = self.distance(points[finite])
        return distance.reshape(relative.shape[:-1]), gradient.reshape(relative.shape)

    def section(self, normal: str, at_m: float, points: int = 161) -> dict:
        """Signed distance on the plane `normal` = at_m of the body frame, not a number outside (thesis Fig. 6.3).

        normal: x, y or z. Returns `title`, `axes` (two names), `first_m` (a,), `second_m` (b,), `distance_m` (b, a).
        """
        across = [axis for axis in range(3) if axis != AXES.index(normal)]
        low, high = self.bounds_m
        lines = [np.linspace(low[axis], high[axis], points) for axis in across]
        grid = np.full((points, points, 3), at_m)
        grid[..., across[0]], grid[..., across[1]] = np.meshgrid(*lines)
        distance, _ = self.signed_distance(grid, np.zeros(3))
        axes = tuple(AXES[axis] for axis in across)
        return {
            "title": f"{axes[0]}{axes[1]} plane, {normal} = {1e3 * at_m:.3g} mm",
            "axes": axes,
            "first_m": lines[0],
            "second_m": lines[1],
            "distance_m": np.where(distance < 0, distance, np.nan),
        }


def read_scene(run: str | Path) -> Scene:
    """The scene of a simulation, from the configuration that its file carries.

    Raises ConfigError for a vessel that turns or has inserts, whose features this network does not have.
    """
    attributes = read_attributes(run)
    mill, case, contact = attributes["mill"], attributes["case"], attributes["contact"]
    config = MillConfig(**mill)
    motion = motion_from_law(config.motion, case["speed_rpm"])
    if motion.turns:
        raise ConfigError(f"{run}: mill {config.name} turns; the surrogate knows vessels that only translate")
    if config.inserts:
        raise ConfigError(f"{run}: mill {config.name} has inserts; the surrogate knows the walls of one vessel")
    vessel = build_vessel(config)
    radius = case["ball_diameter_mm"] / 2e3
    return Scene(
        ball_radius_m=radius,
        ball_mass_kg=contact["density_kg_m3"] * 4 / 3 * np.pi * radius**3,
        speed_rpm=case["speed_rpm"],
        bounds_m=vessel.bounds,
        distance=SignedDistance(vessel),
        wall_position=motion.position,
    )
