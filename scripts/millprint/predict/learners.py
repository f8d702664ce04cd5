"""Every yield model behind one call: learn from some rows, answer for others."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from millprint.config.averaging import AveragingConfig
from millprint.config.yields import HeldOutConfig, TrainingConfig
from millprint.predict.averaging import average, fit_library
from millprint.predict.catalogue import AVERAGED
from millprint.predict.conformal import cross_validated_intervals
from millprint.predict.evaluation import half_width
from millprint.predict.model import YieldModel, fit_model
from millprint.predict.training import train

GAUSSIAN, CROSS, MIXTURE = "gaussian", "cv_plus", "mixture"


@dataclass(frozen=True)
class Answer:
    """Predicted yields (m,) [%], and predictive intervals (m, levels, 2) [%] by the method that they come from."""

    predicted: np.ndarray
    intervals: dict[str, np.ndarray]


# Training rows, their yields (n,) [%], the rows asked for, and the levels of the intervals wanted, which may be none.
Learner = Callable[[pd.DataFrame, np.ndarray, pd.DataFrame, list[float]], Answer]


def gaussian_intervals(model: YieldModel, rows: pd.DataFrame, levels: list[float]) -> np.ndarray | None:
    """Central normal intervals (m, levels, 2) [%] within 0 and 100; None for a model without a distribution."""
    deviation = model.deviation(rows)
    if deviation is None:
        return None
    predicted = model.predict(rows)
    halves = np.stack([half_width(deviation, level) for level in levels], axis=1)
    return np.clip(np.stack([predicted[:, None] - halves, predicted[:, None] + halves], axis=2), 0, 100)


def conformal_intervals(
    model: YieldModel,
    rows: pd.DataFrame,
    yields: np.ndarray,
    asked: pd.DataFrame,
    levels: list[float],
    settings: TrainingConfig,
    folds: int,
) -> np.ndarray:
    """CV+ intervals of a fitted model: its hyper-parameters stay, its steps are fitted again in every fold."""
    parameters = [step.parameters for step in model.steps]

    def fit(kept: pd.DataFrame, target: np.ndarray) -> Callable[[pd.DataFrame], np.ndarray]:
        refitted = fit_model(model.algorithm, model.strategy, parameters, kept, target, settings.choices, settings.seed)
        return refitted.predict

    return cross_validated_intervals(fit, rows, yields, asked, levels, folds, settings.seed)


def tuned_learner(algorithm: str, strategy: str, settings: TrainingConfig, budget: HeldOutConfig) -> Learner:
    """A model of Table 5.6, tuned on the rows that it learns from and on nothing else."""

    def learn(rows: pd.DataFrame, yields: np.ndarray, asked: pd.DataFrame, levels: list[float]) -> Answer:
        model, _ = train(algorithm, strategy, rows, yields, settings, budget)
        intervals = {}
        if levels:
            folds = budget.conformal_folds
            intervals[CROSS] = conformal_intervals(model, rows, yields, asked, levels, settings, folds)
            normal = gaussian_intervals(model, asked, levels)
            if normal is not None:
                intervals[GAUSSIAN] = normal
        return Answer(model.predict(asked), intervals)

    return learn


def averaged_learner(settings: AveragingConfig) -> Learner:
    """The averaged Gaussian process, its weights from the rows that it learns from and from nothing else."""

    def learn(rows: pd.DataFrame, yields: np.ndarray, asked: pd.DataFrame, levels: list[float]) -> Answer:
        model = average(fit_library(rows, yields, settings), settings)
        ends = [np.stack(model.interval(asked, level), axis=1) for level in levels]
        return Answer(model.predict(asked), {MIXTURE: np.stack(ends, axis=1)} if levels else {})

    return learn


def make_learner(
    model: str, strategy: str, training: TrainingConfig, budget: HeldOutConfig, averaging: AveragingConfig
) -> Learner:
    """The learner of a model of the catalogue."""
    if model == AVERAGED:
        return averaged_learner(averaging)
    return tuned_learner(model, strategy, training, budget)
