"""A yield model of one step or two (Sec. 5.2.5), and the search of its hyper-parameters by TPE (Sec. 5.2.6)."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeVar

import numpy as np
import pandas as pd
from sklearn import config_context
from sklearn.model_selection import RepeatedKFold

from millprint.config.yields import PRIMARY, Drawn, SearchConfig, TrainingConfig
from millprint.estimate.quantiles import normal_quantile
from millprint.thesis.yields.features import FEATURES, TIME, Standardisation, YieldWeights, engineer, weighted_mse
from millprint.thesis.yields.regressors import Parameters, regressor, training_of

T = TypeVar("T")
# The rows are finite, and the configuration has checked the parameters. Checks take longer than fits of twenty rows.
checked = config_context(assume_finite=True, skip_parameter_validation=True)


@dataclass(frozen=True)
class Plan:
    """A step before it is fitted: its regressor and its features."""

    regressor: str
    features: tuple[str, ...]

    def standardise(self, features: pd.DataFrame) -> tuple[Standardisation, np.ndarray]:
        """The standardisation on the training rows, and the inputs (n, k) that the estimator sees."""
        raw = features[list(self.features)].to_numpy(float)
        standard = Standardisation.of(raw) if regressor(self.regressor).scaled else Standardisation.none(raw.shape[1])
        return standard, standard(raw)


def plan_steps(name: str, strategy: str) -> list[Plan]:
    """The steps of a model.

    primary: one step, on all ten features unless the regressor's record names others. two_step: a model on only
    the time, then another of the same regressor on the nine other features for the residuals of the first. Raises
    ValueError for an unknown regressor, and for a strategy that the regressor does not have.
    """
    record = regressor(name)
    if strategy not in training_of(name).strategies:
        raise ValueError(f"{name}: strategy = {strategy!r}: it has {', '.join(training_of(name).strategies)}")
    if strategy == PRIMARY:
        return [Plan(name, record.primary_features or FEATURES)]
    return [Plan(name, (TIME,)), Plan(name, tuple(feature for feature in FEATURES if feature != TIME))]


@dataclass(frozen=True)
class Step:
    """A fitted step."""

    plan: Plan
    parameters: Parameters
    standard: Standardisation
    estimator: Any

    def inputs(self, features: pd.DataFrame) -> np.ndarray:
        """The inputs (n, k) of the estimator from engineered features (n, 10)."""
        return self.standard(features[list(self.plan.features)].to_numpy(float))

    def predict(self, features: pd.DataFrame) -> np.ndarray:
        """What this step adds to the prediction, (n,) [pp]."""
        return np.asarray(self.estimator.predict(self.inputs(features)), dtype=float)


def fit_step(
    plan: Plan,
    parameters: Parameters,
    features: pd.DataFrame,
    target: np.ndarray,
    training: TrainingConfig,
    threads: int,
) -> Step:
    """Fit one step on the engineered features (n, 10) of the training rows and its target (n,) [pp]."""
    standard, inputs = plan.standardise(features)
    estimator = regressor(plan.regressor).make(parameters, inputs.shape[1], training, threads)
    return Step(plan, parameters, standard, estimator.fit(inputs, target))


def fit_in_turn(
    rows: pd.DataFrame, yields: np.ndarray, parts: Iterable[T], fit: Callable[[T, pd.DataFrame, np.ndarray], Step]
) -> list[Step]:
    """One step for each part, fitted on the residuals of the steps before it; the first on the yields (n,) [%].

    rows: the six conditions of n runs; fit(part, features, target): fits a step on engineered features (n, 10) and its
    target.
    """
    features, target, steps = engineer(rows), np.asarray(yields, dtype=float), []
    for part in parts:
        steps.append(fit(part, features, target))
        target = target - steps[-1].predict(features)
    return steps


@dataclass(frozen=True)
class YieldModel:
    """A fitted model: the sum of its steps. `name` is that of its regressor."""

    name: str
    strategy: str
    steps: list[Step]

    @property
    def distribution(self) -> str | None:
        """What its own predictive intervals are made from; None for a model that predicts no distribution."""
        return "gaussian" if regressor(self.steps[-1].plan.regressor).deviation else None

    def predict(self, rows: pd.DataFrame) -> np.ndarray:
        """Predicted yields (n,) [%] for rows with the six conditions; they are not clipped to 0 to 100."""
        features = engineer(rows)
        return np.sum([step.predict(features) for step in self.steps], axis=0)

    def deviation(self, rows: pd.DataFrame) -> np.ndarray:
        """Standard deviation of a predicted measurement (n,) [pp]; NaN for a model that predicts no distribution.

        For two steps the variances add up: that of the first step's mean, and that of the second step, which predicts
        the residuals of the first and holds the noise. This takes the errors of both steps as independent. The second
        step partly makes up for an error of the first, so the sum is rather too wide.
        """
        features, last = engineer(rows), self.steps[-1]
        deviation = regressor(last.plan.regressor).deviation
        if deviation is None:
            return np.full(len(rows), np.nan)
        variance = deviation(last.estimator, last.inputs(features)) ** 2
        for step in self.steps[:-1]:
            of_mean = regressor(step.plan.regressor).mean_deviation
            variance = variance + (of_mean(step.estimator, step.inputs(features)) ** 2 if of_mean else np.nan)
        return np.sqrt(variance)

    def intervals(self, rows: pd.DataFrame, levels: Sequence[float]) -> np.ndarray:
        """Ends (n, levels, 2) [%] of the central normal intervals; NaN without a distribution, not clipped."""
        predicted = self.predict(rows)[:, None]
        half = normal_quantile(0.5 + np.asarray(levels) / 2) * self.deviation(rows)[:, None]
        return np.stack([predicted - half, predicted + half], axis=2)


@checked
def fit_model(
    name: str,
    strategy: str,
    parameters: list[Parameters],
    rows: pd.DataFrame,
    yields: np.ndarray,
    training: TrainingConfig,
) -> YieldModel:
    """Fit a model whose hyper-parameters are known: each step on the residuals of those before it.

    name, strategy: as in the registry of regressors; parameters: a set for each step, by the names of the search
    space; rows: the six conditions of n runs; yields: (n,) [%]. Raises ValueError for an unknown regressor or strategy,
    and if there are not as many sets as steps.
    """

    def fit(part: tuple[Plan, Parameters], features: pd.DataFrame, target: np.ndarray) -> Step:
        plan, known = part
        return fit_step(plan, known, features, target, training, threads=1)

    parts = zip(plan_steps(name, strategy), parameters, strict=True)
    return YieldModel(name, strategy, fit_in_turn(rows, yields, parts, fit))


@dataclass(frozen=True)
class SearchResult:
    """The best set of hyper-parameters, its cross-validated weighted MSE [pp2], and the number of sets evaluated."""

    parameters: Parameters
    loss: float
    evaluations: int


# The result for a regressor without hyper-parameters.
NOT_SEARCHED = SearchResult({}, float("nan"), 0)


def _hyperopt_space(space: Mapping[str, Drawn], bounds: dict[str, list]) -> dict[str, Any]:
    """Hyper-parameters between their bounds, in the form that hyperopt needs."""
    from hyperopt import hp
    from hyperopt.pyll import scope

    draw = {
        "uniform": hp.uniform,
        "logarithmic": lambda name, low, high: hp.loguniform(name, np.log(low), np.log(high)),
        "whole": lambda name, low, high: scope.int(hp.quniform(name, low, high, 1)),
    }
    return {name: draw[drawn.how](name, *bounds[name]) for name, drawn in space.items()}


def minimise(
    loss: Callable[[Parameters], float], name: str, bounds: dict[str, list], evaluations: int, seed: int
) -> SearchResult:
    """The hyper-parameters of a regressor between their bounds with the smallest loss [pp2] by hyperopt's TPE."""
    # Imported here, as in _hyperopt_space: the import takes half a second, and reading a model needs no search.
    from hyperopt import Trials, fmin, space_eval, tpe

    trials, space = Trials(), _hyperopt_space(training_of(name).space, bounds)
    best = fmin(
        loss,
        space,
        algo=tpe.suggest,
        max_evals=evaluations,
        trials=trials,
        rstate=np.random.default_rng(seed),
        show_progressbar=False,
        verbose=False,
    )
    return SearchResult(space_eval(space, best), min(trials.losses()), len(trials.trials))


# So many sets TPE draws at random, whatever their losses, before it models them.
DRAWN_AT_RANDOM = 20


@lru_cache
def draw(name: str, bounds: str, evaluations: int, seed: int) -> list[Parameters]:
    """The sets of hyper-parameters that `minimise` evaluates, at most DRAWN_AT_RANDOM; bounds: as JSON."""
    drawn: list[Parameters] = []

    def keep(parameters: Parameters) -> float:
        drawn.append(parameters)
        return 0.0

    minimise(keep, name, json.loads(bounds), evaluations, seed)
    return drawn


@dataclass(frozen=True)
class Trainer:
    """How models are trained: settings, budget of the search, threads, and a function called after each evaluation."""

    training: TrainingConfig
    budget: SearchConfig
    threads: int = 1
    tick: Callable[[], None] = lambda: None

    def evaluations(self, name: str, strategy: str) -> int:
        """Number of sets of hyper-parameters that `train` evaluates. Raises ValueError for an unknown model."""
        plans = plan_steps(name, strategy)
        return sum(self.budget.evaluations[plan.regressor] for plan in plans if training_of(plan.regressor).space)

    @checked
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
            if training_of(plan.regressor).space:
                _, inputs = plan.standardise(features)
                best = self.search(plan.regressor, inputs, target, weigh(yields))
            results.append(best)
            return fit_step(plan, best.parameters, features, target, self.training, self.threads)

        plans = plan_steps(name, strategy)
        return YieldModel(name, strategy, fit_in_turn(rows, yields, plans, fit)), results

    def search(self, name: str, inputs: np.ndarray, target: np.ndarray, weights: np.ndarray) -> SearchResult:
        """The hyper-parameters of a regressor with the smallest weighted MSE (Eq. 5.3), averaged over repeated k-fold.

        inputs: (n, k) features, standardised if the regressor needs it; target [pp], weights [-]: (n,).
        """
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

        bounds, evaluations = self.training.spaces[name], self.budget.evaluations[name]
        if evaluations > DRAWN_AT_RANDOM:
            return minimise(loss, name, bounds, evaluations, seed)
        drawn = draw(name, json.dumps(bounds), evaluations, seed)
        losses = [loss(parameters) for parameters in drawn]
        best = int(np.nanargmin(losses))
        return SearchResult(drawn[best], losses[best], evaluations)
