"""Proper scores, paired tests and permutations of the yield models, against closed forms and simulation."""

import warnings

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm, ttest_1samp
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor

from millprint.thesis.yields.averaging import (
    AveragedModel,
    Candidate,
    closed_form_r2,
    fit_member,
    permutation_p,
    permute,
)
from millprint.thesis.yields.distributions import MixtureYields, NormalYields
from millprint.thesis.yields.estimators import LeastSquares, MarginalLikelihood, gaussian_process
from millprint.thesis.yields.evaluation import paired_test
from millprint.thesis.yields.features import Standardisation, engineer
from millprint.thesis.yields.held_out import climatology
from millprint.thesis.yields.metrics import (
    LEFT_OUT,
    NESTED,
    YieldWeights,
    bootstrap_metrics,
    jackknife_error,
    without_each,
)
from millprint.thesis.yields.yield_model import fit_model
from tests.unit.yield_settings import all_runs, parts, settings

SCALES = ("linear", "linear", "log", "log", "linear")
GPR = {"constant": 100.0, "length_scale": 1.0, "noise": 0.5}


def mixture(*links: str) -> tuple[MixtureYields, AveragedModel, np.ndarray]:
    rows, test = parts()
    config, yields = settings().averaging, rows["yield_percent"].to_numpy(float)
    members = [fit_member(Candidate(link, SCALES, "product"), rows, yields, config) for link in links]
    weights = np.full(len(links), 1 / len(links))
    found = MixtureYields.of(members, weights, test, config.margin)
    return found, AveragedModel(members, weights), test["yield_percent"].to_numpy(float)


def test_scores_of_a_normal_distribution_are_those_of_its_draws():
    generator = np.random.default_rng(0)
    truth, draws = np.array([40.0, 61.0]), generator.normal(50, 8, (2, 4000))
    crps, log_score, below = NormalYields("gaussian", np.full(2, 50.0), np.full(2, 8.0)).scores(truth)
    # CRPS = E|X - y| - E|X - X'| / 2.
    expected = np.abs(draws - truth[:, None]).mean(axis=1) - np.abs(draws[:, :2000] - draws[:, 2000:]).mean(axis=1) / 2
    np.testing.assert_allclose(crps, expected, rtol=0.05)
    np.testing.assert_allclose(log_score, -np.log(norm.pdf(truth, 50, 8)))
    np.testing.assert_allclose(below, norm.cdf(truth, 50, 8))


def test_a_mixture_of_one_identity_member_has_the_scores_of_a_normal():
    found, _, truth = mixture("identity")
    (mean, deviation), *_ = found.latent
    for own, normal in zip(
        found.scores(truth), NormalYields("gaussian", 100 * mean, 100 * deviation).scores(truth), strict=True
    ):
        np.testing.assert_allclose(own, normal, rtol=1e-6, atol=1e-9)


def test_scores_of_a_mixture_are_those_of_its_draws():
    found, model, truth = mixture("logit", "avrami")
    generator = np.random.default_rng(1)
    _, test = parts()
    draws = model.quantiles(test, generator.uniform(size=3000))
    crps, log_score, below = found.scores(truth)
    expected = np.abs(draws - truth[:, None]).mean(axis=1) - np.abs(draws[:, :1500] - draws[:, 1500:]).mean(axis=1) / 2
    np.testing.assert_allclose(crps, expected, rtol=0.1, atol=0.2)
    np.testing.assert_allclose(below, (draws <= truth[:, None]).mean(axis=1), atol=0.03)
    # The density is the slope of the distribution function.
    step = 1e-4
    slope = (found.below((truth[:, None] + step) / 100) - found.below((truth[:, None] - step) / 100))[:, 0] / (2 * step)
    np.testing.assert_allclose(np.exp(-log_score), slope, rtol=1e-3)


def test_climatology_is_the_distribution_of_the_training_yields():
    rows, test = parts()
    yields = rows["yield_percent"].to_numpy(float)
    answer = climatology(rows, yields, test, [0.8])
    assert answer.predicted == pytest.approx(yields.mean())
    half = norm.ppf(0.9) * yields.std(ddof=1) * np.sqrt(1 + 1 / len(yields))
    assert answer.intervals["errors"][0, 0].tolist() == pytest.approx(
        [max(yields.mean() - half, 0), min(yields.mean() + half, 100)]
    )


def test_the_process_is_that_of_scikit_learn():
    rows = all_runs()
    inputs, target = engineer(rows).to_numpy(), rows["yield_percent"].to_numpy(float)
    inputs = Standardisation.of(inputs)(inputs)
    for shape in ("per_feature", "shared"):
        own = gaussian_process(GPR, 10, settings(length_scales=shape).training).fit(inputs[:20], target[:20])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)
            plain = GaussianProcessRegressor(own.kernel).fit(inputs[:20], target[:20])
        np.testing.assert_allclose(own.predict(inputs), plain.predict(inputs), rtol=1e-3, atol=1e-3)
        np.testing.assert_allclose(own.deviation(inputs), plain.predict(inputs, return_std=True)[1], rtol=1e-3)
        likelihood = MarginalLikelihood.of(inputs[:20], target[:20], shared=shape == "shared")
        value, slope = likelihood.negative_log(own.logs + 0.2)
        known, known_slope = plain.log_marginal_likelihood(own.logs + 0.2, True)
        assert value == pytest.approx(-known, rel=1e-9)
        np.testing.assert_allclose(slope, -known_slope, rtol=1e-9, atol=1e-9)


def test_the_line_has_the_error_of_the_closed_form():
    time = np.array([5.0, 5.0, 12.5, 12.5, 20.0, 20.0])
    target = 3 * time + np.array([1.0, -1.0, 2.0, -2.0, 0.5, -0.5])
    line = LeastSquares().fit(time[:, None], target)
    spread = ((target - line.predict(time[:, None])) ** 2).sum() / 4
    expected = np.sqrt(spread * (1 / 6 + (30 - time.mean()) ** 2 / ((time - time.mean()) ** 2).sum()))
    assert line.mean_deviation(np.array([[30.0]]))[0] == pytest.approx(expected)


@pytest.mark.parametrize("first", ["same", "linear"])
def test_the_variance_of_the_first_step_enters_the_intervals(first):
    rows, test = parts()
    training = settings(time_model=first).training
    steps = [GPR if first == "same" else {}, GPR]
    model = fit_model("gpr", "two_step", steps, rows, rows["yield_percent"].to_numpy(float), training)
    far = test.assign(time_h=60.0)
    last, features = model.steps[-1], engineer(far)
    second = last.estimator.deviation(last.inputs(features))
    time = model.steps[0]
    if first == "same":
        own = time.estimator.deviation(time.inputs(features)) ** 2 - np.exp(time.estimator.logs[-1])
    else:
        own = time.estimator.mean_deviation(time.inputs(features)) ** 2
    np.testing.assert_allclose(model.deviation(far) ** 2, second**2 + own)
    # Far beyond the measured times, the first step knows less than within them.
    assert (model.deviation(far) > second * 1.05).all()


def test_jackknife_error_of_a_mean_is_its_standard_error():
    values = np.random.default_rng(2).normal(size=27)
    assert jackknife_error(values[without_each(27)].mean(axis=1)) == pytest.approx(values.std(ddof=1) / np.sqrt(27))
    truth = np.linspace(10, 90, 27)
    table = bootstrap_metrics(truth, truth + np.abs(values), YieldWeights(70, 2.0), 20, 0.95, 0).set_index("metric")
    assert table.loc["mae", "error"] == pytest.approx(np.abs(values).std(ddof=1) / np.sqrt(27))


def pair(seed: int, shift: float, repeats: int, folds: int) -> list[pd.DataFrame]:
    """Two models whose errors differ by chance, or by `shift`, on 25 runs."""
    generator = np.random.default_rng(seed)
    truth = generator.uniform(0, 100, 25)
    errors = generator.normal(0, 10, (2, 25)) + np.array([[0.0], [shift]])
    tables = []
    for error in errors:
        parts = []
        for repeat in range(repeats):
            order = np.random.default_rng(repeat).permutation(25)
            about = {"repeat": repeat, "fold": np.argsort(order) % folds, "case": np.arange(25)}
            parts.append(
                pd.DataFrame({**about, "yield_percent": truth, "predicted_percent": truth + error, "crps_pp": 1})
            )
        tables.append(pd.concat(parts))
    return tables


@pytest.mark.slow
@pytest.mark.parametrize(("scheme", "repeats", "folds"), [(LEFT_OUT, 1, 25), (NESTED, 4, 5)])
def test_paired_tests_reject_equal_models_rarely_and_different_ones_often(scheme, repeats, folds):
    # That models differ is seen nearly always, and so by fewer pairs.
    tests = {
        shift: [paired_test(*pair(seed, shift, repeats, folds), scheme, "r2") for seed in range(pairs)]
        for shift, pairs in {0.0: 150, 20.0: 40}.items()
    }
    rejected = {shift: np.mean([each["p"] < 0.05 for each in found]) for shift, found in tests.items()}
    assert rejected[0.0] < 0.1 and rejected[20.0] > 0.8
    # The second model is worse, so the first minus the second is above zero.
    assert np.mean([each["difference"] for each in tests[20.0]]) > 0


def test_paired_test_of_left_out_crps_is_the_paired_t_test():
    one, other = pair(3, 5.0, 1, 25)
    gaps = np.random.default_rng(0).normal(0.5, 1, 25)
    found = paired_test(one.assign(crps_pp=2 + gaps), other.assign(crps_pp=2.0), LEFT_OUT, "crps_pp")
    known = ttest_1samp(gaps, 0)
    assert (found["statistic"], found["p"]) == pytest.approx((known.statistic, known.pvalue))


def test_corrected_test_of_folds_is_the_formula_of_its_source():
    one, other = pair(5, 4.0, 2, 5)
    found = paired_test(one, other, NESTED, "r2")
    merged = one.merge(other, on=["repeat", "fold", "case"])
    merged["gap"] = (merged["yield_percent_x"] - merged["predicted_percent_y"]) ** 2
    merged["gap"] -= (merged["yield_percent_x"] - merged["predicted_percent_x"]) ** 2
    folds = merged.groupby(["repeat", "fold"])["gap"].mean() / one["yield_percent"].head(25).var(ddof=0)
    statistic = folds.mean() / np.sqrt((1 / 10 + 5 / 20) * folds.var(ddof=1))
    assert found["statistic"] == pytest.approx(statistic) and found["degrees"] == 9
    repeats = folds.groupby("repeat").mean()
    assert found["repeats"] == 2 and found["median"] == pytest.approx(found["difference"])
    assert (found["lowest"], found["highest"]) == pytest.approx((repeats.min(), repeats.max()))


@pytest.mark.slow
def test_a_permutation_test_tells_a_relation_from_none():
    config = settings()
    rows, trial = all_runs(), config.library_trial
    found = permutation_p(permute(rows, config.averaging, trial)).iloc[0]
    assert found["p"] == 1 / 20 and found["measured"] > 0.6
    noise = rows.assign(yield_percent=np.random.default_rng(4).permutation(rows["yield_percent"].to_numpy()))
    assert permutation_p(permute(noise, config.averaging, trial)).iloc[0]["p"] > 0.05
    yields = rows["yield_percent"].to_numpy(float)
    assert closed_form_r2(rows, yields, config.averaging) == pytest.approx(found["measured"])
