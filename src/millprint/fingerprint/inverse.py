"""Inverse mode at a fixed fill ratio: the speeds that keep the descriptors of a target (thesis Sec. 3.3.4)."""

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
import pandas as pd

from millprint.config.fingerprint import DESCRIPTOR_SETS, TARGET_DESCRIPTORS
from millprint.config.sweep import ball_count
from millprint.fingerprint.condition import Condition, descriptors_of, scaled_quantities

# Descriptor -> the exponent of the mill's speed in it, at a fixed fill ratio and ball (Eqs 3.28, 3.29).
SPEED_POWERS = {name: 2 if name.endswith("_J") else 1 for name in TARGET_DESCRIPTORS}

# Descriptors to keep: both energies as in the thesis, each descriptor by itself, or all at once.
KEPT = {
    "both energies": {"normal_energy_J": 1.0, "tangential_energy_J": 1.0},
    "normal energy": {"normal_energy_J": 1.0},
    "tangential energy": {"tangential_energy_J": 1.0},
    "specific frequency": {"specific_frequency_hz": 1.0},
    "all three": dict.fromkeys(DESCRIPTOR_SETS["per_collision"], 1.0),
    "both weighted energies": dict.fromkeys(DESCRIPTOR_SETS["weighted"][:2], 1.0),
    "weighted normal energy": {"weighted_normal_energy_J": 1.0},
    "weighted tangential energy": {"weighted_tangential_energy_J": 1.0},
    "both weighted frequencies": dict.fromkeys(DESCRIPTOR_SETS["weighted"][2:], 1.0),
    "all weighted": dict.fromkeys(DESCRIPTOR_SETS["weighted"], 1.0),
}


def descriptors_shown(target: Iterable[str]) -> list[str]:
    """The descriptors of every set that a target has one of."""
    named = set(target)
    return [name for names in DESCRIPTOR_SETS.values() if named.intersection(names) for name in names]


def nearest_speed(
    target: dict[str, float], basic: Mapping[str, float], condition: Condition[float], weights: dict[str, float]
) -> Condition[float]:
    """The condition at the speed whose descriptors come nearest to `target`; the given speed is ignored.

    basic: Pn, Pt and f at its fill ratio, and En_star, Et_star and f90 for weighted descriptors [-]. Least squares of
    the weighted log residuals: each descriptor is c omega^p with p from SPEED_POWERS, so log(omega) = sum w p
    log(target / c) / sum w p^2. That is exact where one descriptor, or descriptors that agree, have a weight. Raises
    ValueError if every weight is zero.
    """
    unit = descriptors_of(replace(condition, speed_hz=1.0), scaled_quantities(basic))
    weighing = {name: power for name, power in SPEED_POWERS.items() if weights.get(name, 0.0) > 0}
    if not weighing:
        raise ValueError("at least one descriptor must have a weight over 0")
    below = sum(weights[name] * power**2 for name, power in weighing.items())
    above = sum(weights[name] * power * np.log(target[name] / unit[name]) for name, power in weighing.items())
    return replace(condition, speed_hz=float(np.exp(above / below)))


def residuals(found: dict[str, float], target: dict[str, float]) -> dict[str, float]:
    """Relative deviation of each shown descriptor from its target [%]; NaN for one that the target does not have."""
    return {
        f"{name}_residual_percent": 100.0 * (found[name] / target[name] - 1.0) if name in target else np.nan
        for name in descriptors_shown(target)
    }


def invert_speed(
    target: dict[str, float], basic: Mapping[str, float], condition: Condition[float], volume_m3: float
) -> pd.DataFrame:
    """Speeds that keep the target at a fixed fill ratio and ball size, a row for each choice of what can be kept.

    The arguments are as in `nearest_speed`, and the volume of the jar. The residuals show what is lost: energies
    grow with omega^2 and frequencies with omega, so one speed can keep all of them only where the scale of the
    balls has not changed.
    """
    rows = []
    for kept, weights in KEPT.items():
        if not set(weights) <= set(target):
            continue
        nearest = nearest_speed(target, basic, condition, weights)
        found = descriptors_of(nearest, scaled_quantities(basic))
        found = {name: found[name] for name in descriptors_shown(target)}
        rows.append(
            {
                "kept": kept,
                "fill_ratio": nearest.fill_ratio,
                "ball_diameter_mm": nearest.ball_diameter_m * 1e3,
                "balls": ball_count(nearest.fill_ratio, volume_m3, nearest.ball_diameter_m),
                "speed_rpm": nearest.speed_hz * 60.0,
                **found,
                **residuals(found, target),
            }
        )
    return pd.DataFrame(rows)
