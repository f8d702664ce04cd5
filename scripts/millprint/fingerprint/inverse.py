"""Inverse mode: from wanted descriptors to the conditions that give them (thesis Sec. 3.3.4)."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from millprint.config.fingerprint import DESCRIPTORS
from millprint.config.sweep import ball_count
from millprint.fingerprint.scaling import energy_scale

# Descriptor -> power of the mill's speed that it grows with, at a fixed fill ratio and ball (Eqs 3.28, 3.29).
SPEED_POWERS = {"normal_energy_J": 2, "tangential_energy_J": 2, "frequency_per_ball_hz": 1}


@dataclass(frozen=True)
class CurvePoint:
    """Master curves at one fill ratio: specific normal and tangential power, specific collision frequency [-]."""

    normal: float
    tangential: float
    frequency: float


def descriptors_at(
    point: CurvePoint, speed: float, density: float, amplitude: float, diameter: float
) -> dict[str, float]:
    """Energies per collision [J] and frequency per ball [1/s] of a condition, by Eqs 3.22, 3.28 and 3.29.

    speed [Hz], density [kg/m3], amplitude [m], ball diameter [m].
    """
    scale = energy_scale(density, speed, amplitude, diameter)
    return {
        "normal_energy_J": point.normal / point.frequency * scale,
        "tangential_energy_J": point.tangential / point.frequency * scale,
        "frequency_per_ball_hz": point.frequency * speed,
    }


def solve_speed(
    target: dict[str, float],
    point: CurvePoint,
    density: float,
    amplitude: float,
    diameter: float,
    weights: dict[str, float],
) -> float:
    """Speed [Hz] whose descriptors come nearest to `target`: least squares of the weighted log residuals.

    Each descriptor is c omega^p with p from SPEED_POWERS, so log(omega) = sum w p log(target / c) / sum w p^2: exact
    where one descriptor, or descriptors that agree, have a weight. Raises ValueError if every weight is zero.
    """
    unit = descriptors_at(point, 1.0, density, amplitude, diameter)
    below = sum(weights.get(name, 0.0) * power**2 for name, power in SPEED_POWERS.items())
    if below <= 0:
        raise ValueError("at least one descriptor must have a weight over 0")
    above = sum(
        weights.get(name, 0.0) * power * np.log(target[name] / unit[name]) for name, power in SPEED_POWERS.items()
    )
    return float(np.exp(above / below))


def residuals(found: dict[str, float], target: dict[str, float]) -> dict[str, float]:
    """Relative deviation of each descriptor from its target, in per cent; NaN for one that the target leaves open."""
    return {
        f"{name}_residual_percent": 100.0 * (found[name] / target[name] - 1.0) if name in target else np.nan
        for name in DESCRIPTORS
    }


# What a user may keep: both energies as the thesis does, each descriptor alone, or all three at once.
KEPT = {
    "both energies": {"normal_energy_J": 1.0, "tangential_energy_J": 1.0},
    "normal energy": {"normal_energy_J": 1.0},
    "tangential energy": {"tangential_energy_J": 1.0},
    "frequency per ball": {"frequency_per_ball_hz": 1.0},
    "all three": dict.fromkeys(DESCRIPTORS, 1.0),
}


def invert_speed(
    target: dict[str, float],
    point: CurvePoint,
    fill_ratio: float,
    density: float,
    amplitude: float,
    diameter: float,
    volume: float,
) -> pd.DataFrame:
    """Speeds that keep the target at a fixed fill ratio and ball size, a row for each choice of what can be kept.

    The residuals show what is lost: energies grow with omega^2 and the frequency per ball with omega, so one speed
    can keep all three only where the scale of the balls has not changed.
    """
    rows = []
    for kept, weights in KEPT.items():
        if not set(weights) <= set(target):
            continue
        speed = solve_speed(target, point, density, amplitude, diameter, weights)
        found = descriptors_at(point, speed, density, amplitude, diameter)
        rows.append(
            {
                "kept": kept,
                "fill_ratio": fill_ratio,
                "ball_diameter_mm": diameter * 1e3,
                "balls": ball_count(fill_ratio, volume, diameter),
                "speed_rpm": speed * 60.0,
                **found,
                **residuals(found, target),
            }
        )
    return pd.DataFrame(rows)
