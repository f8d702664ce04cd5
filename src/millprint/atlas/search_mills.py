"""The settings of the mills that one could use which do most nearly what a condition of another mill does.

For each mill and each size of balls that is sold, number of balls and speed are searched over all that the atlas knows:
a grid in logarithms, then finer ones around the nearest. Alike are E*_n and E*_t; how often they come is made up by
time. A search asks for values only; verdicts are by the intervals of both mills.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from millprint.atlas.atlas_model import KindModel
from millprint.atlas.estimate_mill import MillEstimate, estimate, estimate_many
from millprint.atlas.kind_groups import MOST_BALLS, Kind, Values
from millprint.estimate.estimates import Estimate, ratio_of
from millprint.estimate.judge import Verdict, judge_all
from millprint.fingerprint.condition_search import verdict_on

# What is to be alike.
ALIKE = ("weighted_normal_energy_J", "weighted_tangential_energy_J")
# Numbers of balls and speeds of the first grid and of the finer ones, how many of these there are, and how much finer.
LOOK, AROUND, ROUNDS = 14, 5, 3


@dataclass(frozen=True)
class Found:
    """A condition that was found: its estimate, the ratios of ALIKE to what is wanted, and its power per mass of balls
    over the wanted one, each with the interval of both mills; distance: root mean square of the ratios' logarithms."""

    title: str
    estimate: MillEstimate
    ratios: Mapping[str, Estimate]
    strength: Estimate
    distance: float

    def verdict(self, near_percent: float) -> Verdict:
        """Whether all of ALIKE are surely within `near_percent` of what is wanted."""
        return judge_all(verdict_on(own, near_percent) for own in self.ratios.values())


def power_of_mass(own: MillEstimate) -> Estimate:
    """Power over the mass of the balls [W/kg]."""
    return own.known["wall_power_W"] * (1 / own.charge_kg)


def settings_near(
    title: str, model: KindModel, base: Values, wanted: MillEstimate, speeds_hz: tuple[float, float]
) -> Found | None:
    """The number of balls and the speed of a mill that do most nearly what is wanted; None where the atlas knows none.

    base: its dimensions, and the balls' size, density and coefficients; speeds_hz: the range of the mill.
    """
    kind = model.kind
    goal = np.log([wanted.known[name].value for name in ALIKE])
    bounds = _bounds(kind, base, speeds_hz)
    if any(low > high for low, high in bounds):
        return None
    axes = [np.geomspace(low, high, LOOK) for low, high in bounds]
    best: tuple[float, dict[str, float]] = (math.inf, {})
    for _ in range(1 + ROUNDS):
        number, speed = (own.ravel() for own in np.meshgrid(*axes))
        asked: dict[str, Any] = {**base, "number": np.round(number), "speed_hz": _as_set(kind, speed)}
        far = _distances(model, asked, goal)
        nearest = int(far.argmin())
        if far[nearest] < best[0]:
            best = float(far[nearest]), {name: float(np.broadcast_to(own, far.shape)[nearest])
                                         for name, own in asked.items()}  # fmt: skip
        if not best[1]:
            return None
        steps = [(own[-1] / own[0]) ** (1 / (len(own) - 1)) for own in axes]
        axes = [
            np.clip(np.geomspace(best[1][name] / step, best[1][name] * step, AROUND), low, high)
            for name, step, (low, high) in zip(("number", "speed_hz"), steps, bounds, strict=True)
        ]
    own = estimate(kind, best[1], model)
    ratios = {name: ratio_of(own.known[name], wanted.known[name]) for name in ALIKE}
    return Found(title, own, ratios, ratio_of(power_of_mass(own), power_of_mass(wanted)), best[0])


def nearest_settings(
    title: str, model: KindModel, dimensions: Values, balls: Values, diameters_mm: Sequence[float],
    wanted: MillEstimate, speeds_hz: tuple[float, float] = (0.0, math.inf),
) -> list[Found]:  # fmt: skip
    """The nearest settings of a mill, one for each size of balls that the atlas knows there, nearest first."""
    each = (
        settings_near(title, model, {**dimensions, **balls, "ball_diameter_mm": size}, wanted, speeds_hz)
        for size in diameters_mm
    )
    return sorted((own for own in each if own is not None), key=lambda own: own.distance)


def _as_set(kind: Kind, speed_hz: np.ndarray) -> np.ndarray:
    """Speeds as a mill is set: whole turns per minute, or tenths of hertz."""
    step = 0.1 if kind.speed_unit == "hz" else 1 / 60
    return np.maximum(np.round(speed_hz / step), 1) * step


def _bounds(kind: Kind, base: Values, speeds_hz: tuple[float, float]) -> list[tuple[float, float]]:
    """The least and the most of number of balls and of speed that groups allow, each with the other's 1."""
    one = kind.groups_of({**base, "number": 1.0, "speed_hz": 1.0})
    ranges = {group.name: group for group in kind.groups}
    fill = ranges["fill"]
    speed, power = (ranges["froude"], 0.5) if "froude" in ranges else (ranges["critical"], 1.0)
    slowest, fastest = ((end / one[speed.name]) ** power for end in (speed.low, speed.high))
    fewest, most = (end / one["fill"] for end in (fill.low, fill.high))
    return [(max(1.0, math.ceil(fewest)), min(math.floor(most), MOST_BALLS)),
            (max(slowest, speeds_hz[0]), min(fastest, speeds_hz[1]))]  # fmt: skip


def _distances(model: KindModel, asked: dict[str, Any], goal: np.ndarray) -> np.ndarray:
    """Root mean square of the logarithms of ALIKE over what is wanted; infinite where the atlas knows nothing."""
    logs, hits = estimate_many(model, asked)
    apart = np.stack([logs[name] for name in ALIKE], axis=1) - goal
    return np.where(hits, np.sqrt((apart**2).mean(axis=1)), math.inf)
