"""Figures of chapter 5 show every model of their tables."""

import numpy as np
import pandas as pd
import pytest

from millprint.thesis.figures.chapter5_figures import (
    STRATEGIES,
    interval_errors,
    plot_test_predictions,
)
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


def test_error_bars_reach_to_the_ends_of_an_interval():
    rows = pd.DataFrame({"covered": [0.6], "lower": [0.5], "upper": [0.9]})
    np.testing.assert_allclose(interval_errors(rows, "covered", 100), [[10], [30]])
    percent = pd.DataFrame({"predicted_percent": [60], "lower_percent": [55], "upper_percent": [80]})
    np.testing.assert_allclose(interval_errors(percent, "predicted_percent"), [[5], [20]])
