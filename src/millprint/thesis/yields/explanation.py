"""SHAP values of the models: what each feature adds to each prediction (thesis Fig. 5.4)."""

import pandas as pd

from millprint.thesis.yields.features import FEATURES, engineer
from millprint.thesis.yields.regressors import regressor
from millprint.thesis.yields.yield_model import YieldModel


def shap_values(model: YieldModel, rows: pd.DataFrame) -> pd.DataFrame:
    """SHAP values of a model: columns case, feature, feature_value, shap_pp, base_percent.

    rows: case and the six conditions. The model is the sum of its steps, so its SHAP values are those of its steps
    added up; in a two-step model the value of time is that of the time model. For each row the values and the base add
    up to the prediction. Raises ValueError for a regressor that cannot be explained.
    """
    features = engineer(rows)
    total = pd.DataFrame(0.0, index=features.index, columns=list(FEATURES))
    base = 0.0
    for step in model.steps:
        explain = regressor(step.plan.regressor).explain
        if explain is None:
            raise ValueError(f"{step.plan.regressor}: a regressor without SHAP values")
        values, offset = explain(step.estimator, step.inputs(features))
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
