"""Small worlds for the physics tests: a few balls in a plain vessel, driven from Python."""

import numpy as np

from millprint.config.contact_set import ContactConfig
from millprint.dem import simulation
from millprint.mill.motion import Motion
from millprint.mill.outlines import facets_of
from millprint.mill.vessel import Vessel

CALIBRATED = ContactConfig(
    name="calibrated",
    source="thesis Table 3.2",
    restitution=0.30,
    static_friction=0.30,
    rolling_friction=0.045,
    density_kg_m3=7700,
    young_modulus_gpa=2.05,
    poisson_ratio=0.235,
)


def uniform(velocity: np.ndarray) -> Motion:
    """Motion at constant velocity (3,) [m/s], as the first moments of a very slow and wide swing."""
    slow = 1e-6
    return Motion(np.array([[slow, 0, 0, 0, *(velocity / slow)]]), slow)


def prism(outline: np.ndarray, height: float, turn: np.ndarray | None = None) -> Vessel:
    """The upright prism over a counter-clockwise outline (k, 2) [m], from z = 0 to `height` [m].

    turn: rotation (3, 3) of the whole about the origin.
    """
    low = np.column_stack([outline, np.zeros(len(outline))])
    high = low + np.array([0.0, 0.0, height])
    if turn is not None:
        low, high = low @ turn.T, high @ turn.T
    sides = [[np.array([high[k], high[k - 1], low[k - 1], low[k]])[::-1]] for k in range(len(outline))]
    return Vessel(facets_of([*sides, [low], [high[::-1]]]))


def box(width: float = 0.2, depth: float = 0.2, height: float = 0.2, turn: np.ndarray | None = None) -> Vessel:
    """A box centred on the origin in plan, floor at z = 0 [m]; turn: rotation (3, 3) of the whole about the origin."""
    x, y = width / 2, depth / 2
    return prism(np.array([[-x, -y], [x, -y], [x, y], [-x, y]]), height, turn)


class FewBalls(simulation.FewBalls):
    """The library's world with defaults: a box, the calibrated contact set."""

    def __init__(self, position, velocity=None, spin=None, radius=5e-3, contact=CALIBRATED, **options) -> None:
        vessel = options.pop("vessel", None) or box()
        super().__init__(vessel, contact, position, velocity, spin, radius, **options)


def crowd(contact: ContactConfig, step: float, skin: float) -> FewBalls:
    """240 balls of two sizes, at random off a lattice, so that half of all neighbours overlap; the last one far away.

    Cells as wide as a ball would be more than there is room for.
    """
    rng = np.random.default_rng(4)
    place = np.stack(np.meshgrid(*(5e-3 + 0.01 * np.arange(n) for n in (8, 6, 5)), indexing="ij"), axis=-1)
    place = place.reshape(-1, 3) - [0.04, 0.03, 0.0] + rng.uniform(-3e-4, 3e-4, (240, 3))
    place[-1], radius, speed = [1.49505, 0.0, 0.025], rng.choice([4.9e-3, 5e-3], 240), rng.normal(size=(240, 3))
    vessel = box(3.0, 0.06, 0.05)
    return FewBalls(place, speed, radius=radius, contact=contact, step=step, skin=skin, vessel=vessel, pitch=0.03)
