"""A condition of a mill, the scales of its dissipation and its descriptors (thesis Eqs 3.20 to 3.32).

The mill speed is in Hz, not in rad/s.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Generic, TypeVar

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


# The scaled quantities from which all others are calculated: specific powers (Eq. 3.28) and frequency (Eq. 3.29).
BASIC = ("Pn", "Pt", "f")
# Quantities that need no counting rule, over the same scales: weighted energies, and the rate of strong collisions.
WEIGHTED_BASIC = ("En_star", "Et_star", "f90")
# The quantities that depend on the counting rule.
COUNTED = ("f", "En", "Et")


def scaled_quantities(basic: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Every scaled quantity [-] from the quantities of BASIC: ratio = Pt / Pn, P = Pn + Pt, En = Pn / f, Et = Pt / f.

    With the quantities of WEIGHTED_BASIC also fn_star = Pn / En_star and ft_star = Pt / Et_star.
    """
    normal, tangential, frequency = (np.asarray(basic[name]) for name in BASIC)
    weighted = {name: np.asarray(basic[name]) for name in WEIGHTED_BASIC if name in basic}
    if weighted:
        weighted |= {"fn_star": normal / weighted["En_star"], "ft_star": tangential / weighted["Et_star"]}
    return weighted | {
        "Pn": normal,
        "Pt": tangential,
        "f": frequency,
        "ratio": tangential / normal,
        "P": normal + tangential,
        "En": normal / frequency,
        "Et": tangential / frequency,
    }


# Descriptor of a condition -> the scaled quantity that it is computed from; a name ends with its unit.
SCALED_BY = {
    "weighted_normal_energy_J": "En_star",
    "weighted_tangential_energy_J": "Et_star",
    "weighted_normal_frequency_hz": "fn_star",
    "weighted_tangential_frequency_hz": "ft_star",
    "strong_frequency_hz": "f90",
    "normal_energy_J": "En",
    "tangential_energy_J": "Et",
    "specific_frequency_hz": "f",
}


# The unit of a descriptor by the end of its name.
UNITS = {"J": "J", "hz": "1/s", "W": "W", "share": "-"}


def descriptors_of(condition: Condition, scaled: Mapping[str, Any]) -> dict[str, Any]:
    """Energies [J] and frequencies per ball [1/s] of a condition, by Eqs 3.22, 3.28 and 3.29: each descriptor of
    SCALED_BY whose scaled quantity is known.

    scaled: quantities of the condition [-]: numbers, arrays or `Estimate`s.
    """
    scales = {"J": energy_scale(condition), "hz": condition.speed_hz}
    return {
        name: scaled[quantity] * scales[name.rpartition("_")[2]]
        for name, quantity in SCALED_BY.items()
        if quantity in scaled
    }


# Scaled quantities with a master curve: the four panels of thesis Fig. 3.12, then those for predictions.
PANELS = ("Pn", "Pt", "f", "ratio")
# The panels of a mill's sheet.
SHEET_PANELS = ("Pn", "Pt", "En_star", "Et_star")
# The panels of the energy-weighted descriptors.
WEIGHTED = tuple(name for name in SCALED_BY.values() if name not in COUNTED)
CURVES = (*PANELS, "P", "En", "Et", *WEIGHTED)
CURVE_COLUMNS = [
    "fill_ratio",
    *(f"{name}{end}" for name in dict.fromkeys((*PANELS, *SHEET_PANELS)) for end in ("", "_lower", "_upper")),
]


def fill_grid(fill_ratios: np.ndarray, points: int) -> np.ndarray:
    """Points from the smallest to the largest fill ratio, with the simulated ones among them."""
    between = np.geomspace(fill_ratios.min(), fill_ratios.max(), points)
    apart = np.abs(between[:, None] / fill_ratios - 1.0).min(axis=1) > 1e-6
    return np.union1d(between[apart], fill_ratios)
