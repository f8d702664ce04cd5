"""Predictions that wait: the table is what the included fingerprints say, one generation a release, and on the page."""

import pandas as pd
import pytest
from tools import fix_mill_predictions
from tools.fix_mill_predictions import BY_MEAN, LEAF_SPRING, digest_of_file, fix_waiting, swing_rows

from millprint.config.setup_models import SETTINGS, SWING
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import find_ready_made, ready_made
from millprint.validation import waiting
from millprint.validation.measured import prediction
from millprint.validation.waiting import IMPACTS, POWER, TABLE, read_waiting
from tests.conftest import ROOT


def test_the_table_holds_what_the_included_fingerprints_predict():
    table = read_waiting(ROOT / TABLE)
    assert set(table["mill"]) == {*ready_made(), LEAF_SPRING}
    place = find_ready_made("planetary")
    own = table[(table["digest"] == digest_of_file(place)) & (table["quantity"] == POWER)]
    by_contact = own[own["interval"] == waiting.BY_CONTACT]
    own = own[own["interval"] == BY_MEAN]
    fingerprint = Fingerprint.read(place)
    for row in own.itertuples():
        condition = fingerprint.condition(
            ball_diameter_m=row.ball_diameter_mm / 1e3, fill_ratio=row.fill_ratio, speed_rpm=row.speed_rpm
        )
        power = fingerprint.predict(condition).wall_power_W
        assert power.value == pytest.approx(row.value, rel=1e-3)
        assert power.mean.upper == pytest.approx(row.upper, rel=1e-3)
    assert len(own) == len(by_contact) == 9
    # What nobody has measured leaves more open than the scatter of the simulation.
    assert ((by_contact["upper"] / by_contact["lower"]).to_numpy() > (own["upper"] / own["lower"]).to_numpy()).all()


def test_a_condition_finds_the_newest_generation_that_is_older_than_the_measurement():
    table = read_waiting(ROOT / TABLE)
    generations = table[table["mill"] == "planetary"].drop_duplicates("release").set_index("release")["date"]
    assert generations.is_monotonic_increasing and table.groupby(["mill", "release"])["date"].nunique().max() == 1
    condition = ("planetary", 10.0, 0.15, 300.0, IMPACTS)
    assert waiting.fixed_before("2026-11-26", *condition) is None
    for date, release in (
        ("2026-11-26 20:00", "0.3.0"),
        ("2026-11-27", "0.3.1"),
        ("2999-01-01", generations.index[-1]),
    ):
        row = waiting.fixed_before(date, *condition)
        assert row["release"] == release and row["lower"] < row["value"] < row["upper"]
    # Rolling was not in the power of earlier releases.
    assert waiting.fixed_before("2026-11-27", *condition[:4], POWER) is None
    assert waiting.fixed_before("2999-01-01", "planetary", 10.0, 0.16, 300.0, POWER) is None


def test_a_changed_fingerprint_replaces_the_rows_of_its_release_and_keeps_earlier_ones(tmp_path, monkeypatch):
    path = tmp_path / "waiting.tsv"
    rows = read_waiting(ROOT / TABLE).query("mill == 'planetary'").reset_index(drop=True)
    monkeypatch.setattr(fix_mill_predictions, "ready_made", lambda: ["planetary"])
    without = rows.drop(columns=["release", "date", "digest"])
    monkeypatch.setattr(fix_mill_predictions, "predictions_of", lambda mill, own: without)
    assert fix_waiting(path, "1.0", "2026-01-01 00:00") == ["planetary"]
    assert fix_waiting(path, "1.1", "2026-01-02 00:00") == []
    for digest, release, now in (("a", "1.1", "2026-01-03 00:00"), ("b", "1.1", "2026-01-04 00:00")):
        monkeypatch.setattr(fix_mill_predictions, "digest_of_file", lambda place, digest=digest: digest)
        assert fix_waiting(path, release, now) == ["planetary"]
    table = read_waiting(path)
    assert len(table) == 2 * len(rows) and list(table["date"].unique()) == ["2026-01-01 00:00", "2026-01-04 00:00"]


def test_a_swing_has_a_row_for_each_second():
    predicted = pd.DataFrame([prediction(SWING, "-", 9.0, x=2.0, lower=8.5, upper=9.5, interval="scatter of seeds")])
    rows = swing_rows(predicted, SETTINGS[LEAF_SPRING])
    assert rows["quantity"].tolist() == [f"{SWING} after 2 s"] and rows["fill_ratio"].tolist() == [0.179]
