"""Training procedures: each learns from some rows and predicts others, whatever kind of yield model it trains."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from millprint.config.averaged_process import AveragingConfig
from millprint.config.yields import HeldOutConfig, TrainingConfig
from millprint.statistics.quantiles import normal_quantile
from millprint.thesis.yields.averaging import fit_averaged
from millprint.thesis.yields.distributions import Distribution, MixtureYields, NormalYields
from millprint.thesis.yields.predictive_intervals import CV_PLUS, cross_intervals, cross_validate, own_intervals, refit
from millprint.thesis.yields.regressors import AVERAGED, CLIMATOLOGY, regressor
from millprint.thesis.yields.search import Trainer

# A normal distribution with the spread of the errors of other runs.
ERRORS = "errors"


@dataclass(frozen=True)
class Prediction:
    """Predicted yields (m,) [%], predictive intervals (m, levels, 2) [%] by the method that they come from.

    distribution: what is scored; a normal one from cross-validated errors for a model that predicts none.
    """

    predicted: np.ndarray
    intervals: dict[str, np.ndarray]
    distribution: Distribution


# Training rows, their yields (n,) [%], the rows to predict, and the levels of their intervals, which may be none.
Procedure = Callable[[pd.DataFrame, np.ndarray, pd.DataFrame, list[float]], Prediction]


def smaller_forests(training: TrainingConfig, largest: int) -> TrainingConfig:
    """The settings with forests of at most `largest` trees: more trees only average out the noise of a forest."""
    spaces = {}
    for name, space in training.spaces:
        if regressor(name).forest and (trees := space.n_estimators)[1] > largest:
            spaces[name] = space.model_copy(update={"n_estimators": [min(trees[0], largest - 1), largest]})
    return training.model_copy(update={"spaces": training.spaces.model_copy(update=spaces)})


def climatology(rows: pd.DataFrame, yields: np.ndarray, unseen: pd.DataFrame, levels: list[float]) -> Prediction:
    """The normal distribution of the training yields (n,) [%] for every row: s^2 (1 + 1 / n) is that of a new run."""
    mean = np.full(len(unseen), yields.mean())
    spread = np.full(len(unseen), yields.std(ddof=1) * np.sqrt(1 + 1 / len(yields)))
    half = spread[:, None] * normal_quantile(0.5 + np.array(levels) / 2)
    ends = np.clip(np.stack([mean[:, None] - half, mean[:, None] + half], axis=2), 0, 100)
    return Prediction(mean, {ERRORS: ends}, NormalYields(ERRORS, mean, spread))


def procedure_of(
    name: str, strategy: str, training: TrainingConfig, budget: HeldOutConfig, averaging: AveragingConfig
) -> Procedure:
    """The training procedure of a model. It makes every choice from the training rows only.

    name: a regressor, which is tuned and fitted, AVERAGED, whose members are fitted and weighted, or CLIMATOLOGY.
    Raises ValueError for an unknown one.
    """
    training = smaller_forests(training, budget.largest_forest)

    def tuned(rows: pd.DataFrame, yields: np.ndarray, unseen: pd.DataFrame, levels: list[float]) -> Prediction:
        model, _ = Trainer(training, budget).train(name, strategy, rows, yields)
        predicted = model.predict(unseen)
        fit, folds = refit(model, training), budget.conformal_folds
        centres, residuals = cross_validate(fit, rows, yields, unseen, folds, training.seed)
        intervals = {CV_PLUS: cross_intervals(centres, residuals, levels)} | own_intervals(model, unseen, levels)
        if model.distribution:
            return Prediction(
                predicted, intervals, NormalYields(model.distribution, predicted, model.deviation(unseen))
            )
        spread = np.full(len(unseen), np.sqrt(np.mean(residuals**2)))
        return Prediction(predicted, intervals, NormalYields(ERRORS, predicted, spread))

    def averaged(rows: pd.DataFrame, yields: np.ndarray, unseen: pd.DataFrame, levels: list[float]) -> Prediction:
        model = fit_averaged(rows, yields, averaging)
        mixture = MixtureYields.of(model.members, model.weights, unseen, averaging.margin)
        return Prediction(model.predict(unseen), own_intervals(model, unseen, levels), mixture)

    if name == AVERAGED:
        return averaged
    if name == CLIMATOLOGY:
        return climatology
    regressor(name)
    return tuned
