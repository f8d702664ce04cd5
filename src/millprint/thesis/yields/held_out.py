"""Held-out predictions: every outer fold repeats scaling, search and fit without the runs that are predicted.

Predictive distributions with their proper scores, and predictive intervals, also from cross-validated errors (CV+).

The scores are those of Gneiting and Raftery, J. Am. Stat. Assoc. 102 (2007) 359: a forecaster does best by saying what
he believes. Smaller is better in both.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pandas as pd
from sklearn.model_selection import KFold, RepeatedKFold, ShuffleSplit

from millprint.config.yields import AveragingConfig, HeldOutConfig, TrainingConfig
from millprint.estimate.quantiles import normal_below, normal_density, normal_log_density, normal_quantile
from millprint.thesis.doe.factorial_designs import YIELD
from millprint.thesis.yields.averaging import (
    LINK,
    LINKS,
    AveragedModel,
    Member,
    fit_averaged,
    fit_surface,
    share_below,
    to_conversion,
)
from millprint.thesis.yields.features import LEFT_OUT, LOCKED_AGAIN, NESTED, RANDOM, describe
from millprint.thesis.yields.regressors import AVERAGED, CLIMATOLOGY, SURFACE, regressor
from millprint.thesis.yields.yield_model import Trainer, YieldModel, fit_model

# CRPS [pp], logarithmic score [-] (of the density in 1/pp), and the probability integral transform [-].
SCORE_COLUMNS = ("crps_pp", "log_score", "pit")
# A yield is read off no better than this [pp]; a model that makes no error at all has no smaller deviation.
SMALLEST_PP = 0.01
# Nodes on each side of the measured yield, for the CRPS of a mixture.
NODES, NODE_WEIGHTS = np.polynomial.legendre.leggauss(96)
# A mixture's distribution function is integrated between these conversions [-] if a member is not bounded.
UNBOUNDED = (-1.0, 2.0)


class Distribution(Protocol):
    """What is predicted for m rows."""

    @property
    def name(self) -> str:
        """What the distribution is made from."""

    def scores(self, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """CRPS [pp], logarithmic score [-] and probability integral [-], (m,) each, for measured yields (m,) [%]."""


@dataclass(frozen=True)
class NormalYields:
    """Normal distributions: mean [%] and standard deviation [pp], (m,) each; `name` says what the deviation is from."""

    name: str
    mean: np.ndarray
    deviation: np.ndarray

    def scores(self, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """As Distribution.scores. CRPS = s (z (2 Phi(z) - 1) + 2 phi(z) - 1 / sqrt(pi)), z = (y - mean) / s."""
        deviation = np.maximum(self.deviation, SMALLEST_PP)
        scaled = (truth - self.mean) / deviation
        below = normal_below(scaled)
        crps = deviation * (scaled * (2 * below - 1) + 2 * normal_density(scaled) - 1 / np.sqrt(np.pi))
        return crps, -normal_log_density(truth, self.mean, deviation), below


@dataclass(frozen=True)
class MixtureYields:
    """A mixture of normal distributions, each behind a link.

    links: names of those of the members; latent: mean and standard deviation of link(y) of each member, (m,) each;
    weights add up to one; margin: the smallest distance of a measured conversion from 0 and 1 [-], where its density is
    asked for.
    """

    links: list[str]
    weights: np.ndarray
    latent: list[tuple[np.ndarray, np.ndarray]]
    margin: float
    name: str = "mixture"

    @classmethod
    def of(cls, members: list[Member], weights: np.ndarray, rows: pd.DataFrame, margin: float) -> "MixtureYields":
        """The mixture that members with these weights predict for rows with the six conditions."""
        inputs = describe(rows).to_numpy()
        links = [member.candidate.link for member in members]
        return cls(links, weights, [member.latent(inputs) for member in members], margin)

    def below(self, conversion: np.ndarray) -> np.ndarray:
        """Probability (m, q) of at most these conversions (m, q) [-]."""
        total = np.zeros(conversion.shape)
        for link, weight, (mean, deviation) in zip(self.links, self.weights, self.latent, strict=True):
            total += weight * share_below(link, conversion, mean[:, None], deviation[:, None])
        return total

    def scores(self, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """As Distribution.scores. CRPS is the integral of (F(x) - 1{x >= y})^2, by Gauss-Legendre on each side of y."""
        conversion = np.asarray(truth, dtype=float) / 100
        bounded = all(link != "identity" for link in self.links)
        low, high = (0.0, 1.0) if bounded else UNBOUNDED
        crps = np.zeros(len(conversion))
        for start, end, beyond in ((low, conversion, 0.0), (conversion, high, 1.0)):
            half = (np.asarray(end) - np.asarray(start)) / 2 * np.ones(len(conversion))
            middle = (np.asarray(end) + np.asarray(start)) / 2
            at = np.reshape(middle, (-1, 1)) + half[:, None] * NODES
            crps += half * ((self.below(at) - beyond) ** 2 @ NODE_WEIGHTS)
        inside, density = to_conversion(truth, self.margin), np.zeros(len(conversion))
        for name, weight, (mean, deviation) in zip(self.links, self.weights, self.latent, strict=True):
            link = LINKS[name]
            slope = np.exp(link.log_slope(inside))
            density += weight * normal_density(link.forward(inside), mean, deviation) * slope
        return 100 * crps, -np.log(density / 100), self.below(conversion[:, None])[:, 0]


CV_PLUS = "cv_plus"
# Fits on rows and their yields (n,) [%], and returns the function that predicts other rows.
Fit = Callable[[pd.DataFrame, np.ndarray], Callable[[pd.DataFrame], np.ndarray]]


def own_intervals(model: YieldModel | AveragedModel, rows: pd.DataFrame, levels: list[float]) -> dict[str, np.ndarray]:
    """Central intervals (m, levels, 2) [%] within 0 and 100 by the name of the model's distribution; {} without one."""
    if model.distribution is None or not levels:
        return {}
    return {model.distribution: np.clip(model.intervals(rows, levels), 0, 100)}


def cross_intervals(centres: np.ndarray, residuals: np.ndarray, levels: list[float]) -> np.ndarray:
    """CV+ intervals, (m, levels, 2) [%], within 0 and 100 (Barber et al., Ann. Stat. 49 (2021) 486, Eq. 1.8).

    centres: (n, m) predictions for m rows by the model that did not see training row i; residuals: (n,) |error| of row
    i by that model. The ends are the floor(a (n + 1))-th smallest centre - residual and the ceil((1 - a)(n + 1))-th
    smallest centre + residual, a = 1 - level, with coverage of at least 1 - 2a. If n is too small for a level, the end
    is 0 or 100.
    """
    count = len(residuals)
    low = np.sort(centres - residuals[:, None], axis=0)
    high = np.sort(centres + residuals[:, None], axis=0)
    ends = np.empty((centres.shape[1], len(levels), 2))
    for index, level in enumerate(levels):
        # Rounded first, so that 0.05 * 40 counts as 2 and not as a little less.
        below = int(np.floor(round((1 - level) * (count + 1), 9)))
        above = int(np.ceil(round(level * (count + 1), 9)))
        ends[:, index, 0] = low[below - 1] if below >= 1 else 0.0
        ends[:, index, 1] = high[above - 1] if above <= count else 100.0
    return np.clip(ends, 0, 100)


def cross_validate(
    fit: Fit, rows: pd.DataFrame, yields: np.ndarray, unseen: pd.DataFrame, folds: int, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, m) [%] and absolute residuals (n,) [pp] by refits of `fit` on folds of the training rows."""
    centres, residuals = np.empty((len(rows), len(unseen))), np.empty(len(rows))
    parts = KFold(min(folds, len(rows)), shuffle=True, random_state=seed)
    for kept, held in parts.split(rows):
        predict = fit(rows.iloc[kept], yields[kept])
        centres[held] = predict(unseen)
        residuals[held] = np.abs(yields[held] - predict(rows.iloc[held]))
    return centres, residuals


def refit(model: YieldModel, training: TrainingConfig) -> Fit:
    """A function that fits the steps of a model on other rows, with the same hyper-parameters."""
    parameters = [step.parameters for step in model.steps]
    return lambda rows, yields: fit_model(model.name, model.strategy, parameters, rows, yields, training).predict


# A normal distribution with the spread of the errors of other runs.
ERRORS = "errors"


@dataclass(frozen=True)
class Prediction:
    """Predicted yields (m,) [%], predictive intervals (m, levels, 2) [%] by the method that they come from.

    distribution: what is scored; a normal one from cross-validated errors for a model that predicts none.
    """

    predicted: np.ndarray
    intervals: dict[str, np.ndarray]
    distribution: Distribution


# Training rows, their yields (n,) [%], the rows to predict, and the levels of their intervals, which may be none.
Procedure = Callable[[pd.DataFrame, np.ndarray, pd.DataFrame, list[float]], Prediction]


def smaller_forests(training: TrainingConfig, largest: int) -> TrainingConfig:
    """The settings with forests of at most `largest` trees: more trees only average out the noise of a forest."""
    spaces = dict(training.spaces)
    for name, space in training.spaces.items():
        if regressor(name).forest and (trees := space["n_estimators"])[1] > largest:
            spaces[name] = space | {"n_estimators": [min(trees[0], largest - 1), largest]}
    return training.model_copy(update={"spaces": spaces})


def climatology(rows: pd.DataFrame, yields: np.ndarray, unseen: pd.DataFrame, levels: list[float]) -> Prediction:
    """The normal distribution of the training yields (n,) [%] for every row: s^2 (1 + 1 / n) is that of a new run."""
    mean = np.full(len(unseen), yields.mean())
    spread = np.full(len(unseen), yields.std(ddof=1) * np.sqrt(1 + 1 / len(yields)))
    half = spread[:, None] * normal_quantile(0.5 + np.array(levels) / 2)
    ends = np.clip(np.stack([mean[:, None] - half, mean[:, None] + half], axis=2), 0, 100)
    return Prediction(mean, {ERRORS: ends}, NormalYields(ERRORS, mean, spread))


def procedure_of(
    name: str, strategy: str, training: TrainingConfig, budget: HeldOutConfig, averaging: AveragingConfig
) -> Procedure:
    """The training procedure of a model. It makes every choice from the training rows only.

    name: a regressor, which is tuned and fitted, AVERAGED, whose members are fitted and weighted, or one of BASELINES.
    Raises ValueError for an unknown one.
    """
    training = smaller_forests(training, budget.largest_forest)

    def tuned(rows: pd.DataFrame, yields: np.ndarray, unseen: pd.DataFrame, levels: list[float]) -> Prediction:
        model, _ = Trainer(training, budget).train(name, strategy, rows, yields)
        predicted = model.predict(unseen)
        if model.distribution:
            own = NormalYields(model.distribution, predicted, model.deviation(unseen))
            return Prediction(predicted, own_intervals(model, unseen, levels), own)
        fit, folds = refit(model, training), budget.conformal_folds
        centres, residuals = cross_validate(fit, rows, yields, unseen, folds, training.seed)
        spread = np.full(len(unseen), np.sqrt(np.mean(residuals**2)))
        intervals = {CV_PLUS: cross_intervals(centres, residuals, levels)}
        return Prediction(predicted, intervals, NormalYields(ERRORS, predicted, spread))

    def averaged(rows: pd.DataFrame, yields: np.ndarray, unseen: pd.DataFrame, levels: list[float]) -> Prediction:
        model = fit_averaged(rows, yields, averaging)
        mixture = MixtureYields.of(model.members, model.weights, unseen, averaging.margin)
        return Prediction(model.predict(unseen), own_intervals(model, unseen, levels), mixture)

    def surface(rows: pd.DataFrame, yields: np.ndarray, unseen: pd.DataFrame, levels: list[float]) -> Prediction:
        model = fit_surface(rows, yields, averaging.margin)
        latent = MixtureYields([LINK], np.ones(1), [model.latent(unseen)], averaging.margin, LINK)
        return Prediction(model.predict(unseen), {LINK: model.intervals(unseen, levels)}, latent)

    known = {AVERAGED: averaged, CLIMATOLOGY: climatology, SURFACE: surface}
    if name not in known:
        regressor(name)
    return known.get(name, tuned)


PREDICTION_COLUMNS = [
    "scheme",
    "repeat",
    "fold",
    "case",
    "yield_percent",
    "predicted_percent",
    "distribution",
    *SCORE_COLUMNS,
]
INTERVAL_COLUMNS = ["scheme", "repeat", "case", "yield_percent", "method", "nominal", "lower_percent", "upper_percent"]


@dataclass(frozen=True)
class OuterFold:
    """Positions of the training rows (kept) and of the predicted rows (held), and the yields (n,) [%] of all rows.

    number: of the fold within its repeat.
    """

    scheme: str
    repeat: int
    kept: np.ndarray
    held: np.ndarray
    yields: np.ndarray
    number: int = 0


def outer_folds(rows: pd.DataFrame, budget: HeldOutConfig) -> list[OuterFold]:
    """The outer folds of every scheme, the same for every model.

    rows: role (train or test) and yield_percent. The random splits hold out as many rows as the locked one. The first
    repeat of leave-one-out has the rows in their own order, the others shuffled.
    """
    yields, positions = rows[YIELD].to_numpy(float), np.arange(len(rows))
    test = (rows["role"] == "test").to_numpy()
    folds = [OuterFold(LOCKED_AGAIN, 0, positions[~test], positions[test], yields)]
    generator = np.random.default_rng(budget.seed)
    orders = [positions, *(generator.permutation(positions) for _ in range(budget.orders - 1))]
    folds += [
        OuterFold(LEFT_OUT, number, order[order != index], positions[[index]], yields, int(index))
        for number, order in enumerate(orders)
        for index in positions
    ]
    nested = RepeatedKFold(n_splits=budget.outer_folds, n_repeats=budget.outer_repeats, random_state=budget.seed)
    for number, (kept, held) in enumerate(nested.split(rows)):
        repeat, part = divmod(number, budget.outer_folds)
        folds.append(OuterFold(NESTED, repeat, kept, held, yields, part))
    splits = ShuffleSplit(budget.random_splits, test_size=int(test.sum()), random_state=budget.seed)
    return folds + [
        OuterFold(RANDOM, number, kept, held, yields) for number, (kept, held) in enumerate(splits.split(rows))
    ]


def predict_held_out(
    procedure: Procedure,
    rows: pd.DataFrame,
    folds: list[OuterFold],
    levels: list[float],
    tick: Callable[[], None] = lambda: None,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Predictions of the held-out rows with PREDICTION_COLUMNS, and their predictive intervals with INTERVAL_COLUMNS.

    rows: case and the six conditions; tick: called after each fold. A procedure never sees the yields that its
    distributions are scored with.
    """
    predictions, intervals = [], []
    for fold in folds:
        unseen = rows.iloc[fold.held]
        answer = procedure(rows.iloc[fold.kept], fold.yields[fold.kept], unseen, levels)
        about = {
            "scheme": fold.scheme,
            "repeat": fold.repeat,
            "case": unseen["case"].to_numpy(),
            "yield_percent": fold.yields[fold.held],
        }
        scored = answer.distribution.scores(fold.yields[fold.held])
        predictions.append(
            pd.DataFrame(
                {
                    **about,
                    "fold": fold.number,
                    "predicted_percent": answer.predicted,
                    "distribution": answer.distribution.name,
                    **dict(zip(SCORE_COLUMNS, scored, strict=True)),
                }
            )
        )
        for method, ends in answer.intervals.items():
            for index, level in enumerate(levels):
                interval = {"lower_percent": ends[:, index, 0], "upper_percent": ends[:, index, 1]}
                intervals.append(pd.DataFrame({**about, "method": method, "nominal": level, **interval}))
        tick()
    return (
        pd.concat(predictions, ignore_index=True)[PREDICTION_COLUMNS],
        pd.concat(intervals, ignore_index=True)[INTERVAL_COLUMNS],
    )
