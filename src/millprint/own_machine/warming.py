"""Power from the warming of a jar: the heat balance of `millprint.dose.heat_balance`, turned round.

The balance is linear in the power P, so that a reading is T(t) = T0 + P u(t), where u is the warming by 1 W. What
nobody knows of the jar (heat transfer inside and outside, where heat is released, heat capacities) is sampled from the
ranges of `dose.heat`. Each sample has its own best P, and weighs exp(-S / 2 s^2 k): S, sum of squared residuals; s^2,
variance of the best sample's; k, how many neighbouring residuals tell the same. The interval is that of the weighted P.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from millprint.dose.heat_balance import Balance, solve
from millprint.estimate.estimates import LEVEL, Estimate, Interval

# Samples that must count, so that their quantiles mean something.
FEWEST_SAMPLES = 50
# Residuals of more than this many resolutions of the thermometer are not noise.
LARGEST_RESIDUAL = 3.0


@dataclass(frozen=True)
class Warming:
    """What a table of temperatures says."""

    power_W: Estimate
    """power in balls and powder while the mill ran"""
    model_degC: np.ndarray
    """temperatures of the best sample at the times of the table (m,)"""
    begin_K_min: float
    """its warming at the start [K/min]"""
    residual_K: float
    """root mean square of the readings about it"""
    resolution_K: float

    @property
    def described(self) -> bool:
        """Whether the balance describes the readings."""
        return self.residual_K <= LARGEST_RESIDUAL * self.resolution_K


def unit_response(balance: Balance, time_s: np.ndarray, start_s: float, stop_s: float, body: int) -> np.ndarray:
    """Warming (m, n) of a body at the times by the balance's sources from start to stop; 0 before the start [K].

    balance: with surroundings of 0 degC.
    """
    running, end = min(stop_s, time_s[-1]) - start_s, time_s[-1] - start_s
    phases = [(0.0, running, True), *([(running, end, False)] if end > running else [])]
    later = time_s[time_s > start_s] - start_s
    course = solve(balance, phases, np.append(0.0, later))
    found = np.zeros((len(time_s), len(balance)))
    found[len(time_s) - len(later) :] = course.temperature_degC[1:, :, body]
    return found


def fit_power(response_K: np.ndarray, time_s: np.ndarray, temperature_degC: np.ndarray, resolution_K: float) -> Warming:
    """The power that warmed a body, from readings (m,); response_K: `unit_response` of 1 W (m, n)."""
    centred = response_K - response_K.mean(axis=0)
    squares = (centred**2).sum(axis=0)
    over = temperature_degC - temperature_degC.mean()
    power = over @ centred / squares
    residual = over[:, None] - power * centred
    misfit = (residual**2).sum(axis=0)
    best = int(misfit.argmin())
    variance = max(misfit[best] / (len(over) - 3), resolution_K**2 / 12)
    alike = _alike(residual[:, best])
    weights = _weights((misfit - misfit[best]) / (2 * variance * alike))
    noise = np.random.default_rng(0).standard_normal(len(power)) * np.sqrt(variance * alike / squares)
    lower, median, upper = weighted_quantiles(power + noise, weights, [(1 - LEVEL) / 2, 0.5, (1 + LEVEL) / 2])
    model = temperature_degC.mean() + power[best] * centred[:, best]
    warms = np.flatnonzero(response_K[:, best] > 0)[:2]
    begin = np.diff(model[warms])[0] / np.diff(time_s[warms])[0] * 60
    power_W = Estimate(float(median), "W", repeats=Interval(float(lower), float(upper)), how="measured")
    return Warming(power_W, model, float(begin), float(np.sqrt(variance)), resolution_K)


def _alike(residual: np.ndarray) -> float:
    """How many neighbouring residuals tell the same: (1 + r) / (1 - r), with the correlation r of neighbours."""
    total = (residual**2).sum()
    r = (residual[1:] * residual[:-1]).sum() / total if total else 0.0
    return float(np.clip((1 + r) / (1 - r), 1.0, len(residual) / 4))


def _weights(exponent: np.ndarray) -> np.ndarray:
    """exp(-exponent) (n,), flattened until FEWEST_SAMPLES count, which widens the interval."""
    while True:
        weights = np.exp(-exponent)
        if weights.sum() ** 2 >= min(FEWEST_SAMPLES, len(weights)) * (weights**2).sum():
            return weights
        exponent = exponent / 1.5


def weighted_quantiles(values: np.ndarray, weights: np.ndarray, shares: Sequence[float]) -> np.ndarray:
    """Quantiles of weighted values (n,): the smallest value below which at least the share of the weight lies."""
    order = np.argsort(values)
    below = np.cumsum(weights[order]) / weights.sum()
    return values[order][np.searchsorted(below, np.asarray(shares) * (1 - 1e-12)).clip(0, len(values) - 1)]
