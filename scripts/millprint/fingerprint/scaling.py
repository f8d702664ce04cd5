"""The scales of dissipation and frequency (thesis Eqs 3.28 to 3.32), with the mill speed in Hz and not in rad/s."""

import numpy as np


def energy_scale(density, speed, amplitude, diameter):
    """Scale of the energy of one collision: rho omega^2 A^2 d^3 [J].

    density [kg/m3], speed omega [Hz], amplitude A [m], ball diameter d [m]; scalars or arrays of one shape.
    """
    return density * speed**2 * amplitude**2 * diameter**3


def power_scale(density, speed, amplitude, diameter):
    """Scale of the power of one ball: rho omega^3 A^2 d^3 [W], the denominator of Eq. 3.28 without the ball count."""
    return energy_scale(density, speed, amplitude, diameter) * speed


def specific_power(power, balls, density, speed, amplitude, diameter):
    """Specific power of Eq. 3.28 [-]: power [W] of all balls over n rho omega^3 A^2 d^3."""
    return power / (balls * power_scale(density, speed, amplitude, diameter))


def specific_frequency(frequency, balls, speed):
    """Specific collision frequency of Eq. 3.29 [-]: collisions of all balls [1/s] over n omega."""
    return frequency / (balls * speed)


def effective_restitution(restitution, static_friction):
    """Effective restitution of Eq. 3.30 [-]: e - 3/2 mu exp(-3 mu)."""
    return restitution - 1.5 * static_friction * np.exp(-3.0 * static_friction)


def universal_factor(effective):
    """Factor (1 - eps)^(1/2) of Eqs 3.31 and 3.32 [-], eps the effective restitution of Eq. 3.30."""
    return np.sqrt(1.0 - effective)
