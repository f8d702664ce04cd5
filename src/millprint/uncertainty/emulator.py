"""An emulator: a Gaussian process that replaces the simulation between the points of a design.

The logarithm y of a quantity is m + g(x) + noise. g is a Matern 5/2 process with a length for each variable; the noise
is the scatter of a simulation with other starting positions. Draws of g show what the design leaves uncertain.

Saltelli's sample (SALib) is evaluated by such draws, so that Sobol indices and intervals include that (Le Gratiet,
Cannamela, Iooss, SIAM/ASA J. Uncertainty Quantif. 2 (2014) 336).
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd
from SALib.analyze import sobol as sobol_analysis
from SALib.sample import sobol as sobol_sample
from scipy.linalg import cholesky

from millprint.estimate.gaussian_process import Conditioned, Covariance, Kernel, Likelihood
from millprint.estimate.quantiles import normal_quantile

# Bounds of lengths in places between 0 and 1, and of variances of the logarithm over the variance of the design.
LENGTHS, VARIANCES, LEAST_NOISE, MOST_NOISE = (0.1, 30.0), (1e-2, 1e2), 1e-6, 1.0
# Number of starts of the search for the parameters with the largest likelihood.
RESTARTS = 2
JITTER = 1e-8


@dataclass(frozen=True)
class Emulator:
    """A fitted emulator: places (n, k), logarithms (n,), their mean and spread.

    known: the process of the logarithms without mean and spread; theta: its parameters, the noise last.
    """

    places: np.ndarray
    logs: np.ndarray
    centre: float
    scale: float
    known: Conditioned
    theta: np.ndarray

    @classmethod
    def fit(cls, places: np.ndarray, logs: np.ndarray, run_error: float = 0.0, seed: int = 0) -> "Emulator":
        """The emulator of largest marginal likelihood.

        places: (n, k) between 0 and 1; logs: (n,) logarithms; run_error: standard error of a logarithm according to the
        runs, a lower bound for the noise [-].
        """
        centre, scale = float(logs.mean()), float(logs.std()) or 1.0
        count, scaled = places.shape[1], (logs - centre) / scale
        kernel = Kernel(("Matern 5/2",), np.array([0]), 1 + np.arange(count)[None])
        least = float(np.clip((run_error / scale) ** 2, LEAST_NOISE, 0.5 * MOST_NOISE))
        bounds = np.log([VARIANCES, *[LENGTHS] * count, (least, MOST_NOISE)])
        first = np.log([1.0, *np.ones(count), max(0.01, least)])
        generator = np.random.RandomState(seed)
        starts = np.array([first, *(generator.uniform(*bounds.T) for _ in range(RESTARTS))])
        theta, _ = Likelihood(kernel, places, scaled, JITTER).maximise(starts, bounds)
        known = Conditioned.fit(Covariance(kernel, theta), places, scaled, np.exp(theta[-1]) + JITTER)
        return cls(places, logs, centre, scale, known, theta)

    @property
    def noise(self) -> float:
        """Standard deviation of the noise of a logarithm: the scatter of one simulation."""
        return self.scale * math.exp(0.5 * self.theta[-1])

    def predict(self, places: np.ndarray) -> np.ndarray:
        """Logarithms (m,) at places (m, k), without noise."""
        return self.centre + self.scale * self.known.mean(places)

    def draws(self, places: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
        """Functions (count, m) that agree with the design, at places (m, k), without noise."""
        mean, covariance = self.known.with_covariance(places)
        covariance[np.diag_indices_from(covariance)] += JITTER
        # Rounding may make a covariance of some thousand places indefinite.
        spread = JITTER
        while True:
            try:
                root = cholesky(covariance, lower=True)
                break
            except np.linalg.LinAlgError:
                spread *= 10
                covariance[np.diag_indices_from(covariance)] += spread
        return self.centre + self.scale * (mean + rng.standard_normal((count, len(mean))) @ root.T)

    @cached_property
    def left_out(self) -> np.ndarray:
        """Logarithms (n,) of the design, each predicted without it, by the parameters of the whole design."""
        scaled = (self.logs - self.centre) / self.scale
        return self.centre + self.scale * self.known.left_out(scaled)[0]


def quality(logs: np.ndarray, left_out: np.ndarray) -> dict[str, float]:
    """Q2 = 1 - sum (y - y_left_out)^2 / sum (y - mean)^2 [-], and the root mean square of y - y_left_out [-]."""
    residual = logs - left_out
    return {
        "q2": float(1.0 - (residual**2).sum() / ((logs - logs.mean()) ** 2).sum()),
        "leave_one_out_error": float(np.sqrt((residual**2).mean())),
    }


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
