"""The models: printed rows, identities, equal runs, and files that give them back."""

import numpy as np
import pytest
from sklearn.ensemble import RandomForestRegressor

from millprint.claims.compare import agrees
from millprint.errors import ConfigError
from millprint.files import read_json, write_json
from millprint.predict.algorithms import make_estimator, quiet_fit
from millprint.predict.catalogue import MODELS
from millprint.predict.explanation import shap_values
from millprint.predict.features import FEATURES, engineer
from millprint.predict.forest import ForestFold
from millprint.predict.metrics import METRICS, YieldWeights, metrics
from millprint.predict.model import Scaling, fit_model, plan_steps
from millprint.predict.store import load_model, save_model, stored_search
from millprint.predict.tables import read_rows
from millprint.predict.training import evaluations_of, train
from tests.conftest import PRINTED
from tests.unit.yield_settings import parts, settings

WEIGH = YieldWeights(70, 2.0)
START = {"constant": 100.0, "length_scale": 2.0, "noise": 0.5}


def trained(model: str, strategy: str):
    rows, _ = parts()
    config = settings()
    return train(model, strategy, rows, rows["yield_percent"].to_numpy(), config.training, config.search)


def refitted(model: str, strategy: str, parameters: list, **choices):
    rows, _ = parts()
    training = settings(**choices).training
    return fit_model(
        model, strategy, parameters, rows, rows["yield_percent"].to_numpy(), training.choices, training.seed
    )


def has_printed_row(model, name: str) -> bool:
    _, test = parts()
    found = metrics(test["yield_percent"].to_numpy(float), model.predict(test), WEIGH)
    return all(agrees(PRINTED[f"5.{name}.{metric}"], "printed", float(found[metric])) for metric in METRICS)


def test_linear_has_every_printed_digit():
    model, found = trained("linear", "primary")
    assert has_printed_row(model, "linear")
    assert found[0].evaluations == 0


def test_linear_on_other_features_has_not():
    assert not has_printed_row(refitted("linear", "primary", [{}], linear_features=list(FEATURES)), "linear")


def test_two_step_gpr_has_every_printed_digit_from_a_plain_start():
    model = refitted("gpr", "two_step", [START, START])
    assert has_printed_row(model, "gpr.two_step")
    outside = model.predict(read_rows(settings().out_of_domain))
    for case, predicted in zip((27, 28), outside[:2], strict=True):
        assert agrees(PRINTED[f"5.ood.{case}.gpr"], "printed", float(predicted))


def test_two_step_gpr_with_one_length_scale_is_far_off():
    _, test = parts()
    model = refitted("gpr", "two_step", [START, START], length_scales="shared")
    assert metrics(test["yield_percent"].to_numpy(float), model.predict(test), WEIGH)["r2"] < 0.6


@pytest.mark.parametrize(("name", "strategy"), [model for model in MODELS if model[1] == "two_step"])
def test_two_step_prediction_is_the_sum_of_its_steps(name, strategy):
    rows, test = parts()
    model, found = trained(name, strategy)
    first, second = model.steps
    assert first.plan.features == ("time_h",)
    assert set(second.plan.features) == set(FEATURES) - {"time_h"}
    np.testing.assert_allclose(
        model.predict(test), first.predict(engineer(test)) + second.predict(engineer(test)), rtol=1e-14
    )
    # The second step alone, fitted on the residuals of the first, is the second step.
    residuals = rows["yield_percent"] - first.predict(engineer(rows))
    training = settings().training
    alone = make_estimator(name, found[1].parameters, 9, training.choices, training.seed)
    quiet_fit(alone, second.inputs(engineer(rows)), residuals)
    np.testing.assert_allclose(alone.predict(second.inputs(engineer(test))), second.predict(engineer(test)), rtol=1e-6)


@pytest.mark.parametrize(("name", "strategy"), MODELS)
def test_a_second_training_and_the_stored_model_predict_the_same(tmp_path, name, strategy):
    rows, test = parts()
    (model, found), (again, found_again) = trained(name, strategy), trained(name, strategy)
    assert [best.parameters for best in found] == [best.parameters for best in found_again]
    assert np.array_equal(model.predict(test), again.predict(test))
    config = settings().training
    for number, each in enumerate((model, again)):
        save_model(each, found, rows, config.choices, config.seed, str(tmp_path / f"{number}.json"))
    assert (tmp_path / "0.json").read_bytes() == (tmp_path / "1.json").read_bytes()
    loaded = load_model(str(tmp_path / "0.json"))
    np.testing.assert_allclose(loaded.predict(test), model.predict(test), rtol=1e-9)
    if name == "gpr":
        np.testing.assert_allclose(loaded.deviation(test), model.deviation(test), rtol=1e-6)
    else:
        assert model.deviation(test) is None
    tuned = sum(search["evaluations"] for search in stored_search(str(tmp_path / "0.json")) if search)
    assert tuned == evaluations_of(name, strategy, config, settings().search)


def test_a_changed_file_is_refused(tmp_path):
    rows, _ = parts()
    model, found = trained("svr", "primary")
    config, path = settings().training, tmp_path / "model.json"
    save_model(model, found, rows, config.choices, config.seed, str(path))
    content = read_json(path)
    content["steps"][0]["parameters"]["gamma"] *= 1.5
    write_json(content, path)
    with pytest.raises(ConfigError, match="the file was changed, or it was written by libraries") as caught:
        load_model(str(path))
    assert "\n" not in str(caught.value)
    write_json({"format": "something else"}, path)
    with pytest.raises(ConfigError, match="format = 'something else'"):
        load_model(str(path))


def test_another_seed_searches_elsewhere():
    rows, _ = parts()
    config = settings()
    other = config.training.model_copy(update={"seed": 5})
    _, found = train("svr", "primary", rows, rows["yield_percent"].to_numpy(), other, config.search)
    assert found[0].parameters != trained("svr", "primary")[1][0].parameters


def test_scaling_uses_the_training_rows_alone():
    rows, test = parts()
    model = refitted("linear", "primary", [{}])
    step = model.steps[0]
    np.testing.assert_allclose(step.scaling.mean, rows[["bpr", "molar_ratio", "time_h"]].mean())
    np.testing.assert_allclose(step.inputs(engineer(rows)).std(axis=0), 1)
    assert abs(step.inputs(engineer(test)).mean(axis=0)).max() > 0.05
    assert Scaling.of(np.array([[1.0], [1.0]]), scaled=True)(np.array([[3.0]])).tolist() == [[2.0]]
    trees = refitted("rf", "primary", [{"n_estimators": 2, "max_depth": 3}])
    np.testing.assert_array_equal(trees.steps[0].inputs(engineer(test)), engineer(test).to_numpy())


@pytest.mark.parametrize(
    ("count", "depth", "split", "leaf"), [(7, 4, 2, 1), (3, 30, 2, 1), (12, 9, 3, 4), (7, 2, 20, 1)]
)
@pytest.mark.parametrize("share", [1.0, 0.4])
def test_shared_trees_are_scikit_learns_forest(count, depth, split, leaf, share):
    rows, test = parts()
    inputs, target = engineer(rows).to_numpy(), rows["yield_percent"].to_numpy(float)
    fold = ForestFold(inputs, target, engineer(test).to_numpy(), share, seed=42, most=12)
    fold.predict(5, depth, split, leaf)
    plain = RandomForestRegressor(
        n_estimators=count,
        max_depth=depth,
        min_samples_split=split,
        min_samples_leaf=leaf,
        max_features=share,
        random_state=42,
    ).fit(inputs, target)
    np.testing.assert_allclose(
        fold.predict(count, depth, split, leaf), plain.predict(engineer(test).to_numpy()), rtol=1e-13
    )


def test_linear_time_model_is_one_choice_away():
    choices = settings(time_model="linear").training.choices
    assert [plan.algorithm for plan in plan_steps("xgb", "two_step", choices)] == ["linear", "xgb"]


@pytest.mark.parametrize("name", ["rf", "xgb"])
def test_shap_values_add_up_to_the_prediction(name):
    _, test = parts()
    model, _ = trained(name, "two_step")
    table = shap_values(model, test)
    by_case = table.groupby("case", sort=False)
    sums = by_case["shap_pp"].sum() + by_case["base_percent"].first()
    np.testing.assert_allclose(sums.loc[test["case"]], model.predict(test), atol=1e-3)
    time = table[table["feature"] == "time_h"].set_index("case")
    np.testing.assert_array_equal(time.loc[test["case"], "feature_value"], test["time_h"])
