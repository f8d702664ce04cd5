"""Metrics, held-out predictions, proper scores, paired tests and permutations, against closed forms."""

import warnings
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import statsmodels.formula.api as smf
from scipy.special import expit, logit
from scipy.stats import norm, ttest_1samp
from scipy.stats import t as student
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

from millprint.estimate.gaussian_process import Likelihood
from millprint.thesis.yields import averaging
from millprint.thesis.yields.averaging import (
    AveragedModel,
    Candidate,
    closed_form_r2,
    permutation_p,
    permute,
)
from millprint.thesis.yields.estimators import JITTER, gaussian_process
from millprint.thesis.yields.evaluation import (
    coverage_table,
    paired_test,
    pit_histogram,
    score_distributions,
    score_table,
    time_variance,
)
from millprint.thesis.yields.features import (
    LEFT_OUT,
    LOCKED_AGAIN,
    NESTED,
    RANDOM,
    SPREAD,
    Standardisation,
    YieldWeights,
    bootstrap_metrics,
    engineer,
    jackknife_error,
    metrics,
    weighted_mse,
    without_each,
)
from millprint.thesis.yields.held_out import (
    MixtureYields,
    NormalYields,
    climatology,
    cross_intervals,
    cross_validate,
    outer_folds,
    predict_held_out,
    procedure_of,
)
from millprint.thesis.yields.yield_model import fit_model
from tests.unit.yield_settings import SCALES, all_runs, fit_member, parts, settings

WEIGH = YieldWeights(70, 2.0)


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


def test_bootstrap_interval_of_the_mae_is_that_of_a_mean():
    generator = np.random.default_rng(1)
    truth = generator.uniform(20, 90, 400)
    error = generator.exponential(5.0, 400)
    table = bootstrap_metrics(truth, truth + error, WEIGH, 4000, 0.95, seed=3).set_index("metric")
    row = table.loc["mae"]
    half = 1.96 * error.std() / np.sqrt(400)
    assert row["value"] == pytest.approx(error.mean())
    assert row["upper"] - row["lower"] == pytest.approx(2 * half, rel=0.04)
    assert row["lower"] < row["value"] - 0.9 * half and row["value"] + 0.9 * half < row["upper"]
    assert row["error"] == pytest.approx(error.std(ddof=1) / np.sqrt(400))


def test_time_explains_what_its_levels_explain():
    time = np.repeat([5.0, 12.5, 20.0], 2)
    yields = np.array([10.0, 20.0, 50.0, 60.0, 10.0, 20.0])
    share = time_variance(time, yields).set_index("measure")["share"]
    between = 2 * (15 - 85 / 3) ** 2 * 2 + 2 * (55 - 85 / 3) ** 2
    assert share["levels"] == pytest.approx(between / (between + 6 * 25))
    assert share["line"] == pytest.approx(0, abs=1e-12)


def runs() -> pd.DataFrame:
    train, test = parts()
    return pd.concat([train.assign(role="train"), test.assign(role="test")], ignore_index=True)


def procedure(model: str, strategy: str):
    config = settings()
    return procedure_of(model, strategy, config.training, config.evaluation, config.averaging)


def test_outer_folds_hold_out_the_rows_of_their_scheme():
    rows, budget = runs(), settings().evaluation
    folds = outer_folds(rows, budget)
    for fold in folds:
        assert sorted([*fold.kept, *fold.held]) == list(range(27))
    by_scheme = {
        scheme: [fold for fold in folds if fold.scheme == scheme] for scheme in {fold.scheme for fold in folds}
    }
    assert [fold.held.tolist() for fold in by_scheme[LEFT_OUT]] == budget.orders * [[index] for index in range(27)]
    in_order, shuffled = (by_scheme[LEFT_OUT][27 * repeat].kept.tolist() for repeat in range(2))
    assert in_order == list(range(1, 27)) and shuffled != in_order
    assert rows["case"].iloc[by_scheme[LOCKED_AGAIN][0].held].tolist() == ["9", "14", "10", "22", "1", "12"]
    for repeat in range(budget.outer_repeats):
        parts = [fold for fold in by_scheme[NESTED] if fold.repeat == repeat]
        assert sorted(np.concatenate([fold.held for fold in parts])) == list(range(27))
        assert [fold.number for fold in parts] == list(range(budget.outer_folds))
    assert all(len(fold.held) == 6 for fold in by_scheme[RANDOM])
    yields = rows["yield_percent"].to_numpy()
    assert all(np.array_equal(fold.yields, yields) for fold in folds)


@pytest.mark.parametrize(("model", "strategy"), [("averaged_gpr", "primary"), ("gpr", "two_step"), ("xgb", "primary")])
@pytest.mark.slow
def test_a_held_out_prediction_does_not_depend_on_the_yield_of_its_run(model, strategy):
    rows, budget = runs().head(9).assign(role=["train"] * 7 + ["test"] * 2), settings().evaluation
    wrong = rows.copy()
    wrong.loc[3, "yield_percent"] = 99.0
    tables = []
    for table in (rows, wrong):
        folds = [fold for fold in outer_folds(table, budget) if fold.scheme == LEFT_OUT][2:4]
        tables.append(predict_held_out(procedure(model, strategy), table, folds, [0.8]))
    (clean, ends), (other, other_ends) = tables
    assert clean["predicted_percent"][1] == other["predicted_percent"][1]
    assert clean["predicted_percent"][0] != other["predicted_percent"][0]
    own = ends["case"] == rows["case"][3]
    # CV+ is for models without a distribution of their own.
    assert set(ends["method"]) == {{"averaged_gpr": "mixture", "gpr": "gaussian", "xgb": "cv_plus"}[model]}
    bounds = ["lower_percent", "upper_percent"]
    assert own.any() and ends.loc[own, bounds].equals(other_ends.loc[own, bounds])


def test_cross_intervals_are_the_order_statistics_of_the_paper():
    residuals = np.array([1.0, 2.0, 3.0, 4.0])
    centres = np.full((4, 1), 50.0)
    # a (n + 1) = 0.4 * 5 = 2 and 0.6 * 5 = 3: the second smallest lower, the third smallest upper candidate.
    assert cross_intervals(centres, residuals, [0.6])[0, 0].tolist() == [47.0, 53.0]
    # a (n + 1) = 1 and 0.8 * 5 = 4: the smallest and the largest.
    assert cross_intervals(centres, residuals, [0.8])[0, 0].tolist() == [46.0, 54.0]
    # Four rows are too few for 95 %: the interval is all possible yields.
    assert cross_intervals(centres, residuals, [0.95])[0, 0].tolist() == [0.0, 100.0]


def test_cross_validation_predicts_each_row_by_models_without_it():
    rows, yields = pd.DataFrame({"x": range(6)}), np.arange(6.0) ** 2

    def fit(kept, known):
        return lambda unseen: np.full(len(unseen), known.mean())

    centres, residuals = cross_validate(fit, rows, yields, rows.head(1), 6, seed=0)
    others = (yields.sum() - yields) / 5
    np.testing.assert_allclose(centres[:, 0], others)
    np.testing.assert_allclose(residuals, np.abs(yields - others))


def held_out(scheme: str, repeats: int, error: float) -> pd.DataFrame:
    truth, signs = np.array([20.0, 40.0, 60.0, 80.0]), np.array([1, -1, 1, -1])
    own = pd.DataFrame({"case": list("abcd"), "yield_percent": truth, "model": "m", "strategy": "primary"})
    tables = [own.assign(repeat=k, predicted_percent=truth + error * (1 + k) * signs) for k in range(repeats)]
    return pd.concat(tables).assign(scheme=scheme)


def test_nested_metrics_are_averaged_over_repeats_and_random_ones_are_a_population():
    budget = settings().evaluation
    table = pd.concat([held_out(NESTED, 3, 2.0), held_out(RANDOM, 3, 2.0)])
    found = score_table(table, WEIGH, budget).set_index(["scheme", "metric"])
    assert found.loc[(NESTED, "mae"), "value"] == pytest.approx((2 + 4 + 6) / 3)
    # Every case has the same error, so resampling cases changes nothing.
    assert found.loc[(NESTED, "mae"), "lower"] == pytest.approx(4) == found.loc[(NESTED, "mae"), "upper"]
    for scheme in (NESTED, RANDOM):
        assert found.loc[(scheme, "mae"), [*SPREAD]].tolist() == pytest.approx([3, 2, 4, 6])
    assert found.loc[(RANDOM, "mae"), "value"] == pytest.approx(4)
    assert found.loc[(RANDOM, "mae"), "lower"] < 2.2 and found.loc[(RANDOM, "mae"), "upper"] > 5.8


def test_coverage_counts_cases_and_not_repeats():
    table = held_out(NESTED, 5, 1.0).assign(method="cv_plus", nominal=0.8)
    table["lower_percent"], table["upper_percent"] = table["yield_percent"] - 1, table["yield_percent"] + 1
    table.loc[table["case"] == "a", "upper_percent"] = 10.0
    row = coverage_table(table, 0.95).iloc[0]
    assert row["covered"] == 0.75 and row["cases"] == 4
    # Three of width 2, and one from 19 to 10.
    assert row["width_pp"] == pytest.approx(-0.75)
    assert row[[*SPREAD]].tolist() == [5, 0.75, 0.75, 0.75]
    assert row["lower"] == pytest.approx(0.194, abs=1e-3) and row["upper"] == pytest.approx(0.994, abs=1e-3)


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
    answer, mean = climatology(rows, yields, test, [0.8]), yields.mean()
    assert answer.predicted == pytest.approx(mean)
    half = norm.ppf(0.9) * yields.std(ddof=1) * np.sqrt(1 + 1 / len(yields))
    assert answer.intervals["errors"][0, 0].tolist() == pytest.approx([max(mean - half, 0), min(mean + half, 100)])


def test_the_response_surface_is_that_of_statsmodels():
    rows, test = parts()
    answer = procedure("response_surface", "primary")(rows, rows["yield_percent"].to_numpy(float), test, [0.8])
    plain = smf.ols(
        "z ~ bpr * molar_ratio + I(molar_ratio**2) + np.log(time_h)", rows.assign(z=logit(rows["yield_percent"] / 100))
    )
    frame = plain.fit().get_prediction(test).summary_frame(alpha=0.2)
    ends = frame[["obs_ci_lower", "obs_ci_upper"]].to_numpy()
    np.testing.assert_allclose(answer.intervals["logit"][:, 0], 100 * expit(ends), rtol=1e-8)
    # The mean over the distribution of the logit, drawn.
    draws = np.random.default_rng(0).normal(size=200_000)
    deviation = (ends[:, 1] - frame["mean"]) / student.ppf(0.9, plain.df_resid)
    drawn = [100 * expit(mean + s * draws).mean() for mean, s in zip(frame["mean"], deviation, strict=True)]
    np.testing.assert_allclose(answer.predicted, drawn, rtol=5e-3)


def test_leave_one_out_in_several_orders_counts_runs_once():
    one, other = (held_out(LEFT_OUT, 3, error).assign(fold=0, crps_pp=1.0) for error in (2.0, 3.0))
    single = [table[table["repeat"] == 1] for table in (one, other)]
    several, middle = paired_test(one, other, LEFT_OUT, "r2"), paired_test(*single, LEFT_OUT, "r2")
    assert several["degrees"] == middle["degrees"] == 3 and several["repeats"] == 3
    # Squared errors are (1 + k)^2 (9 - 4) over the variance 500: their mean over k is that of 1, 4 and 9.
    assert several["difference"] == pytest.approx(5 * 14 / 3 / 500) and middle["difference"] == pytest.approx(
        5 * 4 / 500
    )
    # Without the first or the last run, the yields have a variance of 800/3, without another one of 5600/9.
    assert several["error"] == pytest.approx(3**0.5 / 2 * 70 / 3 * (3 / 800 - 9 / 5600))


def test_scores_of_distributions_are_by_hand():
    rows = [(0, "a", 1, 3, 0.1), (1, "a", 3, 3, 0.1), (0, "b", 5, 4, 0.95), (1, "b", 5, 2, 0.3)]
    model = pd.DataFrame(rows, columns=["repeat", "case", "crps_pp", "log_score", "pit"])
    none = model.assign(crps_pp=[4, 6, 7, 9], log_score=5, model="climatology")
    table = pd.concat([model.assign(model="gpr"), none]).assign(strategy="primary", scheme=NESTED, distribution="d")
    own = score_distributions(table).query("model == 'gpr'").set_index("score")
    # Cases of 2 and 5, repeats of 3 and 4, where climatology has 6.5; then cases of 3, where it has 5.
    columns = ["value", "error", "skill", *SPREAD]
    assert own.loc["crps_pp", columns].tolist() == pytest.approx([3.5, 1.5, 1 - 3.5 / 6.5, 2, 3, 3.5, 4])
    assert own.loc["log_score", columns].tolist() == pytest.approx([3, 0, 2, 2, 2.5, 3, 3.5])
    bins = pit_histogram(table).query("model == 'gpr'")
    assert bins[["from", "to"]].to_numpy() == pytest.approx(np.column_stack([np.arange(5), np.arange(1, 6)]) / 5)
    assert bins["share"].tolist() == [0.5, 0.25, 0, 0, 0.25] and bins["highest"].tolist() == [0.5, 0.5, 0, 0, 0.5]
    assert set(bins["expected"]) == {0.2}


def test_the_process_is_that_of_scikit_learn():
    rows = all_runs()
    inputs, target = engineer(rows).to_numpy(), rows["yield_percent"].to_numpy(float)
    inputs = Standardisation.of(inputs)(inputs)
    for shape in ("per_feature", "shared"):
        own = gaussian_process(GPR, 10, settings(length_scales=shape).training)
        (constant, *lengths, noise), bounds = np.exp(own.starts[0]), tuple(np.exp(own.bounds[0]))
        kernel = ConstantKernel(constant, bounds) * Matern(np.array(lengths), bounds, nu=1.5)
        kernel += WhiteKernel(noise, bounds)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)
            plain = GaussianProcessRegressor(kernel).fit(inputs[:20], target[:20])
        own.fit(inputs[:20], target[:20])
        # Long length scales are hardly determined; the height of the maximum is.
        highest = plain.log_marginal_likelihood_value_
        assert plain.log_marginal_likelihood(own.logs) == pytest.approx(highest, abs=1e-4)
        np.testing.assert_allclose(own.predict(inputs), plain.predict(inputs), rtol=1e-3, atol=1e-3)
        np.testing.assert_allclose(own.deviation(inputs), plain.predict(inputs, return_std=True)[1], rtol=1e-3)
        value, slope = Likelihood(own.kernel(inputs), inputs[:20], target[:20], JITTER).negative_log(own.logs + 0.2)
        known, known_slope = plain.log_marginal_likelihood(own.logs + 0.2, True)
        assert value == pytest.approx(-known, rel=1e-9)
        np.testing.assert_allclose(slope, -known_slope, rtol=1e-9, atol=1e-9)


def test_the_variance_of_the_first_step_enters_the_intervals():
    rows, test = parts()
    training = settings().training
    model = fit_model("gpr", "two_step", [GPR, GPR], rows, rows["yield_percent"].to_numpy(float), training)
    far = test.assign(time_h=60.0)
    last, features = model.steps[-1], engineer(far)
    second = last.estimator.deviation(last.inputs(features))
    time = model.steps[0]
    own = time.estimator.deviation(time.inputs(features)) ** 2 - np.exp(time.estimator.logs[-1])
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
    """Two models whose errors differ by chance, and by `shift`, on 25 runs."""
    generator = np.random.default_rng(seed)
    truth, errors = generator.uniform(0, 100, 25), generator.normal(0, 10, (2, 25)) + np.array([[0.0], [shift]])
    places = [np.argsort(np.random.default_rng(repeat).permutation(25)) % folds for repeat in range(repeats)]
    own = [pd.DataFrame({"case": range(25), "yield_percent": truth, "predicted_percent": truth + e}) for e in errors]
    return [pd.concat([one.assign(repeat=k, fold=place, crps_pp=1) for k, place in enumerate(places)]) for one in own]


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


def test_r2_of_the_average_left_out_is_by_hand(monkeypatch):
    members = [SimpleNamespace(left_out=lambda: np.array([0.2, 0.4])), SimpleNamespace(left_out=lambda: np.zeros(2))]
    monkeypatch.setattr(averaging, "fit_library", lambda *given: members)
    monkeypatch.setattr(
        averaging, "average", lambda found, given: SimpleNamespace(members=found, weights=np.array([0.75, 0.25]))
    )
    # Predicted 15 and 30 %: squares 25 + 100 over 10^2 + 10^2.
    assert closed_form_r2(None, np.array([20.0, 40.0]), None) == pytest.approx(1 - 125 / 200)


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
