"""Are the exponents of the scaling those of the thesis? A regression on our own runs."""

import numpy as np
import pandas as pd
import statsmodels.api as sm

VARIABLES = {"density_kg_m3": "rho", "speed_hz": "omega", "amplitude_m": "A", "ball_diameter_m": "d"}
# Exponents that Eqs 3.28 and 3.29 suppose, of the quantities of one ball or one collision.
SUPPOSED = {
    "normal_power_per_ball_W": {"rho": 1, "omega": 3, "A": 2, "d": 3},
    "tangential_power_per_ball_W": {"rho": 1, "omega": 3, "A": 2, "d": 3},
    "frequency_per_ball_hz": {"rho": 0, "omega": 1, "A": 0, "d": 0},
    "normal_energy_J": {"rho": 1, "omega": 2, "A": 2, "d": 3},
    "tangential_energy_J": {"rho": 1, "omega": 2, "A": 2, "d": 3},
}


def _varied(table: pd.DataFrame) -> list[str]:
    """Variables with more than one level at some fill ratio: only there can an exponent be told."""
    return [name for name in VARIABLES if (table.groupby("fill_ratio")[name].nunique() > 1).any()]


def _fit(table: pd.DataFrame, quantity: str, varied: list[str]):
    """Ordinary least squares of log(quantity) on the logarithms of `varied`, with a constant for each fill ratio."""
    design = np.log(table[varied])
    levels = pd.get_dummies(table["fill_ratio"], dtype=float)
    levels.columns = [f"fill_{fill:g}" for fill in levels.columns]
    design = pd.concat([design, levels], axis=1)
    freedom = len(design) - np.linalg.matrix_rank(design.to_numpy())
    if freedom < 1 or np.linalg.matrix_rank(design.to_numpy()) < design.shape[1]:
        return None
    return sm.OLS(np.log(table[quantity]), design).fit()


def fit_exponents(descriptors: pd.DataFrame, probability: float) -> pd.DataFrame:
    """Exponents of rho, omega, A and d with confidence intervals, for each contact set and quantity.

    The model is log y = c(fill ratio) + sum of exponent log(variable). A variable that no fill ratio has at two levels
    is said to be `not varied`; too few runs for an interval, or variables changed only together, `not separable`.
    """
    table = descriptors.copy()
    table["normal_power_per_ball_W"] = table["normal_power_W"] / table["balls"]
    table["tangential_power_per_ball_W"] = table["tangential_power_W"] / table["balls"]
    rows = []
    for contact, runs in table.groupby("contact", sort=True):
        varied = _varied(runs)
        for quantity, supposed in SUPPOSED.items():
            fit = _fit(runs, quantity, varied) if varied else None
            interval = None if fit is None else fit.conf_int(alpha=1.0 - probability)
            for name, symbol in VARIABLES.items():
                row = {"contact": contact, "quantity": quantity, "variable": symbol, "supposed": supposed[symbol]}
                if name not in varied or fit is None:
                    remark = "not varied" if name not in varied else "not separable"
                    rows.append(row | {"exponent": np.nan, "lower": np.nan, "upper": np.nan, "remark": remark})
                    continue
                lower, upper = interval.loc[name]
                remark = f"fitted over {runs[name].nunique()} levels, {len(runs)} conditions"
                rows.append(row | {"exponent": fit.params[name], "lower": lower, "upper": upper, "remark": remark})
    return pd.DataFrame(rows)
