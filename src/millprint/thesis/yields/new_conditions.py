"""Yields of new conditions by a stored model, with intervals; conditions far from every training row are refused."""

import numpy as np
import pandas as pd

from millprint.config.next_experiments import PredictionConfig
from millprint.config.yields import TrainingConfig
from millprint.thesis.doe.runs import YIELD
from millprint.thesis.yields.averaging import AveragedModel
from millprint.thesis.yields.domain import MillCurves, correlation_warnings
from millprint.thesis.yields.features import CONDITIONS, SHARE, describe
from millprint.thesis.yields.model_files import load_any, training_rows
from millprint.thesis.yields.predictive_intervals import CV_PLUS, cross_validated_intervals, own_intervals, refit
from millprint.thesis.yields.yield_model import YieldModel


def trained_ranges(rows: pd.DataFrame, settings: PredictionConfig) -> dict[str, tuple[float, float]]:
    """Lowest and highest value with a prediction, for each condition and for the tangential share."""
    ranges = {}
    for name in CONDITIONS:
        low, high = float(rows[name].min()), float(rows[name].max())
        slack = settings.tolerance * (high - low)
        ranges[name] = (low - slack, high + slack)
    share = describe(rows)[SHARE]
    return ranges | {SHARE: (share.min() - settings.share_tolerance, share.max() + settings.share_tolerance)}


def range_warnings(rows: pd.DataFrame, ranges: dict[str, tuple[float, float]]) -> list[str]:
    """For each row the conditions outside the ranges as text, empty if there are none.

    The share is checked as well: at another fill ratio each energy can be within its range while their ratio is not.
    """
    values = rows[list(CONDITIONS)].assign(**{SHARE: describe(rows)[SHARE]})
    return [
        "; ".join(
            f"{name} = {row[name]:.4g} is outside {low:.4g} to {high:.4g}"
            for name, (low, high) in ranges.items()
            if not low <= row[name] <= high
        )
        for _, row in values.iterrows()
    ]


def domain_warnings(
    model: YieldModel | AveragedModel,
    known: pd.DataFrame,
    rows: pd.DataFrame,
    limits: PredictionConfig,
    mill: MillCurves | None,
) -> list[str]:
    """For each row why the model should not be asked, empty if it may be.

    Each condition must be within its trained range, the three descriptors must belong to one setting of the mill (if
    there is one), and the yield must be correlated with that of a run (for the averaged process, which has length
    scales for its inputs; for a row outside a range, only the range is reported).

    known: the training rows; rows: the six conditions.
    """
    outside = range_warnings(rows, trained_ranges(known, limits))
    parts = [outside]
    if mill is not None:
        parts.append(mill.warnings(rows, limits.curve_tolerance))
    if isinstance(model, AveragedModel):
        far = correlation_warnings(model, known, rows, limits.correlation_min)
        parts.append([text if not told else "" for text, told in zip(far, outside, strict=True)])
    return ["; ".join(filter(None, texts)) for texts in zip(*parts, strict=True)]


def predict_conditions(
    path: str,
    rows: pd.DataFrame,
    limits: PredictionConfig,
    training: TrainingConfig,
    folds: int,
    level: float,
    extrapolate: bool = False,
    mill: MillCurves | None = None,
) -> pd.DataFrame:
    """Columns: case, the six conditions, predicted_percent, lower_percent, upper_percent, interval, warning.

    path: a stored model; rows: case and the six conditions; folds: of the CV+ intervals; level: of the intervals [-].
    mill: whose descriptors the rows have; None if that is not known. The interval is the model's own if it predicts a
    distribution, else CV+ from its training rows. A row that `domain_warnings` warns of has no numbers, unless
    `extrapolate` is true. Raises ConfigError as load_any.
    """
    model, known = load_any(path), training_rows(path)
    intervals = own_intervals(model, rows, [level])
    if isinstance(model, YieldModel) and not intervals:
        yields = known[YIELD].to_numpy(float)
        fit = refit(model, training)
        intervals = {CV_PLUS: cross_validated_intervals(fit, known, yields, rows, [level], folds, training.seed)}
    ((method, ends),) = intervals.items()
    warnings = domain_warnings(model, known, rows, limits, mill)
    answered = np.array([extrapolate or not text for text in warnings])
    numbers = {"predicted_percent": model.predict(rows), "lower_percent": ends[:, 0, 0], "upper_percent": ends[:, 0, 1]}
    table = rows[["case", *CONDITIONS]].assign(
        **{name: np.where(answered, value, np.nan) for name, value in numbers.items()}
    )
    return table.assign(interval=np.where(answered, method, ""), warning=warnings)
