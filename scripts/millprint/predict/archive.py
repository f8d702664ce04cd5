"""Averaged Gaussian processes as JSON: recipe, learned numbers, training rows and versions; nothing is pickled."""

from importlib.metadata import version

import numpy as np
import pandas as pd

from millprint.config.averaging import INPUTS
from millprint.doe.runs import YIELD
from millprint.errors import ConfigError
from millprint.files import write_json
from millprint.predict.averaging import AveragedModel, Candidate, Member
from millprint.predict.features import CONDITIONS
from millprint.predict.inputs import InputScaling, describe
from millprint.predict.links import LINKS, to_conversion
from millprint.predict.model import YieldModel
from millprint.predict.store import check_agreement, load_model, read_stored
from millprint.predict.structured import Process, terms_of

FORMAT = "millprint averaged yield model 1"
LIBRARIES = ("numpy", "scipy")


def save_averaged(model: AveragedModel, rows: pd.DataFrame, margin: float, path: str) -> None:
    """Write a model with its training rows (case, the six conditions, yield_percent) and its predictions for them."""
    members = [
        {
            "link": member.candidate.link,
            "scales": list(member.candidate.scales),
            "structure": member.candidate.structure,
            "weight": float(weight),
            "log_evidence": float(member.log_evidence),
            "log_parameters": member.process.logs.tolist(),
            "input_mean": member.scaling.mean.tolist(),
            "input_spread": member.scaling.spread.tolist(),
            "target_mean": member.mean,
            "target_spread": member.spread,
        }
        for member, weight in zip(model.members, model.weights, strict=True)
    ]
    content = {
        "format": FORMAT,
        "algorithm": model.algorithm,
        "strategy": model.strategy,
        "inputs": list(INPUTS),
        "margin": margin,
        "members": members,
        "versions": {name: version(name) for name in LIBRARIES},
        "rows": rows[[*CONDITIONS, YIELD]].astype(float).to_dict("list"),
        "cases": rows["case"].astype(str).tolist(),
        "predicted_percent": model.predict(rows).tolist(),
    }
    write_json(content, path)


def _restore(stored: dict, rows: pd.DataFrame, margin: float) -> Member:
    candidate = Candidate(stored["link"], tuple(stored["scales"]), stored["structure"])
    logarithmic = np.array([scale == "log" for scale in candidate.scales])
    scaling = InputScaling(logarithmic, np.array(stored["input_mean"]), np.array(stored["input_spread"]))
    seen = LINKS[candidate.link].forward(to_conversion(rows[YIELD].to_numpy(), margin))
    mean, spread = stored["target_mean"], stored["target_spread"]
    inputs = scaling(describe(rows).to_numpy())
    process = Process(terms_of(candidate.structure), np.array(stored["log_parameters"]), inputs, (seen - mean) / spread)
    return Member(candidate, scaling, mean, spread, process, stored["log_evidence"])


def load_averaged(path: str) -> AveragedModel:
    """Read a model written by save_averaged and check that it predicts its training rows as it did then.

    Raises ConfigError, in one line, for another kind of file and for predictions that differ.
    """
    content = read_stored(path, FORMAT)
    if content["inputs"] != list(INPUTS):
        raise ConfigError(f"{path}: inputs = {', '.join(content['inputs'])}: {', '.join(INPUTS)} are wanted")
    rows = pd.DataFrame(content["rows"])
    members = [_restore(stored, rows, content["margin"]) for stored in content["members"]]
    model = AveragedModel(members, np.array([stored["weight"] for stored in content["members"]]))
    check_agreement(path, content, model.predict(rows))
    return model


def load_any(path: str) -> YieldModel | AveragedModel:
    """Read a stored yield model of either kind; raises ConfigError as load_model and load_averaged do."""
    return load_averaged(path) if read_stored(path).get("format") == FORMAT else load_model(path)


def training_rows(path: str) -> pd.DataFrame:
    """The rows that a stored model was trained on: case, the six conditions, yield_percent."""
    content = read_stored(path)
    return pd.DataFrame(content["rows"]).assign(case=content["cases"])


def describe_members(model: AveragedModel) -> pd.DataFrame:
    """A row a member, heaviest first: link, a column of scales an input, structure, weight, log_evidence, kernel."""
    table = []
    for member, weight in zip(model.members, model.weights, strict=True):
        count = len(INPUTS)
        lengths = np.exp(member.process.logs[:count])
        table.append(
            {
                "link": member.candidate.link,
                **{f"{name}_scale": scale for name, scale in zip(INPUTS, member.candidate.scales, strict=True)},
                "structure": member.candidate.structure,
                "weight": weight,
                "log_evidence": member.log_evidence,
                **{f"{name}_length_scale": length for name, length in zip(INPUTS, lengths, strict=True)},
                "noise_variance": member.process.noise,
            }
        )
    return pd.DataFrame(table).sort_values("weight", ascending=False, kind="stable", ignore_index=True)
