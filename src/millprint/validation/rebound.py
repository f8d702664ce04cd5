"""An impact of a sphere on a plate in numbers: velocities before and after, and the scales of the elastic impact."""

import math
from dataclasses import dataclass

from millprint.config.contact_set import ContactConfig
from millprint.dem.overlap import impact_duration as hertz_duration
from millprint.dem.overlap import impact_overlap


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


def largest_overlap(contact: ContactConfig, radius: float, speed: float) -> float:
    """Largest overlap of an elastic sphere and a plate, (15 m v^2 / (16 sqrt(R) E*))^(2/5) [m] (Hertz 1882).

    radius [m], speed along the normal [m/s].
    """
    return impact_overlap(*_mass_and_stiffness(contact, radius), speed)


def impact_duration(contact: ContactConfig, radius: float, speed: float) -> float:
    """Duration of the elastic impact of a sphere on a plate, 2.9432 d / v with the largest overlap d [s] (Hertz 1882).

    radius [m], speed along the normal [m/s].
    """
    return hertz_duration(*_mass_and_stiffness(contact, radius), speed)


def _mass_and_stiffness(contact: ContactConfig, radius: float) -> tuple[float, float]:
    """Mass of a sphere [kg], and Hertz's stiffness 4/3 E* sqrt(R) of its contact with a plate [N/m^(3/2)]."""
    effective = contact.young_modulus_gpa * 1e9 / (2 * (1 - contact.poisson_ratio**2))
    return contact.density_kg_m3 * 4 / 3 * math.pi * radius**3, 4 / 3 * effective * math.sqrt(radius)
