"""Yield against fill ratio at constant speed and at constant power: two straight lines (thesis Sec. 4.3.1)."""

import pandas as pd
from statsmodels.regression.linear_model import OLS
from statsmodels.tools import add_constant

SERIES = {"speed": "constant speed", "power": "constant power"}


def fit_slopes(runs: pd.DataFrame, probability: float) -> pd.DataFrame:
    """Ordinary least squares of the yield [-] on the fill ratio [percentage points], for each way of running.

    runs: mode, fill_ratio, yield_percent; the reference belongs to both lines. `slope_per_pp` is what one percentage
    point of fill ratio changes, with its confidence interval; three points leave one degree of freedom, so the
    interval is wide however high R2 is.
    """
    rows = []
    for mode, title in SERIES.items():
        line = runs[runs["mode"].isin(["reference", mode])]
        if line["fill_ratio"].nunique() < 3:
            continue
        fit = OLS(
            (line["yield_percent"] / 100.0).to_numpy(), add_constant((line["fill_ratio"] * 100.0).to_numpy())
        ).fit()
        lower, upper = fit.conf_int(alpha=1.0 - probability)[1]
        rows.append(
            {
                "series": mode,
                "title": title,
                "points": len(line),
                "intercept": fit.params[0],
                "slope_per_pp": fit.params[1],
                "slope_lower": lower,
                "slope_upper": upper,
                "p_value": fit.pvalues[1],
                "r2": fit.rsquared,
            }
        )
    columns = ["series", "title", "points", "intercept", "slope_per_pp", "slope_lower", "slope_upper", "p_value", "r2"]
    return pd.DataFrame(rows, columns=columns)
