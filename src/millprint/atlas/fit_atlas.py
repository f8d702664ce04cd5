"""The fit of the atlas, and its comparison with what a clever person would use on mills that none has seen.

Each row has its own noise, known from its turns; what else scatters is one further variance, and rows far off count
less. Lengths and variances are those of the largest marginal likelihood. Widths come from residuals of rows that are
left out, with the lengths kept.

Baselines: the scaling law from the included mill of the kind (its fingerprint, with amplitude, speed, balls and fill
ratio of the new mill); the nearest simulated neighbour in the groups; a linear model in the logarithms of the groups.
Others that learn: gradient boosting and small networks (scikit-learn). Each predicts the logarithms of `SHOWN` over
their scales. Training mills are compared by cross-validation; held-out mills are asked once, at the end.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
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
    FORMAT,
    HITS,
    MARKS,
    PREDICTED,
    KindModel,
    Surface,
    Width,
    combined,
    inputs_of,
    logistic,
)
from millprint.atlas.design import FAILED, HELD_OUT, SKIPPED
from millprint.atlas.kind_groups import Kind, within_limits
from millprint.config.included import SOURCES, load_mill
from millprint.estimate.gaussian_process import Conditioned, Covariance, Kernel, Likelihood
from millprint.estimate.quantiles import normal_quantile
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import find_fingerprint
from millprint.observables.condition import Condition
from millprint.observables.definitions import PREDICTED as PREDICTED_BY_CURVES

# Strengths of the ridges of power laws of numbers and of widths, in rows; level of the intervals [-].
RIDGE, SHRINK, LEVEL = 0.3, 10.0, 0.90
# Noise of the logarithm of a row: least, most, and where turns do not tell it [-].
LEAST_NOISE, MOST_NOISE, OTHER_NOISE = 0.003, 1.0, 0.02
# The relative standard error of each of FITTED, as far as turns tell it.
NOISE_OF = {
    "power": "wall_power_relative_se",
    "normal_energy": "weighted_normal_energy_relative_se",
    "normal_frequency": "weighted_normal_frequency_relative_se",
    "tangential_energy": "weighted_tangential_energy_relative_se",
    "tangential_frequency": "weighted_tangential_frequency_relative_se",
}
# Of the process, as a share of what power laws leave: start and bounds of its variance, of its lengths in ranges of the
# groups, and of the further noise.
VARIANCE, LENGTH, NOISE = (1.0, 1e-3, 1e2), (1.5, 0.15, 40.0), (0.1, 1e-5, 2.0)
# Steps of the search for them, at first and in each round of weights; more of them change no error.
ITERATIONS, FURTHER_ITERATIONS = 25, 12
# Rows that the search takes, the first, which fill the ranges as all do: its time grows with their cube. With half as
# many, the mean errors of other rows were larger for every number that was tried.
SEARCHED = 800
# Rounds of weights, degrees of freedom of Student's distribution, a normal standard deviation over the median error.
ROUNDS, FREEDOM, NORMAL_OF_MEDIAN = 4, 2.0, 1.4826
# Parts of the rows that are left out in turn.
TENTHS = 10
# Noise that the power law allows for, in addition to that of each row.
LAW_NOISE = 0.05
# Rows of these words have no hits, nor those whose E*n is under this share of m (2 pi f A)^2: of 50 planetary mills,
# hardly one lies between e^-5 and e^-7.
NO_HITS, LEAST_ENERGY = ("no impacts", "moves with the wall"), 1 / 400
# Labels of rows with and without hits, and their noise: the logistic function of 3 is 0.95.
LABEL, LABEL_NOISE = 3.0, 0.5


@dataclass(frozen=True)
class Rows:
    """Rows of the table of the atlas as a fit takes them.

    inputs (n, p); hits (n,): whether balls hit anything; fitted, noise: logarithms of FITTED over their scales, and the
    noise of each (n,), NaN where there is none; table: the rows themselves; within (n,): whether the limits of the kind
    allow it. Rows beyond train, and are not judged.
    """

    inputs: np.ndarray
    hits: np.ndarray
    fitted: Mapping[str, np.ndarray]
    noise: Mapping[str, np.ndarray]
    table: pd.DataFrame
    within: np.ndarray

    def __len__(self) -> int:
        """The number of rows."""
        return len(self.inputs)

    def some(self, chosen: np.ndarray) -> "Rows":
        """Those rows."""
        fitted, noise = ({name: own[chosen] for name, own in each.items()} for each in (self.fitted, self.noise))
        table, within = self.table.iloc[chosen].reset_index(drop=True), self.within[chosen]
        return Rows(self.inputs[chosen], self.hits[chosen], fitted, noise, table, within)

    def asked(self) -> "Rows":
        """Those that the atlas may be asked for."""
        return self.some(np.flatnonzero(self.within))


def simulated(table: pd.DataFrame, kind: Kind, part: str) -> pd.DataFrame:
    """The rows of a kind that were simulated to their end: the held-out ones, or for `training` all others."""
    own = table[(table["kind"] == kind.name) & ((table["part"] == HELD_OUT) == (part == HELD_OUT))]
    return own[~own["motion"].fillna("").str.startswith((FAILED, SKIPPED))].reset_index(drop=True)


def scaled(table: pd.DataFrame, kind: Kind) -> pd.DataFrame:
    """Logarithms of PREDICTED over their scales, a row each."""
    scales = [kind.scales(kind.condition_of(row)) for row in table.to_dict("records")]
    with np.errstate(divide="ignore", invalid="ignore"):
        columns = {name: np.log(table[name] / [own[scale] for own in scales]) for name, scale in PREDICTED.items()}
    return pd.DataFrame(columns).replace([np.inf, -np.inf], np.nan)


def rows_of(table: pd.DataFrame, kind: Kind, part: str) -> Rows:
    """The rows of a part of a kind for a fit."""
    own = simulated(table, kind, part)
    logs = scaled(own, kind)
    words = own["motion"].fillna("")
    hits = ~np.any([words.str.contains(word) for word in NO_HITS], axis=0)
    hits &= (logs["weighted_normal_energy_J"] > math.log(LEAST_ENERGY)).to_numpy()
    channels = ("normal", "tangential")
    fitted = {
        "power": logs["wall_power_W"],
        **{f"{name}_energy": logs[f"weighted_{name}_energy_J"] for name in channels},
        **{f"{name}_frequency": logs[f"weighted_{name}_frequency_hz"] for name in channels},
        "rolling_ratio": logs["rolling_power_W"] - logs["tangential_power_W"],
        "strong_frequency": logs["strong_frequency_hz"],
    }
    noise = dict.fromkeys(FITTED, np.full(len(own), OTHER_NOISE))
    noise |= {name: own[column].fillna(MOST_NOISE).clip(LEAST_NOISE, MOST_NOISE) for name, column in NOISE_OF.items()}
    return Rows(
        inputs_of(kind, own),
        hits,
        {name: np.asarray(value) for name, value in fitted.items()},
        {name: np.asarray(value) for name, value in noise.items()},
        own,
        within_limits(kind, own),
    )


@dataclass(frozen=True)
class Fit:
    """A power law and a process of what it leaves, for values (n,) with known variances (n,).

    linear (p + 1,); spread: that of what the law leaves, in which the process is scaled; theta: its parameters;
    deviations (n,): of each value from that of the others (Rasmussen and Williams 2006, Eq. 5.12).
    """

    linear: np.ndarray
    spread: float
    theta: np.ndarray
    process: Conditioned
    deviations: np.ndarray

    @classmethod
    def of(
        cls, inputs: np.ndarray, values: np.ndarray, known: np.ndarray, theta: np.ndarray | None, steps: int
    ) -> "Fit":
        """From inputs (n, p); theta: where the search for the largest likelihood starts, which ends after `steps`."""
        width = inputs.shape[1]
        design = np.column_stack([np.ones(len(inputs)), inputs])
        weight = 1 / (known + LAW_NOISE**2)
        penalty = np.diag([0.0, *[RIDGE * weight.mean()] * width])
        linear = np.linalg.solve(design.T @ (design * weight[:, None]) + penalty, design.T @ (weight * values))
        left = values - design @ linear
        spread = float(np.std(left)) or 1.0
        kernel = Kernel(("Matern 5/2",), np.zeros(1, dtype=int), np.arange(1, 1 + width)[None])
        start, *bounds = np.log([VARIANCE, *[LENGTH] * width, NOISE]).T
        theta = start if theta is None else theta
        if steps:
            likelihood = Likelihood(kernel, inputs, left / spread, known / spread**2)
            theta, _ = likelihood.maximise([theta], np.transpose(bounds), steps)
        noise = known / spread**2 + math.exp(theta[-1])
        process = Conditioned.fit(Covariance(kernel, theta), inputs, left / spread, noise)
        return cls(linear, spread, theta, process, left - spread * process.left_out(left / spread)[0])

    def at(self, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The values (m,) at inputs (m, p), and their standard deviations, with the noise that all rows share."""
        mean, deviation = self.process.with_deviation(inputs)
        value = self.linear[0] + inputs @ self.linear[1:] + self.spread * mean
        return value, self.spread * np.sqrt(deviation**2 + math.exp(self.theta[-1]))


def fit_robust(
    inputs: np.ndarray, values: np.ndarray, noise: np.ndarray, theta: np.ndarray | None = None
) -> tuple[Fit, np.ndarray]:
    """The fit of values (n,) with noise (n,), and the variances (n,) that it took: few values far off do not bend it.

    Deviations of rows that are left out count as of Student's distribution of FREEDOM degrees: each round takes the
    variance of a row as s^2 (1 / w - 1) larger, with w = (nu + 1) / (nu + e^2 / s^2) and s their spread, by the median
    (Lange, Little, Taylor, J. Am. Stat. Assoc. 84 (1989) 881). theta: parameters that are kept, if they are known; they
    are searched with SEARCHED rows.
    """
    if theta is None and len(values) > SEARCHED:
        theta = fit_robust(inputs[:SEARCHED], values[:SEARCHED], noise[:SEARCHED])[0].theta
    searched = theta is None
    fit = Fit.of(inputs, values, known := noise**2, theta, ITERATIONS if searched else 0)
    for _ in range(ROUNDS):
        spread = NORMAL_OF_MEDIAN * np.median(np.abs(fit.deviations))
        weights = (FREEDOM + 1) / (FREEDOM + (fit.deviations / max(spread, LEAST_NOISE)) ** 2)
        known = noise**2 + spread**2 * (1 / np.minimum(weights, 1.0) - 1)
        fit = Fit.of(inputs, values, known, fit.theta, FURTHER_ITERATIONS if searched else 0)
    return fit, known


def fit_surface(
    inputs: np.ndarray, values: np.ndarray, noise: np.ndarray, rows: np.ndarray
) -> tuple[Surface, np.ndarray]:
    """The surface of values (n,) at inputs (n, p) with noise (n,), and theta.

    rows (n,): their numbers among all simulations of the kind.
    """
    fit, known = fit_robust(inputs, values, noise)
    amplitude, *lengths, further = np.exp(fit.theta)
    own = fit.spread**2
    weights = fit.spread * amplitude * fit.process.weights
    surface = Surface(fit.linear, np.array(lengths), weights, rows, known + own * further, own * amplitude)
    return surface, fit.theta


def without_own(
    inputs: np.ndarray, values: np.ndarray, noise: np.ndarray, theta: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Value and standard deviation (n,) at each row of a fit without its tenth of the rows, with known theta.

    Not the closed form for a row that is left out, since the weights of its neighbours know it.
    """
    tenth, found = np.arange(len(values)) % TENTHS, np.empty((2, len(values)))
    for number in range(TENTHS):
        others, own = tenth != number, tenth == number
        found[:, own] = fit_robust(inputs[others], values[others], noise[others], theta)[0].at(inputs[own])
    return found[0], found[1]


def growth(values: np.ndarray, noise: np.ndarray, told: np.ndarray, deviation: np.ndarray) -> float:
    """`Surface.factor`, from values (n,) with their noise, and what a process without them told with its deviation."""
    off = np.abs(values - told) / np.hypot(deviation, noise)
    return max(1.0, float(np.quantile(off, LEVEL)) / normal_quantile(0.5 + LEVEL / 2))


def fit_width(inputs: np.ndarray, residuals: np.ndarray) -> Width:
    """The width that holds LEVEL of the residuals (n,): a power law of their size, and the quantile short of it; their
    median by the same law.

    The quantile is of residuals over a size that was fitted without their tenth of the rows (split conformal intervals:
    Lei, G'Sell, Rinaldo, Tibshirani, Wasserman, J. Am. Stat. Assoc. 113 (2018) 1094).
    """
    known = np.isfinite(residuals)
    size = np.log(np.abs(residuals[known]) + 1e-3)
    design = np.column_stack([np.ones(known.sum()), inputs[known]])

    def power_law(rows: np.ndarray) -> np.ndarray:
        part = design[rows]
        return np.linalg.solve(part.T @ part + np.diag([0.0, *[SHRINK] * inputs.shape[1]]), part.T @ size[rows])

    tenth = np.arange(len(size)) % TENTHS
    laws = [power_law(tenth != number) for number in range(TENTHS)]
    fitted = np.exp([own @ laws[number] for own, number in zip(design, tenth, strict=True)])
    over = np.abs(residuals[known]) / fitted
    place = min(1.0, math.ceil((len(over) + 1) * LEVEL) / len(over))
    return Width(power_law(tenth >= 0), float(np.quantile(over, place)), float(np.median(over)))


def _of_number(rows: Rows, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Inputs, values and noise of one of FITTED, and the rows that have it: the power of all rows, the rest of those
    in which balls hit something."""
    own = np.flatnonzero(np.isfinite(rows.fitted[name]) & (rows.hits | (name == "power")))
    inputs = np.column_stack([rows.inputs, rows.hits]) if name == "power" else rows.inputs
    return inputs[own], rows.fitted[name][own], rows.noise[name][own], own


def fit_kind(kind: Kind, rows: Rows) -> KindModel:
    """The model of a kind."""
    surfaces, without = {}, {}
    for name in FITTED:
        inputs, values, noise, own = _of_number(rows, name)
        surface, theta = fit_surface(inputs, values, noise, own)
        told, deviation = without_own(inputs, values, noise, theta)
        surfaces[name] = replace(surface, factor=growth(values, noise, told, deviation))
        without[name] = np.full(len(rows), np.nan)
        without[name][own] = told
    residuals = scaled(rows.table, kind) - pd.DataFrame(combined(without), index=rows.table.index)
    widths = {
        name: fit_width(
            rows.inputs, np.where(rows.within & (rows.hits | (name == "wall_power_W")), residuals[name], np.nan)
        )
        for name in PREDICTED
    }
    return KindModel(kind, np.column_stack([rows.inputs, rows.hits]), surfaces, widths, fit_hits(rows))


def fit_hits(rows: Rows) -> Surface:
    """The surface whose logistic function is the probability that balls hit something: of labels, smoothed."""
    labels = np.where(rows.hits, LABEL, -LABEL)
    everything = np.arange(len(rows))
    if rows.hits.all() or not rows.hits.any():
        zero = np.zeros(rows.inputs.shape[1])
        return Surface(np.array([labels[0], *zero]), zero + 1.0, np.zeros(1), everything[:1], np.ones(1), 0.0)
    return fit_surface(rows.inputs, labels, np.full(len(rows), LABEL_NOISE), everything)[0]


def fit_atlas(rows: Mapping[Kind, Rows]) -> dict:
    """The content of the file of the atlas: its models of some kinds, and what they were made from."""
    models = {kind.name: fit_kind(kind, own).plain() | {"about": _about(own)} for kind, own in rows.items()}
    return {"format": FORMAT, "kinds": models}


def _about(rows: Rows) -> dict:
    table = rows.table
    return {
        "simulations": len(table),
        "without_hits": int((~rows.hits).sum()),
        "version": str(table["version"].iloc[0]),
        "processor_s": round(float(table["processor_s"].sum())),
    }


# The numbers of MARKS as they are fitted.
MARKED = FITTED[:5]
FOLDS, SEED, SHARES = 5, 0, (0.25, 0.5, 1.0)
NETWORKS = 3
# Half of normal errors are smaller than this times their standard deviation.
QUARTILE = 0.6745
# Logarithms of `SHOWN` over their scales by name, each (m,), of the rows of a test, from the rows of a training.
Answer = dict[str, np.ndarray]
Model = Callable[[Kind, Rows, Rows], Answer]


def atlas(kind: Kind, training: Rows, test: Rows) -> Answer:
    """The model that ships: power laws and Gaussian processes."""
    surfaces = {name: fit_surface(*_of_number(training, name))[0] for name in MARKED}
    centres = np.column_stack([training.inputs, training.hits])
    hits = logistic(fit_hits(training).at(test.inputs, centres)) > HITS
    inputs = np.column_stack([test.inputs, hits])
    return {name: surfaces[own].at(inputs, centres) for name, own in zip(MARKS, MARKED, strict=True)}


def scaling_law(kind: Kind, training: Rows, test: Rows) -> Answer:
    """The fingerprint of the included mill of the kind, by its scales."""
    fingerprint = Fingerprint.read(find_fingerprint(kind.name, sources=SOURCES))
    built = kind.recognised(load_mill(kind.name))
    conditions = [kind.condition_of(row) for row in test.table.to_dict("records")]
    travel_of = kind.travel_m or kind.stroke_m
    travel = (
        np.array([travel_of(row) for row in conditions]) / travel_of(built or {}) * fingerprint.about["amplitude_m"]
    )
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
