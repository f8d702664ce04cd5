"""Predictive intervals: from a model's own distribution, or from the errors of a cross-validation (CV+)."""

from collections.abc import Callable

import numpy as np
import pandas as pd
from sklearn.model_selection import KFold

from millprint.config.yields import TrainingConfig
from millprint.thesis.yields.averaging import AveragedModel
from millprint.thesis.yields.yield_model import YieldModel, fit_model

CV_PLUS = "cv_plus"
# Fits on rows and their yields (n,) [%], and returns the function that predicts other rows.
Fit = Callable[[pd.DataFrame, np.ndarray], Callable[[pd.DataFrame], np.ndarray]]


def own_intervals(model: YieldModel | AveragedModel, rows: pd.DataFrame, levels: list[float]) -> dict[str, np.ndarray]:
    """Central intervals (m, levels, 2) [%] within 0 and 100 by the name of the model's distribution; {} without one."""
    if model.distribution is None or not levels:
        return {}
    return {model.distribution: np.clip(model.intervals(rows, levels), 0, 100)}


def cross_intervals(centres: np.ndarray, residuals: np.ndarray, levels: list[float]) -> np.ndarray:
    """CV+ intervals, (m, levels, 2) [%], within 0 and 100 (Barber et al., Ann. Stat. 49 (2021) 486, Eq. 1.8).

    centres: (n, m) predictions for m rows by the model that did not see training row i; residuals: (n,) |error| of row
    i by that model. The ends are the floor(a (n + 1))-th smallest centre - residual and the ceil((1 - a)(n + 1))-th
    smallest centre + residual, a = 1 - level, with coverage of at least 1 - 2a. If n is too small for a level, the end
    is 0 or 100.
    """
    count = len(residuals)
    low = np.sort(centres - residuals[:, None], axis=0)
    high = np.sort(centres + residuals[:, None], axis=0)
    ends = np.empty((centres.shape[1], len(levels), 2))
    for index, level in enumerate(levels):
        # Rounded first, so that 0.05 * 40 counts as 2 and not as a little less.
        below = int(np.floor(round((1 - level) * (count + 1), 9)))
        above = int(np.ceil(round(level * (count + 1), 9)))
        ends[:, index, 0] = low[below - 1] if below >= 1 else 0.0
        ends[:, index, 1] = high[above - 1] if above <= count else 100.0
    return np.clip(ends, 0, 100)


def cross_validate(
    fit: Fit, rows: pd.DataFrame, yields: np.ndarray, unseen: pd.DataFrame, folds: int, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, m) [%] and absolute residuals (n,) [pp] by refits of `fit` on folds of the training rows."""
    centres, residuals = np.empty((len(rows), len(unseen))), np.empty(len(rows))
    parts = KFold(min(folds, len(rows)), shuffle=True, random_state=seed)
    for kept, held in parts.split(rows):
        predict = fit(rows.iloc[kept], yields[kept])
        centres[held] = predict(unseen)
        residuals[held] = np.abs(yields[held] - predict(rows.iloc[held]))
    return centres, residuals


def cross_validated_intervals(
    fit: Fit, rows: pd.DataFrame, yields: np.ndarray, unseen: pd.DataFrame, levels: list[float], folds: int, seed: int
) -> np.ndarray:
    """CV+ intervals (m, levels, 2) [%] for the rows `unseen`, by refits of `fit` on folds of the training rows."""
    return cross_intervals(*cross_validate(fit, rows, yields, unseen, folds, seed), levels)


def refit(model: YieldModel, training: TrainingConfig) -> Fit:
    """A function that fits the steps of a model on other rows, with the same hyper-parameters."""
    parameters = [step.parameters for step in model.steps]
    return lambda rows, yields: fit_model(model.name, model.strategy, parameters, rows, yields, training).predict
