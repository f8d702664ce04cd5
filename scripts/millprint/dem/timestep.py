"""The Rayleigh time of a ball, and the step of a case."""

import math


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
