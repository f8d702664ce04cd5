"""Residuals of the analysis of variance, and whether they look like independent normal errors."""

import numpy as np
import pandas as pd
from scipy.stats import norm, rankdata, shapiro
from statsmodels.regression.linear_model import RegressionResultsWrapper
from statsmodels.stats.diagnostic import normal_ad

from millprint.doe.runs import YIELD


def residual_table(runs: pd.DataFrame, fit: RegressionResultsWrapper) -> pd.DataFrame:
    """Each run with its fitted yield, residual, leverage, studentised residuals, Cook's distance, normal quantile.

    Residuals are in per cent of yield. Studentised values are empty where the leverage is 1, that is where the model
    goes through the run whatever its yield.
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
        }
    )


def _statistics(residuals: np.ndarray, scale: np.ndarray, fitted_ranks: np.ndarray) -> list[float]:
    """The statistics of one set of residuals, each large where the errors are not as assumed: (4,)."""
    ratio = residuals / scale
    spread = np.corrcoef(rankdata(np.abs(ratio)), fitted_ranks)[0, 1] if np.ptp(fitted_ranks) else 0.0
    return [1 - shapiro(residuals).statistic, normal_ad(residuals)[0], np.max(np.abs(ratio)), abs(spread)]


def residual_checks(fit: RegressionResultsWrapper, simulations: int, seed: int) -> pd.DataFrame:
    """Checks of the residuals, each with the p-value of its textbook and one that holds for this model.

    The textbook's p-values are for independent observations, and the residuals of a model with nearly as many
    parameters as runs are far from that. p_simulated is the share of `simulations` sets of normal errors, put through
    the same model, whose statistic is at least as large.
    """
    hat = fit.model.exog @ np.linalg.pinv(fit.model.exog)
    leverage = np.diag(hat)
    free = leverage < 1 - 1e-9
    fitted_ranks = rankdata(np.round(fit.fittedvalues.to_numpy(), 12))[free]

    def statistics(residuals: np.ndarray) -> list[float]:
        deviation = np.sqrt(residuals @ residuals / fit.df_resid)
        return _statistics(residuals[free], deviation * np.sqrt(1 - leverage[free]), fitted_ranks)

    own = fit.resid.to_numpy()
    found = statistics(own)
    errors = np.random.default_rng(seed).standard_normal((simulations, len(own)))
    simulated = np.array([statistics(row) for row in errors - errors @ hat])
    p_simulated = (1 + np.sum(simulated >= found, axis=0)) / (simulations + 1)
    return pd.DataFrame(
        {
            "check": ["shapiro_wilk", "anderson_darling", "largest_studentised", "spread_with_fitted"],
            "assumption": ["normal errors", "normal errors", "no outlier", "equal spread at low and high yield"],
            "statistic": [1 - found[0], *found[1:]],
            "p_textbook": [shapiro(own[free]).pvalue, normal_ad(own[free])[1], np.nan, np.nan],
            "p_simulated": p_simulated,
            "residual_degrees_of_freedom": int(fit.df_resid),
            "simulations": simulations,
        }
    )
