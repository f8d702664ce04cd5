"""SHAP values of the tree models: what each feature adds to each prediction (thesis Fig. 5.4)."""

import warnings
from typing import Any

import numpy as np
import pandas as pd
from sklearn.ensemble import RandomForestRegressor

from millprint.predict.features import FEATURES, engineer
from millprint.predict.model import Step, YieldModel


def _forest_values(estimator: RandomForestRegressor, inputs: np.ndarray) -> tuple[np.ndarray, float]:
    # Imported here: it takes seconds and only this job needs it. Its colour maps warn of a future matplotlib.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PendingDeprecationWarning)
        from shap import TreeExplainer
    explainer = TreeExplainer(estimator)
    return explainer.shap_values(inputs), float(np.ravel(explainer.expected_value)[0])


def _boosted_values(estimator: Any, inputs: np.ndarray) -> tuple[np.ndarray, float]:
    """By XGBoost's own implementation of the same algorithm, which knows its base score exactly."""
    from xgboost import DMatrix

    values = estimator.get_booster().predict(DMatrix(inputs), pred_contribs=True)
    return values[:, :-1].astype(float), float(values[0, -1])


def _tree_values(step: Step, features: pd.DataFrame) -> tuple[np.ndarray, float]:
    """SHAP values (n, k) [pp] of one step, and its mean prediction as the trees hold it."""
    explain = _boosted_values if step.plan.algorithm == "xgb" else _forest_values
    return explain(step.estimator, step.inputs(features))


def shap_values(model: YieldModel, rows: pd.DataFrame) -> pd.DataFrame:
    """SHAP values of a tree model: columns case, feature, feature_value, shap_pp, base_percent.

    The model is the sum of its steps, so its values are the sums of theirs: a two-step model's time gets what the
    time model gives it. For each row the values and the base add up to the prediction.
    """
    features = engineer(rows)
    total = pd.DataFrame(0.0, index=features.index, columns=list(FEATURES))
    base = 0.0
    for step in model.steps:
        values, offset = _tree_values(step, features)
        total[list(step.plan.features)] += values
        base += offset
    long = total.assign(case=rows["case"]).melt("case", var_name="feature", value_name="shap_pp")
    long.insert(2, "feature_value", features.melt()["value"].to_numpy())
    return long.assign(base_percent=base)


def rank_features(values: pd.DataFrame) -> pd.DataFrame:
    """Mean |SHAP| of each feature of each model, largest first: columns model, strategy, feature, mean_abs_shap_pp."""
    keys = ["model", "strategy", "feature"]
    mean = values.assign(mean_abs_shap_pp=values["shap_pp"].abs()).groupby(keys, sort=False)["mean_abs_shap_pp"].mean()
    return mean.reset_index().sort_values(["model", "mean_abs_shap_pp"], ascending=[True, False], ignore_index=True)
