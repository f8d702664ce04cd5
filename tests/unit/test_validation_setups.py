"""The set-ups of the validation: their registry, and what they predict and assume."""

import numpy as np
import pandas as pd
import pytest

from millprint.config.errors import ConfigError
from millprint.config.setup_models import SETTINGS, SetupConfig
from millprint.config.sweep import DemConfig
from millprint.validation.measured import CONTACT, PREDICTION_COLUMNS, UNKNOWN, check_predictions, read_measurements
from millprint.validation.setups import assumption_table, predict
from tests.physics.test_impacts import ALUMINA
from tests.unit.test_validation import MEASURED, points_of, predictions_of


def test_every_setup_answers_a_measured_row():
    # That of the box on a leaf spring waits for its curve.
    assert set(read_measurements(MEASURED, SETTINGS)["setup"]) - {UNKNOWN} == set(SETTINGS) - {"leaf_spring"}


def test_a_table_of_predictions_is_checked():
    good = predictions_of((1, 2.0), lower=1.0, upper=3.0, interval=CONTACT)
    assert list(check_predictions(good, "t").columns) == list(PREDICTION_COLUMNS)
    for wrong, words in (
        (good.drop(columns="unit"), "columns"),
        (good.assign(interval="luck"), "interval by 'luck'"),
        (good.assign(lower=2.5), "outside its own interval"),
        (good.assign(lower=-0.1), "interval from -0.1 W on"),
    ):
        with pytest.raises(ValueError, match=words):
            check_predictions(wrong, "t")


def small_impact(**changes) -> SetupConfig:
    return SETTINGS["alumina_impact"].model_copy(update={"angles_deg": [60.0], "steps_per_impact": 500, **changes})


def predict_impact(measured: pd.DataFrame, **changes) -> pd.DataFrame:
    return predict(
        "alumina_impact", small_impact(**changes), None, {ALUMINA.name: ALUMINA}, DemConfig(), {}, "", measured
    )


AT_50_DEGREES = {
    "quantity": "tangential restitution",
    "unit": "-",
    "value": "50:0.8",
    "uncertainty": "",
    "uncertainty_unit": "",
}


def test_an_impact_is_predicted_at_the_measured_places_too(tmp_path):
    measured = points_of(tmp_path, AT_50_DEGREES)
    table = predict_impact(measured)
    dem = table[(table["model"] == "DEM") & (table["quantity"] == "tangential restitution")]
    assert dem["x"].tolist() == [50, 60] and dem["id"].tolist() == ["t1", ""]
    assert (dem["lower"] < dem["predicted"]).all() and (dem["predicted"] < dem["upper"]).all()
    assert set(dem["interval"]) == {CONTACT}
    assert dem["predicted"].iloc[0] == pytest.approx(1 - 0.092 * 1.98 / np.tan(np.radians(50)), rel=2e-3)


def test_a_setup_does_not_learn_the_measured_values(tmp_path):
    row = {"quantity": "tangential restitution", "unit": "-", "uncertainty": "", "uncertainty_unit": ""}
    tables = [predict_impact(points_of(tmp_path, {**row, "value": value})) for value in ("50:0.8", "50:0.1")]
    pd.testing.assert_frame_equal(*tables)


def test_a_measured_quantity_that_a_setup_does_not_predict_is_refused(tmp_path):
    with pytest.raises(ConfigError, match="quantity, id t1 = 'power': set-up alumina_impact predicts tangential rest"):
        predict_impact(points_of(tmp_path, {"value": "50:1"}))


def test_assumptions_name_every_coefficient_and_its_source():
    rows = pd.DataFrame(assumption_table("alumina_impact", small_impact(), None, {ALUMINA.name: ALUMINA}))
    (friction,) = rows[rows["what"].str.startswith("static_friction")].to_dict("records")
    assert friction["value"] == "0.092" and "Kharaz" in friction["source"]
    assert (rows["source"] != "").all()
