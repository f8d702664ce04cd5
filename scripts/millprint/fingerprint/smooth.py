"""Smooth master curves with a band: a Gaussian process of the logarithm over the logarithm of the fill ratio."""

import warnings

import numpy as np
import pandas as pd
from scipy.stats import norm
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

from millprint.errors import ConfigError
from millprint.fingerprint.curves import QUANTITIES

FEWEST_FILLS = 3
# In logarithms: correlation over a factor exp(0.4) to exp(3) of fill ratio, curves that vary by 20 % or more.
LENGTH_BOUNDS = (0.4, 3.0)
SIGNAL_BOUNDS = (0.04, 10.0)
NOISE_BOUNDS = (1e-5, 0.01)  # 0.3 % to 10 %, where conditions at one fill ratio do not tell
FEWEST_FREEDOM = 3


def _noise(fill_ratio: np.ndarray, logs: np.ndarray) -> WhiteKernel:
    """Variance of log values between conditions at one fill ratio, pooled: known, so not left to the fit.

    Left free, a few scattered conditions are best explained as noise alone, with a flat curve.
    """
    groups = [logs[fill_ratio == fill] for fill in np.unique(fill_ratio)]
    freedom = sum(group.size - 1 for group in groups)
    if freedom < FEWEST_FREEDOM:
        return WhiteKernel(1e-3, NOISE_BOUNDS)
    pooled = sum(((group - group.mean()) ** 2).sum() for group in groups) / freedom
    return WhiteKernel(max(pooled, NOISE_BOUNDS[0]), "fixed")


def _fit(fill_ratio: np.ndarray, values: np.ndarray, grid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean and predictive standard deviation of log(values) on `grid`; all three are flat arrays."""
    logs = np.log(values)
    kernel = ConstantKernel(0.1, SIGNAL_BOUNDS) * Matern(1.0, LENGTH_BOUNDS, nu=2.5) + _noise(fill_ratio, logs)
    process = GaussianProcessRegressor(kernel, n_restarts_optimizer=1, random_state=0)
    with warnings.catch_warnings():
        # A parameter at its bound is meant: few fill ratios cannot tell noise from shape.
        warnings.simplefilter("ignore", ConvergenceWarning)
        process.fit(np.log(fill_ratio)[:, None], logs - logs.mean())
    mean, deviation = process.predict(np.log(grid)[:, None], return_std=True)
    return mean + logs.mean(), deviation


def smooth_curves(descriptors: pd.DataFrame, points: int, probability: float) -> pd.DataFrame:
    """Every quantity on a grid of fill ratios with the band in which a new condition falls with `probability`.

    The values of ratio, P, En and Et follow from those of Pn, Pt and f, so that they agree with each other; each
    band is that of the quantity's own process, because the errors of Pn, Pt and f are not independent.
    Raises ConfigError for fewer than three fill ratios or a quantity that is not positive.
    """
    fills = np.sort(descriptors["fill_ratio"].unique())
    contact = descriptors["contact"].iloc[0]
    if fills.size < FEWEST_FILLS:
        raise ConfigError(
            f"sweeps: contact set {contact} is simulated at {fills.size} fill ratios; a curve needs {FEWEST_FILLS}"
        )
    grid = np.geomspace(fills[0], fills[-1], points)
    grid[0], grid[-1] = fills[0], fills[-1]
    value, deviation = {}, {}
    for quantity in QUANTITIES:
        known = descriptors[quantity].to_numpy()
        if not np.all(known > 0):
            raise ConfigError(f"descriptors: {quantity} = {known.min():g} with {contact}: a curve needs values over 0")
        log_mean, deviation[quantity] = _fit(descriptors["fill_ratio"].to_numpy(), known, grid)
        value[quantity] = np.exp(log_mean)
    value["ratio"] = value["Pt"] / value["Pn"]
    value["P"] = value["Pn"] + value["Pt"]
    value["En"] = value["Pn"] / value["f"]
    value["Et"] = value["Pt"] / value["f"]
    width = norm.ppf(0.5 + 0.5 * probability)
    table = {"fill_ratio": grid}
    for quantity in QUANTITIES:
        factor = np.exp(width * deviation[quantity])
        table |= {
            quantity: value[quantity],
            f"{quantity}_lower": value[quantity] / factor,
            f"{quantity}_upper": value[quantity] * factor,
        }
    return pd.DataFrame(table)
