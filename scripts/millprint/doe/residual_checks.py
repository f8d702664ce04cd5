"""Whether the residuals of an analysis of variance look like independent normal errors of one size."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.stats import rankdata, shapiro
from statsmodels.regression.linear_model import RegressionResultsWrapper
from statsmodels.stats.diagnostic import normal_ad

from millprint.config.design import DesignConfig
from millprint.doe.runs import RUN_ORDER
from millprint.job import progress


@dataclass(frozen=True)
class Check:
    """A statistic of the residuals, large where the errors are not as assumed; p_textbook for independent errors."""

    name: str
    assumption: str
    statistic: Callable[[np.ndarray], float]
    p_textbook: Callable[[np.ndarray], float] = lambda _: np.nan
    shown: Callable[[float], float] = lambda value: value


@dataclass(frozen=True)
class _Fit:
    """What the checks need of a fit: leverages, the runs that the model does not go through, fitted values."""

    leverage: np.ndarray
    free: np.ndarray
    fitted: np.ndarray
    freedom: int
    parameters: int
    off_model: np.ndarray

    def studentised(self, residuals: np.ndarray) -> np.ndarray:
        deviation = np.sqrt(residuals @ residuals / self.freedom)
        return residuals[self.free] / (deviation * np.sqrt(1 - self.leverage[self.free]))


def _correlation(one: np.ndarray, two: np.ndarray) -> float:
    return abs(float(np.corrcoef(one, two)[0, 1])) if np.ptp(one) and np.ptp(two) else 0.0


def _normality(own: _Fit) -> list[Check]:
    def free(residuals: np.ndarray) -> np.ndarray:
        return residuals[own.free]

    return [
        Check(
            "shapiro_wilk",
            "normal errors",
            lambda rest: 1 - shapiro(free(rest)).statistic,
            lambda rest: shapiro(free(rest)).pvalue,
            lambda value: 1 - value,
        ),
        Check(
            "anderson_darling",
            "normal errors",
            lambda rest: normal_ad(free(rest))[0],
            lambda rest: normal_ad(free(rest))[1],
        ),
    ]


def _influence(own: _Fit) -> list[Check]:
    share = own.leverage[own.free] / (1 - own.leverage[own.free]) / own.parameters
    return [
        Check("largest_studentised", "no outlier", lambda rest: float(np.max(np.abs(own.studentised(rest))))),
        Check(
            "largest_cooks_distance",
            "no run that decides the fit",
            lambda rest: float(np.max(own.studentised(rest) ** 2 * share)),
        ),
    ]


def _spread(own: _Fit, config: DesignConfig, runs: pd.DataFrame) -> list[Check]:
    ranks = rankdata(np.round(own.fitted, 12))[own.free]
    checks = [
        Check(
            "spread_with_fitted",
            "equal spread at low and high yield",
            lambda rest: _correlation(rankdata(np.abs(own.studentised(rest))), ranks),
        )
    ]
    # Levene's statistic as a share: of the variation of the sizes, what lies between the levels.
    for factor in config.factors:
        codes = runs[factor.symbol].to_numpy()[own.free]
        groups = [np.flatnonzero(codes == code) for code in range(len(factor.levels))]

        def over_levels(rest: np.ndarray, groups: list[np.ndarray] = groups) -> float:
            size = np.abs(own.studentised(rest))
            between = sum(len(group) * (size[group].mean() - size.mean()) ** 2 for group in groups)
            return float(between / np.sum((size - size.mean()) ** 2))

        if min(map(len, groups)) > 1:
            checks.append(Check(f"spread_over_{factor.symbol}", f"equal spread at each {factor.column}", over_levels))
    return checks


def _shape(own: _Fit) -> list[Check]:
    # Tukey's degree of freedom: what the square of the fitted yield holds beyond the model.
    if np.linalg.norm(own.off_model) < 1e-9:
        return []
    return [
        Check(
            "tukey_nonadditivity",
            "no curvature in the fitted yield",
            lambda rest: float(abs(own.off_model @ rest) / np.linalg.norm(own.off_model) / np.linalg.norm(rest)),
        )
    ]


def _order(runs: pd.DataFrame) -> list[Check]:
    if RUN_ORDER not in runs:
        return []
    order = np.argsort(runs[RUN_ORDER].to_numpy())
    places = np.arange(len(order))
    return [
        Check("trend_over_run_order", "no drift over the runs", lambda rest: _correlation(rest[order], places)),
        Check(
            "durbin_watson",
            "no likeness of runs one after the other",
            lambda rest: abs(2 - float(np.sum(np.diff(rest[order]) ** 2) / (rest @ rest))),
        ),
    ]


def residual_checks(
    config: DesignConfig, runs: pd.DataFrame, fit: RegressionResultsWrapper, simulations: int, seed: int
) -> pd.DataFrame:
    """Checks of the residuals, each with the p-value of its textbook and one that holds for this model.

    The textbook's p-values are for independent observations, and the residuals of a model with nearly as many
    parameters as runs are far from that. p_simulated is the share of `simulations` sets of normal errors, put through
    the same model, whose statistic is at least as large. durbin_watson is the distance of that statistic from 2. The
    leverage has no p-value: it is the design's. Without a column run_order in the runs, the checks of it are empty.
    """
    hat = fit.model.exog @ np.linalg.pinv(fit.model.exog)
    leverage = np.diag(hat)
    free = leverage < 1 - 1e-9
    fitted = fit.fittedvalues.to_numpy()
    off_model = fitted**2 - hat @ fitted**2
    own = _Fit(leverage, free, fitted, int(fit.df_resid), fit.model.exog.shape[1], off_model)
    checks = [*_normality(own), *_influence(own), *_spread(own, config, runs), *_shape(own), *_order(runs)]
    rest = fit.resid.to_numpy()
    found = np.array([check.statistic(rest) for check in checks])
    errors = np.random.default_rng(seed).standard_normal((simulations, len(rest)))
    simulated = []
    with progress(simulations, "residual checks", "set") as bar:
        for row in errors - errors @ hat:
            simulated.append([check.statistic(row) for check in checks])
            bar.update()
    p_simulated = (1 + np.sum(np.array(simulated) >= found, axis=0)) / (simulations + 1)
    rows = [
        (check.name, check.assumption, check.shown(value), check.p_textbook(rest), share, "")
        for check, value, share in zip(checks, found, p_simulated, strict=True)
    ]
    rows.append(_leverage_row(runs, leverage))
    if RUN_ORDER not in runs:
        note = f"not known: the table of runs has no column {RUN_ORDER}"
        rows.append(("durbin_watson", "no likeness of runs one after the other", np.nan, np.nan, np.nan, note))
    table = pd.DataFrame(rows, columns=["check", "assumption", "statistic", "p_textbook", "p_simulated", "note"])
    return table.assign(residual_degrees_of_freedom=int(fit.df_resid), simulations=simulations)


def _leverage_row(runs: pd.DataFrame, leverage: np.ndarray) -> tuple:
    most = int(np.argmax(leverage))
    note = f"case {runs['case'].iloc[most]}; mean {leverage.mean():.3f}, least {leverage.min():.3f}"
    return "largest_leverage", "no run that the model must go through", leverage[most], np.nan, np.nan, note
