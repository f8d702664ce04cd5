"""Where the balls are: the walls of a vessel, its motion, and what is the same for every ball."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from millprint.config.mill import MillConfig
from millprint.errors import ConfigError
from millprint.mill.distance import SignedDistance
from millprint.mill.motion import build_motion
from millprint.mill.vessel import build_vessel
from millprint.surrogate.trajectory import read_attributes

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
        # A roll-out may run away; what is not finite has no distance.
        finite = np.isfinite(points).all(axis=1)
        distance, gradient = np.full(len(points), np.nan), np.full(points.shape, np.nan)
        distance[finite], gradient[finite] = self.distance(points[finite])
        return distance.reshape(relative.shape[:-1]), gradient.reshape(relative.shape)


def read_scene(run: str | Path) -> Scene:
    """The scene of a simulation, from the configuration that its file carries.

    Raises ConfigError for a vessel that turns or has inserts, whose features this network does not have.
    """
    attributes = read_attributes(run)
    mill, case, contact = attributes["mill"], attributes["case"], attributes["contact"]
    config = MillConfig(**mill)
    motion = build_motion(config, case["speed_rpm"])
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
