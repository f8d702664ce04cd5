"""Scales on which a Gaussian process sees a yield: as it is, bounded by a logit, or as reaction kinetics."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import expit, logit


@dataclass(frozen=True)
class Link:
    """z = forward(y) of a conversion y [-], its inverse, and log |dz/dy|, which makes likelihoods in z comparable."""

    forward: Callable[[np.ndarray], np.ndarray]
    inverse: Callable[[np.ndarray], np.ndarray]
    log_slope: Callable[[np.ndarray], np.ndarray]


def _rate(conversion: np.ndarray) -> np.ndarray:
    return np.log(-np.log1p(-conversion))


LINKS = {
    "identity": Link(lambda y: np.asarray(y, dtype=float), lambda z: z, lambda y: np.zeros_like(y)),
    "logit": Link(logit, expit, lambda y: -np.log(y * (1 - y))),
    # Avrami's kinetics y = 1 - exp(-(k t)^n): ln(-ln(1 - y)) = n ln k + n ln t, so that effects on the rate constant
    # add up and time enters by its logarithm.
    "avrami": Link(
        _rate,
        lambda z: -np.expm1(-np.exp(np.minimum(z, 30.0))),
        lambda y: -np.log(-(1 - y) * np.log1p(-y)),
    ),
}


def to_conversion(yields_percent: np.ndarray, margin: float) -> np.ndarray:
    """Yields [%] as conversions [-], kept `margin` away from 0 and 1, where bounded links have no finite value."""
    return np.clip(np.asarray(yields_percent, dtype=float) / 100, margin, 1 - margin)
