"""The Rayleigh time of a ball, the step of a case, and the skin of its lists."""

import math
from collections.abc import Iterable, Mapping

from millprint.config.contact_set import ContactConfig
from millprint.config.sweep import Case, DemConfig

# The skin over the smallest ball's radius and the root of the step over the Rayleigh time [-].
SKIN_SHARE = 1.5


def rayleigh_time(radius_m: float, density: float, young_modulus_pa: float, poisson: float) -> float:
    """Time for a surface wave to run round half a ball, pi R sqrt(rho / G) / (0.1631 nu + 0.8766) [s].

    density in kg/m3, Young's modulus in Pa. A step must be a fraction of it for a contact to be resolved.
    """
    shear_modulus = young_modulus_pa / (2 * (1 + poisson))
    return math.pi * radius_m * math.sqrt(density / shear_modulus) / (0.1631 * poisson + 0.8766)


def aligned_step(longest_s: float, interval_s: float) -> tuple[float, int]:
    """The largest step [s] up to `longest_s` of which a whole number makes `interval_s`, and that number."""
    steps = max(1, math.ceil(interval_s / longest_s - 1e-9))
    return interval_s / steps, steps


def requested_step(case: Case, dem: DemConfig, rayleigh_s: float) -> float:
    """The requested step of a case [s]: its own, its fraction of the Rayleigh time, or that of `dem`."""
    if case.time_step_s:
        return case.time_step_s
    if case.rayleigh_fraction:
        return case.rayleigh_fraction * rayleigh_s
    return dem.time_step_s


def longest_step(
    ball_diameter_mm: float, cases: Iterable[Case], contacts: Mapping[str, ContactConfig], dem: DemConfig
) -> float:
    """The longest requested step [s] of the cases with balls of a diameter [mm] and the density of their contact set.

    That of `dem` if there are none.
    """
    steps = []
    for case in cases:
        if (case.ball_diameter_mm, case.mixture, case.density_kg_m3) == (ball_diameter_mm, None, None):
            own, stiffness = contacts[case.contact], contacts[case.contact].young_modulus_gpa * 1e9
            t_r = rayleigh_time(ball_diameter_mm / 2000, own.density_kg_m3, stiffness, own.poisson_ratio)
            steps.append(requested_step(case, dem, t_r))
    return max(steps, default=dem.time_step_s)


def largest_fraction(case: Case, dem: DemConfig) -> float:
    """The largest step that is allowed for a case, over its Rayleigh time [-]."""
    return case.rayleigh_fraction_max or dem.rayleigh_fraction_max


def skin_of(radius_m: float, step_over_rayleigh: float) -> float:
    """The skin of the lists of candidates [m]: SKIN_SHARE R sqrt(step / t_R). A contact is listed at a smaller gap.

    Lists are made again when a ball has moved by half the skin, so that their cost in a step goes with step / skin.
    That of going through them goes with their length, and so with skin / R. The sum is least where the skin goes with
    the root of R times the step, and t_R goes with R.
    """
    return SKIN_SHARE * radius_m * math.sqrt(step_over_rayleigh)


def resolved_step(contact: ContactConfig, radius_m: float, wanted_s: float, rayleigh_fraction_max: float) -> float:
    """The requested step [s], or a shorter one if the Rayleigh time of a ball requires it."""
    rayleigh = rayleigh_time(radius_m, contact.density_kg_m3, contact.young_modulus_gpa * 1e9, contact.poisson_ratio)
    return min(wanted_s, rayleigh_fraction_max * rayleigh)
