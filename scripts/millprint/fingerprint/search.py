"""Conditions, among those a user can set, whose descriptors come nearest to a target."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.optimize import minimize_scalar

from millprint.fingerprint.inverse import DESCRIPTORS, CurvePoint, descriptors_at, residuals, solve_speed
from millprint.fingerprint.master import MasterCurves

GRID = 121  # fill ratios tried before the refinement; the curves have few turns, each far wider than a step


@dataclass(frozen=True)
class Allowed:
    """What a user can change: speeds [Hz] and fill ratios from-to, ball diameters [m] as a list."""

    speeds_hz: tuple[float, float]
    fill_ratios: tuple[float, float]
    ball_diameters_m: tuple[float, ...]


def curve_point(curves: MasterCurves, fill_ratio: float) -> CurvePoint:
    """The curves at a fill ratio, without their bands."""
    scaled = curves.at(fill_ratio)
    return CurvePoint(scaled["Pn"].value, scaled["Pt"].value, scaled["f"].value)


def _best_speed(
    curves: MasterCurves, fill_ratio: float, diameter: float, target: dict, weights: dict, speeds: tuple[float, float]
) -> tuple[float, dict[str, float]]:
    """Best speed at one fill ratio, held in the user's range: the cost is convex in log(omega), so a clip is exact."""
    point = curve_point(curves, fill_ratio)
    machine = (curves.about["density_kg_m3"], curves.about["amplitude_m"], diameter)
    speed = float(np.clip(solve_speed(target, point, *machine, weights), *speeds))
    return speed, descriptors_at(point, speed, *machine)


def _minima(cost: Callable[[float], float], low: float, high: float) -> list[float]:
    """Places of the local minima of `cost` on [low, high], refined between the points of a grid."""
    if high <= low:
        return [low]
    grid = np.geomspace(low, high, GRID)
    values = np.array([cost(place) for place in grid])
    padded = np.concatenate([[np.inf], values, [np.inf]])
    found = []
    for index in np.flatnonzero((padded[1:-1] <= padded[:-2]) & (padded[1:-1] <= padded[2:])):
        bounds = grid[max(index - 1, 0)], grid[min(index + 1, GRID - 1)]
        refined = minimize_scalar(cost, bounds=bounds, method="bounded", options={"xatol": 1e-6})
        found.append(float(refined.x) if refined.fun < values[index] else float(grid[index]))
    return found


def rank_conditions(
    target: dict[str, float], curves: list[MasterCurves], allowed: Allowed, weights: dict[str, float], best: int
) -> pd.DataFrame:
    """The `best` conditions nearest to `target`, nearest first, with the residual of each descriptor.

    For each contact set and ball size, every fill ratio that is a local minimum of the weighted root mean square of
    log(found / target), with the best allowed speed at each. `outside` names what lies beyond the simulations.
    """
    rows = []
    total = sum(weights.values())
    for curve in curves:
        low = max(allowed.fill_ratios[0], curve.about["ranges"]["fill_ratio"][0])
        high = min(allowed.fill_ratios[1], curve.about["ranges"]["fill_ratio"][1])
        for diameter in allowed.ball_diameters_m:

            def distance(fill_ratio: float, curve=curve, diameter=diameter) -> float:
                _, found = _best_speed(curve, fill_ratio, diameter, target, weights, allowed.speeds_hz)
                squares = (weights[name] * np.log(found[name] / target[name]) ** 2 for name in DESCRIPTORS)
                return float(np.sqrt(sum(squares) / total))

            for fill_ratio in _minima(distance, low, high) if low <= high else []:
                speed, found = _best_speed(curve, fill_ratio, diameter, target, weights, allowed.speeds_hz)
                prediction = curve.predict(speed, diameter, fill_ratio)
                rows.append(
                    {
                        "contact": curve.about["contact"],
                        "ball_diameter_mm": diameter * 1e3,
                        "fill_ratio": fill_ratio,
                        "balls": prediction.balls,
                        "speed_rpm": speed * 60.0,
                        "distance": distance(fill_ratio),
                        **found,
                        **residuals(found, target),
                        "outside": ", ".join(prediction.outside) or "nothing",
                    }
                )
    columns = ["contact", "ball_diameter_mm", "fill_ratio", "balls", "speed_rpm", "distance", *DESCRIPTORS]
    columns += [*(f"{name}_residual_percent" for name in DESCRIPTORS), "outside"]
    table = pd.DataFrame(rows, columns=columns).sort_values("distance", ignore_index=True).head(best)
    table.insert(0, "rank", np.arange(1, len(table) + 1))
    return table
