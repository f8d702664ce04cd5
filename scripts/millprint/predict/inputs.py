"""What a structured model sees of a run: conditions, two derived descriptors, and their scaling."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from millprint.config.averaging import INPUTS, AveragingConfig
from millprint.predict.features import CONDITIONS

NORMAL, TANGENTIAL, FREQUENCY = "normal_energy_uJ", "tangential_energy_uJ", "specific_frequency_hz"
MICROJOULE_HZ_IN_MW = 1e-3


def describe(rows: pd.DataFrame) -> pd.DataFrame:
    """The inputs of every row, (n, 5), in the order of INPUTS.

    Power that one ball dissipates (En + Et) f [mW], how hard the powder is stressed, and the tangential share
    Et / (En + Et) [-], how it is stressed. At one fill ratio the first follows the cube of the speed and the second
    is constant (Eqs 3.28 and 3.29), so that a speed and a regime do not mix.
    """
    values = rows[list(CONDITIONS)].astype(float)
    both = values[NORMAL] + values[TANGENTIAL]
    derived = {
        "power_per_ball_mW": both * values[FREQUENCY] * MICROJOULE_HZ_IN_MW,
        "tangential_share": values[TANGENTIAL] / both,
    }
    return values.assign(**derived)[list(INPUTS)]


@dataclass(frozen=True)
class InputScaling:
    """x_scaled = (g(x) - mean) / spread, each of shape (k,); g is the logarithm where `logarithmic` says so."""

    logarithmic: np.ndarray
    mean: np.ndarray
    spread: np.ndarray

    @classmethod
    def of(cls, raw: np.ndarray, logarithmic: np.ndarray, smallest: np.ndarray) -> "InputScaling":
        """That of training inputs (n, k), with the population deviation, or `smallest` (k,) where that is larger.

        An input that the training rows hardly vary would otherwise be blown up to the size of the others.
        """
        seen = np.where(logarithmic, np.log(raw), raw)
        return cls(logarithmic, seen.mean(axis=0), np.maximum(seen.std(axis=0), smallest))

    def __call__(self, raw: np.ndarray) -> np.ndarray:
        """Raw inputs (n, k) as the model takes them."""
        return (np.where(self.logarithmic, np.log(raw), raw) - self.mean) / self.spread


def smallest_spreads(settings: AveragingConfig) -> np.ndarray:
    """The floors of the scaling in the order of INPUTS, (k,)."""
    return np.array([getattr(settings.smallest_spread, name, 0.0) for name in INPUTS])
