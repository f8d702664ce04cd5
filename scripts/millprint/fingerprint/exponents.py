"""Are the exponents of the scaling those of the thesis? A regression on our own runs."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from statsmodels.regression.linear_model import OLS

from millprint.fingerprint.descriptors import as_built

VARIABLES = {"density_kg_m3": "rho", "speed_hz": "omega", "amplitude_m": "A", "ball_diameter_m": "d"}
# Exponents that Eqs 3.28 and 3.29 suppose, of the quantities of one ball or one collision.
POWER = {"rho": 1, "omega": 3, "A": 2, "d": 3}
ENERGY = {"rho": 1, "omega": 2, "A": 2, "d": 3}
FREQUENCY = {"rho": 0, "omega": 1, "A": 0, "d": 0}
SUPPOSED = {
    "normal_power_per_ball_W": POWER,
    "tangential_power_per_ball_W": POWER,
    "power_per_ball_W": POWER,
    "frequency_per_ball_hz": FREQUENCY,
    "normal_energy_J": ENERGY,
    "tangential_energy_J": ENERGY,
}
# Eqs 3.31 and 3.32: a scaled power or frequency times (1 - eps)^(1/2) is that of any contact set.
FACTOR = "1 - eps"
UNIVERSAL = {"Pn": -0.5, "Pt": -0.5, "P": -0.5, "f": -0.5}
COLUMNS = [
    *("contact", "quantity", "counting_rule", "variable", "supposed", "exponent", "lower", "upper"),
    *("agrees", "levels", "conditions", "remark"),
]


def _regress(runs: pd.DataFrame, quantity: str, variable: str, alike: list[str], probability: float) -> dict:
    """The exponent of `variable` over groups of runs that are alike in all else: log y = c(group) + p log x.

    Ordinary least squares with a constant for each group that has two levels at least, and Student's interval. It is
    as wide as the exponents of the groups differ: an exponent that holds at some fill ratios only is not certain.
    """
    groups = runs.groupby(alike, sort=True)
    told = runs[groups[variable].transform("nunique") > 1]
    found = {"levels": told[variable].nunique(), "conditions": len(told)}
    nothing = {"exponent": np.nan, "lower": np.nan, "upper": np.nan, "agrees": ""}
    if told.empty:
        return found | nothing | {"remark": "not varied with all else kept"}
    group = told.groupby(alike, sort=True).ngroup()
    constants = pd.get_dummies(group, dtype=float)
    if len(told) - constants.shape[1] < 2:
        return found | nothing | {"remark": "too few conditions for an interval"}
    design = constants.assign(exponent=np.log(told[variable]))
    fit = OLS(np.log(told[quantity]).to_numpy(), design.to_numpy()).fit()
    lower, upper = fit.conf_int(alpha=1.0 - probability)[-1]
    return found | {
        "exponent": fit.params[-1],
        "lower": lower,
        "upper": upper,
        "remark": f"{constants.shape[1]} groups alike in all else",
    }


def _row(
    runs: pd.DataFrame,
    quantity: str,
    variable: str,
    symbol: str,
    supposed: float,
    alike: list[str],
    probability: float,
) -> dict:
    row = _regress(runs, quantity, variable, alike, probability)
    if not np.isnan(row["exponent"]):
        row["agrees"] = "yes" if row["lower"] <= supposed <= row["upper"] else "no"
    return {"quantity": quantity, "variable": symbol, "supposed": supposed} | row


def fit_exponents(descriptors: pd.DataFrame, counting_rules: pd.DataFrame, probability: float) -> pd.DataFrame:
    """Exponents of rho, omega, A and d with confidence intervals, for each contact set and quantity.

    Runs are compared that differ in one variable alone: at one fill ratio, of one mill, with the other three kept. The
    frequency is also given by every counting rule without thresholds, because a gap in seconds is no part of the
    scaling. Last, over all contact sets, the exponent of 1 - eps in the scaled quantities (Eqs 3.31, 3.32 suppose
    -1/2), of runs that differ in the contact set alone.
    """
    table = descriptors.copy()
    for channel in ("normal", "tangential"):
        table[f"{channel}_power_per_ball_W"] = table[f"{channel}_power_W"] / table["balls"]
    table["power_per_ball_W"] = table["normal_power_per_ball_W"] + table["tangential_power_per_ball_W"]
    rule = table["counting_rule"].iloc[0]
    rows = []
    for contact, runs in table.groupby("contact", sort=True):
        for quantity, supposed in SUPPOSED.items():
            rows += _of_all_variables(runs, quantity, supposed, probability, contact, rule)
    whole = (counting_rules["collision_peak_force_min_N"] == 0) & (counting_rules["collision_duration_min_s"] == 0)
    others = counting_rules[whole & (counting_rules["counting_rule"] != rule)]
    for (contact, name), runs in others.groupby(["contact", "counting_rule"], sort=True):
        rows += _of_all_variables(runs, "frequency_per_ball_hz", FREQUENCY, probability, contact, name)
    rows += _of_restitution(as_built(descriptors), probability, rule)
    return pd.DataFrame(rows, columns=COLUMNS)


def _of_all_variables(
    runs: pd.DataFrame, quantity: str, supposed: Mapping[str, float], probability: float, contact: str, rule: str
) -> list[dict]:
    rows = []
    for name, symbol in VARIABLES.items():
        alike = ["mill", "fill_ratio", *(other for other in VARIABLES if other != name)]
        row = _row(runs, quantity, name, symbol, supposed[symbol], alike, probability)
        rows.append({"contact": contact, "counting_rule": rule} | row)
    return rows


def _of_restitution(descriptors: pd.DataFrame, probability: float, rule: str) -> list[dict]:
    runs = descriptors.assign(**{FACTOR: 1.0 - descriptors["effective_restitution"]})
    alike = ["mill", "fill_ratio", *VARIABLES]
    return [
        {"contact": "all", "counting_rule": rule} | _row(runs, name, FACTOR, FACTOR, supposed, alike, probability)
        for name, supposed in UNIVERSAL.items()
    ]
