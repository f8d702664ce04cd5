"""Inputs of the yield models: engineered features, inputs of the averaged process, and their standardisation.

How far predictions are from measured yields (thesis Eqs 5.3 and 5.17 to 5.20), and the ways to split the rows.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.special import expit

from millprint.config.yields import INPUTS, TrainingConfig

TIME = "time_h"
CHEMICAL = ("bpr", "molar_ratio", TIME)
NORMAL, TANGENTIAL, FREQUENCY = "normal_energy_uJ", "tangential_energy_uJ", "specific_frequency_hz"
CONDITIONS = (*CHEMICAL, NORMAL, TANGENTIAL, FREQUENCY)
FEATURES = (*CONDITIONS, "molar_ratio_squared", "bpr_molar_ratio", "time_sigmoid", "bpr_sigmoid")
POWER, SHARE = "power_per_ball_mW", "tangential_share"
MICROJOULE_HZ_IN_MW = 1e-3


def engineer(rows: pd.DataFrame) -> pd.DataFrame:
    """The ten features of every row (thesis Sec. 5.2.2), (n, 10), in the order of FEATURES.

    The six conditions, molar_ratio^2, bpr * molar_ratio, and the sigmoids 1 / (1 + exp(-x)) of the time in hours and of
    the ball-to-powder ratio. Their arguments are unscaled, so they hardly do more than separate 5 h from longer times
    and a ratio of 10 from 30.
    """
    values = dict(zip(CONDITIONS, rows[list(CONDITIONS)].to_numpy(float).T, strict=True))
    values |= {
        "molar_ratio_squared": values["molar_ratio"] ** 2,
        "bpr_molar_ratio": values["bpr"] * values["molar_ratio"],
        "time_sigmoid": expit(values[TIME]),
        "bpr_sigmoid": expit(values["bpr"]),
    }
    return pd.DataFrame(np.array([values[name] for name in FEATURES]).T, rows.index, list(FEATURES))


def describe(rows: pd.DataFrame) -> pd.DataFrame:
    """The inputs of the averaged process for every row, (n, 5), in the order of INPUTS.

    The power per ball (En + Et) f [mW] measures how strongly the powder is stressed, the tangential share Et / (En +
    Et) [-] in which way. At one fill ratio the power follows the cube of the speed and the share is constant (Eqs 3.28
    and 3.29): another speed changes only the power, another regime also the share.
    """
    values = dict(zip(CONDITIONS, rows[list(CONDITIONS)].to_numpy(float).T, strict=True))
    both = values[NORMAL] + values[TANGENTIAL]
    values |= {POWER: both * values[FREQUENCY] * MICROJOULE_HZ_IN_MW, SHARE: values[TANGENTIAL] / both}
    return pd.DataFrame(np.array([values[name] for name in INPUTS]).T, rows.index, list(INPUTS))


@dataclass(frozen=True)
class Standardisation:
    """x -> (g(x) - mean) / deviation, Eq. 5.2, each of shape (k,); g is the logarithm where `logarithmic` is true."""

    mean: np.ndarray
    deviation: np.ndarray
    logarithmic: np.ndarray

    @classmethod
    def of(
        cls, inputs: np.ndarray, logarithmic: np.ndarray | bool = False, smallest: np.ndarray | float = 0.0
    ) -> "Standardisation":
        """From training inputs (n, k): their mean, and their population deviation or `smallest` (k,) if that is larger.

        Without `smallest`, an input that hardly varies among the training rows would be scaled to the same spread as
        the others. An input that does not vary at all is only centred.
        """
        # Imported here, since the checks before a run import this module and do not need scikit-learn.
        from sklearn.preprocessing import StandardScaler

        logarithmic = np.broadcast_to(logarithmic, inputs.shape[1])
        scaled = np.where(logarithmic, np.log(inputs), inputs) if logarithmic.any() else inputs
        scaler = StandardScaler().fit(scaled)
        deviation = np.maximum(np.sqrt(scaler.var_), smallest)
        return cls(scaler.mean_, np.where(deviation > 0, deviation, 1.0), logarithmic)

    @classmethod
    def none(cls, columns: int) -> "Standardisation":
        """A standardisation that leaves inputs with this number of columns as they are."""
        return cls(np.zeros(columns), np.ones(columns), np.zeros(columns, dtype=bool))

    def __call__(self, inputs: np.ndarray) -> np.ndarray:
        """Standardised inputs, (n, k)."""
        scaled = np.where(self.logarithmic, np.log(inputs), inputs) if self.logarithmic.any() else inputs
        return (scaled - self.mean) / self.deviation


LEFT_OUT, NESTED, RANDOM = "leave_one_out", "nested_cv", "random_split"
# The locked split at the budget of the other schemes, to be compared with them.
LOCKED_AGAIN = "locked_reduced_budget"


METRICS = ("rmse", "mae", "mape", "r2", "wmse")
# How a score that is repeated with other folds spreads.
SPREAD = ("repeats", "lowest", "median", "highest")


@dataclass(frozen=True)
class YieldWeights:
    """The weights of Eq. 5.3: `weight` for a yield above `threshold` [%], 1 for any other."""

    threshold: float
    weight: float

    @classmethod
    def of(cls, settings: TrainingConfig) -> "YieldWeights":
        """The weights that the settings give."""
        return cls(settings.high_yield_percent, settings.high_yield_weight)

    def __call__(self, yields: np.ndarray) -> np.ndarray:
        """Weights of shape (n,), for yields (n,) [%]."""
        return np.where(np.asarray(yields) > self.threshold, self.weight, 1.0)


def weighted_mse(truth: np.ndarray, predicted: np.ndarray, weights: np.ndarray) -> float:
    """Mean of weights * (truth - predicted)^2, Eq. 5.3 [pp2]; the sum is divided by n and not by the weights."""
    return float(np.mean(weights * (truth - predicted) ** 2))


def metrics(truth: np.ndarray, predicted: np.ndarray, weigh: YieldWeights) -> dict[str, np.ndarray | float]:
    """RMSE [pp], MAE [pp], MAPE [%], R2 [-] and weighted MSE [pp2] over the last axis: Eqs 5.17 to 5.20 and 5.3.

    truth, predicted: (..., n) yields [%]. R2 is NaN where all yields are equal, MAPE where one is zero.
    """
    error = truth - predicted
    spread = ((truth - truth.mean(axis=-1, keepdims=True)) ** 2).sum(axis=-1)
    squares = (error**2).sum(axis=-1)
    shares = np.abs(np.divide(error, truth, out=np.full_like(error, np.nan), where=truth != 0))
    return {
        "rmse": np.sqrt((error**2).mean(axis=-1)),
        "mae": np.abs(error).mean(axis=-1),
        "mape": 100 * shares.mean(axis=-1),
        "r2": 1 - np.divide(squares, spread, out=np.full_like(squares, np.nan), where=spread > 0),
        "wmse": (weigh(truth) * error**2).mean(axis=-1),
    }


def spread(scores: ArrayLike) -> dict[str, float]:
    """SPREAD of the scores of the repeats, (r,): their number, and the lowest, median and highest where r > 1."""
    scores = np.asarray(scores, dtype=float)
    ends = np.quantile(scores, [0, 0.5, 1]) if len(scores) > 1 else np.full(3, np.nan)
    return dict(zip(SPREAD, (len(scores), *ends.tolist()), strict=True))


def jackknife_error(estimates: np.ndarray) -> np.ndarray:
    """Standard error from the n estimates (..., n) without one case each: sqrt((n - 1) / n sum (estimate - mean)^2).

    Efron and Stein, Ann. Stat. 9 (1981) 586. For a mean it is that of the mean. The models are not fitted again.
    """
    count = estimates.shape[-1]
    return np.sqrt((count - 1) * np.var(estimates, axis=-1))


def without_each(count: int) -> np.ndarray:
    """Positions (count, count - 1) of the cases that are left when each is taken out."""
    return np.array([np.delete(np.arange(count), index) for index in range(count)])


def bootstrap_metrics(
    truth: np.ndarray, predicted: np.ndarray, weigh: YieldWeights, resamples: int, level: float, seed: int
) -> pd.DataFrame:
    """Each metric, its jackknife error and its percentile interval over resampled cases.

    Columns: metric, value, error, lower, upper, SPREAD.

    truth, predicted: (cases,) yields [%], or (repeats, cases). A metric is averaged over the repeats, whose spread is
    given too, and a resample takes the same cases in all of them. The models are not fitted again: the interval shows
    how much the value depends on the choice of cases. Resamples in which a metric is not defined (all yields equal) are
    left out.
    """
    truth, predicted = np.atleast_2d(truth), np.atleast_2d(predicted)
    cases = truth.shape[1]
    drawn = np.random.default_rng(seed).integers(cases, size=(resamples, cases))
    values = metrics(truth, predicted, weigh)
    # A repeat at a time: all at once would take gigabytes.
    resampled = [metrics(one[drawn], other[drawn], weigh) for one, other in zip(truth, predicted, strict=True)]
    left = metrics(truth[:, without_each(cases)], predicted[:, without_each(cases)], weigh)
    tail = (1 - level) / 2
    rows = []
    for name in METRICS:
        lower, upper = np.nanquantile(np.mean(np.stack([part[name] for part in resampled]), axis=0), [tail, 1 - tail])
        error = float(jackknife_error(np.asarray(left[name]).mean(axis=0)))
        rows.append(
            {"metric": name, "value": float(np.mean(values[name])), "error": error, "lower": lower, "upper": upper}
            | spread(values[name])
        )
    return pd.DataFrame(rows)
