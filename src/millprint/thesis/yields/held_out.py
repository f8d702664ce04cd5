"""Held-out predictions: every outer fold repeats scaling, search and fit without the runs that are predicted."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from sklearn.model_selection import RepeatedKFold, ShuffleSplit

from millprint.config.yields import AveragingConfig, HeldOutConfig, TrainingConfig
from millprint.estimate.quantiles import normal_quantile
from millprint.thesis.doe.runs import YIELD
from millprint.thesis.yields.averaging import fit_averaged
from millprint.thesis.yields.distributions import (
    CV_PLUS,
    SCORE_COLUMNS,
    Distribution,
    MixtureYields,
    NormalYields,
    cross_intervals,
    cross_validate,
    own_intervals,
    refit,
)
from millprint.thesis.yields.metrics import LEFT_OUT, LOCKED_AGAIN, NESTED, RANDOM
from millprint.thesis.yields.regressors import AVERAGED, CLIMATOLOGY, SURFACE, regressor
from millprint.thesis.yields.response_surface import LINK, fit_surface
from millprint.thesis.yields.yield_model import Trainer

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
        fit, folds = refit(model, training), budget.conformal_folds
        centres, residuals = cross_validate(fit, rows, yields, unseen, folds, training.seed)
        intervals = {CV_PLUS: cross_intervals(centres, residuals, levels)} | own_intervals(model, unseen, levels)
        if model.distribution:
            return Prediction(
                predicted, intervals, NormalYields(model.distribution, predicted, model.deviation(unseen))
            )
        spread = np.full(len(unseen), np.sqrt(np.mean(residuals**2)))
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
