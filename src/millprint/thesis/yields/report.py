"""Tables of fitted models: metrics, predictions with intervals, and hyper-parameters."""

import pandas as pd

from millprint.thesis.doe.runs import YIELD
from millprint.thesis.yields.averaging import AveragedModel
from millprint.thesis.yields.metrics import YieldWeights, metrics
from millprint.thesis.yields.regressors import regressor
from millprint.thesis.yields.yield_model import YieldModel

MODEL_KEYS = ["model", "strategy"]


def labelled(table: pd.DataFrame, model: YieldModel | AveragedModel) -> pd.DataFrame:
    """A table with the model's name and strategy as its first columns."""
    return table.assign(model=model.name, strategy=model.strategy)[[*MODEL_KEYS, *table]]


def locked_metrics(models: list[YieldModel | AveragedModel], test: pd.DataFrame, weigh: YieldWeights) -> pd.DataFrame:
    """Table 5.6: for each model rmse, mae [pp], mape [%], r2 [-], wmse [pp2], and the number of test rows."""
    truth = test[YIELD].to_numpy(float)
    tables = [
        labelled(pd.DataFrame([{**metrics(truth, model.predict(test), weigh), "test_rows": len(test)}]), model)
        for model in models
    ]
    return pd.concat(tables, ignore_index=True)


def predictions(models: list[YieldModel | AveragedModel], rows: pd.DataFrame, level: float) -> pd.DataFrame:
    """Every model's prediction for every row, with a predictive interval if the model has one.

    rows: case, the six conditions, yield_percent, and role where there is one. Columns: model, strategy, case, (role,)
    yield_percent, predicted_percent, error_pp, deviation_pp, lower_percent, upper_percent.
    """
    tables = []
    for model in models:
        predicted, (lower, upper) = model.predict(rows), model.interval(rows, level)
        table = rows[[name for name in ("case", "role", YIELD) if name in rows]].assign(
            predicted_percent=predicted,
            error_pp=predicted - rows[YIELD],
            deviation_pp=model.deviation(rows),
            lower_percent=lower,
            upper_percent=upper,
        )
        tables.append(labelled(table, model))
    return pd.concat(tables, ignore_index=True)


def hyperparameters(models: list[YieldModel], searches: list[list[dict | None]]) -> pd.DataFrame:
    """Columns: model, strategy, step (yield, time or residual), parameter, value, loss_pp2, evaluations."""
    rows = []
    for model, results in zip(models, searches, strict=True):
        titles = ("time", "residual") if len(model.steps) > 1 else ("yield",)
        for title, step, result in zip(titles, model.steps, results, strict=True):
            values = dict(step.parameters)
            if fitted := regressor(step.plan.regressor).fitted:
                values |= fitted(step.estimator, step.plan.features)
            about = {"model": model.name, "strategy": model.strategy, "step": title, **(result or {})}
            rows += [about | {"parameter": name, "value": value} for name, value in values.items()]
    return pd.DataFrame(rows, columns=[*MODEL_KEYS, "step", "parameter", "value", "loss_pp2", "evaluations"])
