"""Whether the residual of the analysis is the scatter of repeated runs, or effects that the model leaves out."""

from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import chi2
from scipy.stats import f as f_distribution
from statsmodels.regression.linear_model import RegressionResultsWrapper

from millprint.config.analysis import AnalysisConfig
from millprint.doe.design import treatments
from millprint.doe.model import sums_of_squares
from millprint.doe.runs import YIELD


def pure_error(config: AnalysisConfig, runs: pd.DataFrame) -> tuple[float, int]:
    """Sum of squares of runs of the same treatment about their mean, yield as a fraction, and its freedom."""
    groups = (runs[YIELD] / 100).groupby(treatments(runs[config.symbols]))
    return float((groups.var(ddof=0) * groups.size()).sum()), int((groups.size() - 1).sum())


def lack_of_fit_table(config: AnalysisConfig, runs: pd.DataFrame, fit: RegressionResultsWrapper) -> pd.DataFrame:
    """Each term, and the residual, against what is known of repeated runs.

    The first row is the classical test, F = (SS_residual - SS_pure) / df over the mean square of pure error, where some
    treatment was run twice. The others are SS / s2 against chi-squared, s the configured repeatability: its residual
    row asks whether the model leaves something out, its other rows (type II sums) whether a term would stand out from
    repeated runs alone, which is not whether it stands out from what the model leaves out.
    """
    table = sums_of_squares(config, fit, 2)[["degrees_of_freedom", "sum_of_squares"]]
    rest = table.loc["Residual"]
    squares, freedom = pure_error(config, runs)
    left = int(rest["degrees_of_freedom"]) - freedom
    row: dict[str, Any] = {"against": "repeated treatments", "term": "Residual", "degrees_of_freedom": left}
    row["error_percent"] = 100 * np.sqrt(squares / freedom) if freedom else np.nan
    if freedom and left and squares > 0:
        row["sum_of_squares"] = rest["sum_of_squares"] - squares
        row["statistic"] = row["sum_of_squares"] / left / (squares / freedom)
        row["p_value"] = f_distribution.sf(row["statistic"], left, freedom)
        row["note"] = f"F on {left} and {freedom} degrees of freedom"
    else:
        row["note"] = "no test: no treatment was run twice" if not freedom else "no test: nothing is left to be tested"
    rows = [row]
    if config.repeatability_percent is not None:
        error = config.repeatability_percent / 100
        for term, line in table.iterrows():
            statistic = line["sum_of_squares"] / error**2
            own = {"term": term, **line, "error_percent": 100 * error, "statistic": statistic}
            own["p_value"] = chi2.sf(statistic, line["degrees_of_freedom"])
            note = "chi-squared of the residual: what the model leaves out" if term == "Residual" else "chi-squared"
            rows.append({"against": "repeatability", **own, "note": note})
    columns = [
        "against",
        "term",
        "degrees_of_freedom",
        "sum_of_squares",
        "error_percent",
        "statistic",
        "p_value",
        "note",
    ]
    return pd.DataFrame(rows).reindex(columns=columns)
