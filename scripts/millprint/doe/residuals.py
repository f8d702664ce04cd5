"""Residuals of the analysis of variance, a row for each run."""

import numpy as np
import pandas as pd
from scipy.stats import norm, rankdata
from statsmodels.regression.linear_model import RegressionResultsWrapper

from millprint.doe.runs import RUN_ORDER, YIELD


def residual_table(runs: pd.DataFrame, fit: RegressionResultsWrapper) -> pd.DataFrame:
    """Each run with its fitted yield, residual, leverage, studentised residuals, Cook's distance, normal quantile.

    Residuals are in per cent of yield. Studentised values are empty where the leverage is 1, that is where the model
    goes through the run whatever its yield. The column run_order is there where the runs have one.
    """
    influence = fit.get_influence()
    leverage = influence.hat_matrix_diag
    free = leverage < 1 - 1e-9
    order = rankdata(fit.resid)
    # Blom's plotting positions.
    quantile = norm.ppf((order - 0.375) / (len(order) + 0.25))

    def where_free(values: np.ndarray) -> np.ndarray:
        return np.where(free, values, np.nan)

    return pd.DataFrame(
        {
            "case": runs["case"].to_numpy(),
            YIELD: runs[YIELD].to_numpy(),
            "fitted_percent": 100 * fit.fittedvalues.to_numpy(),
            "residual_percent": 100 * fit.resid.to_numpy(),
            "leverage": leverage,
            "studentised": where_free(influence.resid_studentized_internal),
            "studentised_external": where_free(influence.resid_studentized_external),
            "cooks_distance": where_free(influence.cooks_distance[0]),
            "normal_quantile": quantile,
            **({RUN_ORDER: runs[RUN_ORDER].to_numpy()} if RUN_ORDER in runs else {}),
        }
    )
