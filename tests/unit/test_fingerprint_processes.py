"""Processes of many conditions: what is left out is predicted as if it had never been known, from one inverse."""

import numpy as np
import pytest

from millprint.estimate.gaussian_process import Likelihood
from millprint.fingerprint import processes
from millprint.fingerprint.coverage import LEFT_OUT, grouped
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.processes import Process, Reduced, logarithms, pivoted, varied_components
from tests.unit.synthetic_mill import VOLUME, descriptors


@pytest.fixture(scope="module")
def process() -> Process:
    """Of conditions with scatter and errors of their own, and a stretch over 1."""
    table, rng = descriptors(), np.random.default_rng(3)
    logs = np.log(table["Pn"].to_numpy()) + 0.1 * rng.normal(size=len(table))
    errors = rng.uniform(0.01, 0.1, len(table))
    found = Process.fit(logarithms(table), logs, errors, varied_components(table))
    return Process(**{**vars(found), "stretch": 1.3})


@pytest.mark.parametrize("left_out", LEFT_OUT)
def test_what_is_left_out_is_predicted_as_by_a_process_that_never_knew_it(process, left_out):
    groups = grouped(process.inputs, LEFT_OUT[left_out])
    means, deviations = process.leave_out(groups)
    wanted = []
    for group in groups:
        kept = np.setdiff1d(np.arange(len(process.logs)), group)
        rest = {name: getattr(process, name)[kept] for name in ("inputs", "logs", "errors", "seeds")}
        told = Process(**{**vars(process), **rest}).predictor().predict(process.inputs[group])
        own = process.stretch * np.hypot(process.errors[group], np.sqrt(process.noise))
        wanted.append((told.logs, np.hypot(told.of_mean, own)))
    np.testing.assert_allclose(means, np.concatenate([mean for mean, _ in wanted]), atol=1e-6)
    np.testing.assert_allclose(deviations, np.concatenate([deviation for _, deviation in wanted]), rtol=1e-5)


def test_a_mean_alone_is_that_of_a_prediction_to_the_last_bit(process):
    between, own = 0.5 * (process.inputs[:-1] + process.inputs[1:]), process.predictor()
    assert np.array_equal(own.mean(between), own.predict(between).logs)


@pytest.mark.slow
def test_of_many_conditions_some_give_the_parameters_and_all_of_them_the_curves(monkeypatch):
    table = descriptors()
    whole = Fingerprint.fit(table, VOLUME, 0.95)
    sizes = []
    likelihood = Likelihood.negative_log

    def counted(self, theta):
        sizes.append(len(self.target))
        return likelihood(self, theta)

    monkeypatch.setattr(Likelihood, "negative_log", counted)
    few = len(table) // 2
    monkeypatch.setattr(processes, "LEARNT_FROM", few)
    part = Fingerprint.fit(table, VOLUME, 0.95)
    assert few in sizes
    # Every condition is known to it, and its curves are those of all of them within the intervals.
    assert all(len(own.logs) == len(table) for own in part.processes.values())
    fills = np.geomspace(*whole.fill_range, 10)
    curve, other = whole.curve(fills), part.curve(fills)
    assert ((other["Pn"] > curve["Pn_lower"]) & (other["Pn"] < curve["Pn_upper"])).all()
    again = Fingerprint.fit(table, VOLUME, 0.95)
    assert again.processes["Pn"].theta.tolist() == part.processes["Pn"].theta.tolist()


def test_a_reduced_process_predicts_what_the_whole_one_does_within_a_hundredth_of_its_deviation(process, monkeypatch):
    between = 0.5 * (process.inputs[:-1] + process.inputs[1:])
    mean, _, deviation = process.predictor().predict(between)
    centre, covariance = process.predictor().joint(between)
    monkeypatch.setattr(processes, "WHOLE_MAX", 10)
    predictor = process.predictor()
    assert isinstance(predictor.known, Reduced)
    found, _, wide = predictor.predict(between)
    assert np.abs((found - mean) / deviation).max() < 0.01
    np.testing.assert_allclose(wide, deviation, rtol=0.005)
    middle, together = predictor.joint(between)
    assert np.abs(middle - centre).max() < 0.01 * deviation.min()
    assert np.abs(together - covariance).max() < 0.01 * deviation.min() ** 2


def test_a_reduced_process_leaves_out_as_the_whole_one_does(process, monkeypatch):
    groups = grouped(process.inputs, LEFT_OUT["fill ratio"])
    means, deviations = process.leave_out(groups)
    monkeypatch.setattr(processes, "WHOLE_MAX", 10)
    found, wide = process.leave_out(groups)
    assert np.abs((found - means) / deviations).max() < 0.01
    np.testing.assert_allclose(wide, deviations, rtol=0.005)


def test_what_few_conditions_leave_out_of_the_others_is_below_what_is_allowed(process):
    kernel = process._kernel()
    rows, order, left = pivoted(kernel, process.inputs, 1e-6)
    rest = kernel(process.inputs) - rows.T @ rows
    assert 3 < len(order) < len(process.logs)
    np.testing.assert_allclose(np.diag(rest), left, atol=1e-12)
    assert np.abs(rest).max() <= 1.01e-6
    # The corner from which new conditions are predicted is a triangle.
    assert not np.triu(rows[:, order].T, 1).any()


def test_conditions_that_were_simulated_twice_are_reduced_to_one(process):
    twice = np.vstack([process.inputs, process.inputs])
    kernel = process._kernel()
    assert len(pivoted(kernel, twice, 1e-9)[1]) <= len(process.inputs)
