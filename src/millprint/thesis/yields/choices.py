"""Choices that the thesis leaves open, and how each affects the metrics on the locked split."""

from collections.abc import Callable
from dataclasses import dataclass, field

import pandas as pd

from millprint.config.yields import Choices, TrainingConfig
from millprint.thesis.doe.runs import YIELD
from millprint.thesis.yields.features import CONDITIONS, FEATURES
from millprint.thesis.yields.metrics import YieldWeights, metrics
from millprint.thesis.yields.regressors import RESIDUAL_WEIGHTS, SEARCH_SEED, TWO_STEP, otherwise, regressor
from millprint.thesis.yields.yield_model import YieldModel, fit_model

TAKEN = "as taken"


@dataclass(frozen=True)
class Alternative:
    """Another value of one choice, or another seed of the trees."""

    value: str
    changes: dict = field(default_factory=dict)
    seed_shift: int = 0


def _other_length_scales(choices: Choices) -> list[Alternative]:
    other = {"per_feature": "shared", "shared": "per_feature"}[choices.length_scales]
    return [Alternative(other, {"length_scales": other})]


def _other_time_model(choices: Choices) -> list[Alternative]:
    return [Alternative("linear", {"time_model": "linear"})] if choices.time_model == "same" else []


# The alternatives to each choice that do not need another search.
ALTERNATIVES: dict[str, Callable[[Choices], list[Alternative]]] = {
    "linear_features": lambda choices: [
        Alternative("the six conditions", {"linear_features": list(CONDITIONS)}),
        Alternative("all ten features", {"linear_features": list(FEATURES)}),
    ],
    "length_scales": _other_length_scales,
    "kernel_bounds": lambda choices: [
        Alternative(f"{low:g} to {high:g}", {"kernel_bounds": [low, high]}) for low, high in ((1e-3, 1e3), (1e-2, 1e6))
    ],
    "max_features": lambda choices: [Alternative("1/3", {"max_features": 1 / 3})],
    "seed": lambda choices: [Alternative(f"seed + {shift}", seed_shift=shift) for shift in (1, 2, 3)],
    "time_model": _other_time_model,
}


def _row(
    model: YieldModel, choice: str, value: str, test: pd.DataFrame, outside: pd.DataFrame, training: TrainingConfig
) -> dict:
    """Metrics on the test rows, and the predicted yield of each run outside the domain [%]."""
    beyond = zip(outside["case"], model.predict(outside), strict=True)
    return {
        "model": model.name,
        "strategy": model.strategy,
        "choice": choice,
        "value": value,
        **metrics(test[YIELD].to_numpy(float), model.predict(test), YieldWeights.of(training)),
        **{f"case_{case}_percent": float(predicted) for case, predicted in beyond},
    }


def compare_choices(
    model: YieldModel, train: pd.DataFrame, test: pd.DataFrame, outside: pd.DataFrame, training: TrainingConfig
) -> pd.DataFrame:
    """Metrics on the test rows for the model itself and for each alternative, with the same hyper-parameters.

    train, test, outside: case, the six conditions and yield_percent. Columns: model, strategy, choice, value, rmse
    [pp], mae [pp], mape [%], r2 [-], wmse [pp2], and case_CASE_percent for each row of `outside`.
    """
    rows = [_row(model, TAKEN, "", test, outside, training)]
    applicable = [*regressor(model.name).choices, *(["time_model"] if model.strategy == TWO_STEP else [])]
    fit = (model.name, model.strategy, [step.parameters for step in model.steps], train, train[YIELD].to_numpy(float))
    for choice in applicable:
        for other in ALTERNATIVES[choice](training.choices):
            choices = Choices(**{**training.choices.model_dump(), **other.changes})
            changed = training.model_copy(update={"choices": choices, "seed": training.seed + other.seed_shift})
            rows.append(_row(fit_model(*fit, changed), choice, other.value, test, outside, training))
    return pd.DataFrame(rows)


def describe_search(
    model: YieldModel, test: pd.DataFrame, outside: pd.DataFrame, choice: str, training: TrainingConfig
) -> pd.DataFrame:
    """The row of compare_choices for a model that was searched again with `otherwise(training, choice)`.

    Raises ValueError for a choice that a search does not depend on.
    """
    changed = otherwise(training, choice)
    value = {
        SEARCH_SEED: f"seed {changed.seed} for folds, search and fit",
        RESIDUAL_WEIGHTS: f"{changed.choices.residual_weights}, searched anew",
    }[choice]
    return pd.DataFrame([_row(model, choice, value, test, outside, training)])
