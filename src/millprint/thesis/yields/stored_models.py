"""Yield models as JSON files: what a fit has learned, or what is needed to repeat it exactly. Nothing is pickled."""

from collections.abc import Sequence
from importlib.metadata import distributions, version

import numpy as np
import pandas as pd

from millprint.config.errors import ConfigError
from millprint.config.yields import INPUTS, TrainingConfig
from millprint.run.files import read_format, write_json
from millprint.thesis.doe.factorial_designs import YIELD
from millprint.thesis.yields.averaging import (
    LINKS,
    AveragedModel,
    Candidate,
    Member,
    to_conversion,
)
from millprint.thesis.yields.estimators import Process, kernel_of
from millprint.thesis.yields.features import (
    CONDITIONS,
    Standardisation,
    describe,
)
from millprint.thesis.yields.regressors import regressor
from millprint.thesis.yields.yield_model import Plan, SearchResult, Step, YieldModel, fit_in_turn

FORMAT, AVERAGED_FORMAT = "millprint yield model 2", "millprint averaged yield model 1"
# Largest difference between the predictions of a stored model and those in its file [pp].
AGREEMENT_PP = 1e-6


def _about(model: YieldModel | AveragedModel, rows: pd.DataFrame, libraries: Sequence[str]) -> dict:
    """What every file contains: the model's name, its training rows, its predictions for them, and library versions."""
    return {
        "algorithm": model.name,
        "strategy": model.strategy,
        "versions": {name: version(name) for name in libraries if any(distributions(name=name))},
        "rows": rows[[*CONDITIONS, YIELD]].astype(float).to_dict("list"),
        "cases": rows["case"].astype(str).tolist(),
        "predicted_percent": model.predict(rows).tolist(),
    }


def save_model(
    model: YieldModel, results: list[SearchResult], rows: pd.DataFrame, training: TrainingConfig, path: str
) -> None:
    """Write a model with the results of its search, a result for each step.

    rows: the training rows, with case, the six conditions and yield_percent.
    """
    steps = [
        {
            "algorithm": step.plan.regressor,
            "features": list(step.plan.features),
            "mean": step.standard.mean.tolist(),
            "deviation": step.standard.deviation.tolist(),
            "parameters": step.parameters,
            "search": {"loss_pp2": best.loss, "evaluations": best.evaluations} if best.evaluations else None,
            "learned": regressor(step.plan.regressor).keep(step.estimator),
        }
        for step, best in zip(model.steps, results, strict=True)
    ]
    own = {"format": FORMAT, "seed": training.seed, "length_scales": training.length_scales, "steps": steps}
    write_json(_about(model, rows, ("numpy", "scipy", "scikit-learn", "xgboost", "xgboost-cpu")) | own, path)


def save_averaged(model: AveragedModel, rows: pd.DataFrame, margin: float, path: str) -> None:
    """Write an averaged process.

    rows: the training rows, with case, the six conditions and yield_percent; margin: the smallest distance of the
    conversions from 0 and 1 [-].
    """
    members = [
        fitted_content(member, weight)
        | {"structure": member.candidate.structure, "log_evidence": float(member.log_evidence)}
        for member, weight in zip(model.members, model.weights, strict=True)
    ]
    own = {"format": AVERAGED_FORMAT, "inputs": list(INPUTS), "margin": margin, "members": members}
    write_json(_about(model, rows, ("numpy", "scipy")) | own, path)


def fitted_content(member: Member, weight: float) -> dict:
    """What a member has learned, and its weight."""
    return {
        "weight": float(weight),
        "link": member.candidate.link,
        "scales": list(member.candidate.scales),
        "log_parameters": member.process.logs.tolist(),
        "input_mean": member.standard.mean.tolist(),
        "input_spread": member.standard.deviation.tolist(),
        "target_mean": float(member.mean),
        "target_spread": float(member.spread),
    }


def read_stored(path: str, expected: str | None = None) -> dict:
    """The content of a model's file.

    Raises ConfigError, in one line, if it is missing, holds no yield model, or has another format than `expected`.
    """
    return read_format(path, [expected] if expected else [FORMAT, AVERAGED_FORMAT], "stored model")


def training_rows(path: str) -> pd.DataFrame:
    """The rows that a stored model was trained on: case, the six conditions, yield_percent.

    Raises ConfigError as read_stored.
    """
    content = read_stored(path)
    return pd.DataFrame(content["rows"]).assign(case=content["cases"])


def _check_agreement(path: str, content: dict, predicted: np.ndarray) -> None:
    """Raise ConfigError unless a model predicts its training rows, `predicted` (n,) [%], as when it was written."""
    worst = float(np.max(np.abs(predicted - np.array(content["predicted_percent"]))))
    if not worst <= AGREEMENT_PP:
        versions = ", ".join(f"{name} {number}" for name, number in content["versions"].items())
        raise ConfigError(
            f"{path}: predictions for the training rows are off by {worst:.2g} points: the file was changed, or it was "
            f"written by libraries that compute differently ({versions})"
        )


def load_model(path: str) -> YieldModel:
    """Read a model written by save_model and check that it predicts its training rows as it did then.

    Raises ConfigError, in one line, for another kind of file and for predictions that differ, and ValueError for an
    unknown regressor.
    """
    content = read_stored(path, FORMAT)
    rows, training = (
        pd.DataFrame(content["rows"]),
        TrainingConfig(length_scales=content["length_scales"], seed=content["seed"]),
    )

    def restore(stored: dict, features: pd.DataFrame, target: np.ndarray) -> Step:
        plan, parameters = Plan(stored["algorithm"], tuple(stored["features"])), stored["parameters"]
        standard, inputs = plan.standardise(features)
        record = regressor(plan.regressor)
        estimator = record.make(parameters, inputs.shape[1], training, 1)
        return Step(plan, parameters, standard, record.restore(estimator, stored["learned"], inputs, target))

    steps = fit_in_turn(rows, rows[YIELD].to_numpy(float), content["steps"], restore)
    model = YieldModel(content["algorithm"], content["strategy"], steps)
    _check_agreement(path, content, model.predict(rows))
    return model


def _restore_member(stored: dict, rows: pd.DataFrame, margin: float) -> Member:
    candidate = Candidate(stored["link"], tuple(stored["scales"]), stored["structure"])
    input_mean, input_spread = np.array(stored["input_mean"]), np.array(stored["input_spread"])
    standard = Standardisation(input_mean, input_spread, candidate.logarithmic)
    latent = LINKS[candidate.link].forward(to_conversion(rows[YIELD].to_numpy(), margin))
    mean, spread = stored["target_mean"], stored["target_spread"]
    inputs = standard(describe(rows).to_numpy())
    process = Process(
        kernel_of(candidate.structure), np.array(stored["log_parameters"]), inputs, (latent - mean) / spread
    )
    return Member(candidate, standard, mean, spread, process, stored["log_evidence"])


def load_averaged(path: str) -> AveragedModel:
    """Read a model written by save_averaged and check that it predicts its training rows as it did then.

    Raises ConfigError, in one line, for another kind of file and for predictions that differ.
    """
    content = read_stored(path, AVERAGED_FORMAT)
    if content["inputs"] != list(INPUTS):
        raise ConfigError(f"{path}: inputs = {', '.join(content['inputs'])}: must be {', '.join(INPUTS)}")
    rows = pd.DataFrame(content["rows"])
    members = [_restore_member(stored, rows, content["margin"]) for stored in content["members"]]
    model = AveragedModel(members, np.array([stored["weight"] for stored in content["members"]]))
    _check_agreement(path, content, model.predict(rows))
    return model


def load_any(path: str) -> YieldModel | AveragedModel:
    """Read a stored yield model of either kind; raises ConfigError as load_model and load_averaged do."""
    return load_averaged(path) if read_stored(path)["format"] == AVERAGED_FORMAT else load_model(path)
