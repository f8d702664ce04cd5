"""The search of hyper-parameters: hyperopt's TPE over repeated k-fold cross-validation (thesis Sec. 5.2.6)."""

from collections.abc import Callable
from typing import Any

import numpy as np
from sklearn.model_selection import RepeatedKFold

from millprint.config.yields import SearchConfig, Spaces, TrainingConfig
from millprint.predict.algorithms import make_estimator, quiet_fit
from millprint.predict.forest import ForestFold
from millprint.predict.metrics import weighted_mse
from millprint.predict.model import Found

# How each hyper-parameter is drawn: Tables 5.2 to 5.5.
DRAWS = {
    "gpr": {"constant": "uniform", "length_scale": "uniform", "noise": "uniform"},
    "rf": {"n_estimators": "whole", "max_depth": "whole", "min_samples_split": "whole", "min_samples_leaf": "whole"},
    "svr": {"C": "logarithmic", "epsilon": "uniform", "gamma": "logarithmic"},
    "xgb": {
        "max_depth": "whole",
        "learning_rate": "logarithmic",
        "n_estimators": "whole",
        "subsample": "uniform",
        "colsample_bytree": "uniform",
        "gamma": "uniform",
    },
}

Predictor = Callable[[int, dict[str, Any]], np.ndarray]


def search_space(algorithm: str, spaces: Spaces) -> dict[str, Any]:
    """The search space of an algorithm for hyperopt."""
    from hyperopt import hp

    space = {}
    for name, draw in DRAWS[algorithm].items():
        low, high = getattr(getattr(spaces, algorithm), name)
        if draw == "whole":
            space[name] = hp.quniform(name, low, high, 1)
        elif draw == "logarithmic":
            space[name] = hp.loguniform(name, np.log(low), np.log(high))
        else:
            space[name] = hp.uniform(name, low, high)
    return space


def _plain(algorithm: str, drawn: dict[str, float]) -> dict[str, float]:
    """Drawn values as Python's own numbers, whole ones as int."""
    draws = DRAWS[algorithm]
    return {name: int(drawn[name]) if draws[name] == "whole" else float(drawn[name]) for name in draws}


def _predictor(
    algorithm: str, inputs: np.ndarray, target: np.ndarray, folds: list, settings: TrainingConfig, threads: int
) -> Predictor:
    """A function of (fold number, hyper-parameters) that predicts the rows which the fold holds out."""
    if algorithm == "rf":
        most = settings.spaces.rf.n_estimators[1]
        share = float(settings.choices.max_features)
        forests = [
            ForestFold(inputs[kept], target[kept], inputs[held], share, settings.seed, most) for kept, held in folds
        ]
        return lambda fold, parameters: forests[fold].predict(**parameters)

    def predict(fold: int, parameters: dict[str, float]) -> np.ndarray:
        kept, held = folds[fold]
        columns = inputs.shape[1]
        estimator = make_estimator(algorithm, parameters, columns, settings.choices, settings.seed, threads)
        return quiet_fit(estimator, inputs[kept], target[kept]).predict(inputs[held])

    return predict


def search(
    algorithm: str,
    inputs: np.ndarray,
    target: np.ndarray,
    weights: np.ndarray,
    settings: TrainingConfig,
    budget: SearchConfig,
    threads: int = 1,
    tick: Callable[[], None] = lambda: None,
) -> Found:
    """Find the hyper-parameters of the smallest weighted MSE (Eq. 5.3), averaged over repeated k-fold.

    inputs: (n, k) features as the algorithm sees them; target, weights: (n,); tick: called after each evaluation.
    """
    # Imported here, as in search_space: it takes half a second, and who only reads models or predicts searches nothing.
    from hyperopt import fmin, tpe

    repeated = RepeatedKFold(n_splits=budget.folds, n_repeats=budget.repeats, random_state=settings.seed)
    folds = list(repeated.split(inputs))
    predict = _predictor(algorithm, inputs, target, folds, settings, threads)
    losses: list[float] = []
    tried: list[dict[str, float]] = []

    def objective(drawn: dict[str, float]) -> float:
        parameters = _plain(algorithm, drawn)
        scores = [
            weighted_mse(target[held], predict(fold, parameters), weights[held]) for fold, (_, held) in enumerate(folds)
        ]
        losses.append(float(np.mean(scores)))
        tried.append(parameters)
        tick()
        return losses[-1]

    evaluations = getattr(budget.evaluations, algorithm)
    fmin(
        objective,
        search_space(algorithm, settings.spaces),
        algo=tpe.suggest,
        max_evals=evaluations,
        rstate=np.random.default_rng(settings.seed),
        show_progressbar=False,
        verbose=False,
    )
    best = int(np.argmin(losses))
    return Found(tried[best], losses[best], evaluations)
