"""The models: printed rows, identities, and stored files."""

import numpy as np
import pytest
from sklearn.ensemble import RandomForestRegressor
from xgboost import XGBRegressor

from millprint.thesis.claims.tolerances import agrees
from millprint.thesis.yields.estimators import BoostingFold, Forest, ForestFold, ProcessFold, Trees, gaussian_process
from millprint.thesis.yields.features import FEATURES, Standardisation, engineer
from millprint.thesis.yields.metrics import METRICS, YieldWeights, metrics
from millprint.thesis.yields.regressors import REGRESSORS
from millprint.thesis.yields.run_tables import read_rows
from millprint.thesis.yields.yield_model import Trainer, fit_model, plan_steps
from tests.conftest import PRINTED
from tests.unit.yield_settings import parts, settings

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


@pytest.mark.parametrize("name", [name for name, record in REGRESSORS.items() if record.two_step])
def test_yields_that_are_a_line_in_time_leave_nothing_to_the_second_step(name):
    """The first step is the line itself, so the second is fitted on zeros and not on the yields."""
    rows, test = parts()
    training = settings(time_model="linear").training
    model, _ = Trainer(training, settings().search).train(name, "two_step", rows, 10 + 2 * rows["time_h"].to_numpy())
    first, second = model.steps
    assert first.plan.features == ("time_h",) and set(second.plan.features) == set(FEATURES) - {"time_h"}
    np.testing.assert_allclose(second.predict(engineer(test)), 0, atol=1e-6)
    np.testing.assert_allclose(model.predict(test), 10 + 2 * test["time_h"], atol=1e-6)


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


@pytest.mark.parametrize(
    ("count", "depth", "split", "leaf"), [(7, 4, 2, 1), (3, 30, 2, 1), (12, 9, 3, 4), (7, 2, 20, 1)]
)
@pytest.mark.parametrize("share", [1.0, 0.4])
def test_shared_trees_are_scikit_learns_forest(count, depth, split, leaf, share):
    rows, test = parts()
    inputs, target = engineer(rows).to_numpy(), rows["yield_percent"].to_numpy(float)
    unseen = engineer(test).to_numpy()
    fold = ForestFold(Trees(inputs, target, share, seed=42, count=12), unseen)
    fold.predict(5, depth, split, leaf)
    plain = RandomForestRegressor(
        n_estimators=count,
        max_depth=depth,
        min_samples_split=split,
        min_samples_leaf=leaf,
        max_features=share,
        random_state=42,
    ).fit(inputs, target)
    own = Forest(count, depth, split, leaf, share, seed=42).fit(inputs, target)
    for predicted in (fold.predict(count, depth, split, leaf), own.predict(unseen)):
        np.testing.assert_allclose(predicted, plain.predict(unseen), rtol=1e-13)


@pytest.mark.parametrize("lengths", ["per_feature", "shared"])
def test_a_fold_predicts_as_the_process_that_is_fitted_from_the_same_start(lengths):
    rows, test = parts()
    training = settings(length_scales=lengths).training
    plan = plan_steps("gpr", "primary", training.choices)[0]
    standard, inputs = plan.standardise(engineer(rows))
    unseen, target = standard(engineer(test).to_numpy()), rows["yield_percent"].to_numpy(float)
    fold = ProcessFold(inputs, target, unseen, training.choices)
    for start in (START, {"constant": 900.0, "length_scale": 0.1, "noise": 1e-4}):
        plain = gaussian_process(start, inputs.shape[1], training).fit(inputs, target)
        np.testing.assert_allclose(fold.predict(start), plain.predict(unseen), rtol=1e-8)


@pytest.mark.parametrize(("split", "leaf"), [(2, 1), (2, 2), (9, 1)])
def test_a_fold_gives_the_same_forest_whatever_depth_it_was_asked_for_before(split, leaf):
    rows, test = parts()
    inputs, target, unseen = engineer(rows).to_numpy(), rows["yield_percent"].to_numpy(float), engineer(test).to_numpy()
    trees = Trees(inputs, target, 1.0, seed=42, count=9)
    asked = ForestFold(trees, unseen)
    for depth in (1, 30, 3, 2, 5, 4, 8, 3):
        fresh = ForestFold(trees, unseen)
        np.testing.assert_array_equal(asked.predict(9, depth, split, leaf), fresh.predict(9, depth, split, leaf))


def test_boosting_is_xgboost_bit_for_bit():
    rows, test = parts()
    inputs, target, unseen = engineer(rows).to_numpy(), rows["yield_percent"].to_numpy(float), engineer(test).to_numpy()
    for share, trees in ((0.7, 30), (1.0, 5)):
        shape = {
            "n_estimators": trees,
            "subsample": share,
            "colsample_bytree": share,
            "learning_rate": 0.1,
            "gamma": 1.0,
        }
        plain = XGBRegressor(**shape, random_state=42, n_jobs=1).fit(inputs, target)
        fold = BoostingFold(inputs, target, unseen)
        for _ in range(2):
            found = fold.predict({**shape, "random_state": 42, "n_jobs": 1})
            np.testing.assert_array_equal(found, plain.predict(unseen))
