"""Figures of chapter 5 show every model of their tables."""

import numpy as np
import pandas as pd
import pytest

from millprint.thesis.figures.chapter5_figures import (
    STRATEGIES,
    interval_errors,
    plot_attributions,
    plot_test_predictions,
)
from millprint.thesis.figures.yield_score_figures import plot_pit, plot_scores
from millprint.thesis.yields.metrics import SPREAD
from millprint.thesis.yields.regressors import TITLES


def predictions(models: list[str]) -> pd.DataFrame:
    keys = pd.MultiIndex.from_product([models, STRATEGIES, ["train", "test"], [20.0, 80.0]])
    table = keys.to_frame(index=False, name=["model", "strategy", "role", "yield_percent"])
    return table.assign(predicted_percent=table["yield_percent"] + 5)


@pytest.mark.parametrize("count", [1, 4, 5])
def test_test_predictions_have_a_panel_for_every_model(count):
    models = [name for name in TITLES if name != "linear"][:count]
    figure = plot_test_predictions(predictions(["linear", *models]))
    assert [axis.get_title() for axis in figure.axes] == [TITLES[name] for name in models]
    for axis in figure.axes:
        _, *points = axis.get_lines()
        assert [line.get_xdata().tolist() for line in points] == [[20, 80]] * len(STRATEGIES)


def test_attributions_have_a_panel_for_every_model_that_is_explained():
    keys = pd.MultiIndex.from_product([["rf", "xgb", "gpr"], STRATEGIES, ["time_h", "bpr"], [1.0, 2.0]])
    table = keys.to_frame(index=False, name=["model", "strategy", "feature", "feature_value"])
    figure = plot_attributions(table.assign(shap_pp=np.linspace(-1, 1, len(table))))
    titles = [axis.get_title() for axis in figure.axes if axis.get_title()]
    assert titles == ["two-step GPR", "two-step XGBoost", "two-step random forest"]


def test_error_bars_reach_to_the_ends_of_an_interval():
    rows = pd.DataFrame({"covered": [0.6], "lower": [0.5], "upper": [0.9]})
    np.testing.assert_allclose(interval_errors(rows, "covered", 100), [[10], [30]])
    percent = pd.DataFrame({"predicted_percent": [60], "lower_percent": [55], "upper_percent": [80]})
    np.testing.assert_allclose(interval_errors(percent, "predicted_percent"), [[5], [20]])


def test_figures_of_repeated_scores_show_their_range_and_median():
    schemes = {"leave_one_out": (1, np.nan, np.nan, np.nan), "nested_cv": (10, 5.0, 6.5, 9.0)}
    about = {"model": "gpr_starts", "strategy": "two_step", "value": 7.0, "error": 0.5}
    rows = [
        about | {"scheme": scheme, "score": score} | dict(zip(SPREAD, own, strict=True))
        for score in ("crps_pp", "log_score")
        for scheme, own in schemes.items()
    ]
    axis = plot_scores(pd.DataFrame(rows)).axes[0]
    ranges = [line for bars in axis.collections for line in bars.get_segments() if bars.get_linewidth()[0] == 4]
    assert [line[:, 0].tolist() for line in ranges] == [[5, 9]]
    assert [6.5] in [line.get_xdata().tolist() for line in axis.get_lines() if line.get_marker() == "|"]
    bins = [row | {"from": low, "to": low + 0.2, "share": 0.2, "expected": 0.2} for row in rows[:2] for low in (0, 0.2)]
    # A line for each scheme, and a band for the one with repeats.
    assert len(plot_pit(pd.DataFrame(bins)).axes[0].patches) == 3
