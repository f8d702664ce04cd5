"""Every regressor of the registry: trained, stored and read back, explained; unknown names are refused."""

import numpy as np
import pytest

from millprint.config.search_spaces import SPACES
from millprint.run.files import read_json
from millprint.thesis.yields.estimators import GaussianProcess, gaussian_process
from millprint.thesis.yields.evaluation import shap_values
from millprint.thesis.yields.model_files import load_model, save_model
from millprint.thesis.yields.regressors import (
    REGRESSORS,
    models_of,
    regressor,
)
from millprint.thesis.yields.yield_model import Trainer
from tests.unit.yield_settings import parts, settings

# Whether SHAP values can be calculated, by regressor.
EXPLAINED = {name: record.explain is not None for name, record in REGRESSORS.items()}
EVERY_MODEL = models_of(list(REGRESSORS))


def trained(name: str, strategy: str):
    rows, _ = parts()
    config = settings()
    return Trainer(config.training, config.search).train(name, strategy, rows, rows["yield_percent"].to_numpy())


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
    alone = [GaussianProcess(many.kernel, [start]).fit(inputs, target) for start in many.starts]
    single = [each.process.log_marginal_likelihood_value_ for each in alone]
    many.fit(inputs, target)
    assert many.process.log_marginal_likelihood_value_ == pytest.approx(max(single), rel=1e-9)
    # The starts matter here: they end at different maxima.
    assert max(single) - min(single) > 0.5
    low, high = (np.array([bounds[end] for bounds in training.spaces["gpr"].values()]) for end in (0, 1))
    for start in np.exp(many.starts):
        assert (low <= start[[0, 1, -1]]).all() and (start[[0, 1, -1]] <= high).all()
