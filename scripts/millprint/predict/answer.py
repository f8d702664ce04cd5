"""Yields of new conditions by a stored model, with intervals; what no training row is near is not answered."""

import numpy as np
import pandas as pd

from millprint.config.proposals import PredictionConfig
from millprint.config.yields import TrainingConfig
from millprint.doe.runs import YIELD
from millprint.predict.archive import load_any, training_rows
from millprint.predict.averaging import AveragedModel
from millprint.predict.features import CONDITIONS
from millprint.predict.inputs import describe
from millprint.predict.learners import conformal_intervals, gaussian_intervals

SHARE = "tangential_share"


def trained_ranges(rows: pd.DataFrame, settings: PredictionConfig) -> dict[str, tuple[float, float]]:
    """Lowest and highest value that is answered, of each condition and of the tangential share."""
    ranges = {}
    for name in CONDITIONS:
        low, high = float(rows[name].min()), float(rows[name].max())
        slack = settings.tolerance * (high - low)
        ranges[name] = (low - slack, high + slack)
    share = describe(rows)[SHARE]
    return ranges | {SHARE: (share.min() - settings.share_tolerance, share.max() + settings.share_tolerance)}


def range_warnings(rows: pd.DataFrame, ranges: dict[str, tuple[float, float]]) -> list[str]:
    """For each row what lies outside the ranges, empty where nothing does.

    The share says whether the energies belong to the fill ratios that were trained, which no energy does alone.
    """
    values = rows[list(CONDITIONS)].assign(**{SHARE: describe(rows)[SHARE]})
    found = []
    for _, row in values.iterrows():
        outside = [
            f"{name} = {row[name]:.4g} is outside {low:.4g} to {high:.4g}"
            for name, (low, high) in ranges.items()
            if not low <= row[name] <= high
        ]
        found.append("; ".join(outside))
    return found


def answer(
    path: str,
    rows: pd.DataFrame,
    limits: PredictionConfig,
    training: TrainingConfig,
    folds: int,
    level: float,
    extrapolate: bool = False,
) -> pd.DataFrame:
    """Columns: case, the six conditions, predicted_percent, lower_percent, upper_percent, interval, warning.

    rows: case and the six conditions; level: of the intervals [-]. The interval is the model's own where it has a
    distribution, else CV+ of its training rows, in so many folds. A row outside the trained ranges by more than
    `limits` allows has a warning and no numbers, unless `extrapolate`.
    """
    model, known = load_any(path), training_rows(path)
    if isinstance(model, AveragedModel):
        method, ends = "mixture", np.stack(model.interval(rows, level), axis=1)
    elif (normal := gaussian_intervals(model, rows, [level])) is not None:
        method, ends = "gaussian", normal[:, 0]
    else:
        yields = known[YIELD].to_numpy(float)
        method = "cv_plus"
        ends = conformal_intervals(model, known, yields, rows, [level], training, folds)[:, 0]
    told = range_warnings(rows, trained_ranges(known, limits))
    answered = np.array([extrapolate or not text for text in told])
    numbers = {"predicted_percent": model.predict(rows), "lower_percent": ends[:, 0], "upper_percent": ends[:, 1]}
    table = rows[["case", *CONDITIONS]].assign(
        **{name: np.where(answered, value, np.nan) for name, value in numbers.items()}
    )
    return table.assign(interval=np.where(answered, method, ""), warning=told)
