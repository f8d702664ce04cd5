"""The atlas next to what a clever person would use, on mills that none of them has seen.

Baselines: the scaling law from the included mill of the kind (its fingerprint, with amplitude, speed, balls and fill
ratio of the new mill); the nearest simulated neighbour in the groups; a linear model in the logarithms of the groups.
Others that learn: gradient boosting and small networks (scikit-learn). Each predicts the logarithms of `MARKS` over
their scales. Training mills are compared by cross-validation; held-out mills are asked once, at the end.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pandas as pd
from sklearn.ensemble import HistGradientBoostingRegressor
from sklearn.linear_model import Ridge
from sklearn.model_selection import KFold
from sklearn.neighbors import KNeighborsRegressor
from sklearn.neural_network import MLPRegressor

from millprint.atlas.atlas_model import (
    FITTED,
    HITS,
    MARKS,
    PREDICTED,
    KindModel,
    combined,
    logistic,
)
from millprint.atlas.fit_atlas import Rows, fit_hits, fit_surface, of_number, scaled
from millprint.atlas.kind_groups import Kind
from millprint.config.included import load_mill
from millprint.config.load import MILL_FOLDER, shipped
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import FOLDER
from millprint.observables.condition import Condition
from millprint.observables.definitions import PREDICTED as PREDICTED_BY_CURVES

# The numbers of MARKS as they are fitted.
MARKED = FITTED[:5]
FOLDS, SEED, SHARES = 5, 0, (0.25, 0.5, 1.0)
NETWORKS = 3
# Half of normal errors are smaller than this times their standard deviation.
QUARTILE = 0.6745
# Logarithms of `MARKS` over their scales by name, each (m,), of the rows of a test, from the rows of a training.
Answer = dict[str, np.ndarray]
Model = Callable[[Kind, Rows, Rows], Answer]


def atlas(kind: Kind, training: Rows, test: Rows) -> Answer:
    """The model that ships: power laws and Gaussian processes."""
    surfaces = {name: fit_surface(*of_number(training, name))[0] for name in MARKED}
    centres = np.column_stack([training.inputs, training.hits])
    hits = logistic(fit_hits(training).at(test.inputs, centres)) > HITS
    inputs = np.column_stack([test.inputs, hits])
    return {name: surfaces[own].at(inputs, centres) for name, own in zip(MARKS, MARKED, strict=True)}


def of_radius(condition: Mapping[str, float], radius_mm: float) -> dict[str, float]:
    """The condition with the same groups, but for softness, in a jar of this radius [mm]."""
    size = radius_mm / condition["radius_mm"]
    lengths = {name: size * value for name, value in condition.items() if name.endswith("_mm")}
    return {**condition, **lengths, "speed_hz": condition["speed_hz"] / math.sqrt(size)}


def scaling_law(kind: Kind, training: Rows, test: Rows) -> Answer:
    """The fingerprint of the included mill of the kind, by its scales, whatever the working folder has of that name.

    In a jar of its own radius, since its measured exponents of speed and diameter keep no groups.
    """
    fingerprint = Fingerprint.read(str(shipped(f"{FOLDER}/{kind.name}.json")))
    built = kind.recognised(load_mill(str(shipped(f"{MILL_FOLDER}/{kind.name}.yaml")))) or {}
    conditions = [of_radius(kind.condition_of(row), built["radius_mm"]) for row in test.table.to_dict("records")]
    travel_of = kind.travel_m or kind.stroke_m
    travel = np.array([travel_of(row) for row in conditions]) / travel_of(built) * fingerprint.about["amplitude_m"]
    low, high = fingerprint.fill_range
    asked = Condition(
        fill_ratio=np.clip([row["fill"] for row in test.table.to_dict("records")], low, high),
        speed_hz=np.array([row["speed_hz"] for row in conditions]),
        ball_diameter_m=np.array([row["ball_diameter_mm"] / 1e3 for row in conditions]),
        density_kg_m3=np.array([row["density_kg_m3"] for row in conditions]),
        amplitude_m=travel,
    )
    found = fingerprint.descriptors(asked)
    balls = np.array([row["number"] for row in conditions])
    scales = [kind.scales(row) for row in conditions]
    # A power is of all balls, and its curve of one.
    power = fingerprint.scaled(asked)["Pw"].to_numpy() * PREDICTED_BY_CURVES["wall_power_W"].scale_of(asked, balls)
    values = {"wall_power_W": power} | {name: found[name] for name in MARKS if name != "wall_power_W"}
    return {name: np.log(value / [own[PREDICTED[name]] for own in scales]) for name, value in values.items()}


def nearest(kind: Kind, training: Rows, test: Rows) -> Answer:
    """The numbers over their scales of the simulated condition nearest in the groups."""
    return _of_rows(kind, training, test, KNeighborsRegressor(1).fit)


def linear(kind: Kind, training: Rows, test: Rows) -> Answer:
    """A linear model in the logarithms of the groups, without what the kind derives from them."""
    width = len(kind.groups)
    return _of_rows(kind, training, test, Ridge(1e-3).fit, width)


def boosting(kind: Kind, training: Rows, test: Rows) -> Answer:
    """Gradient boosting of trees on what the linear model leaves."""
    return _of_rows(kind, training, test, lambda inputs, values: _OnLinear(
        HistGradientBoostingRegressor(max_iter=200, learning_rate=0.06, max_leaf_nodes=8, min_samples_leaf=8,
                                      l2_regularization=1.0, random_state=SEED), inputs, values))  # fmt: skip


def networks(kind: Kind, training: Rows, test: Rows) -> Answer:
    """The mean of a few networks of two layers of 24 on what the linear model leaves."""
    return _of_rows(kind, training, test, lambda inputs, values: _OnLinear(
        [MLPRegressor(hidden_layer_sizes=(24, 24), activation="tanh", solver="lbfgs", alpha=1.0, max_iter=250,
                      random_state=seed) for seed in range(NETWORKS)], inputs, values))  # fmt: skip


class _OnLinear:
    def __init__(self, further: Any, inputs: np.ndarray, values: np.ndarray) -> None:
        self.linear = Ridge(1e-3).fit(inputs, values)
        left = values - self.linear.predict(inputs)
        self.spread = float(np.std(left)) or 1.0
        self.further = [
            each.fit(inputs, left / self.spread) for each in (further if isinstance(further, list) else [further])
        ]

    def predict(self, inputs: np.ndarray) -> np.ndarray:
        return self.linear.predict(inputs) + self.spread * np.mean(
            [each.predict(inputs) for each in self.further], axis=0
        )


def _of_rows(kind: Kind, training: Rows, test: Rows, fit: Callable, width: int | None = None) -> Answer:
    """What a regressor of each number answers; numbers but the power are learned where balls hit."""
    values = scaled(training.table, kind)
    answers = {}
    for name in MARKS:
        own = values[name].to_numpy()
        chosen = np.isfinite(own) & (training.hits | (name == "wall_power_W"))
        answers[name] = fit(training.inputs[chosen, :width], own[chosen]).predict(test.inputs[:, :width])
    return answers


MODELS: dict[str, Model] = {
    "scaling law": scaling_law,
    "nearest neighbour": nearest,
    "linear": linear,
    "boosting": boosting,
    "networks": networks,
    "atlas": atlas,
}


def errors(kind: Kind, test: Rows, answer: Answer) -> pd.DataFrame:
    """Relative errors [-] of an answer, a row each, a column for each of MARKS; NaN where nothing is hit."""
    actual = scaled(test.table, kind)
    return _where_hit({name: np.exp(answer[name] - actual[name].to_numpy()) - 1 for name in MARKS}, test)


def _where_hit(found: dict, test: Rows) -> pd.DataFrame:
    """Numbers of MARKS by name as a table, NaN but for the power where nothing is hit."""
    return pd.DataFrame(
        {name: np.where(test.hits | (name == "wall_power_W"), own, np.nan) for name, own in found.items()}
    )


def cross_validated(kind: Kind, rows: Rows, model: Model, share: float = 1.0) -> dict[str, Any]:
    """The median error of a model on rows that it has not seen, by cross-validation with a share of the rows of each
    fold, and how many these are."""
    parts, used = [], 0
    for own, test in KFold(FOLDS, shuffle=True, random_state=SEED).split(rows.inputs):
        fewer = own[: max(20, round(share * len(own)))]
        used += len(fewer)
        asked = rows.some(test).asked()
        parts.append(errors(kind, asked, model(kind, rows.some(fewer), asked)))
    return {"kind": kind.name, "rows": round(used / FOLDS), **pd.concat(parts).abs().median().to_dict()}


def compared(kind: Kind, rows: Rows) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The errors of each model by cross-validation, and of the atlas with `SHARES` of the rows."""
    learned = [cross_validated(kind, rows, atlas, share) for share in SHARES]
    others = {name: cross_validated(kind, rows, model) for name, model in MODELS.items() if model is not atlas}
    found = [{"kind": kind.name, "model": name} | own for name, own in {**others, "atlas": learned[-1]}.items()]
    return pd.DataFrame(found), pd.DataFrame(learned)


def inside(model: KindModel, test: Rows) -> pd.DataFrame:
    """Whether the 90 % interval holds each number of MARKS, a row each; NaN where there is nothing to hit.

    The interval is of one simulation, as the test's rows are.
    """
    actual, found = scaled(test.table, model.kind), model.logarithms(test.inputs)
    return _where_hit({name: abs(actual[name] - found[name][0]) <= found[name][1] for name in MARKS}, test)


def judged(model: KindModel, training: Rows, test: Rows) -> pd.DataFrame:
    """Each model on the held-out mills: median error of each number, the share that the atlas's intervals hold, and the
    scatter of one simulation, as the median of its relative standard error times the quartile of a normal error.

    Mills beyond the limits of the kind, which the atlas refuses, are left out, and counted."""
    kind, refused, test = model.kind, int((~test.within).sum()), test.asked()
    answers = {name: own(kind, training, test) for name, own in MODELS.items() if own is not atlas}
    answers["atlas"] = combined(model.fitted(test.inputs))
    found = [
        {"kind": kind.name, "model": name, "mills": len(test), **errors(kind, test, answer).abs().median().to_dict()}
        for name, answer in answers.items()
    ]
    about = {"kind": kind.name, "mills": len(test)}
    sure = pd.DataFrame({name: model.widths[name].typical(test.inputs) <= mark for name, mark in MARKS.items()})
    wrong = errors(kind, test, answers["atlas"]).abs()
    found.append(about | {"model": "atlas where it asks for no simulation", **wrong.where(sure).median().to_dict()})
    found.append(about | {"model": "share of such mills", **sure.where(wrong.notna()).mean().to_dict()})
    found.append({"kind": kind.name, "model": "refused", "mills": refused})
    found.append(about | {"model": "share held by the 90 % interval", **inside(model, test).mean().to_dict()})
    noise = {name: test.table.loc[test.hits, _error_column(name)].median() * QUARTILE for name in MARKS}
    found.append(about | {"model": "scatter of one simulation", **noise})
    found.append(about | {"model": "mark", **MARKS})
    right = (model.probability(test.inputs) > HITS) == test.hits
    found.append(about | {"model": "share of motions told right", "wall_power_W": right.mean()})
    return pd.DataFrame(found)


def _error_column(name: str) -> str:
    return f"{name.rpartition('_')[0]}_relative_se"


def regions(model: KindModel, test: Rows) -> pd.DataFrame:
    """Errors and intervals of the held-out mills by tenth of the fill ratio."""
    kind, test = model.kind, test.asked()
    wrong, held = errors(kind, test, combined(model.fitted(test.inputs))).abs(), inside(model, test)
    tenth = pd.qcut(test.table["fill"], 10, labels=False, duplicates="drop")
    found = []
    for number, own in test.table.reset_index(drop=True).groupby(tenth.to_numpy()):
        part = {"kind": kind.name, "tenth": int(number) + 1, "mills": len(own)}
        part |= {"fill_from": own["fill"].min(), "fill_to": own["fill"].max()}
        part |= {f"{name}_error": wrong.loc[own.index, name].median() for name in MARKS}
        found.append(part | {f"{name}_held": held.loc[own.index, name].mean() for name in MARKS})
    return pd.DataFrame(found)
