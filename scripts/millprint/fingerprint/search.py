"""Conditions, among those a user can set, whose descriptors come nearest to a target."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.ndimage import minimum_filter
from scipy.optimize import minimize

from millprint.config.fingerprint import DESCRIPTORS
from millprint.fingerprint.inverse import residuals
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.scaling import energy_scale

# Fill ratios and speeds tried before the refinement; the curves have few turns, each far wider than a step.
GRID = (81, 61)


@dataclass(frozen=True)
class Allowed:
    """What a user can change: speeds [Hz] and fill ratios from-to, ball diameters [m] and densities [kg/m3] as lists.

    No density means that of the fingerprint's own balls.
    """

    speeds_hz: tuple[float, float]
    fill_ratios: tuple[float, float]
    ball_diameters_m: tuple[float, ...]
    densities_kg_m3: tuple[float, ...] = ()


@dataclass(frozen=True)
class Medium:
    """One kind of ball in one mill."""

    fingerprint: Fingerprint
    diameter: float
    density: float

    def descriptors(self, fill_ratio: np.ndarray, speed: np.ndarray) -> dict[str, np.ndarray]:
        """The descriptors (m,) at fill ratios (m,) and speeds (m,) [Hz], by Eqs 3.22, 3.28 and 3.29."""
        amplitude = self.fingerprint.about["amplitude_m"]
        conditions = pd.DataFrame(
            {
                "fill_ratio": fill_ratio,
                "speed_hz": speed,
                "ball_diameter_m": self.diameter,
                "density_kg_m3": self.density,
                "amplitude_m": amplitude,
            }
        )
        scaled = self.fingerprint.means(conditions)
        energy = energy_scale(self.density, conditions["speed_hz"].to_numpy(), amplitude, self.diameter)
        return {
            "normal_energy_J": scaled["En"] * energy,
            "tangential_energy_J": scaled["Et"] * energy,
            "frequency_per_ball_hz": scaled["f"] * conditions["speed_hz"].to_numpy(),
        }


def distance(found: dict[str, np.ndarray], target: dict[str, float], weights: dict[str, float]) -> np.ndarray:
    """Weighted root mean square of log(found / target) over the descriptors of the target."""
    total = sum(weights[name] for name in target)
    return np.sqrt(sum(weights[name] * np.log(found[name] / target[name]) ** 2 for name in target) / total)


def _local_minima(
    medium: Medium, target: dict, weights: dict, fills: tuple, speeds: tuple
) -> Iterator[tuple[float, float]]:
    """Fill ratio and speed of every local minimum of the distance, refined from those of a grid in logarithms."""
    ranges = zip((fills, speeds), GRID, strict=True)
    axes = [np.geomspace(low, high, size if high > low else 1) for (low, high), size in ranges]
    fill, speed = (part.ravel() for part in np.meshgrid(*axes, indexing="ij"))
    grid = distance(medium.descriptors(fill, speed), target, weights).reshape(axes[0].size, axes[1].size)
    bounds = np.log([fills, speeds])

    def cost(place: np.ndarray) -> float:
        return float(distance(medium.descriptors(*np.exp(place)[:, None]), target, weights)[0] ** 2)

    lowest = np.argwhere(grid == minimum_filter(grid, size=3, mode="nearest"))
    for i, j in lowest:
        start = np.log([axes[0][i], axes[1][j]])
        # Squared distances are smooth, so that the slope is right at a target that can be met.
        found = minimize(cost, start, bounds=bounds, method="L-BFGS-B", options={"ftol": 1e-14, "gtol": 1e-10})
        yield tuple(np.exp(found.x if found.fun < grid[i, j] ** 2 else start))


def _row(medium: Medium, fill_ratio: float, speed: float, target: dict, weights: dict) -> dict:
    """One condition with its descriptors, their intervals and residuals, and where it stands to the simulations."""
    fingerprint = medium.fingerprint
    prediction = fingerprint.predict(speed, medium.diameter, fill_ratio, medium.density)
    bands = {name: getattr(prediction, name) for name in DESCRIPTORS}
    found = {name: band.value for name, band in bands.items()}
    row = {
        "mill": fingerprint.about["mill"],
        "contact": fingerprint.about["contact"],
        "ball_diameter_mm": medium.diameter * 1e3,
        "density_kg_m3": medium.density,
        "fill_ratio": fill_ratio,
        "balls": prediction.balls,
        "speed_rpm": speed * 60.0,
        "distance": float(distance(found, target, weights)),
    }
    for name, band in bands.items():
        row |= {name: band.value, f"{name}_lower": band.lower, f"{name}_upper": band.upper}
    held = [name for name in target if bands[name].lower <= target[name] <= bands[name].upper]
    return row | {
        **residuals(found, target),
        "power_W": prediction.power_W.value,
        "within_interval": ", ".join(held) or "nothing",
        "inside": "no" if prediction.outside else "yes",
        "outside": ", ".join(prediction.outside) or "nothing",
    }


def rank_conditions(
    target: dict[str, float], fingerprints: list[Fingerprint], allowed: Allowed, weights: dict[str, float], best: int
) -> pd.DataFrame:
    """The `best` conditions nearest to `target`, nearest first, with the residual of each descriptor.

    target: some or all of DESCRIPTORS; weights: of all of them. For each fingerprint, ball size and density, every
    fill ratio and speed that is a local minimum of the weighted root mean square of log(found / target) within what
    is allowed. `within_interval` names the descriptors whose target lies in the interval of the condition; `outside`
    names what lies beyond the simulations. Fill ratios that were not simulated are not looked at.
    """
    rows = []
    for fingerprint in fingerprints:
        low = max(allowed.fill_ratios[0], fingerprint.fill_range[0])
        high = min(allowed.fill_ratios[1], fingerprint.fill_range[1])
        densities = allowed.densities_kg_m3 or (fingerprint.about["density_kg_m3"],)
        if low > high:
            continue
        for diameter, density in itertools.product(allowed.ball_diameters_m, densities):
            medium = Medium(fingerprint, diameter, density)
            for fill_ratio, speed in _local_minima(medium, target, weights, (low, high), allowed.speeds_hz):
                rows.append(_row(medium, fill_ratio, speed, target, weights))
    bands = [f"{name}{end}" for name in DESCRIPTORS for end in ("", "_lower", "_upper")]
    columns = ["mill", "contact", "ball_diameter_mm", "density_kg_m3", "fill_ratio", "balls", "speed_rpm", "distance"]
    columns += [*bands, *(f"{name}_residual_percent" for name in DESCRIPTORS)]
    columns += ["power_W", "within_interval", "inside", "outside"]
    table = pd.DataFrame(rows, columns=columns).sort_values("distance", ignore_index=True)
    table = _distinct(table).head(best).reset_index(drop=True)
    table.insert(0, "rank", np.arange(1, len(table) + 1))
    return table


def _distinct(table: pd.DataFrame) -> pd.DataFrame:
    """Without the rows that two starts of the search have led to alike."""
    places = table[["mill", "contact", "ball_diameter_mm", "density_kg_m3"]].assign(
        fill=table["fill_ratio"].astype(float).round(3), speed=table["speed_rpm"].astype(float).round(0)
    )
    return table[~places.duplicated()]
