"""What a contact law is: its springs and dashpots, its bound on the step, and its words."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from millprint.config.contact_set import ContactConfig


@dataclass(frozen=True)
class InLammps:
    """A law that is damped by a restitution, in the words of `pair_style granular`.

    words(contact, coefficient, friction): of the normal and the tangential force, of LAMMPS's coefficient of
        restitution; damping: of an impact whose force is x^p + c x^((p - 1) / 2) v, c over the damping ratio.
    """

    words: Callable[[ContactConfig, float, float], list[str]]
    damping: float


@dataclass(frozen=True)
class ContactLaw:
    """A contact law, by its `kind` in a contact set.

    mark: a named tuple without fields, by whose type the kernels are compiled for this law (advance.advance);
        cohesive_mark: another one, for the law with cohesion.
    coefficients(contact, radius, mass): its first four columns of layout.LawColumns, of reduced radius [m] and mass
        [kg]: normal and tangential stiffness, normal and tangential damping.
    springs(overlap, *coefficients): at an overlap [m], the elastic normal force [N], tangential stiffness [N/m], normal
        and tangential damping [N s/m], and the elastic energy of the normal spring [J]. Numba compiles it into the
        kernels.
    step_scale(contact, radius): the time of which a step is a fraction, dem.rayleigh_fraction_max at most, for a ball
        [s]; scale_title: what it is.
    impact(mass, stiffness, speed): largest overlap [m] and duration [s] of an elastic impact, of the reduced mass [kg],
        the coefficient of normal stiffness, and the speed along the normal [m/s].
    lammps: the same law in the words of LAMMPS; None where it has none.
    overlap_power: for 1 / x of an impact's largest overlap, the stiffness is x ** overlap_power times as large.
    """

    mark: type[tuple]
    cohesive_mark: type[tuple]
    coefficients: Callable[[ContactConfig, float, float], tuple[float, float, float, float]]
    springs: Callable[..., tuple[float, float, float, float, float]]
    step_scale: Callable[[ContactConfig, float], float]
    scale_title: str
    impact: Callable[[float, float, float], tuple[float, float]]
    overlap_power: float
    lammps: "InLammps | None" = None


def damping_ratio(restitution: float) -> float:
    """beta = ln e / sqrt(ln^2 e + pi^2), Eq. 3.10 [-]."""
    logarithm = math.log(restitution)
    return logarithm / math.hypot(logarithm, math.pi)


def ball_mass(contact: ContactConfig, radius_m: float) -> float:
    """Mass of a ball [kg]."""
    return contact.density_kg_m3 * 4 / 3 * math.pi * radius_m**3
