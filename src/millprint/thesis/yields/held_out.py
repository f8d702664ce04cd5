"""Held-out predictions: every outer fold repeats scaling, search and fit without the runs that are predicted."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from sklearn.model_selection import RepeatedKFold, ShuffleSplit

from millprint.config.yields import HeldOutConfig
from millprint.thesis.doe.runs import YIELD
from millprint.thesis.yields.distributions import SCORE_COLUMNS
from millprint.thesis.yields.procedures import Procedure
from millprint.thesis.yields.schemes import LEFT_OUT, LOCKED_AGAIN, NESTED, RANDOM

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

    rows: role (train or test) and yield_percent. The random splits hold out as many rows as the locked one.
    """
    yields, positions = rows[YIELD].to_numpy(float), np.arange(len(rows))
    test = (rows["role"] == "test").to_numpy()
    folds = [OuterFold(LOCKED_AGAIN, 0, positions[~test], positions[test], yields)]
    folds += [
        OuterFold(LEFT_OUT, 0, np.delete(positions, index), positions[[index]], yields, int(index))
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
