"""Tables of fitted models: metrics, predictions with intervals, and hyper-parameters."""

import numpy as np
import pandas as pd
from sklearn.gaussian_process import GaussianProcessRegressor

from millprint.doe.runs import YIELD
from millprint.predict.averaging import AveragedModel
from millprint.predict.evaluation import half_width
from millprint.predict.metrics import YieldWeights, metrics
from millprint.predict.model import Step, YieldModel


def locked_metrics(models: list[YieldModel | AveragedModel], test: pd.DataFrame, weigh: YieldWeights) -> pd.DataFrame:
    """Table 5.6: a row a model with rmse, mae [pp], mape [%], r2 [-], wmse [pp2], and the number of test rows."""
    truth = test[YIELD].to_numpy(float)
    return pd.DataFrame(
        {
            "model": model.algorithm,
            "strategy": model.strategy,
            **metrics(truth, model.predict(test), weigh),
            "test_rows": len(test),
        }
        for model in models
    )


def _interval(model: YieldModel | AveragedModel, rows: pd.DataFrame, level: float) -> tuple[np.ndarray, ...]:
    """Prediction, deviation and the ends of the predictive interval, each (n,) [%], NaN where a model gives none."""
    predicted = model.predict(rows)
    if isinstance(model, AveragedModel):
        return predicted, np.full(len(rows), np.nan), *model.interval(rows, level)
    deviation = model.deviation(rows)
    deviation = np.full(len(rows), np.nan) if deviation is None else deviation
    half = half_width(deviation, level)
    return predicted, deviation, predicted - half, predicted + half


def predictions(models: list[YieldModel | AveragedModel], rows: pd.DataFrame, level: float) -> pd.DataFrame:
    """Every model's prediction for every row, with a predictive interval where the model gives one.

    rows: case, the six conditions, yield_percent, and role where there is one. Columns: model, strategy, case, (role,)
    yield_percent, predicted_percent, error_pp, deviation_pp, lower_percent, upper_percent.
    """
    tables = []
    for model in models:
        predicted, deviation, lower, upper = _interval(model, rows, level)
        table = rows[[name for name in ("case", "role", YIELD) if name in rows]].copy()
        table.insert(0, "model", model.algorithm)
        table.insert(1, "strategy", model.strategy)
        table = table.assign(
            predicted_percent=predicted,
            error_pp=predicted - rows[YIELD],
            deviation_pp=deviation,
            lower_percent=lower,
            upper_percent=upper,
        )
        tables.append(table)
    return pd.concat(tables, ignore_index=True)


def _fitted_kernel(step: Step) -> dict[str, float]:
    """What the marginal likelihood made of a kernel; length scales in standard deviations of their feature."""
    kernel = step.estimator.kernel_
    lengths = np.atleast_1d(kernel.k1.k2.length_scale)
    names = step.plan.features if len(lengths) == len(step.plan.features) else ("all",)
    return {
        "fitted_constant": kernel.k1.k1.constant_value,
        **{f"fitted_length_scale.{name}": float(length) for name, length in zip(names, lengths, strict=True)},
        "fitted_noise": kernel.k2.noise_level,
    }


def hyperparameters(models: list[YieldModel], searches: list[list[dict | None]]) -> pd.DataFrame:
    """Columns: model, strategy, step (yield, time or residual), parameter, value, loss_pp2, evaluations."""
    rows = []
    for model, found in zip(models, searches, strict=True):
        titles = ("time", "residual") if len(model.steps) > 1 else ("yield",)
        for title, step, search in zip(titles, model.steps, found, strict=True):
            values = dict(step.parameters)
            if isinstance(step.estimator, GaussianProcessRegressor):
                values |= _fitted_kernel(step)
            rows += [
                {"model": model.algorithm, "strategy": model.strategy, "step": title, "parameter": name, "value": value}
                | (search or {})
                for name, value in values.items()
            ]
    columns = ["model", "strategy", "step", "parameter", "value", "loss_pp2", "evaluations"]
    return pd.DataFrame(rows, columns=columns)
