"""The validation: the measured table, and the verdicts on its numbers."""

import numpy as np
import pandas as pd
import pytest

from millprint.config.errors import ConfigError
from millprint.config.setup_models import SETTINGS
from millprint.validation.measured import (
    CONTACT,
    SCATTER,
    UNKNOWN,
    measured_points,
    parse_value,
    prediction,
    read_measurements,
)
from millprint.validation.verdicts import NOT_EXPLAINED, count_verdicts, give_verdicts, tabulate_coverage
from tests.refusals import refusal, refusals, truths
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
    return measured_points(read_measurements(table_with(tmp_path, *changes), SETTINGS))


# ---- The measured table ----


def test_the_measured_table_is_whole():
    rows = read_measurements(MEASURED, SETTINGS)
    given = {"1a", "1c", "1d", "2a", "2c", "3a", "3b", "4a", "4b", "4c", "5a", "5b", "5c", "7", "8a", "8b", "8c", "8d"}
    assert set(rows["id"]) >= given
    assert (rows["source"] != "").all()
    assert (rows.set_index("id").loc[["8b", "8c", "8d"], "setup"] == UNKNOWN).all()
    points = measured_points(rows)
    assert len(points[points["id"] == "3a"]) == 10
    # 5 to 8 % of 134.9 rad/s; the larger is taken.
    first = points[points["id"] == "3b"].iloc[0]
    assert first["measured_upper"] - first["measured"] == pytest.approx(0.08 * 134.9)


@pytest.mark.parametrize(("change", "words"), refusals("a_measured_table_is_refused_in_one_line"))
def test_a_measured_table_is_refused_in_one_line(tmp_path, change, words):
    path = table_with(tmp_path, change)
    line = refusal(read_measurements, path, SETTINGS)
    assert str(path) in line
    for word in words:
        assert word in line


def test_two_rows_of_one_id_are_refused(tmp_path):
    with pytest.raises(ConfigError, match="column id = a appears twice"):
        read_measurements(table_with(tmp_path, {"id": "a"}, {"id": "a"}), SETTINGS)


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
    return give_verdicts(points, {setup: predictions}, {setup: variants}, **options)


@pytest.mark.parametrize(("predicted", "lower", "upper", "reason"), truths("verdicts_on_a_number"))
def test_the_rules_of_a_verdict(tmp_path, predicted, lower, upper, reason):
    points = points_of(tmp_path, {"value": "10:100"})
    bounds = {"lower": lower, "upper": upper, "interval": CONTACT}
    row = judge(points, predictions_of((10, predicted), **bounds)).iloc[0]
    assert (row["verdict"], row["reason"]) == ("differs" if reason == "off" else "agrees", reason)
    assert row["ratio"] == pytest.approx(predicted / 100)
    assert row["explanation"] == (NOT_EXPLAINED if reason == "off" else "")


@pytest.mark.parametrize(("unit", "tolerance", "close"), truths("tolerances_by_unit"))
def test_angles_places_and_counts_have_a_tolerance_and_a_verdict_of_their_own(tmp_path, unit, tolerance, close):
    points = points_of(tmp_path, {"value": "27", "x": "", "unit": unit, "uncertainty": "", "uncertainty_unit": ""})
    for shift, verdict in ((0.99, close), (1.01, "off")):
        row = judge(points, predictions_of((np.nan, 27 - shift * tolerance), unit=unit)).iloc[0]
        assert row["tolerance"] == pytest.approx(tolerance)
        assert row["reason"] == verdict


def test_a_series_that_changes_its_sign_is_not_judged_by_ratios_near_zero(tmp_path):
    points = points_of(tmp_path, {"value": "1:-1;2:0.01;3:2", "uncertainty": "", "uncertainty_unit": ""})
    rows = judge(points, predictions_of((1, -1.0), (2, 0.1), (3, 2.3)))
    assert rows["tolerance"].tolist() == pytest.approx([0.10033, 0.10033, 0.2], rel=1e-3)
    assert rows["reason"].tolist() == ["near", "near", "off"]


SERIES = {"value": "10:100;20:100;30:100;40:100", "uncertainty": "", "uncertainty_unit": ""}
OURS = [(10.0, 50.0), (20.0, 60.0), (30.0, 99.0), (40.0, 101.0)]


@pytest.mark.parametrize(("variant", "explained", "text"), truths("variants_that_explain"))
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
    rows = give_verdicts(points, predicted, {name: ["slip"] for name in predicted})
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
    assert tabulate_coverage(judge(points.assign(setup=UNKNOWN), ours)).empty
    assert tabulate_coverage(judge(points, ours))["numbers"].tolist() == [1, 1, 1]


def test_an_unknown_setup_is_shown_and_never_judged(tmp_path):
    points = points_of(
        tmp_path, {"setup": UNKNOWN, "value": "below 100", "x": "", "uncertainty": "", "uncertainty_unit": ""}
    )
    row = judge(points, predictions_of((np.nan, 50))).iloc[0]
    assert (row["verdict"], row["reason"]) == ("open", "set-up unknown")


def test_what_was_not_predicted_is_not_run(tmp_path):
    points = points_of(tmp_path, {"value": "10:100;20:100"})
    rows = judge(points, predictions_of((10, 100), lower=99.0, upper=101.0, interval=CONTACT))
    assert rows["reason"].tolist() == ["within both intervals", "not run"]
    counts = count_verdicts(rows).iloc[0]
    assert counts[["within both intervals", "not run", "off"]].tolist() == [1, 1, 0]


def test_a_reference_line_is_no_prediction(tmp_path):
    points = points_of(tmp_path, {"value": "10:100"})
    assert judge(points, predictions_of((10, 100), model="a formula"))["reason"].tolist() == ["not run"]


def test_a_prediction_in_another_unit_stops(tmp_path):
    with pytest.raises(ValueError, match="predicted in J/rev, measured in W"):
        judge(points_of(tmp_path, {"value": "10:100"}), predictions_of((10, 100), unit="J/rev"))
