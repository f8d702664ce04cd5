"""Training procedures: each learns from some rows and predicts others, whatever kind of yield model it trains."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from millprint.config.averaging import AveragingConfig
from millprint.config.yields import HeldOutConfig, TrainingConfig
from millprint.predict.averaging import fit_averaged
from millprint.predict.intervals import CV_PLUS, cross_validated_intervals, own_intervals, refit
from millprint.predict.regressors import AVERAGED, regressor
from millprint.predict.search import Trainer


@dataclass(frozen=True)
class Prediction:
    """Predicted yields (m,) [%], and predictive intervals (m, levels, 2) [%] by the method that they come from."""

    predicted: np.ndarray
    intervals: dict[str, np.ndarray]


# Training rows, their yields (n,) [%], the rows to predict, and the levels of their intervals, which may be none.
Procedure = Callable[[pd.DataFrame, np.ndarray, pd.DataFrame, list[float]], Prediction]


def procedure_of(
    name: str, strategy: str, training: TrainingConfig, budget: HeldOutConfig, averaging: AveragingConfig
) -> Procedure:
    """The training procedure of a model. Everything that it chooses, it chooses from the training rows alone.

    name: a regressor, which is tuned and fitted, or AVERAGED, whose members are fitted and weighted. Raises ValueError
    for an unknown one.
    """

    def tuned(rows: pd.DataFrame, yields: np.ndarray, unseen: pd.DataFrame, levels: list[float]) -> Prediction:
        model, _ = Trainer(training, budget).train(name, strategy, rows, yields)
        intervals = {}
        if levels:
            fit, folds = refit(model, training), budget.conformal_folds
            intervals[CV_PLUS] = cross_validated_intervals(fit, rows, yields, unseen, levels, folds, training.seed)
        return Prediction(model.predict(unseen), intervals | own_intervals(model, unseen, levels))

    def averaged(rows: pd.DataFrame, yields: np.ndarray, unseen: pd.DataFrame, levels: list[float]) -> Prediction:
        model = fit_averaged(rows, yields, averaging)
        return Prediction(model.predict(unseen), own_intervals(model, unseen, levels))

    if name == AVERAGED:
        return averaged
    regressor(name)
    return tuned
