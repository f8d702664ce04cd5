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


def effect_sizes(terms: pd.DataFrame, residual: pd.Series, runs: int, confidence: float) -> pd.DataFrame:
    """Partial eta squared and omega squared of each term, and an interval of the share of variance it explains.

    partial eta2 = SS / (SS + SS_residual); partial omega2 = df (F - 1) / (df (F - 1) + N), zero where F < 1.
    The interval holds the share lambda / (lambda + N) of the population, N runs, with lambda the noncentrality
    that puts F at the two tails of its distribution (Steiger, Psychological Methods 9, 164, 2004). Both estimate
    that share; eta squared is biased upwards, strongly so with few residual degrees of freedom.
    """
    freedom, f_value = terms["degrees_of_freedom"], terms["F"]
    tail = (1 - confidence) / 2
    shares = []
    for own, statistic in zip(freedom, f_value, strict=True):
        limits = [
            noncentrality(statistic, own, residual["degrees_of_freedom"], probability)
            for probability in (1 - tail, tail)
        ]
        shares.append([limit / (limit + runs) for limit in limits])
    gain = np.maximum(freedom * (f_value - 1), 0)
    lower, upper = np.transpose(shares)
    return pd.DataFrame(
        {
            "partial_eta_squared": terms["sum_of_squares"] / (terms["sum_of_squares"] + residual["sum_of_squares"]),
            "partial_omega_squared": gain / (gain + runs),
            "effect_lower": lower,
            "effect_upper": upper,
            "confidence": confidence,
        },
        index=terms.index,
    )
