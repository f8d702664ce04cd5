"""Training: the search and the fit of each step in turn, on training rows alone."""

from collections.abc import Callable

import numpy as np
import pandas as pd

from millprint.config.yields import SearchConfig, TrainingConfig
from millprint.predict.features import engineer
from millprint.predict.metrics import YieldWeights
from millprint.predict.model import Found, YieldModel, fit_step, plan_steps, scale
from millprint.predict.search import search


def evaluations_of(algorithm: str, strategy: str, settings: TrainingConfig, budget: SearchConfig) -> int:
    """How many sets of hyper-parameters `train` tries, for a progress bar."""
    plans = plan_steps(algorithm, strategy, settings.choices)
    return sum(getattr(budget.evaluations, plan.algorithm) for plan in plans if plan.algorithm != "linear")


def train(
    algorithm: str,
    strategy: str,
    rows: pd.DataFrame,
    yields: np.ndarray,
    settings: TrainingConfig,
    budget: SearchConfig,
    threads: int = 1,
    tick: Callable[[], None] = lambda: None,
) -> tuple[YieldModel, list[Found]]:
    """Tune and fit a model on the given rows, and on nothing else.

    rows: the six conditions; yields: (n,) [%]. A two-step model's second step is tuned and fitted on the residuals
    of its first (Sec. 5.2.5). Returns the model and what the search found for each step.
    """
    features, target = engineer(rows), np.asarray(yields, dtype=float)
    weigh = YieldWeights(settings.high_yield_percent, settings.high_yield_weight)
    weights = weigh(target)
    steps, found = [], []
    for plan in plan_steps(algorithm, strategy, settings.choices):
        if plan.algorithm == "linear":
            best = Found({}, float("nan"), 0)
        else:
            _, inputs = scale(plan, features)
            best = search(plan.algorithm, inputs, target, weights, settings, budget, threads, tick)
        steps.append(fit_step(plan, best.parameters, features, target, settings.choices, settings.seed, threads))
        found.append(best)
        target = target - steps[-1].predict(features)
        if settings.choices.residual_weights == "residual":
            weights = weigh(target)
    return YieldModel(algorithm, strategy, steps), found
