"""The set-ups of the validation: their registry, what they predict and assume, and when their settings were fixed."""

import shutil

import numpy as np
import pandas as pd
import pytest
from tools import fix_predictions

from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.config.setup_models import QUICK, SETTINGS, SetupConfig
from millprint.config.sweep import DemConfig
from millprint.config.workflow import WorkflowConfig
from millprint.figures.validation_figures import plot_setup
from millprint.validation.fixed import Fixed, fix, fixed_table, read_fixed, settings_digest, status_of
from millprint.validation.measured import (
    CONTACT,
    PREDICTION_COLUMNS,
    UNKNOWN,
    check_predictions,
    read_measurements,
)
from millprint.validation.setups import SETUPS, assumption_table, predict, setup_named
from tests.physics.test_impacts import ALUMINA, contact_set
from tests.unit.test_validation import MEASURED, points_of, predictions_of
from tests.workflow.conftest import ROOT


def test_every_setup_has_settings_and_a_record():
    assert set(SETTINGS) == set(SETUPS)
    assert all(name == setup.name for name, setup in SETUPS.items())
    assert all(type(quick) is type(SETTINGS[name]) for name, quick in QUICK.items())
    for section in SETTINGS.values():
        assert set(section.places) <= set(type(section).model_fields)


def test_every_setup_answers_a_measured_row():
    # That of the box on a leaf spring waits for its curve.
    assert set(read_measurements(MEASURED, SETUPS)["setup"]) - {UNKNOWN} == set(SETUPS) - {"leaf_spring"}


def test_what_is_not_in_the_registry_raises():
    with pytest.raises(ConfigError, match=r"unknown set-up 'cannon'; known: "):
        setup_named("cannon")
    with pytest.raises(ConfigError, match=r"validation: setups: unknown set-up 'cannon'; known: "):
        check_model({"validation": {"setups": ["cannon"]}, "mill": "emax"}, WorkflowConfig, "own.yaml")


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


def test_the_figure_shows_every_quantity_and_the_measured_points(tmp_path):
    measured = points_of(tmp_path, AT_50_DEGREES)
    figure = plot_setup(predict_impact(measured), measured, "a title")
    labels = [axis.get_ylabel().replace("\n", " ") for axis in figure.axes if axis.get_visible()]
    assert "tangential restitution [-]" in labels and "rebound angle of the centre [deg]" in labels
    drawn = [each.get_label() for each in figure.axes[0].containers]
    assert "measured" in drawn


def test_a_digest_changes_with_every_setting_and_with_nothing_else():
    def digest(setup=None, contact=ALUMINA, dem=None) -> str:
        return settings_digest(setup or small_impact(), None, {contact.name: contact}, dem or DemConfig())

    first = digest()
    assert digest(small_impact(angles_deg=[10.0])) == first
    assert digest(contact=contact_set("alumina_on_glass", source="another text")) == first
    # A set-up that simulates on its own does not use the settings of the sweeps.
    assert digest(dem=DemConfig(time_step_s=1e-6)) == first
    assert digest(small_impact(speed_m_s=4.0)) != first
    assert digest(small_impact(static_friction=None)) != first
    assert digest(contact=contact_set("alumina_on_glass", static_friction=0.1)) != first


def test_every_date_is_kept_with_its_reason_and_the_last_one_is_shown(tmp_path):
    path = tmp_path / "fixed.tsv"
    assert fix(path, {"a": "1", "b": "2"}, "2026-01-02 10:00") == ["a", "b"]
    with pytest.raises(ConfigError, match="b had been fixed with other settings: say why"):
        fix(path, {"a": "1", "b": "3"}, "2026-03-04 11:00")
    assert fix(path, {"a": "1", "b": "3"}, "2026-03-04 11:00", "a ball was lost") == ["b"]
    fixed = read_fixed(path)
    again = Fixed("2026-03-04 11:00", "3", "a ball was lost")
    assert fixed == {"a": [Fixed("2026-01-02 10:00", "1")], "b": [Fixed("2026-01-02 10:00", "2"), again]}
    assert status_of("a", "1", fixed) == "settings fixed on 2026-01-02 10:00"
    once = "settings fixed on 2026-01-02 10:00; fixed again once, on 2026-03-04 11:00: a ball was lost"
    assert status_of("b", "3", fixed) == once
    assert status_of("a", "9", fixed) == "settings changed since they were fixed on 2026-01-02 10:00"
    # Settings that were fixed once, and replaced, are not those that were fixed last.
    assert status_of("b", "2", fixed) == "settings changed since they were fixed on 2026-03-04 11:00"
    assert status_of("c", "1", fixed) == "settings not fixed"
    fix(path, {"b": "4"}, "2026-03-05 09:00", "a key has another name")
    assert "again 2 times, the last time on 2026-03-05 09:00: a key" in status_of("b", "4", read_fixed(path))
    table = fixed_table(read_fixed(path), {"b": "4", "c": "1"})
    assert table["today"].tolist() == ["no", "no", "yes"]
    assert table["why"].tolist() == ["fixed for the first time", "a ball was lost", "a key has another name"]


def test_the_settings_in_the_repository_are_those_that_were_fixed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "config", tmp_path / "config")
    lines = fix_predictions.main([], "config/config.yaml")
    assert [line for line in lines if not line.endswith("unchanged")] == []
    fixed = read_fixed("config/data/fixed_predictions.tsv")
    assert list(fixed) == sorted(SETUPS)
    for times in fixed.values():
        assert [each.date for each in times] == sorted(each.date for each in times)
        assert [each.why == "fixed for the first time" for each in times] == [True] + [False] * (len(times) - 1)


def test_an_unknown_setup_cannot_be_fixed(monkeypatch):
    monkeypatch.chdir(ROOT)
    with pytest.raises(ConfigError, match="unknown set-up 'cannon'"):
        fix_predictions.main(["cannon"], "config/config.yaml")
