"""The split, the regressors: printed rows, identities, stored files; and predictions of new conditions."""

import json

import numpy as np
import pandas as pd
import pytest
from scipy.stats import multivariate_normal
from sklearn.ensemble import RandomForestRegressor
from sklearn.gaussian_process.kernels import Matern
from sklearn.model_selection import train_test_split
from xgboost import XGBRegressor

from millprint.config.errors import ConfigError
from millprint.config.yields import SPACES, TRAININGS
from millprint.run.files import read_json
from millprint.thesis.claims.evidence import agrees
from millprint.thesis.yields.averaging import fit_averaged
from millprint.thesis.yields.estimators import (
    BinnedRows,
    Boosting,
    Forest,
    ForestFold,
    GaussianProcess,
    Trees,
    gaussian_process,
)
from millprint.thesis.yields.evaluation import shap_values
from millprint.thesis.yields.experiments import read_rows, read_split
from millprint.thesis.yields.features import FEATURES, METRICS, Standardisation, YieldWeights, engineer, metrics
from millprint.thesis.yields.new_conditions import MillCurves, predict_conditions
from millprint.thesis.yields.regressors import REGRESSORS, models_of, regressor
from millprint.thesis.yields.stored_models import load_any, load_model, save_averaged, save_model
from millprint.thesis.yields.yield_model import DRAWN_AT_RANDOM, Trainer, draw, fit_model, minimise
from tests.conftest import PRINTED
from tests.unit.yield_settings import SPLIT, parts, settings


def test_split_is_the_locked_one():
    split = read_split(str(SPLIT))
    known, drawn = train_test_split(np.arange(27), test_size=0.2, random_state=42)
    assert split["case"].astype(int).tolist() == [*(drawn + 1), *(known + 1)]
    assert split["role"].tolist() == ["test"] * 6 + ["train"] * 21
    train, test = parts()
    assert test["case"].tolist() == ["9", "14", "10", "22", "1", "12"]
    assert test["yield_percent"].tolist() == [73, 71, 26, 31, 12, 42]
    assert len(train) == 21 and not set(train["case"]) & set(test["case"])


def test_features_are_those_of_the_thesis():
    rows, _ = parts()
    features = engineer(rows)
    assert list(features) == list(FEATURES) and len(FEATURES) == 10
    np.testing.assert_array_equal(features["molar_ratio_squared"], rows["molar_ratio"] ** 2)
    np.testing.assert_array_equal(features["bpr_molar_ratio"], rows["bpr"] * rows["molar_ratio"])
    for name, column in (("time_sigmoid", "time_h"), ("bpr_sigmoid", "bpr")):
        np.testing.assert_allclose(features[name], 1 / (1 + np.exp(-rows[column].to_numpy(float))), rtol=1e-14)


WEIGH = YieldWeights(70, 2.0)

START = {"constant": 100.0, "length_scale": 2.0, "noise": 0.5}


def trained(model: str, strategy: str):
    rows, _ = parts()
    config = settings()
    return Trainer(config.training, config.search).train(model, strategy, rows, rows["yield_percent"].to_numpy())


def refitted(model: str, strategy: str, parameters: list, **choices):
    rows, _ = parts()
    return fit_model(model, strategy, parameters, rows, rows["yield_percent"].to_numpy(), settings(**choices).training)


def has_printed_row(model, name: str) -> bool:
    _, test = parts()
    found = metrics(test["yield_percent"].to_numpy(float), model.predict(test), WEIGH)
    return all(agrees(PRINTED[f"5.{name}.{metric}"], "printed", float(found[metric])) for metric in METRICS)


def test_linear_has_every_printed_digit():
    model, results = trained("linear", "primary")
    assert has_printed_row(model, "linear")
    assert results[0].evaluations == 0


def test_two_step_gpr_has_every_printed_digit_from_a_plain_start():
    model = refitted("gpr", "two_step", [START, START])
    assert has_printed_row(model, "gpr.two_step")
    outside = model.predict(read_rows(settings().out_of_domain))
    for case, predicted in zip((27, 28), outside[:2], strict=True):
        assert agrees(PRINTED[f"5.ood.{case}.gpr"], "printed", float(predicted))


def test_interval_of_gpr_is_that_of_a_normal_and_others_have_none():
    _, test = parts()
    model = refitted("gpr", "two_step", [START, START])
    lower, upper = model.intervals(test, [0.95])[:, 0].T
    np.testing.assert_allclose((lower + upper) / 2, model.predict(test), rtol=1e-12)
    np.testing.assert_allclose((upper - lower) / 2, 1.959964 * model.deviation(test), rtol=1e-6)
    assert np.isnan(refitted("linear", "primary", [{}]).intervals(test, [0.95])[:, 0].T).all()


@pytest.mark.parametrize("name", [name for name, own in TRAININGS.items() if own.two_step])
def test_yields_that_do_not_differ_leave_nothing_to_the_second_step(name):
    """The first step is their value, so the second is fitted on zeros and not on the yields."""
    rows, test = parts()
    model, _ = Trainer(settings().training, settings().search).train(name, "two_step", rows, np.full(len(rows), 50.0))
    first, second = model.steps
    assert first.plan.features == ("time_h",) and set(second.plan.features) == set(FEATURES) - {"time_h"}
    # Support vectors leave each step within the tube, half as wide as 1 pp at most.
    np.testing.assert_allclose(second.predict(engineer(test)), 0, atol=1.0)
    np.testing.assert_allclose(model.predict(test), 50, atol=2.0)


def test_standardisation_uses_the_training_rows_alone():
    rows, test = parts()
    model = refitted("linear", "primary", [{}])
    step = model.steps[0]
    np.testing.assert_allclose(step.standard.mean, rows[["bpr", "molar_ratio", "time_h"]].mean())
    np.testing.assert_allclose(step.inputs(engineer(rows)).std(axis=0), 1)
    assert abs(step.inputs(engineer(test)).mean(axis=0)).max() > 0.05
    assert Standardisation.of(np.array([[1.0], [1.0]]))(np.array([[3.0]])).tolist() == [[2.0]]
    # The deviation of seven times 0.1 is 1e-17, which must not count as variation.
    assert Standardisation.of(np.full((7, 1), 0.1)).deviation.tolist() == [1.0]
    trees = refitted("rf", "primary", [{"n_estimators": 2, "max_depth": 3}])
    np.testing.assert_array_equal(trees.steps[0].inputs(engineer(test)), engineer(test).to_numpy())


@pytest.mark.parametrize(("depth", "split", "leaf"), [(4, 2, 1), (30, 2, 1), (9, 3, 4), (2, 20, 1)])
def test_shared_trees_are_scikit_learns_forest(depth, split, leaf):
    rows, test = parts()
    inputs, target = engineer(rows).to_numpy(), rows["yield_percent"].to_numpy(float)
    unseen = engineer(test).to_numpy()
    trees = Trees(inputs, target, seed=42, count=12)
    asked, fresh = ForestFold(trees, unseen), ForestFold(trees, unseen)
    # What it was asked for before does not matter.
    for other in (1, 30, 3, 8):
        asked.predict(5, other, split, leaf)
    limits = {"min_samples_split": split, "min_samples_leaf": leaf}
    plain = RandomForestRegressor(7, max_depth=depth, random_state=42, **limits).fit(inputs, target)
    own = Forest(7, depth, split, leaf, seed=42).fit(inputs, target)
    folds = (fold.predict(7, depth, split, leaf) for fold in (asked, fresh))
    for predicted in (*folds, own.predict(unseen)):
        np.testing.assert_allclose(predicted, plain.predict(unseen), rtol=1e-13)


def test_boosting_is_xgboost_bit_for_bit():
    rows, test = parts()
    inputs, target, unseen = engineer(rows).to_numpy(), rows["yield_percent"].to_numpy(float), engineer(test).to_numpy()
    for share, trees in ((0.7, 30), (1.0, 5)):
        shape = {"n_estimators": trees, "subsample": share, "colsample_bytree": share}
        shape |= {"learning_rate": 0.1, "gamma": 1.0, "random_state": 42, "n_jobs": 1}
        plain, rows_in_bins = XGBRegressor(**shape).fit(inputs, target), BinnedRows(inputs, target, nthread=1)
        for fitted in (
            *(Boosting(**shape).learn(rows_in_bins) for _ in range(2)),
            Boosting(**shape).fit(inputs, target),
        ):
            np.testing.assert_array_equal(fitted.predict(unseen), plain.predict(unseen))


# Whether SHAP values can be calculated, by regressor.
EXPLAINED = {name: record.explain is not None for name, record in REGRESSORS.items()}

EVERY_MODEL = models_of(list(REGRESSORS))


@pytest.mark.parametrize(("name", "strategy"), EVERY_MODEL)
@pytest.mark.slow
def test_a_second_training_and_the_stored_model_predict_the_same(tmp_path, name, strategy):
    rows, test = parts()
    (model, results), (again, results_again) = trained(name, strategy), trained(name, strategy)
    assert [best.parameters for best in results] == [best.parameters for best in results_again]
    assert np.array_equal(model.predict(test), again.predict(test))
    config = settings()
    for number, each in enumerate((model, again)):
        save_model(each, results, rows, config.training, str(tmp_path / f"{number}.json"))
    assert (tmp_path / "0.json").read_bytes() == (tmp_path / "1.json").read_bytes()
    loaded = load_model(str(tmp_path / "0.json"))
    np.testing.assert_allclose(loaded.predict(test), model.predict(test), rtol=1e-9)
    np.testing.assert_allclose(loaded.deviation(test), model.deviation(test), rtol=1e-6)
    assert np.isfinite(model.deviation(test)).all() == (model.distribution is not None)
    assert (model.distribution is not None) == (regressor(name).deviation is not None)
    tuned = sum(step["search"]["evaluations"] for step in read_json(tmp_path / "0.json")["steps"] if step["search"])
    assert tuned == Trainer(config.training, config.search).evaluations(name, strategy)


@pytest.mark.parametrize("name", REGRESSORS)
def test_found_hyperparameters_lie_between_their_bounds(name):
    _, (best,) = trained(name, "primary")
    bounds, space = settings().training.spaces.get(name, {}), SPACES.get(name, {})
    assert set(best.parameters) == set(space) == set(bounds)
    for key, value in best.parameters.items():
        low, high = bounds[key]
        assert low <= value <= high and isinstance(value, int) == (space[key].how == "whole")


def test_a_small_search_evaluates_what_hyperopt_evaluates():
    for name, space in SPACES.items():
        bounds = {key: [drawn.low, drawn.high] for key, drawn in space.items()}
        asked: list[dict] = []

        def loss(parameters, asked=asked):
            asked.append(parameters)
            return float(np.sin(sum(map(hash, parameters.values())) % 1000))

        best = minimise(loss, name, bounds, DRAWN_AT_RANDOM, seed=3)
        assert asked == draw(name, json.dumps(bounds), DRAWN_AT_RANDOM, 3) and best.parameters in asked
    # One more set is not drawn at random.
    count = DRAWN_AT_RANDOM + 1
    more: list[list[dict]] = [[], []]
    for sets, sign in zip(more, (1, -1), strict=True):
        minimise(
            lambda one, s=sets, k=sign: s.append(one) or k * one["C"],
            "svr",
            settings().training.spaces["svr"],
            count,
            3,
        )
    assert more[0][:-1] == more[1][:-1] and more[0][-1] != more[1][-1]


@pytest.mark.parametrize("name", [name for name in REGRESSORS if EXPLAINED[name]])
@pytest.mark.slow
def test_shap_values_add_up_to_the_prediction(name):
    _, test = parts()
    model, _ = trained(name, "two_step")
    table = shap_values(model, test)
    by_case = table.groupby("case", sort=False)
    sums = by_case["shap_pp"].sum() + by_case["base_percent"].first()
    np.testing.assert_allclose(sums.loc[test["case"]], model.predict(test), atol=1e-3)
    time = table[table["feature"] == "time_h"].set_index("case")
    np.testing.assert_array_equal(time.loc[test["case"], "feature_value"], test["time_h"])


def test_several_starts_reach_the_largest_marginal_likelihood_of_any_of_them():
    rows, _ = parts()
    training = settings().training.model_copy(update={"kernel_starts": 8})
    inputs, target = rows[["bpr", "molar_ratio", "time_h"]].to_numpy(float), rows["yield_percent"].to_numpy(float)
    inputs = (inputs - inputs.mean(axis=0)) / inputs.std(axis=0)
    many = gaussian_process({}, 3, training)
    assert len(many.starts) == training.kernel_starts
    alone = [GaussianProcess(start[None]).fit(inputs, target) for start in many.starts]

    def likelihood(own: GaussianProcess) -> float:
        factor, *lengths, noise = np.exp(own.logs)
        covariance = factor * Matern(lengths, nu=1.5)(inputs) + noise * np.eye(len(inputs))
        return multivariate_normal(cov=covariance).logpdf(target)

    single = [likelihood(each) for each in alone]
    assert likelihood(many.fit(inputs, target)) == pytest.approx(max(single), rel=1e-9)
    # The starts matter here: they end at different maxima.
    assert max(single) - min(single) > 0.5
    low, high = (np.array([bounds[end] for bounds in training.spaces["gpr"].values()]) for end in (0, 1))
    for start in np.exp(many.starts):
        assert (low <= start[[0, 1, -1]]).all() and (start[[0, 1, -1]] <= high).all()


@pytest.fixture(scope="module")
def models(tmp_path_factory) -> dict[str, str]:
    """One stored model for each kind of interval."""
    folder, config = tmp_path_factory.mktemp("models"), settings()
    rows, _ = parts()
    yields = rows["yield_percent"].to_numpy(float)
    paths = {name: str(folder / f"{name}.json") for name in ("mixture", "gaussian", "cv_plus")}
    averaged = fit_averaged(rows, yields, config.averaging)
    save_averaged(averaged, rows, config.averaging.margin, paths["mixture"])
    for name, kind in (("gaussian", ("gpr", "two_step")), ("cv_plus", ("svr", "primary"))):
        model, results = Trainer(config.training, config.search).train(*kind, rows, yields)
        save_model(model, results, rows, config.training, paths[name])
    return paths


def arguments(level: float) -> tuple:
    """The arguments of predict_conditions after model and conditions: limits, training, folds, level."""
    config = settings()
    return config.prediction, config.training, config.evaluation.conformal_folds, level


@pytest.mark.parametrize("kind", ["mixture", "gaussian", "cv_plus"])
def test_every_kind_of_model_predicts_with_its_interval(models, kind):
    rows, _ = parts()
    table = predict_conditions(models[kind], rows, *arguments(0.8))
    assert (table["interval"] == kind).all() and (table["warning"] == "").all()
    assert (table["lower_percent"] <= table["upper_percent"]).all()
    wider = predict_conditions(models[kind], rows, *arguments(0.95))
    assert (wider["upper_percent"] - wider["lower_percent"] >= table["upper_percent"] - table["lower_percent"]).all()


def test_a_stored_model_and_the_curves_of_a_mill_are_not_taken_for_each_other(models, tmp_path):
    curves = tmp_path / "curves.json"
    table = pd.DataFrame({"fill_ratio": [0.1, 0.2], "Pn": 1.0, "Pt": 1.0, "f": 1.0})
    MillCurves("mine", table, 7800.0, 0.017, (10.0,), (300.0, 1200.0)).write(curves)
    for model in models.values():
        assert load_any(model).predict(parts()[0]).shape == (len(parts()[0]),)
        with pytest.raises(ConfigError, match="format"):
            MillCurves.read(model)
    with pytest.raises(ConfigError, match="format"):
        load_any(str(curves))


def test_conditions_outside_the_trained_ranges_are_refused_with_the_reason(models):
    rows, _ = parts()
    requested = rows.head(4).reset_index(drop=True)
    requested.loc[1, "bpr"] = 80.0
    requested.loc[2, "time_h"] = 20.1  # within one per cent of the trained 15 h
    # Another fill ratio: both energies are within their ranges, but their share is not.
    requested.loc[3, ["normal_energy_uJ", "tangential_energy_uJ"]] = [500.0, 600.0]
    table = predict_conditions(models["mixture"], requested, *arguments(0.95))
    assert table["predicted_percent"].isna().tolist() == [False, True, False, True]
    assert "bpr = 80" in table["warning"][1] and "tangential_share = 0.5455" in table["warning"][3]
    extrapolated = predict_conditions(models["mixture"], requested, *arguments(0.95), extrapolate=True)
    assert extrapolated["predicted_percent"].notna().all() and extrapolated["warning"].equals(table["warning"])
