"""A sphere hits a plate: rebound and spin in the DEM's own kernel, at real stiffness, and the forms of rigid bodies.

The plate lies at z = 0 and the sphere comes along +x. Nothing else acts on it, so an impact is two velocities and a
contact set. The step is a fraction of the duration of the elastic normal impact (Hertz).
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product

import numpy as np
import pandas as pd

from millprint.config.contact import ContactConfig
from millprint.config.geometry import BoxGeometry
from millprint.config.validation import AluminaImpactConfig, ElasticImpactConfig, ImpactConfig
from millprint.dem.world import World, walls_for
from millprint.mill.vessel import Vessel, shape_facets
from millprint.mill.walls import Walls
from millprint.validation.inputs import Inputs
from millprint.validation.predictions import CONTACT, prediction

# The run ends after so many durations of the elastic impact; damping makes an impact longer.
DURATIONS = 4.0
# The box is so many radii wide; nothing of it but the floor is ever near the sphere.
WIDTH_RADII = 200.0
# Speed at which the first touch begins at a distance of one step [-]: the sphere starts with its surface on the plate.
FORMULA_SLIDING, FORMULA_STICKING = "full sliding (Walton 1993)", "rolling at the end"


@dataclass(frozen=True)
class Rebound:
    """Velocities of a sphere before and after an impact.

    normal, tangential: of the centre [m/s], the normal one positive towards the plate before and away from it after;
    spin: about the axis across both, positive for rolling along +x [rad/s]; radius [m].
    """

    normal_before: float
    tangential_before: float
    normal: float
    tangential: float
    spin: float
    radius: float

    @property
    def restitution(self) -> float:
        """Normal velocity after over before [-]."""
        return self.normal / self.normal_before

    @property
    def tangential_restitution(self) -> float:
        """Tangential velocity of the centre after over before [-]."""
        return self.tangential / self.tangential_before

    @property
    def angle_deg(self) -> float:
        """Rebound angle of the centre from the normal [deg]."""
        return math.degrees(math.atan2(self.tangential, self.normal))

    @property
    def surface_velocity(self) -> float:
        """Tangential velocity of the surface at the contact point after the impact [m/s]."""
        return self.tangential - self.radius * self.spin

    @property
    def surface_angle_deg(self) -> float:
        """Rebound angle of the contact point from the normal [deg]."""
        return math.degrees(math.atan2(self.surface_velocity, self.normal))


def impact_duration(contact: ContactConfig, radius: float, speed: float) -> float:
    """Duration of the elastic impact of a sphere on a plate, 2.9432 (m^2 / (k^2 v))^(1/5) [s] (Hertz 1882).

    k = 16/15 sqrt(R) E*: the time is 2.9432 d / v with the largest overlap d = (15 m v^2 / (16 sqrt(R) E*))^(2/5).
    radius [m], speed along the normal [m/s].
    """
    mass = contact.density_kg_m3 * 4 / 3 * math.pi * radius**3
    effective = contact.young_modulus_gpa * 1e9 / (2 * (1 - contact.poisson_ratio**2))
    overlap = (15 * mass * speed**2 / (16 * math.sqrt(radius) * effective)) ** 0.4
    return 2.9432 * overlap / speed


def pair_modulus(first_gpa: float, second_gpa: float) -> float:
    """Young's modulus of one material that acts as two of the same Poisson's ratio: 2 E1 E2 / (E1 + E2) [GPa].

    1/E* = (1 - nu^2) (1/E1 + 1/E2) and 1/G* = 2 (2 - nu) (1 + nu) (1/E1 + 1/E2) are those of the pair.
    """
    return 2 * first_gpa * second_gpa / (first_gpa + second_gpa)


def _plate(radius: float) -> tuple[Vessel, Walls]:
    side = 1e3 * WIDTH_RADII * radius
    box = BoxGeometry(kind="box", x_mm=side, y_mm=side, z_mm=side / 10)
    vessel = Vessel(shape_facets(box, "impact", solid=False), "impact")
    return vessel, walls_for(vessel, radius, 0.1 * radius, WIDTH_RADII * radius / 20)


class Plate:
    """A plate for impacts of spheres of one radius [m]."""

    def __init__(self, radius: float) -> None:
        self.radius = radius
        self.vessel, self.walls = _plate(radius)

    def hit(self, contact: ContactConfig, normal: float, tangential: float, steps: int, spin: float = 0.0) -> Rebound:
        """One impact at velocities [m/s] towards and along the plate, with a spin [rad/s], in `steps` steps a duration.

        Raises SimulationError as `World.run`.
        """
        duration = impact_duration(contact, self.radius, normal)
        low = self.vessel.bounds[0][2]
        world = World(
            self.vessel, contact, [0.0, 0.0, low + self.radius], [tangential, 0.0, -normal], [0.0, spin, 0.0],
            self.radius, step=duration / steps, skin=0.1 * self.radius, walls=self.walls,
        )  # fmt: skip
        world.run(DURATIONS * duration)
        (vx, _, vz), (_, turn, _) = world.balls.velocity[0], world.balls.angular_velocity[0]
        return Rebound(normal, tangential, float(vz), float(vx), float(turn), self.radius)


def sliding_restitution(friction: float, restitution: float, angle_deg: np.ndarray) -> np.ndarray:
    """Tangential restitution of a sphere that slides throughout, 1 - mu (1 + e) / tan(theta) [-] (Walton 1993).

    It slides throughout if tan(theta) > 7/2 mu (1 + e); below, the value is not a number.
    """
    slope = np.tan(np.radians(angle_deg))
    return np.where(slope > 3.5 * friction * (1 + restitution), 1 - friction * (1 + restitution) / slope, np.nan)


def variants(contact: ContactConfig, settings: ImpactConfig) -> list[ContactConfig]:
    """The contact set, and those at every corner of the intervals of restitution and friction."""
    ranges = {
        "restitution": settings.restitution or (contact.restitution,),
        "static_friction": settings.static_friction or (contact.static_friction,),
    }
    corners = [dict(zip(ranges, values, strict=True)) for values in product(*ranges.values())]
    changed = [contact.model_copy(update=corner) for corner in corners]
    return [contact, *(each for each in changed if each != contact)]


def _rows(quantity: str, unit: str, ids: dict[float, str], x: float, values: list[float]) -> dict:
    """A row with the first value as the prediction and the span of all as its interval."""
    varied = len(values) > 1
    return prediction(
        quantity, unit, values[0], id=ids.get(x, ""), x=x, lower=min(values) if varied else math.nan,
        upper=max(values) if varied else math.nan, interval=CONTACT if varied else "",
    )  # fmt: skip


def _ids(inputs: Inputs, quantity: str) -> dict[float, str]:
    """The ids of the measured points of a quantity by their x."""
    points = inputs.places[inputs.places["quantity"] == quantity]
    return dict(zip(points["x"], points["id"], strict=True))


def _all_places(given: Iterable[float], places: pd.Series) -> list[float]:
    return sorted({*map(float, given), *places})


def predict_alumina_impact(inputs: Inputs) -> pd.DataFrame:
    """Set-up 3: tangential restitution, spin and rebound angles over the angle of incidence, at one speed."""
    settings: AluminaImpactConfig = inputs.settings
    contact, plate = inputs.contact, Plate(settings.radius_mm * 1e-3)
    # The spin is counted as in the source: rolling along the way of the sphere is negative.
    quantities = {
        "tangential restitution": ("-", lambda hit: hit.tangential_restitution),
        "spin after the impact": ("rad/s", lambda hit: -hit.spin),
        "rebound angle of the centre": ("deg", lambda hit: hit.angle_deg),
        "rebound angle of the contact point": ("deg", lambda hit: hit.surface_angle_deg),
        "normal restitution": ("-", lambda hit: hit.restitution),
    }
    ids = {quantity: _ids(inputs, quantity) for quantity in quantities}
    angles = np.array(_all_places(settings.angles_deg, inputs.places["x"]))
    rows = []
    for angle in angles:
        speeds = settings.speed_m_s * math.cos(math.radians(angle)), settings.speed_m_s * math.sin(math.radians(angle))
        hits = [plate.hit(each, *speeds, settings.steps_per_impact) for each in variants(contact, settings)]
        for quantity, (unit, read) in quantities.items():
            rows.append(_rows(quantity, unit, ids[quantity], float(angle), [read(hit) for hit in hits]))
    sliding = sliding_restitution(contact.static_friction, contact.restitution, angles)
    sticking = np.full(len(angles), 5 / 7)
    for name, values in ((FORMULA_SLIDING, sliding), (FORMULA_STICKING, sticking)):
        speed = settings.speed_m_s * np.sin(np.radians(angles))
        spins = -2.5 * (1 - values) * speed / plate.radius
        for angle, value, spin in zip(angles, values, spins, strict=True):
            if value == value:
                rows.append(prediction("tangential restitution", "-", float(value), x=float(angle), model=name))
                rows.append(prediction("spin after the impact", "rad/s", float(spin), x=float(angle), model=name))
    return pd.DataFrame(rows)


def predict_elastic_impact(inputs: Inputs) -> pd.DataFrame:
    """Set-up 9: tangential over mu times normal velocity of the contact point, after against before."""
    settings: ElasticImpactConfig = inputs.settings
    contact, plate = inputs.contact, Plate(settings.radius_mm * 1e-3)
    quantity, normal = "tangential over mu times normal velocity after the impact", settings.normal_speed_m_s
    ids, rows = _ids(inputs, quantity), []
    for slope in _all_places(settings.slopes, inputs.places["x"]):
        values = []
        for each in variants(contact, settings):
            scale = each.static_friction * normal
            values.append(plate.hit(each, normal, slope * scale, settings.steps_per_impact).surface_velocity / scale)
        rows.append(_rows(quantity, "-", ids, slope, values))
        slides = slope - 3.5 * (1 + contact.restitution)
        if slides >= 0:
            rows.append(prediction(quantity, "-", slides, x=slope, model=FORMULA_SLIDING))
        rows.append(prediction(quantity, "-", 0.0, x=slope, model=FORMULA_STICKING))
    return pd.DataFrame(rows)
