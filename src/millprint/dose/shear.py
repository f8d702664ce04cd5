"""Shear against compression: what a kJ of tangential dose is worth in kJ of normal dose, by measured yields.

With separate rates for the normal dose x_n and the tangential dose x_t, Avrami's law is

    y = 100 (1 - exp(-(k (x_n + w x_t))^n)),    first order: n = 1

The one with the smaller AICc is taken. w = 1: only the total dose matters; above 1, shear does more than compression.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.optimize import brentq, minimize_scalar

from millprint.dose.energy_doses import NORMAL, TANGENTIAL, TOTAL, YIELD
from millprint.dose.kinetics import FEWEST_RUNS, MODELS, aicc, fit_law
from millprint.statistics.quantiles import f_quantile

LAWS = ("first order", "Avrami")
# w is searched between 1 / MOST_WORTH and MOST_WORTH.
MOST_WORTH = 1e3
# Runs whose tangential shares differ by less give no information on w [%].
SMALLEST_SPREAD = 5.0


@dataclass(frozen=True)
class ShearWorth:
    """How many kJ of compression one kJ of shear equals by the yields: w of the weighted law, and its evidence.

    lower, upper: 95 % interval by the profile of the likelihood; an end is 0 or infinite if the yields do not bound it.
    aicc: of the law with w free. gain_aicc: AICc with w = 1 less aicc; above 0, a free w is worth its parameter.
    """

    law: str
    worth: float
    lower: float
    upper: float
    aicc: float
    gain_aicc: float


def shear_worth(runs: pd.DataFrame) -> ShearWorth:
    """Fit w between 1 / MOST_WORTH and MOST_WORTH by the law of LAWS with the smallest AICc.

    runs: normal_kJ_g, tangential_kJ_g and yield_percent. The interval is the profile of normal errors: each w at which
    the sum of squares is below S_min (1 + F / (N - p)), F the 95 % quantile of F(1, N - p), p the parameters of the law
    and w.
    """
    return min((_worth_by(runs, law) for law in LAWS), key=lambda found: found.aicc)


def _worth_by(runs: pd.DataFrame, law: str) -> ShearWorth:
    yields = runs[YIELD].to_numpy(dtype=float)
    normal, tangential = (runs[name].to_numpy(dtype=float) for name in (NORMAL, TANGENTIAL))
    count, model = len(yields), MODELS[law]

    def squares(worth: float) -> float:
        return fit_law(normal + worth * tangential, yields, model)[1]

    grid = np.geomspace(1 / MOST_WORTH, MOST_WORTH, 41)
    profile = np.array([squares(worth) for worth in grid])
    place = int(np.argmin(profile))
    near = np.log(grid[max(place - 1, 0)]), np.log(grid[min(place + 1, len(grid) - 1)])
    found = minimize_scalar(lambda log_w: squares(np.exp(log_w)), bounds=near, method="bounded")
    worth, least = float(np.exp(found.x)), max(float(found.fun), 1e-12 * float(profile.max()))
    free = count - len(model.names) - 1
    bound = least * (1 + f_quantile(0.95, 1, free) / free) if free > 0 else np.inf

    def end(beyond: np.ndarray, otherwise: float) -> float:
        if not len(beyond):
            return otherwise
        return float(
            np.exp(brentq(lambda log_w: squares(np.exp(log_w)) - bound, np.log(beyond[0]), found.x, xtol=1e-3))
        )

    out = profile > bound
    lower = end(grid[out & (grid < worth)][::-1], 0.0)
    upper = end(grid[out & (grid > worth)], np.inf)
    even = max(squares(1.0), least)
    # The scatter is a parameter too.
    own = aicc(least, count, len(model.names) + 2)
    return ShearWorth(law, worth, lower, upper, own, aicc(even, count, len(model.names) + 1) - own)


def said_of_shear(runs: pd.DataFrame) -> str:
    """A sentence on shear against compression, only from the runs and the fit."""
    share = 100 * runs[TANGENTIAL] / runs[TOTAL]
    spread = f"{share.min():.0f} to {share.max():.0f} % of the dose is tangential"
    if len(runs) < FEWEST_RUNS:
        return f"Shear against compression: {spread}, in {len(runs)} runs, too few for a rate for each."
    if np.ptp(share) < SMALLEST_SPREAD:
        return f"Shear against compression: {spread} in every run, which cannot tell the two apart."
    found = shear_worth(runs)
    worth = f"{found.worth:.2g}" if found.worth < 0.99 * MOST_WORTH else f"{MOST_WORTH:g} or more"
    ends = f"{found.lower:.2g} to {'no upper end' if np.isinf(found.upper) else f'{found.upper:.2g}'}"
    apart = "are told apart" if found.lower > 1 or found.upper < 1 else "are not told apart"
    change = f"{'falls' if found.gain_aicc > 0 else 'rises'} by {abs(found.gain_aicc):.1f}"
    return (
        f"Shear against compression: {spread}; by {found.law} kinetics a kJ of shear is worth {worth} kJ of "
        f"compression (95 % interval {ends}), so the two {apart}; with a rate for each, AICc {change}."
    )
