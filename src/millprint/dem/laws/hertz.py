"""Hertz-Mindlin contact: springs that stiffen with the root of the overlap (thesis Eqs 3.4 to 3.12)."""

import math
from typing import NamedTuple

from millprint.config.contact_set import ContactConfig
from millprint.dem.laws.record import ContactLaw, InLammps, damping_ratio


class Hertz(NamedTuple):
    """The mark of the law."""


class CohesiveHertz(NamedTuple):
    """The mark of the law with cohesion."""


def effective_modulus(contact: ContactConfig) -> float:
    """E* of two bodies of one material [Pa], Eq. 3.11."""
    return contact.value_of("young_modulus_gpa") * 1e9 / (2 * (1 - contact.value_of("poisson_ratio") ** 2))


def coefficients(contact: ContactConfig, radius: float, mass: float) -> tuple[float, float, float, float]:
    """K_n over delta^(1/2), K_t over delta^(1/2), and the dampings over delta^(1/4)."""
    modulus, poisson = contact.value_of("young_modulus_gpa") * 1e9, contact.value_of("poisson_ratio")
    effective = effective_modulus(contact)
    shear = modulus / (4 * (2 - poisson) * (1 + poisson))
    damping = -2 * math.sqrt(5 / 6) * damping_ratio(contact.value_of("restitution"))
    tangential = 8 * shear * math.sqrt(radius)
    return (
        4 / 3 * effective * math.sqrt(radius),
        tangential,
        damping * math.sqrt(2 * effective * math.sqrt(radius) * mass),
        damping * math.sqrt(tangential * mass),
    )


def springs(
    overlap: float, normal: float, tangential: float, damping: float, viscous: float
) -> tuple[float, float, float, float, float]:
    """F = k d^(3/2), with energy 2/5 F d; K_t goes with d^(1/2), dampings with d^(1/4)."""
    root = math.sqrt(overlap)
    quarter = math.sqrt(root)
    elastic = normal * overlap * root
    return elastic, tangential * root, damping * quarter, viscous * quarter, 0.4 * elastic * overlap


def rayleigh_time(contact: ContactConfig, radius_m: float) -> float:
    """Time for a surface wave to run round half a ball, pi R sqrt(rho / G) / (0.1631 nu + 0.8766) [s]."""
    poisson = contact.value_of("poisson_ratio")
    shear_modulus = contact.value_of("young_modulus_gpa") * 1e9 / (2 * (1 + poisson))
    surface = 0.1631 * poisson + 0.8766
    return math.pi * radius_m * math.sqrt(contact.density_kg_m3 / shear_modulus) / surface


def impact(mass: float, stiffness: float, speed: float) -> tuple[float, float]:
    """d = (5 m v^2 / (4 k))^(2/5), and 2.9432 d / v (Hertz 1882)."""
    overlap = float((1.25 * mass * speed**2 / stiffness) ** 0.4)
    return overlap, 2.9432 * overlap / speed


def tangential_damping_ratio(poisson: float) -> float:
    """Tangential over normal damping at equal overlap, sqrt(K_t / S_n) = sqrt(2 (1 - nu) / (2 - nu)), Eqs 3.7, 3.9."""
    return math.sqrt(2 * (1 - poisson) / (2 - poisson))


def lammps_words(contact: ContactConfig, coefficient: float, friction: float) -> list[str]:
    """`hertz/material`, with the dashpot of Eq. 3.9 on a tangential spring that is stored as a force."""
    modulus, poisson = contact.value_of("young_modulus_gpa") * 1e9, contact.value_of("poisson_ratio")
    sliding = tangential_damping_ratio(poisson)
    return [
        f"hertz/material {modulus!r} {coefficient!r} {poisson!r}",
        f"tangential mindlin/force NULL {sliding!r} {friction!r}",
    ]


LAW = ContactLaw(
    mark=Hertz,
    cohesive_mark=CohesiveHertz,
    coefficients=coefficients,
    springs=springs,
    step_scale=rayleigh_time,
    scale_title="the Rayleigh time",
    impact=impact,
    overlap_power=2.5,
    # 2 sqrt(5 / 6) sqrt(S_n m), S_n = 3/2 x^(1/2).
    lammps=InLammps(lammps_words, math.sqrt(5)),
)
