"""A yield model: one step or two, each with its features, its scaling and its estimator (thesis Sec. 5.2.5)."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from sklearn.gaussian_process import GaussianProcessRegressor

from millprint.config.yields import Choices
from millprint.predict.algorithms import SCALED, make_estimator, quiet_fit
from millprint.predict.features import FEATURES, TIME, engineer


@dataclass(frozen=True)
class Plan:
    """What a step is before it is fitted: its algorithm and its features."""

    algorithm: str
    features: tuple[str, ...]


def plan_steps(algorithm: str, strategy: str, choices: Choices) -> list[Plan]:
    """The steps of a model.

    primary: one step on all ten features, for `linear` on choices.linear_features. two_step: first a model on the
    time alone, then one on the nine other features, for what the first leaves.
    """
    if algorithm == "linear":
        return [Plan("linear", tuple(choices.linear_features))]
    if strategy == "primary":
        return [Plan(algorithm, FEATURES)]
    first = algorithm if choices.time_model == "same" else "linear"
    return [Plan(first, (TIME,)), Plan(algorithm, tuple(name for name in FEATURES if name != TIME))]


@dataclass(frozen=True)
class Scaling:
    """x_scaled = (x - mean) / deviation, Eq. 5.2, with the population deviation; each of shape (k,)."""

    mean: np.ndarray
    deviation: np.ndarray

    @classmethod
    def of(cls, inputs: np.ndarray, scaled: bool) -> "Scaling":
        """That of the training inputs (n, k), or none at all; a feature that does not vary is only centred."""
        columns = inputs.shape[1]
        if not scaled:
            return cls(np.zeros(columns), np.ones(columns))
        deviation = inputs.std(axis=0)
        return cls(inputs.mean(axis=0), np.where(deviation > 0, deviation, 1.0))

    def __call__(self, inputs: np.ndarray) -> np.ndarray:
        """Inputs (n, k) as the regressor takes them."""
        return (inputs - self.mean) / self.deviation


@dataclass(frozen=True)
class Step:
    """A fitted step."""

    plan: Plan
    parameters: dict[str, float]
    scaling: Scaling
    estimator: Any

    def inputs(self, features: pd.DataFrame) -> np.ndarray:
        """What the estimator sees of engineered features, (n, k)."""
        return self.scaling(features[list(self.plan.features)].to_numpy(float))

    def predict(self, features: pd.DataFrame) -> np.ndarray:
        """The step's own share of the prediction, (n,) [pp]."""
        return np.asarray(self.estimator.predict(self.inputs(features)), dtype=float)


@dataclass(frozen=True)
class Found:
    """The best set of hyper-parameters, its cross-validated weighted MSE [pp2], and how many sets were tried."""

    parameters: dict[str, float]
    loss: float
    evaluations: int


def scale(plan: Plan, features: pd.DataFrame) -> tuple[Scaling, np.ndarray]:
    """The scaling of a step on its training rows, and the inputs (n, k) that its estimator sees."""
    raw = features[list(plan.features)].to_numpy(float)
    scaling = Scaling.of(raw, plan.algorithm in SCALED)
    return scaling, scaling(raw)


def fit_step(
    plan: Plan,
    parameters: dict[str, float],
    features: pd.DataFrame,
    target: np.ndarray,
    choices: Choices,
    seed: int,
    threads: int = 1,
) -> Step:
    """Fit one step on the engineered features of the training rows and its target (n,) [pp]."""
    scaling, inputs = scale(plan, features)
    estimator = make_estimator(plan.algorithm, parameters, inputs.shape[1], choices, seed, threads)
    return Step(plan, parameters, scaling, quiet_fit(estimator, inputs, target))


@dataclass(frozen=True)
class YieldModel:
    """A fitted model: the sum of its steps."""

    algorithm: str
    strategy: str
    steps: list[Step]

    def predict(self, rows: pd.DataFrame) -> np.ndarray:
        """Predicted yields (n,) [%] for rows with the six conditions; they are not clipped to 0 to 100."""
        features = engineer(rows)
        return np.sum([step.predict(features) for step in self.steps], axis=0)

    def deviation(self, rows: pd.DataFrame) -> np.ndarray | None:
        """Standard deviation of a predicted measurement (n,) [pp], Eq. 5.9 with noise; None but for GPR.

        For two steps it is that of the second: the first one's errors are what the second is a distribution of.
        """
        last = self.steps[-1]
        if not isinstance(last.estimator, GaussianProcessRegressor):
            return None
        return last.estimator.predict(last.inputs(engineer(rows)), return_std=True)[1]


def fit_model(
    algorithm: str,
    strategy: str,
    parameters: list[dict[str, float]],
    rows: pd.DataFrame,
    yields: np.ndarray,
    choices: Choices,
    seed: int,
    threads: int = 1,
) -> YieldModel:
    """Fit a model with known hyper-parameters, a set for each step: each step on what those before it leave."""
    features, target, steps = engineer(rows), np.asarray(yields, dtype=float), []
    for plan, chosen in zip(plan_steps(algorithm, strategy, choices), parameters, strict=True):
        steps.append(fit_step(plan, chosen, features, target, choices, seed, threads))
        target = target - steps[-1].predict(features)
    return YieldModel(algorithm, strategy, steps)
