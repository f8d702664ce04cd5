"""Effect sizes of an analysis of variance, with intervals from the noncentral F distribution."""

import numpy as np
import pandas as pd
from scipy.optimize import brentq
from scipy.stats import ncf


def noncentrality(statistic: float, freedom: float, residual: float, probability: float) -> float:
    """The noncentrality at which an F as small as `statistic` has `probability`; 0 if there is none."""

    def excess(value: float) -> float:
        return float(ncf.cdf(statistic, freedom, residual, value)) - probability

    # scipy's noncentral distribution is not defined at exactly zero noncentrality in every release.
    low, high = 1e-9, 10.0
    if excess(low) <= 0:
        return 0.0
    while excess(high) > 0:
        high *= 2
    return float(brentq(excess, low, high, xtol=1e-9))


def effect_sizes(terms: pd.DataFrame, residual: pd.Series, runs: int, total: float, confidence: float) -> pd.DataFrame:
    """Eta and omega squared of each term of an analysis of `runs` runs with the `total` sum of squares.

    partial eta2 = SS / (SS + SS_residual) = df F / (df F + df_residual)
    partial omega2 = df (F - 1) / (df (F - 1) + N), 0 if F < 1
    omega2 = (SS - df MS_residual) / (SS_total + MS_residual), 0 if F < 1

    The intervals follow from the noncentrality lambda that puts F at the two tails of its distribution (Steiger,
    Psychological Methods 9, 164, 2004): lambda / (lambda + df_residual) for partial eta2, the convention of R's
    effectsize, and the share of variance lambda / (lambda + N) for partial omega2. Eta squared is biased upwards,
    strongly so with few residual degrees of freedom, where its interval leans to one side of it.
    """
    freedom, f_value = terms["degrees_of_freedom"], terms["F"]
    rest = residual["degrees_of_freedom"]
    mean_square = residual["sum_of_squares"] / rest
    tail = (1 - confidence) / 2
    limits = np.array(
        [
            [noncentrality(statistic, own, rest, probability) for probability in (1 - tail, tail)]
            for own, statistic in zip(freedom, f_value, strict=True)
        ]
    ).reshape(-1, 2)
    eta, omega = limits / (limits + rest), limits / (limits + runs)
    gain = np.maximum(freedom * (f_value - 1), 0)
    return pd.DataFrame(
        {
            "partial_eta_squared": terms["sum_of_squares"] / (terms["sum_of_squares"] + residual["sum_of_squares"]),
            "partial_eta_squared_lower": eta[:, 0],
            "partial_eta_squared_upper": eta[:, 1],
            "partial_omega_squared": gain / (gain + runs),
            "partial_omega_squared_lower": omega[:, 0],
            "partial_omega_squared_upper": omega[:, 1],
            "omega_squared": gain * mean_square / (total + mean_square),
            "confidence": confidence,
        },
        index=terms.index,
    )
