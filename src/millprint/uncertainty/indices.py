"""Sobol indices and intervals of a quantity from an emulator: the contribution of each parameter, and of all together.

Saltelli's sample (SALib) is evaluated by functions drawn from the emulator, so that indices and intervals include what
the design leaves uncertain (Le Gratiet, Cannamela, Iooss, SIAM/ASA J. Uncertainty Quantif. 2 (2014) 336).
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from SALib.analyze import sobol as sobol_analysis
from SALib.sample import sobol as sobol_sample

from millprint.statistics.quantiles import normal_quantile
from millprint.uncertainty.emulator import Emulator

# Bootstrap resamples of the sums in an index.
RESAMPLES = 50
ORDERS = {"first": "S1", "total": "ST"}


@dataclass(frozen=True)
class Draws:
    """Values of an emulator over the distributions.

    logs: (draws, rows) over Saltelli's sample of the contact parameters.
    """

    names: list[str]
    logs: np.ndarray

    @property
    def independent(self) -> np.ndarray:
        """The rows (draws, m) that are independent draws from the distributions: the first and last of each block."""
        block = len(self.names) + 2
        return self.logs.reshape(len(self.logs), -1, block)[:, :, [0, -1]].reshape(len(self.logs), -1)

    def ends(self, probability: float) -> tuple[float, float]:
        """Lower and upper quantile of the logarithm over distributions and draws."""
        low, high = np.quantile(self.independent, [(1 - probability) / 2, (1 + probability) / 2])
        return float(low), float(high)


def saltelli_shares(names: list[str], base_samples: int, seed: int) -> np.ndarray:
    """Saltelli's sample of independent variables uniform between 0 and 1: (base_samples (k + 2), k)."""
    return sobol_sample.sample(problem_of(names), base_samples, calc_second_order=False, seed=seed)


def problem_of(names: list[str]) -> dict:
    """The problem, as SALib takes it."""
    return {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}


def draw(emulator: Emulator, names: list[str], places: np.ndarray, count: int, seed: int) -> Draws:
    """Functions drawn from an emulator over Saltelli's sample of the variables `names`.

    places: (rows, k) of the emulator for each row of the sample.
    """
    return Draws(names, emulator.draws(places, count, np.random.default_rng(seed)))


def sobol_indices(draws: Draws, probability: float, seed: int) -> pd.DataFrame:
    """First-order and total indices of each variable: parameter, first, first_lower, first_upper, total, ...

    S_i = V(E(y | x_i)) / V(y), S_Ti = 1 - V(E(y | all but x_i)) / V(y). The interval includes the spread between draws
    of the emulator and, by bootstrap, the error of the sums.
    """
    width = normal_quantile(0.5 + 0.5 * probability)
    # SALib treats a seed of 0 as no seed.
    found = [
        sobol_analysis.analyze(
            problem_of(draws.names), logs, calc_second_order=False, num_resamples=RESAMPLES, conf_level=probability,
            seed=seed + 1,
        )
        for logs in draws.logs
    ]  # fmt: skip
    table = pd.DataFrame({"parameter": draws.names})
    for order, key in ORDERS.items():
        values = np.array([each[key] for each in found])
        sums = np.array([each[f"{key}_conf"] for each in found]) / width
        half = width * np.sqrt(values.var(axis=0) + (sums**2).mean(axis=0))
        table[order] = values.mean(axis=0)
        table[f"{order}_lower"], table[f"{order}_upper"] = table[order] - half, table[order] + half
    return table
