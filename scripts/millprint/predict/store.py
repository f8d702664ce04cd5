"""Yield models as JSON: what was learned where that is small, the recipe and the training rows where it is not."""

from importlib.metadata import version

import numpy as np
import pandas as pd
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.linear_model import LinearRegression

from millprint.config.yields import Choices
from millprint.doe.runs import YIELD
from millprint.errors import ConfigError
from millprint.files import read_json, write_json
from millprint.predict.algorithms import make_estimator
from millprint.predict.features import CONDITIONS, engineer
from millprint.predict.model import Found, Plan, Step, YieldModel, scale

FORMAT = "millprint yield model 1"
LIBRARIES = ("numpy", "scipy", "scikit-learn", "xgboost-cpu")
AGREEMENT_PP = 1e-6


def _learned(step: Step) -> dict:
    """What the search and the fit have found; a forest and an SVR are quickly and exactly fitted again."""
    estimator = step.estimator
    if isinstance(estimator, LinearRegression):
        return {"coefficients": estimator.coef_.tolist(), "intercept": float(estimator.intercept_)}
    if isinstance(estimator, GaussianProcessRegressor):
        return {"log_kernel_parameters": estimator.kernel_.theta.tolist()}
    if step.plan.algorithm == "xgb":
        return {"booster": estimator.get_booster().save_raw("json").decode()}
    return {}


def save_model(
    model: YieldModel, found: list[Found], rows: pd.DataFrame, choices: Choices, seed: int, path: str
) -> None:
    """Write a model with what the search found, its training rows and its predictions for them.

    rows: case, the six conditions and yield_percent.
    """
    content = {
        "format": FORMAT,
        "algorithm": model.algorithm,
        "strategy": model.strategy,
        "seed": seed,
        "choices": choices.model_dump(mode="json"),
        "versions": {name: version(name) for name in LIBRARIES},
        "rows": rows[[*CONDITIONS, YIELD]].astype(float).to_dict("list"),
        "cases": rows["case"].astype(str).tolist(),
        "predicted_percent": model.predict(rows).tolist(),
        "steps": [
            {
                "algorithm": step.plan.algorithm,
                "features": list(step.plan.features),
                "mean": step.scaling.mean.tolist(),
                "deviation": step.scaling.deviation.tolist(),
                "parameters": step.parameters,
                "search": {"loss_pp2": best.loss, "evaluations": best.evaluations} if best.evaluations else None,
                "learned": _learned(step),
            }
            for step, best in zip(model.steps, found, strict=True)
        ],
    }
    write_json(content, path)


def _restore(step: dict, features: pd.DataFrame, target: np.ndarray, choices: Choices, seed: int) -> Step:
    plan = Plan(step["algorithm"], tuple(step["features"]))
    scaling, inputs = scale(plan, features)
    estimator = make_estimator(plan.algorithm, step["parameters"], inputs.shape[1], choices, seed)
    learned = step["learned"]
    if plan.algorithm == "linear":
        estimator.coef_, estimator.intercept_ = np.array(learned["coefficients"]), learned["intercept"]
    elif plan.algorithm == "gpr":
        kernel = estimator.kernel.clone_with_theta(np.array(learned["log_kernel_parameters"]))
        estimator = GaussianProcessRegressor(kernel, optimizer=None).fit(inputs, target)
    elif plan.algorithm == "xgb":
        estimator.load_model(bytearray(learned["booster"], "utf-8"))
    else:
        estimator.fit(inputs, target)
    return Step(plan, step["parameters"], scaling, estimator)


def read_stored(path: str, wanted: str | None = None) -> dict:
    """The content of a model's file; raises ConfigError, in one line, if it is missing, no model, or not `wanted`."""
    try:
        content = read_json(path)
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such model") from None
    except ValueError as error:
        raise ConfigError(f"{path}: not a stored model ({str(error).splitlines()[0]})") from None
    given = content.get("format") if isinstance(content, dict) else None
    if not str(given).startswith("millprint ") or (wanted and given != wanted):
        raise ConfigError(f"{path}: format = {given!r}: {wanted or 'a yield model of millprint'!r} is wanted")
    return content


def stored_search(path: str) -> list[dict | None]:
    """For each step of a stored model the search's loss_pp2 and evaluations; None for a step that is not tuned."""
    return [step["search"] for step in read_json(path)["steps"]]


def check_agreement(path: str, content: dict, predicted: np.ndarray) -> None:
    """Raise ConfigError unless a model read back predicts what it did when it was written, `predicted` (rows,) [%]."""
    worst = float(np.max(np.abs(predicted - np.array(content["predicted_percent"]))))
    if not worst <= AGREEMENT_PP:
        then = ", ".join(f"{name} {number}" for name, number in content["versions"].items())
        raise ConfigError(
            f"{path}: predictions for the training rows are off by {worst:.2g} points: the file was changed, or it was "
            f"written by libraries that compute otherwise ({then})"
        )


def load_model(path: str) -> YieldModel:
    """Read a model written by save_model and check that it predicts its training rows as it did then.

    Raises ConfigError, in one line, for another kind of file and for predictions that differ.
    """
    content = read_stored(path, FORMAT)
    rows, choices = pd.DataFrame(content["rows"]), Choices(**content["choices"])
    features, target, steps = engineer(rows), rows[YIELD].to_numpy(float), []
    for step in content["steps"]:
        steps.append(_restore(step, features, target, choices, content["seed"]))
        target = target - steps[-1].predict(features)
    model = YieldModel(content["algorithm"], content["strategy"], steps)
    check_agreement(path, content, model.predict(rows))
    return model
