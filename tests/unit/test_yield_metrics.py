"""Metrics, intervals and the share of variance against closed forms."""

import numpy as np
import pytest

from millprint.thesis.yields.evaluation import time_variance
from millprint.thesis.yields.metrics import YieldWeights, bootstrap_metrics, metrics, weighted_mse

WEIGH = YieldWeights(70, 2.0)


def test_weights_count_double_only_above_the_threshold():
    assert WEIGH(np.array([0, 69.9, 70.0, 70.1, 100])).tolist() == [1, 1, 1, 2, 2]


def test_metrics_are_the_thesis_equations():
    truth, predicted = np.array([80.0, 50.0, 20.0]), np.array([70.0, 55.0, 22.0])
    found = metrics(truth, predicted, WEIGH)
    assert found["rmse"] == pytest.approx(np.sqrt((100 + 25 + 4) / 3))
    assert found["mae"] == pytest.approx(17 / 3)
    assert found["mape"] == pytest.approx(100 * (10 / 80 + 5 / 50 + 2 / 20) / 3)
    assert found["r2"] == pytest.approx(1 - 129 / 1800)
    # Divided by the number of rows, not by the sum of the weights.
    assert found["wmse"] == pytest.approx((2 * 100 + 25 + 4) / 3)
    assert found["wmse"] == pytest.approx(weighted_mse(truth, predicted, WEIGH(truth)))


def test_metrics_that_are_not_defined_are_nan():
    found = metrics(np.array([0.0, 0.0]), np.array([1.0, 2.0]), WEIGH)
    assert np.isnan(found["r2"]) and np.isnan(found["mape"]) and found["mae"] == pytest.approx(1.5)


def test_bootstrap_interval_of_the_mae_is_that_of_a_mean():
    generator = np.random.default_rng(1)
    truth = generator.uniform(20, 90, 400)
    error = generator.exponential(5.0, 400)
    table = bootstrap_metrics(truth, truth + error, WEIGH, 4000, 0.95, seed=3).set_index("metric")
    row = table.loc["mae"]
    half = 1.96 * error.std() / np.sqrt(400)
    assert row["value"] == pytest.approx(error.mean())
    assert row["upper"] - row["value"] == pytest.approx(half, rel=0.1)
    assert row["value"] - row["lower"] == pytest.approx(half, rel=0.1)


def test_bootstrap_leaves_out_resamples_without_spread():
    table = bootstrap_metrics(np.array([10.0, 90.0]), np.array([12.0, 80.0]), WEIGH, 100, 0.95, seed=0)
    assert np.isfinite(table[["value", "lower", "upper"]].to_numpy()).all()


def test_repeats_are_averaged_within_each_resample():
    truth, error = np.tile(np.linspace(10, 90, 12), (2, 1)), np.array([[3.0], [5.0]])
    table = bootstrap_metrics(truth, truth + error, WEIGH, 300, 0.95, seed=1).set_index("metric")
    assert table.loc["mae", ["value", "lower", "upper"]].tolist() == pytest.approx([4, 4, 4])


def test_time_explains_what_its_levels_explain():
    time = np.repeat([5.0, 12.5, 20.0], 2)
    yields = np.array([10.0, 20.0, 50.0, 60.0, 10.0, 20.0])
    share = time_variance(time, yields).set_index("measure")["share"]
    between = 2 * (15 - 85 / 3) ** 2 * 2 + 2 * (55 - 85 / 3) ** 2
    assert share["levels"] == pytest.approx(between / (between + 6 * 25))
    assert share["line"] == pytest.approx(0, abs=1e-12)
