"""The averaged Gaussian process: gradients, closed forms, and stored models."""

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import approx_fprime
from scipy.stats import multivariate_normal, norm

from millprint.config.averaged_process import INPUTS, Priors
from millprint.run.files import read_json
from millprint.thesis.yields.averaging import (
    LINKS,
    AveragedModel,
    Candidate,
    evidence_weights,
    fit_averaged,
    fit_member,
    to_conversion,
)
from millprint.thesis.yields.features import Standardisation, describe
from millprint.thesis.yields.model_files import load_any, save_averaged, training_rows
from millprint.thesis.yields.posterior_process import (
    JITTER,
    MEAN_VARIANCE,
    Pairs,
    Posterior,
    Process,
    covariance_terms,
    fit_process,
    prior_of,
    terms_of,
)
from tests.unit.yield_settings import all_runs, parts, settings, thesis_yields

SCALES = ("linear", "linear", "log", "log", "linear")
STRUCTURES = thesis_yields()["averaging"]["structures"]


def fitted() -> tuple[AveragedModel, pd.DataFrame]:
    rows, _ = parts()
    config = settings().averaging
    return fit_averaged(rows, rows["yield_percent"].to_numpy(float), config), rows


@pytest.mark.parametrize("structure", STRUCTURES)
def test_gradient_is_the_slope_of_the_posterior(structure):
    generator = np.random.default_rng(3)
    inputs, target = generator.normal(size=(9, len(INPUTS))), generator.normal(size=9)
    terms = terms_of(structure)
    prior = prior_of(terms, settings().averaging.priors)
    where = prior[0] + 0.4 * generator.normal(size=len(prior[0]))
    posterior = Posterior(terms, Pairs.of(inputs, inputs), target, prior)
    slope = approx_fprime(where, lambda at: posterior.negative_log(at)[0], 1e-6)
    np.testing.assert_allclose(posterior.negative_log(where)[1], slope, rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize("structure", STRUCTURES)
def test_posterior_is_the_likelihood_of_its_kernel_times_the_prior(structure):
    """The value, which keeps parts of the covariance from call to call, against densities that know nothing of it."""
    generator = np.random.default_rng(4)
    inputs, target = generator.normal(size=(9, len(INPUTS))), generator.normal(size=9)
    terms = terms_of(structure)
    prior = prior_of(terms, settings().averaging.priors)
    posterior = Posterior(terms, Pairs.of(inputs, inputs), target, prior)
    for spread in (0.0, 0.4, 0.8):
        logs = prior[0] + spread * generator.normal(size=len(prior[0]))
        covariance = covariance_terms(logs, terms, Pairs.of(inputs, inputs))[0].sum(axis=0) + MEAN_VARIANCE
        covariance += (np.exp(logs[-1]) + JITTER) * np.eye(len(target))
        density = multivariate_normal(cov=covariance).logpdf(target) + norm(*prior).logpdf(logs).sum()
        assert posterior.negative_log(logs)[0] == pytest.approx(-density, rel=1e-9)


def test_evidence_is_the_integral_over_the_noise_where_nothing_else_is_free():
    """With length scales and the variance fixed by narrow priors, the evidence is one integral over the noise."""
    priors = settings().averaging.priors
    narrow = Priors(
        *(prior._replace(log_deviation=width) for prior, width in zip(priors, (1e-3, 1e-3, 0.4), strict=True))
    )
    generator = np.random.default_rng(0)
    inputs, terms = generator.normal(size=(30, len(INPUTS))), terms_of("product")
    target = inputs[:, 0] + 0.2 * generator.normal(size=30)
    _, evidence = fit_process(inputs, target / target.std(), terms, narrow)
    prior = prior_of(terms, narrow)
    posterior = Posterior(terms, Pairs.of(inputs, inputs), target / target.std(), prior)
    noise = prior[0][-1] + np.linspace(-3, 3, 601)
    # The integral over the narrow priors divides out their density at the mean.
    width = np.log(prior[1][:-1] * np.sqrt(2 * np.pi)).sum()
    heights = [-posterior.negative_log(np.append(prior[0][:-1], at))[0] + width for at in noise]
    exact = np.log(np.trapezoid(np.exp(np.array(heights) - max(heights)), noise)) + max(heights)
    assert evidence == pytest.approx(exact, abs=0.05)


@pytest.mark.parametrize("link", ["identity", "logit", "avrami"])
def test_the_evidence_is_that_of_the_yields_by_the_slope_of_the_whole_transformation(link):
    rows, _ = parts()
    config, yields = settings().averaging, rows["yield_percent"].to_numpy(float)
    member = fit_member(Candidate(link, SCALES, "product"), rows, yields, config)
    process, conversion = member.process, to_conversion(yields, config.margin)
    _, of_target = fit_process(process.inputs, process.target, process.terms, config.priors)
    low, high = ((LINKS[link].forward(conversion + step) - member.mean) / member.spread for step in (-1e-6, 1e-6))
    assert member.log_evidence == pytest.approx(of_target + np.log((high - low) / 2e-6).sum(), rel=1e-6)


@pytest.mark.parametrize("name", ["identity", "logit", "avrami"])
def test_links_have_their_inverse_and_their_slope(name):
    link, conversion = LINKS[name], np.array([0.02, 0.3, 0.63, 0.95])
    np.testing.assert_allclose(link.inverse(link.forward(conversion)), conversion, rtol=1e-12)
    slope = (link.forward(conversion + 1e-7) - link.forward(conversion - 1e-7)) / 2e-7
    np.testing.assert_allclose(np.exp(link.log_slope(conversion)), slope, rtol=1e-5)


def test_avrami_link_makes_kinetics_a_straight_line_in_log_time():
    time = np.array([1.0, 3.0, 10.0])
    conversion = 1 - np.exp(-((0.1 * time) ** 0.7))
    slope = np.diff(LINKS["avrami"].forward(conversion)) / np.diff(np.log(time))
    np.testing.assert_allclose(slope, 0.7)
    assert to_conversion(np.array([0.0, 50.0, 100.0]), 0.005).tolist() == [0.005, 0.5, 0.995]


def test_an_input_that_hardly_varies_is_not_scaled_up():
    raw = np.array([[1.0, 0.69], [2.0, 0.70], [3.0, 0.69]])
    standard = Standardisation.of(raw, np.array([False, False]), np.array([0.0, 0.05]))
    assert standard.deviation[0] == pytest.approx(np.std([1, 2, 3])) and standard.deviation[1] == 0.05
    logarithmic = Standardisation.of(raw, np.array([True, False]))
    np.testing.assert_allclose(logarithmic(raw)[:, 0], (np.log(raw[:, 0]) - np.log(6) / 3) / np.std(np.log([1, 2, 3])))


def test_left_out_in_closed_form_is_the_process_without_the_row():
    rows, _ = parts()
    member = fit_member(
        Candidate("identity", SCALES, "mains_product"),
        rows,
        rows["yield_percent"].to_numpy(float),
        settings().averaging,
    )
    whole = member.process
    mean, deviation = whole.left_out()
    for index in (0, 7, 20):
        kept = np.arange(len(rows)) != index
        without = Process(whole.terms, whole.logs, whole.inputs[kept], whole.target[kept])
        one, spread = without.predict(whole.inputs[[index]])
        assert one[0] == pytest.approx(mean[index], rel=1e-6) and spread[0] == pytest.approx(deviation[index], rel=1e-5)


@pytest.mark.parametrize("structure", ["product", "trend_product", "mains_product"])
def test_deviation_of_a_prediction_is_the_diagonal_of_the_posterior(structure):
    rows, _ = parts()
    member = fit_member(
        Candidate("identity", SCALES, structure), rows, rows["yield_percent"].to_numpy(float), settings().averaging
    )
    process, inputs = member.process, member.process.inputs[:6] + 0.3
    mean, covariance = process.posterior(inputs)
    one, deviation = process.predict(inputs)
    np.testing.assert_allclose(one, mean, rtol=1e-12)
    np.testing.assert_allclose(deviation**2, np.diag(covariance) + process.noise, rtol=1e-9)


def test_weights_are_posterior_probabilities():
    weights = evidence_weights(np.array([0.0, np.log(3.0), -50.0]), 0.01)
    np.testing.assert_allclose(weights, [0.25, 0.75, 0.0], rtol=1e-12)


def test_quantiles_of_one_identity_member_are_those_of_a_normal():
    rows, test = parts()
    member = fit_member(
        Candidate("identity", SCALES, "product"), rows, rows["yield_percent"].to_numpy(float), settings().averaging
    )
    model = AveragedModel([member], np.array([1.0]))
    mean, deviation = member.latent(describe(test).to_numpy())
    levels = np.array([0.1, 0.5, 0.9])
    normal = 100 * np.clip(mean[:, None] + deviation[:, None] * norm.ppf(levels), 0, 1)
    np.testing.assert_allclose(model.quantiles(test, levels), normal, atol=1e-6)
    np.testing.assert_allclose(model.predict(test), 100 * mean, rtol=1e-10)


def test_evidence_finds_the_link_and_the_time_scale_of_avrami_kinetics():
    """Yields from Avrami's law are a straight line with the avrami link and log time."""
    rows, config = all_runs(), settings().averaging
    rate = 0.05 * (rows["bpr"] / 30) ** 0.8 * (rows["specific_frequency_hz"] / 500) ** 0.5
    latent = 1.2 * np.log(rate * rows["time_h"]) + np.random.default_rng(1).normal(0, 0.05, len(rows))
    yields = (100 * LINKS["avrami"].inverse(latent)).to_numpy()
    evidence = {
        (link, time): fit_member(
            Candidate(link, ("log", "linear", time, "log", "linear"), "trend_product"), rows, yields, config
        ).log_evidence
        for link in ("avrami", "identity")
        for time in ("log", "linear")
    }
    best = evidence.pop(("avrami", "log"))
    assert best > max(evidence.values()) + 3


def test_a_second_fit_and_the_stored_model_are_the_same(tmp_path):
    (model, rows), (again, _) = fitted(), fitted()
    _, test = parts()
    for number, each in enumerate((model, again)):
        save_averaged(each, rows, settings().averaging.margin, str(tmp_path / f"{number}.json"))
    assert (tmp_path / "0.json").read_bytes() == (tmp_path / "1.json").read_bytes()
    loaded = load_any(str(tmp_path / "0.json"))
    assert isinstance(loaded, AveragedModel)
    np.testing.assert_allclose(loaded.predict(test), model.predict(test), rtol=1e-12)
    np.testing.assert_allclose(loaded.intervals(test, [0.9])[:, 0].T, model.intervals(test, [0.9])[:, 0].T, rtol=1e-9)
    assert training_rows(str(tmp_path / "0.json"))["case"].tolist() == rows["case"].tolist()
    assert model.weights.sum() == pytest.approx(1)
    assert set(read_json(tmp_path / "0.json")["versions"]) == {"numpy", "scipy"}
