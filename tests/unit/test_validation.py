"""The validation: the measured table, the registry, the verdicts, and the dates of the settings."""

import shutil
from contextlib import nullcontext

import numpy as np
import pandas as pd
import pytest
from tools import fix_predictions

from millprint.config.checks import load_workflow
from millprint.config.errors import ConfigError
from millprint.config.included import SOURCES, load_mill
from millprint.config.load import check_model
from millprint.config.setup_models import QUICK, SETTINGS, SetupConfig
from millprint.config.sweep import DemConfig
from millprint.config.workflow import WorkflowConfig
from millprint.figures.validation_figures import plot_setup
from millprint.run.files import write_table
from millprint.validation.fixed import Fixed, fix, fixed_table, read_fixed, settings_digest, status_of
from millprint.validation.measured import (
    CONTACT,
    PREDICTION_COLUMNS,
    SCATTER,
    UNKNOWN,
    check_measured,
    check_predictions,
    measured_points,
    parse_value,
    prediction,
    read_measurements,
)
from millprint.validation.setups import SETUPS, assumption_table, predict, setup_named
from millprint.validation.tumbling_runs import design, measured_speeds
from millprint.validation.verdicts import NOT_EXPLAINED, count_verdicts, give_verdicts, tabulate_coverage
from tests.physics.test_impacts import ALUMINA, contact_set
from tests.workflow.conftest import ROOT

MEASURED = ROOT / "config/data/measured.tsv"
HEAD = "id\tsetup\tmill\tdescription\tquantity\tx\tvalue\tunit\tuncertainty\tuncertainty_unit\tclass\tsource\tnote"
ROW = {
    "id": "t1", "setup": "alumina_impact", "mill": "plate", "description": "a test", "quantity": "power",
    "x": "speed [rpm]", "value": "10:5;20:-1", "unit": "W", "uncertainty": "0.5", "uncertainty_unit": "W",
    "class": "measured", "source": "nowhere", "note": "",
}  # fmt: skip


def table_with(tmp_path, *changes: dict):
    path = tmp_path / "measured.tsv"
    lines = ["\t".join({**ROW, "id": f"t{place}", **change}.values()) for place, change in enumerate(changes, start=1)]
    path.write_text("\n".join([HEAD, *lines]) + "\n")
    return path


def points_of(tmp_path, *changes: dict) -> pd.DataFrame:
    return measured_points(read_measurements(table_with(tmp_path, *changes), SETUPS))


# ---- The measured table ----


def test_the_measured_table_is_whole():
    rows = read_measurements(MEASURED, SETUPS)
    given = {
        "1a",
        "1c",
        "1d",
        "2a",
        "2c",
        "3a",
        "3b",
        "4a",
        "4b",
        "4c",
        "5a",
        "5b",
        "5c",
        "7",
        *("8a", "8b", "8c", "8d"),
        "9",
    }
    assert set(rows["id"]) >= given
    assert (rows["source"] != "").all()
    points = measured_points(rows)
    assert len(points[points["id"] == "3a"]) == 10
    # 5 to 8 % of 134.9 rad/s; the larger is taken.
    first = points[points["id"] == "3b"].iloc[0]
    assert first["measured_upper"] - first["measured"] == pytest.approx(0.08 * 134.9)


def test_rows_without_a_known_setup_stay_in_the_table():
    rows = read_measurements(MEASURED, SETUPS).set_index("id")
    assert (rows.loc[["8b", "8c", "8d"], "setup"] == UNKNOWN).all()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"unit": "horsepower"}, ("column unit, row 1 = 'horsepower'", "must be W or")),
        ({"setup": "alumina"}, ("column setup, row 1 = 'alumina'", "unknown set-up; known: alumina_impact")),
        ({"value": "10:5;20"}, ("column value, row 1 = '10:5;20'", "must be a number, a series")),
        ({"value": "3 to 1"}, ("column value, row 1 = '3 to 1'", "must be")),
        ({"value": ""}, ("column value, row 1 = ''", "must be")),
        ({"x": ""}, ("column x, row 1 = ''", "must say what the x of a series is")),
        ({"uncertainty_unit": "kW"}, ("column uncertainty_unit, row 1 = 'kW'", "must be W or %")),
        ({"uncertainty_unit": ""}, ("column uncertainty_unit, row 1 = ''", "must be W or %")),
        ({"uncertainty": ""}, ("column uncertainty_unit, row 1 = 'W'", "empty where there is none")),
        ({"uncertainty": "-1"}, ("column uncertainty, row 1 = -1", "above 0")),
        ({"uncertainty": "5 to 8 %"}, ("column uncertainty", "5 to 8 %", "finite number")),
    ],
)  # fmt: skip
def test_a_measured_table_is_refused_in_one_line(tmp_path, change, words):
    path = table_with(tmp_path, change)
    with pytest.raises(ConfigError) as refused:
        read_measurements(path, SETUPS)
    line = str(refused.value)
    assert "\n" not in line and str(path) in line
    for word in words:
        assert word in line


def test_two_rows_of_one_id_are_refused(tmp_path):
    with pytest.raises(ConfigError, match="column id = a appears twice"):
        read_measurements(table_with(tmp_path, {"id": "a"}, {"id": "a"}), SETUPS)


def test_values_are_numbers_series_ranges_and_bounds():
    assert [(each.x, each.value) for each in parse_value("10:5; 20:-1.5e2")] == [(10, 5), (20, -150)]
    assert parse_value(".5")[0].value == 0.5
    (single,) = parse_value("27")
    assert single.value == 27 and np.isnan(single.x) and np.isnan(single.lower)
    (spread,) = parse_value("1.8 to 3.3")
    assert (spread.lower, spread.value, spread.upper) == (1.8, pytest.approx(2.55), 3.3)
    (low,), (high,) = parse_value("below 100"), parse_value("above 200")
    assert (low.lower, low.upper) == (-np.inf, 100) and (high.lower, high.upper) == (200, np.inf)


def test_an_uncertainty_in_per_cent_is_of_the_size_of_the_value(tmp_path):
    points = points_of(
        tmp_path, {"uncertainty": "10", "uncertainty_unit": "%"}, {"uncertainty": "", "uncertainty_unit": ""}
    )
    first = points[points["id"] == "t1"]
    assert first["measured_lower"].tolist() == pytest.approx([4.5, -1.1])
    assert first["measured_upper"].tolist() == pytest.approx([5.5, -0.9])
    assert points.loc[points["id"] == "t2", ["measured_lower", "measured_upper"]].isna().all(axis=None)


# ---- Verdicts ----


def predictions_of(*values: tuple, id: str = "t1", unit: str = "W", **bounds) -> pd.DataFrame:
    return pd.DataFrame([prediction("power", unit, value, id=id, x=x, **bounds) for x, value in values])


def judge(points, predictions, variants=(), setup="alumina_impact", **options) -> pd.DataFrame:
    return give_verdicts(points, {setup: predictions}, {setup: "settings fixed"}, {setup: variants}, **options)


@pytest.mark.parametrize(
    ("predicted", "lower", "upper", "verdict"),
    [
        (100.4, 99.0, 101.0, "within both intervals"),
        (100.4, np.nan, np.nan, "within 10 %"),  # the prediction has no interval
        (104.0, 99.0, 106.0, "within 10 %"),  # the prediction lies outside the measured interval
        (101.0, 100.4, 101.5, "within 10 %"),  # the ends overlap, but no number lies within both
        (109.9, 109.0, 110.5, "within 10 %"),
        (110.1, 109.0, 110.5, "off"),
        (89.9, np.nan, np.nan, "off"),
    ],
)  # fmt: skip
def test_the_rules_of_a_verdict(tmp_path, predicted, lower, upper, verdict):
    points = points_of(tmp_path, {"value": "10:100"})
    bounds = {"lower": lower, "upper": upper, "interval": CONTACT}
    row = judge(points, predictions_of((10, predicted), **bounds)).iloc[0]
    assert row["verdict"] == verdict
    assert row["ratio"] == pytest.approx(predicted / 100)
    assert row["explanation"] == (NOT_EXPLAINED if verdict == "off" else "")


@pytest.mark.parametrize(
    ("unit", "tolerance", "close"),
    [
        ("deg", 3.0, "near"),
        ("m", 0.003, "near"),
        ("rings", 0.5, "near"),
        ("W", 2.7, "within 10 %"),
        ("rad/s", 2.7, "within 10 %"),
    ],
)
def test_angles_places_and_counts_have_a_tolerance_and_a_verdict_of_their_own(tmp_path, unit, tolerance, close):
    points = points_of(tmp_path, {"value": "27", "x": "", "unit": unit, "uncertainty": "", "uncertainty_unit": ""})
    for shift, verdict in ((0.99, close), (1.01, "off")):
        row = judge(points, predictions_of((np.nan, 27 - shift * tolerance), unit=unit)).iloc[0]
        assert row["tolerance"] == pytest.approx(tolerance)
        assert row["verdict"] == verdict


def test_a_series_that_changes_its_sign_is_not_judged_by_ratios_near_zero(tmp_path):
    points = points_of(tmp_path, {"value": "1:-1;2:0.01;3:2", "uncertainty": "", "uncertainty_unit": ""})
    rows = judge(points, predictions_of((1, -1.0), (2, 0.1), (3, 2.3)))
    assert rows["tolerance"].tolist() == pytest.approx([0.10033, 0.10033, 0.2], rel=1e-3)
    assert rows["verdict"].tolist() == ["near", "near", "off"]


SERIES = {"value": "10:100;20:100;30:100;40:100", "uncertainty": "", "uncertainty_unit": ""}
OURS = [(10.0, 50.0), (20.0, 60.0), (30.0, 99.0), (40.0, 101.0)]


@pytest.mark.parametrize(
    ("variant", "explained", "text"),
    [
        # It meets both misses and spoils nothing.
        ([98, 97, 100, 105], [True, True], "met by: slip. It meets 4 of all 4 numbers that it predicts, ours 2"),
        # It meets both misses, and misses a number that we meet.
        ([98, 97, 100, 130], [False, False], "slip meets this number, and 3 of 4 of its row, 3 of all 4 numbers"),
        # It meets one miss, and misses the other.
        ([98, 70, 100, 105], [False, False], "slip meets this number, and 3 of 4 of its row"),
        # It meets none.
        ([70, 70, 100, 105], [False, False], NOT_EXPLAINED),
    ],
)
def test_a_variant_explains_a_miss_only_if_other_numbers_confirm_it(tmp_path, variant, explained, text):
    points = points_of(tmp_path, SERIES)
    places = [x for x, _ in OURS]
    lines = [predictions_of(*OURS), predictions_of(*zip(places, variant, strict=True), model="slip", id="")]
    rows = judge(points, pd.concat(lines), variants=["slip"])
    assert rows["explanation"].str.startswith("met by: ").tolist() == [*explained, False, False]
    assert text in rows["explanation"].iloc[0]
    assert rows["explanation"].tolist()[2:] == ["", ""]
    # A line that is not a variant of ours is never an explanation.
    assert judge(points, pd.concat(lines))["explanation"].tolist() == [NOT_EXPLAINED, NOT_EXPLAINED, "", ""]


def test_what_another_code_computed_confirms_no_explanation(tmp_path):
    points = points_of(tmp_path, {**SERIES, "value": "10:100"}, {**SERIES, "value": "20:100", "class": "other DEM"})
    ours = pd.concat([predictions_of((10, 50)), predictions_of((20, 50), id="t2")])
    slip = predictions_of((10, 99), (20, 99), model="slip", id="")
    rows = judge(points, pd.concat([ours, slip]), variants=["slip"])
    text = "slip meets this number, and 1 of 1 of its row, 1 of all 1 numbers that it predicts, ours 0"
    assert rows["explanation"].tolist() == [f"{NOT_EXPLAINED}; {text}"] * 2


@pytest.mark.parametrize(("elsewhere", "explained"), [(99, True), (80, False)])
def test_an_explanation_has_to_stand_in_other_setups_too(tmp_path, elsewhere, explained):
    other = {**SERIES, "setup": "bond_mill", "value": "10:100"}
    points = points_of(tmp_path, {**SERIES, "value": "10:100;20:100"}, other)
    predicted = {
        "alumina_impact": pd.concat(
            [predictions_of((10, 50), (20, 50)), predictions_of((10, 99), (20, 99), model="slip", id="")]
        ),
        "bond_mill": pd.concat(
            [predictions_of((10, 99), id="t2"), predictions_of((10, elsewhere), model="slip", id="")]
        ),
    }
    rows = give_verdicts(points, predicted, {}, {name: ["slip"] for name in predicted})
    assert rows["explanation"].str.startswith("met by: slip").tolist() == [explained, explained, False]


def test_the_intervals_are_counted_by_setup_and_kind(tmp_path):
    points = points_of(
        tmp_path,
        {"value": "10:100;20:100", "uncertainty": "2"},
        {"value": "10:100", "class": "independent DEM"},
        {"value": "10:100", "uncertainty": "", "uncertainty_unit": ""},
    )
    ours = [
        predictions_of((10, 104), lower=99, upper=109, interval=CONTACT),
        predictions_of((20, 104), lower=101, upper=107, interval=CONTACT),
        predictions_of((10, 104), lower=99, upper=109, interval=CONTACT, id="t2"),
        predictions_of((10, 110), lower=105, upper=115, interval=SCATTER, id="t3"),
    ]
    table = tabulate_coverage(judge(points, pd.concat(ours))).set_index(["setup", "interval"])
    counts = table[["held", "overlapping", "numbers"]]
    assert counts.loc[("alumina_impact", CONTACT)].tolist() == [1, 2, 2]
    assert counts.loc[("alumina_impact", SCATTER)].tolist() == [0, 0, 1]
    assert counts.loc[("all", "all")].tolist() == [1, 2, 3]
    # Clopper and Pearson: none of one is 0 to 1 - 0.025; one of two is the interval of a beta distribution.
    assert table.loc[("all", SCATTER), ["lower", "upper"]].tolist() == pytest.approx([0, 0.975])
    assert table.loc[("all", CONTACT), ["lower", "upper"]].tolist() == pytest.approx([0.01258, 0.98742], abs=1e-4)


def test_coverage_counts_nothing_that_is_not_judged(tmp_path):
    points = points_of(tmp_path, {"value": "10:100;20:100"})
    ours = predictions_of((10, 100), lower=99, upper=101, interval=CONTACT)
    assert tabulate_coverage(judge(points, ours, unknown=["alumina_impact"])).empty
    assert tabulate_coverage(judge(points, ours))["numbers"].tolist() == [1, 1, 1]


def test_an_unknown_setup_is_shown_and_never_judged(tmp_path):
    points = points_of(
        tmp_path, {"setup": UNKNOWN, "value": "below 100", "x": "", "uncertainty": "", "uncertainty_unit": ""}
    )
    row = judge(points, predictions_of((np.nan, 50))).iloc[0]
    assert row["verdict"] == "set-up unknown"


def test_an_order_of_magnitude_is_shown_without_a_verdict(tmp_path):
    points = points_of(
        tmp_path, {"setup": "spex_shaker", "value": "1 to 3", "x": "", "uncertainty": "", "uncertainty_unit": ""}
    )
    (row,) = judge(points, predictions_of((np.nan, 2.0)), unknown=["spex_shaker"]).to_dict("records")
    assert (row["verdict"], row["predicted"], row["measured_uncertainty"]) == ("set-up unknown", 2.0, 1.0)


def test_what_was_not_predicted_is_not_run(tmp_path):
    points = points_of(tmp_path, {"value": "10:100;20:100"})
    rows = judge(points, predictions_of((10, 100), lower=99.0, upper=101.0, interval=CONTACT))
    assert rows["verdict"].tolist() == ["within both intervals", "not run"]
    counts = count_verdicts(rows).iloc[0]
    assert counts[["within both intervals", "not run", "off"]].tolist() == [1, 1, 0]


def test_a_reference_line_is_no_prediction(tmp_path):
    points = points_of(tmp_path, {"value": "10:100"})
    assert judge(points, predictions_of((10, 100), model="a formula"))["verdict"].tolist() == ["not run"]


def test_a_prediction_in_another_unit_stops(tmp_path):
    with pytest.raises(ValueError, match="predicted in J/rev, measured in W"):
        judge(points_of(tmp_path, {"value": "10:100"}), predictions_of((10, 100), unit="J/rev"))


# ---- The registry ----


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


def test_an_impact_is_predicted_at_the_measured_places_too(tmp_path):
    measured = points_of(
        tmp_path,
        {
            "quantity": "tangential restitution",
            "unit": "-",
            "value": "50:0.8",
            "uncertainty": "",
            "uncertainty_unit": "",
        },
    )
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
    measured = points_of(
        tmp_path,
        {
            "quantity": "tangential restitution",
            "unit": "-",
            "value": "50:0.8",
            "uncertainty": "",
            "uncertainty_unit": "",
        },
    )
    figure = plot_setup(predict_impact(measured), measured, "a title")
    labels = [axis.get_ylabel().replace("\n", " ") for axis in figure.axes if axis.get_visible()]
    assert "tangential restitution [-]" in labels and "rebound angle of the centre [deg]" in labels
    drawn = [each.get_label() for each in figure.axes[0].containers]
    assert "measured" in drawn


# ---- When the settings were fixed ----


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


# ---- Own measurements ----

OWN = "id\tsetup\tquantity\tx\tvalue\tunit\nmine\tslice_mill\tpower\tspeed\t{value}\tW\n"


def own_table(tmp_path, value: str = "55:.5;65:21.6", old: str = "", new: str = ""):
    path = tmp_path / "mine.tsv"
    path.write_text(OWN.format(value=value).replace(old, new))
    return path


def test_a_table_of_own_rows_is_enough(tmp_path):
    rows = read_measurements(own_table(tmp_path), SETUPS)
    assert measured_points(rows)["measured"].tolist() == [0.5, 21.6]
    assert rows.loc[0, "class"] == "measured"
    check_measured(own_table(tmp_path), SETTINGS)


@pytest.mark.parametrize(
    ("old", "new", "part"),
    [
        ("power", "powr", "id mine: quantity = 'powr'.*did you mean power?"),
        ("\tW\n", "\tm/s\n", "id mine: unit = 'm/s': must be W"),
        ("power", "power, 169 balls", None),
    ],
)
def test_a_quantity_that_no_run_predicts_is_refused_before_it(tmp_path, old, new, part):
    path = own_table(tmp_path, old=old, new=new)
    with pytest.raises(ConfigError, match=part) if part else nullcontext():
        check_measured(path, SETTINGS)


def test_the_included_rows_can_all_be_asked():
    check_measured(MEASURED, SETTINGS)


def test_own_points_cost_one_simulation_each_unless_intervals_are_asked_for(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    points = measured_points(read_measurements(own_table(tmp_path, "20:1;30:2;40:3"), SETUPS))

    def simulated(**keys) -> int:
        content = {"mill": "slice_mill", "validation": {"measured": "mine.tsv", **keys}}
        config, _, contacts, _ = load_workflow(content, [], SOURCES)
        (settings,) = config.validation.chosen.values()
        return len(design(settings, contacts, measured_speeds(settings, points)))

    assert simulated() == 3
    assert simulated(intervals=True) == 112


def test_a_tumbling_mill_without_intervals_is_compared_too(tmp_path):
    """One seed and one contact set: numbers without intervals, at the measured speeds."""
    settings = SETTINGS["slice_mill"].without_intervals()
    points = measured_points(read_measurements(own_table(tmp_path, "55:17"), SETUPS))
    slice_contact = contact_set("slice_mill", restitution=0.5)
    runs = design(settings, {settings.contact: slice_contact}, measured_speeds(settings, points))
    results = {"power_W": 18.0, "toe_deg": 130.0, "shoulder_deg": 300.0, "rings": 0.0, "carried": 0}
    write_table(runs.assign(**results), tmp_path / "runs.tsv")
    predicted = predict(
        "slice_mill", settings, load_mill("slice_mill"), {settings.contact: slice_contact}, DemConfig(), {},
        "", points, tmp_path,
    )  # fmt: skip
    (own,) = predicted[predicted["id"] == "mine"].to_dict("records")
    assert own["predicted"] == 18.0 and own["lower"] != own["lower"] and own["interval"] == ""
    verdicts = give_verdicts(points, {"slice_mill": predicted}, {}, {})
    assert verdicts["verdict"].tolist() == ["within 10 %"]
