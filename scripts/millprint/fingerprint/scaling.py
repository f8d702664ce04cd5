"""The scales of dissipation and frequency (thesis Eqs 3.28 to 3.32), with the mill speed in Hz and not in rad/s."""

from typing import TypeVar

import numpy as np

# A number, or an array of them; a column of a table goes for an array.
Quantity = TypeVar("Quantity", float, np.ndarray)


def energy_scale(
    density: Quantity | float, speed: Quantity, amplitude: Quantity | float, diameter: Quantity | float
) -> Quantity:
    """Scale of the energy of one collision: rho omega^2 A^2 d^3 [J].

    density [kg/m3], speed omega [Hz], amplitude A [m], ball diameter d [m]; scalars or arrays of one shape.
    """
    return density * speed**2 * amplitude**2 * diameter**3


def power_scale(
    density: Quantity | float, speed: Quantity, amplitude: Quantity | float, diameter: Quantity | float
) -> Quantity:
    """Scale of the power of one ball: rho omega^3 A^2 d^3 [W], the denominator of Eq. 3.28 without the ball count."""
    return energy_scale(density, speed, amplitude, diameter) * speed


def specific_power(
    power: Quantity,
    balls: Quantity | float,
    density: Quantity | float,
    speed: Quantity,
    amplitude: Quantity | float,
    diameter: Quantity | float,
) -> Quantity:
    """Specific power of Eq. 3.28 [-]: power [W] of all balls over n rho omega^3 A^2 d^3."""
    return power / (balls * power_scale(density, speed, amplitude, diameter))


def specific_frequency(frequency: Quantity, balls: Quantity | float, speed: Quantity) -> Quantity:
    """Specific collision frequency of Eq. 3.29 [-]: collisions of all balls [1/s] over n omega."""
    return frequency / (balls * speed)


def effective_restitution(restitution: Quantity, static_friction: Quantity) -> Quantity:
    """Effective restitution of Eq. 3.30 [-]: e - 3/2 mu exp(-3 mu)."""
    return restitution - 1.5 * static_friction * np.exp(-3.0 * static_friction)


def universal_factor(effective: Quantity) -> Quantity:
    """Factor (1 - eps)^(1/2) of Eqs 3.31 and 3.32 [-], eps the effective restitution of Eq. 3.30."""
    return np.sqrt(1.0 - effective)
