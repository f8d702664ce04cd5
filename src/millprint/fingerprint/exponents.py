"""Do the exponents of the scaling agree with the thesis? A regression on our own runs."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from millprint.fingerprint.condition import SCALED_BY
from millprint.fingerprint.cycles import CHANNELS
from millprint.fingerprint.descriptors import CHARGE, as_built

# Variable of the scaling -> its symbol in Eqs 3.28 and 3.29.
SYMBOLS = {"density_kg_m3": "rho", "speed_hz": "omega", "amplitude_m": "A", "ball_diameter_m": "d"}
# Exponents in the equations, for quantities of one ball or one collision.
POWER = {"rho": 1, "omega": 3, "A": 2, "d": 3}
ENERGY = {"rho": 1, "omega": 2, "A": 2, "d": 3}
FREQUENCY = {"rho": 0, "omega": 1, "A": 0, "d": 0}
SUPPOSED = {
    "normal_power_per_ball_W": POWER,
    "tangential_power_per_ball_W": POWER,
    "power_per_ball_W": POWER,
    **{name: ENERGY if name.endswith("_J") else FREQUENCY for name in SCALED_BY},
}
# Eqs 3.31 and 3.32: a scaled power or frequency times (1 - eps)^(1/2) is the same for every contact set.
FACTOR = "1 - eps"
UNIVERSAL = {"Pn": -0.5, "Pt": -0.5, "P": -0.5, "f": -0.5}
# What compared runs always share. A charge of several sizes does not count as another ball size.
ALIKE = ["mill", CHARGE, "fill_ratio"]
EXPONENT_COLUMNS = [
    *("contact", "quantity", "counting_rule", "variable", "supposed", "exponent", "lower", "upper"),
    *("agrees", "levels", "conditions", "remark"),
]


def with_power_per_ball(descriptors: pd.DataFrame) -> pd.DataFrame:
    """The descriptors with the normal, tangential and total power per ball [W]."""
    normal, tangential = (descriptors[f"{channel}_power_W"] / descriptors["balls"] for channel in CHANNELS)
    return descriptors.assign(
        normal_power_per_ball_W=normal, tangential_power_per_ball_W=tangential, power_per_ball_W=normal + tangential
    )


def _exponent(
    runs: pd.DataFrame, quantity: str, variable: str, supposed: float, alike: list[str], probability: float
) -> dict:
    """The exponent of `variable` over groups of otherwise equal runs: log y = c(group) + p log x.

    Ordinary least squares with a constant for each group that has at least two levels, and Student's interval. The
    interval grows with the differences between groups: an exponent that holds only at some fill ratios is uncertain.
    """
    # Imported here: slow to import, and the claims import this module.
    from statsmodels.regression.linear_model import OLS

    levels = runs.groupby(alike, sort=True)[variable].transform("nunique")
    compared = runs[levels > 1]
    row = {
        "quantity": quantity,
        "variable": SYMBOLS.get(variable, variable),
        "supposed": supposed,
        "levels": compared[variable].nunique(),
        "conditions": len(compared),
        "agrees": "",
    }
    if compared.empty:
        return row | {"remark": "not varied with all else kept"}
    constants = pd.get_dummies(compared.groupby(alike, sort=True).ngroup(), dtype=float)
    if len(compared) - constants.shape[1] < 2:
        return row | {"remark": "too few conditions for an interval"}
    design = constants.assign(exponent=np.log(compared[variable]))
    fit = OLS(np.log(compared[quantity]).to_numpy(), design.to_numpy()).fit()
    lower, upper = fit.conf_int(alpha=1.0 - probability)[-1]
    return row | {
        "exponent": fit.params[-1],
        "lower": lower,
        "upper": upper,
        "agrees": "yes" if lower <= supposed <= upper else "no",
        "remark": f"{constants.shape[1]} groups alike in all else",
    }


def _exponents(
    runs: pd.DataFrame, quantity: str, supposed: Mapping[str, float], probability: float, rule: str
) -> list[dict]:
    """The exponents of all variables in a quantity of one contact set."""
    rows = []
    for name, symbol in SYMBOLS.items():
        alike = [*ALIKE, *(other for other in SYMBOLS if other != name)]
        row = _exponent(runs, quantity, name, supposed[symbol], alike, probability)
        rows.append(row | {"contact": runs["contact"].iloc[0], "counting_rule": rule})
    return rows


def fit_exponents(descriptors: pd.DataFrame, counting_rules: pd.DataFrame, probability: float) -> pd.DataFrame:
    """Exponents of rho, omega, A and d with confidence intervals, for each contact set and quantity.

    The compared runs differ in only one variable: they share fill ratio, mill, charge and the other three variables.
    The specific frequency is also given by every counting rule without thresholds. Last, over all contact sets, the
    exponent of 1 - eps in the scaled quantities (Eqs 3.31, 3.32 suppose -1/2), from runs that differ only in the
    contact set.
    """
    table = with_power_per_ball(descriptors)
    rule = table["counting_rule"].iloc[0]
    rows = []
    for _, runs in table.groupby("contact", sort=True):
        for quantity, supposed in SUPPOSED.items():
            rows += _exponents(runs, quantity, supposed, probability, rule)
    whole = (counting_rules["collision_peak_force_min_N"] == 0) & (counting_rules["collision_duration_min_s"] == 0)
    others = counting_rules[whole & (counting_rules["counting_rule"] != rule)]
    for (_, name), runs in others.groupby(["contact", "counting_rule"], sort=True):
        rows += _exponents(runs, "specific_frequency_hz", FREQUENCY, probability, name)
    built = as_built(descriptors)
    built = built.assign(**{FACTOR: 1.0 - built["effective_restitution"]})
    for quantity, exponent in UNIVERSAL.items():
        row = _exponent(built, quantity, FACTOR, exponent, [*ALIKE, *SYMBOLS], probability)
        rows.append(row | {"contact": "all", "counting_rule": rule})
    return pd.DataFrame(rows, columns=EXPONENT_COLUMNS)
