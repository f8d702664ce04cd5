"""Inputs of the yield models: engineered features, inputs of the averaged process, and their standardisation."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.special import expit

from millprint.config.yields import INPUTS

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
