"""Linear springs and dashpots (Cundall and Strack, Geotechnique 29, 1979, 47): stiffnesses do not depend on overlap."""

import math
from typing import NamedTuple

from millprint.config.contact_set import ContactConfig
from millprint.dem.laws.record import ContactLaw, InLammps, ball_mass, damping_ratio

# The step's scale over the shortest duration of an impact, as the Rayleigh time is of a usual Hertz impact: at the
# largest step that is usually allowed, 0.2 of the scale, an impact takes 25 steps.
SCALE_SHARE = 0.2


class Linear(NamedTuple):
    """The mark of the law."""


class CohesiveLinear(NamedTuple):
    """The mark of the law with cohesion."""


def stiffnesses(contact: ContactConfig) -> tuple[float, float]:
    """k_n and k_t [N/m]."""
    normal = contact.value_of("normal_stiffness_n_m")
    return normal, normal * contact.value_of("tangential_stiffness_ratio")


def coefficients(contact: ContactConfig, radius: float, mass: float) -> tuple[float, float, float, float]:
    """k_n, k_t [N/m], and 2 beta sqrt(k m*) of both [N s/m]: a restitution of exactly e, at any speed."""
    normal, tangential = stiffnesses(contact)
    damping = -2 * damping_ratio(contact.value_of("restitution"))
    return normal, tangential, damping * math.sqrt(normal * mass), damping * math.sqrt(tangential * mass)


def springs(
    overlap: float, normal: float, tangential: float, damping: float, viscous: float
) -> tuple[float, float, float, float, float]:
    """F = k d, with energy F d / 2."""
    elastic = normal * overlap
    return elastic, tangential, damping, viscous, 0.5 * elastic * overlap


def step_scale(contact: ContactConfig, radius_m: float) -> float:
    """SCALE_SHARE of pi sqrt(m* / k) of two equal balls [s]; k: the larger of k_n and, of solid balls, 7/2 k_t."""
    normal, tangential = stiffnesses(contact)
    return SCALE_SHARE * math.pi * math.sqrt(ball_mass(contact, radius_m) / 2 / max(normal, 3.5 * tangential))


def impact(mass: float, stiffness: float, speed: float) -> tuple[float, float]:
    """d = v sqrt(m / k), and pi sqrt(m / k)."""
    root = math.sqrt(mass / stiffness)
    return speed * root, math.pi * root


def lammps_words(contact: ContactConfig, coefficient: float, friction: float) -> list[str]:
    """`hooke`, and a tangential spring that is stored as a displacement."""
    (normal, tangential), ratio = stiffnesses(contact), contact.value_of("tangential_stiffness_ratio")
    return [
        f"hooke {normal!r} {coefficient!r}",
        f"tangential linear_history {tangential!r} {math.sqrt(ratio)!r} {friction!r}",
    ]


LAW = ContactLaw(
    mark=Linear,
    cohesive_mark=CohesiveLinear,
    coefficients=coefficients,
    springs=springs,
    step_scale=step_scale,
    scale_title="a fifth of an impact's duration",
    impact=impact,
    overlap_power=2.0,
    # 2 sqrt(k m).
    lammps=InLammps(lammps_words, 2.0),
)
