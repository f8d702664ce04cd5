"""What the thesis leaves open, and what each choice does to the metrics on the locked split."""

from dataclasses import dataclass

import pandas as pd

from millprint.config.yields import Choices, TrainingConfig
from millprint.doe.runs import YIELD
from millprint.predict.catalogue import otherwise
from millprint.predict.features import CONDITIONS, FEATURES
from millprint.predict.metrics import YieldWeights, metrics
from millprint.predict.model import YieldModel, fit_model

TAKEN = "as taken"
OTHER_BOUNDS = ((1e-3, 1e3), (1e-2, 1e6))


@dataclass(frozen=True)
class Alternative:
    """Another value of one choice, or another seed of the trees."""

    choice: str
    value: str
    changes: dict
    seed_shift: int = 0


def alternatives(algorithm: str, strategy: str, choices: Choices) -> list[Alternative]:
    """The alternatives that bear on a model and need no new search."""
    found = []
    if algorithm == "linear":
        for title, features in (("the six conditions", CONDITIONS), ("all ten features", FEATURES)):
            found.append(Alternative("linear_features", title, {"linear_features": list(features)}))
    if algorithm == "gpr":
        other = "shared" if choices.length_scales == "per_feature" else "per_feature"
        found.append(Alternative("length_scales", other, {"length_scales": other}))
        found += [
            Alternative("kernel_bounds", f"{low:g} to {high:g}", {"kernel_bounds": [low, high]})
            for low, high in OTHER_BOUNDS
        ]
    if algorithm == "rf":
        found.append(Alternative("max_features", "1/3", {"max_features": 1 / 3}))
    if algorithm in ("rf", "xgb"):
        found += [Alternative("seed", f"seed + {shift}", {}, shift) for shift in (1, 2, 3)]
    if strategy == "two_step" and choices.time_model == "same":
        found.append(Alternative("time_model", "linear", {"time_model": "linear"}))
    return found


def _judged(model: YieldModel, test: pd.DataFrame, outside: pd.DataFrame, weigh: YieldWeights) -> dict:
    """Metrics on the test rows, and what the model says of each run outside the domain [%]."""
    beyond = zip(outside["case"], model.predict(outside), strict=True)
    return metrics(test[YIELD].to_numpy(float), model.predict(test), weigh) | {
        f"case_{case}_percent": float(predicted) for case, predicted in beyond
    }


def compare_choices(
    model: YieldModel,
    train: pd.DataFrame,
    test: pd.DataFrame,
    outside: pd.DataFrame,
    choices: Choices,
    seed: int,
    weigh: YieldWeights,
) -> pd.DataFrame:
    """Metrics on the test rows for the model as taken and for each alternative, with the hyper-parameters as found.

    Columns: model, strategy, choice, value, rmse [pp], mae [pp], mape [%], r2 [-], wmse [pp2], and
    case_CASE_percent for each row of `outside`.
    """
    parameters = [step.parameters for step in model.steps]
    about = {"model": model.algorithm, "strategy": model.strategy}
    rows = [{**about, "choice": TAKEN, "value": "", **_judged(model, test, outside, weigh)}]
    for other in alternatives(model.algorithm, model.strategy, choices):
        changed = Choices(**{**choices.model_dump(), **other.changes})
        refitted = fit_model(
            model.algorithm,
            model.strategy,
            parameters,
            train,
            train[YIELD].to_numpy(float),
            changed,
            seed + other.seed_shift,
        )
        values = _judged(refitted, test, outside, weigh)
        rows.append({**about, "choice": other.choice, "value": other.value, **values})
    return pd.DataFrame(rows)


def describe_search(
    model: YieldModel,
    test: pd.DataFrame,
    outside: pd.DataFrame,
    choice: str,
    settings: TrainingConfig,
    weigh: YieldWeights,
) -> pd.DataFrame:
    """The row of compare_choices for a model that was searched anew with `otherwise(settings, choice)`."""
    changed = otherwise(settings, choice)
    value = f"{changed.choices.residual_weights}, searched anew"
    if choice == "search_seed":
        value = f"seed {changed.seed} for folds, search and fit"
    about = {"model": model.algorithm, "strategy": model.strategy, "choice": choice, "value": value}
    return pd.DataFrame([{**about, **_judged(model, test, outside, weigh)}])
