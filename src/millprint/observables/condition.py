"""A condition of a mill, the scales of its dissipation and its descriptors (thesis Eqs 3.20 to 3.32).

The mill speed is in Hz, not in rad/s.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
import pandas as pd

# A number, or an array of them; a column of a table counts as an array.
Quantity = TypeVar("Quantity", float, np.ndarray)


@dataclass(frozen=True)
class Condition(Generic[Quantity]):
    """Settings of a mill and its balls: numbers, or arrays of one shape (a number holds for all rows).

    fill_ratio: volume of the balls over the jar's; speed_hz: set speed of the mill, omega; amplitude_m: half the
    longest travel of a point of the wall along an axis, A.
    """

    fill_ratio: Quantity | float
    speed_hz: Quantity
    ball_diameter_m: Quantity | float
    density_kg_m3: Quantity | float
    amplitude_m: Quantity | float

    @classmethod
    def of_table(cls, table: pd.DataFrame) -> "Condition":
        """The conditions of a table that has a column for each field."""
        return cls(**{name: table[name] for name in VARIABLES})

    def rows(self) -> np.ndarray:
        """A row for each condition, a column for each field (m, 5)."""
        return np.column_stack(np.broadcast_arrays(*np.atleast_1d(*vars(self).values())))


# The variables of a condition, in the order of every table, array and file of fingerprints.
VARIABLES = tuple(field.name for field in fields(Condition))


def energy_scale(condition: Condition[Quantity]) -> Quantity:
    """Scale of the energy of one collision: rho omega^2 A^2 d^3 [J]."""
    speed, amplitude, diameter = condition.speed_hz, condition.amplitude_m, condition.ball_diameter_m
    return condition.density_kg_m3 * speed**2 * amplitude**2 * diameter**3


def power_scale(condition: Condition[Quantity]) -> Quantity:
    """Scale of the power of one ball: rho omega^3 A^2 d^3 [W], the denominator of Eq. 3.28 without the ball count."""
    return energy_scale(condition) * condition.speed_hz


def specific_power(power: Quantity, balls: Quantity | float, condition: Condition[Quantity]) -> Quantity:
    """Specific power of Eq. 3.28 [-]: power [W] of all balls over n rho omega^3 A^2 d^3."""
    return power / (balls * power_scale(condition))


def specific_frequency(frequency: Quantity, balls: Quantity | float, speed: Quantity) -> Quantity:
    """Specific collision frequency of Eq. 3.29 [-]: collisions of all balls [1/s] over n omega."""
    return frequency / (balls * speed)


def effective_restitution(restitution: Quantity, static_friction: Quantity) -> Quantity:
    """Effective restitution of Eq. 3.30 [-]: e - 3/2 mu exp(-3 mu), with e and mu of ball on ball.

    The thesis has one contact set for balls and walls; Eqs 3.30 to 3.32 do not allow for different values at the wall.
    """
    return restitution - 1.5 * static_friction * np.exp(-3.0 * static_friction)


class Scale(NamedTuple):
    """How a quantity of one ball or one collision grows with a condition: its scale, and the exponents in it."""

    of: Callable[[Condition], Any]
    exponents: Mapping[str, int]


# The scales of Eqs 3.28 and 3.29, and those that follow for speeds and times.
SCALES = {
    "power": Scale(power_scale, {"rho": 1, "omega": 3, "A": 2, "d": 3}),
    "energy": Scale(energy_scale, {"rho": 1, "omega": 2, "A": 2, "d": 3}),
    "frequency": Scale(lambda condition: condition.speed_hz, {"rho": 0, "omega": 1, "A": 0, "d": 0}),
    "speed": Scale(
        lambda condition: condition.speed_hz * condition.amplitude_m, {"rho": 0, "omega": 1, "A": 1, "d": 0}
    ),
    "time": Scale(lambda condition: 1 / condition.speed_hz, {"rho": 0, "omega": -1, "A": 0, "d": 0}),
    "none": Scale(lambda condition: 1.0, {"rho": 0, "omega": 0, "A": 0, "d": 0}),
}


def fill_grid(fill_ratios: np.ndarray, points: int) -> np.ndarray:
    """Points from the smallest to the largest fill ratio, with the simulated ones among them."""
    between = np.geomspace(fill_ratios.min(), fill_ratios.max(), points)
    apart = np.abs(between[:, None] / fill_ratios - 1.0).min(axis=1) > 1e-6
    return np.union1d(between[apart], fill_ratios)
