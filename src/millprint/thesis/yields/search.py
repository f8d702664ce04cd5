"""Training: the hyper-parameters of each step by hyperopt's TPE over repeated k-fold (Sec. 5.2.6), then its fit."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from sklearn.model_selection import RepeatedKFold

from millprint.config.search_spaces import SearchSpace
from millprint.config.yields import SearchConfig, TrainingConfig
from millprint.thesis.yields.metrics import YieldWeights, weighted_mse
from millprint.thesis.yields.regressors import Parameters, regressor
from millprint.thesis.yields.yield_model import Plan, Step, YieldModel, fit_in_turn, fit_step, plan_steps


@dataclass(frozen=True)
class SearchResult:
    """The best set of hyper-parameters, its cross-validated weighted MSE [pp2], and the number of sets evaluated."""

    parameters: Parameters
    loss: float
    evaluations: int


# The result for a regressor without hyper-parameters.
NOT_SEARCHED = SearchResult({}, float("nan"), 0)


def _hyperopt_space(space: SearchSpace) -> dict[str, Any]:
    """A search space in the form that hyperopt needs."""
    from hyperopt import hp
    from hyperopt.pyll import scope

    draw = {
        "uniform": hp.uniform,
        "logarithmic": lambda name, low, high: hp.loguniform(name, np.log(low), np.log(high)),
        "whole": lambda name, low, high: scope.int(hp.quniform(name, low, high, 1)),
    }
    return {name: draw[how](name, *getattr(space, name)) for name, how in space.draws().items()}


@dataclass(frozen=True)
class Trainer:
    """How models are trained: settings, budget of the search, threads, and a function called after each evaluation."""

    training: TrainingConfig
    budget: SearchConfig
    threads: int = 1
    tick: Callable[[], None] = lambda: None

    def evaluations(self, name: str, strategy: str) -> int:
        """Number of sets of hyper-parameters that `train` evaluates. Raises ValueError for an unknown model."""
        plans = plan_steps(name, strategy, self.training.choices)
        return sum(
            getattr(self.budget.evaluations, plan.regressor) for plan in plans if regressor(plan.regressor).space
        )

    def train(
        self, name: str, strategy: str, rows: pd.DataFrame, yields: np.ndarray
    ) -> tuple[YieldModel, list[SearchResult]]:
        """Tune and fit a model on the given rows, and on nothing else.

        rows: the six conditions of n runs; yields: (n,) [%]. The second of two steps is tuned and fitted on the
        residuals of the first (Sec. 5.2.5). Returns the model and the result of the search for each step. Raises
        ValueError for an unknown regressor or strategy.
        """
        weigh, results = YieldWeights.of(self.training), []

        def fit(plan: Plan, features: pd.DataFrame, target: np.ndarray) -> Step:
            best = NOT_SEARCHED
            if regressor(plan.regressor).space:
                _, inputs = plan.standardise(features)
                weights = weigh({"yield": yields, "residual": target}[self.training.choices.residual_weights])
                best = self.search(plan.regressor, inputs, target, weights)
            results.append(best)
            return fit_step(plan, best.parameters, features, target, self.training, self.threads)

        plans = plan_steps(name, strategy, self.training.choices)
        return YieldModel(name, strategy, fit_in_turn(rows, yields, plans, fit)), results

    def search(self, name: str, inputs: np.ndarray, target: np.ndarray, weights: np.ndarray) -> SearchResult:
        """The hyper-parameters of a regressor with the smallest weighted MSE (Eq. 5.3), averaged over repeated k-fold.

        inputs: (n, k) features, standardised if the regressor needs it; target [pp], weights [-]: (n,).
        """
        # Imported here, as in _hyperopt_space: the import takes half a second, and reading a model needs no search.
        from hyperopt import Trials, fmin, space_eval, tpe

        record, seed = regressor(name), self.training.seed
        repeated = RepeatedKFold(n_splits=self.budget.folds, n_repeats=self.budget.repeats, random_state=seed)
        folds = list(repeated.split(inputs))

        def fit_and_predict(fold: int, parameters: Parameters) -> np.ndarray:
            kept, held = folds[fold]
            estimator = record.make(parameters, inputs.shape[1], self.training, self.threads)
            return estimator.fit(inputs[kept], target[kept]).predict(inputs[held])

        quicker = record.fold_predictor and record.fold_predictor(inputs, target, folds, self.training)
        predict = quicker or fit_and_predict

        def loss(parameters: Parameters) -> float:
            errors = [
                weighted_mse(target[held], predict(fold, parameters), weights[held])
                for fold, (_, held) in enumerate(folds)
            ]
            self.tick()
            return float(np.mean(errors))

        trials, space = Trials(), _hyperopt_space(getattr(self.training.spaces, name))
        best = fmin(
            loss,
            space,
            algo=tpe.suggest,
            max_evals=getattr(self.budget.evaluations, name),
            trials=trials,
            rstate=np.random.default_rng(seed),
            show_progressbar=False,
            verbose=False,
        )
        return SearchResult(space_eval(space, best), min(trials.losses()), len(trials.trials))
