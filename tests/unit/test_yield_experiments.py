"""The batch of next experiments, and ask and tell: what is running or done changes the next batch."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import predict_yields
import train_averaged_models
from millprint.run.files import read_table, write_table
from millprint.thesis.curves.regimes import read_regimes
from millprint.thesis.yields.experiments import DONE, RUNNING, SETTINGS, read_experiments, region_conditions
from millprint.thesis.yields.model_files import load_averaged, training_rows
from millprint.thesis.yields.new_conditions import MillCurves, predict_conditions
from millprint.thesis.yields.proposals import choose_centre, choose_repeats, same_setting
from millprint.thesis.yields.run_tables import read_rows
from tests.unit.doe_settings import settings as doe_settings
from tests.unit.test_yield_proposals import MILL, REFERENCE, REGIMES
from tests.unit.yield_settings import all_runs, parts, settings

CASES = read_regimes(str(REGIMES))
CHEMISTRY = doe_settings().chemistry
NEW = {"case": "mine", "status": DONE, "bpr": 40, "molar_ratio": 10, "time_h": 17.5, "speed_rpm": 900}
NEW |= {"fill_ratio": 0.08, "ball_diameter_mm": 10, "yield_percent": 93.0}


def batch(folder: Path, experiments: pd.DataFrame | None = None, **changes) -> SimpleNamespace:
    """What the scripts write for a table of experiments: paths, and the tables of proposals and of what is left out."""
    folder.mkdir(exist_ok=True)
    config = settings()
    paths = {name: str(folder / f"{name}.tsv") for name in ("train", "test", "rows", "next", "left_out", "reasons")}
    for name, rows in zip(("train", "test"), parts(), strict=True):
        write_table(rows, paths[name])
    proposals = config.proposals.model_copy(update=changes)
    if experiments is not None:
        write_table(experiments, folder / "experiments.tsv")
        proposals = proposals.model_copy(update={"experiments": str(folder / "experiments.tsv")})
    model, mill = str(folder / "averaged_gpr_final.json"), str(folder / "mill.json")
    screening = [paths["train"], paths["test"]]
    train_averaged_models.collect(screening, CASES, None, paths["rows"], mill, REFERENCE, "emax", 125e-6, proposals)
    train_averaged_models.main([paths["rows"]], model, config.averaging)
    output = SimpleNamespace(proposals=paths["next"], left_out=paths["left_out"], reasons=paths["reasons"])
    predict_yields.propose_experiments(model, mill, output, 125e-6, proposals, config.prediction, CHEMISTRY)
    text = ["case", "status", "purpose", "gain_unit", "repeats"]
    return SimpleNamespace(
        model=model, mill=mill, path=paths["next"], next=read_table(paths["next"], text=text), config=config
    )


@pytest.fixture(scope="module")
def first(tmp_path_factory) -> SimpleNamespace:
    return batch(tmp_path_factory.mktemp("first"))


def test_the_model_that_proposes_also_predicts_every_proposal(first):
    """One final model with 31 rows: what it recommends, it does not refuse."""
    assert len(training_rows(first.model)) == 31
    rows, config = read_rows(first.path, yields=False), first.config
    own = (config.prediction, config.training, config.evaluation.conformal_folds, config.proposals.level)
    table = predict_conditions(first.model, rows, *own, mill=MillCurves.read(first.mill))
    assert (table["warning"] == "").all()
    np.testing.assert_allclose(table["predicted_percent"], first.next["predicted_percent"], rtol=1e-5)
    np.testing.assert_allclose(table["lower_percent"], first.next["lower_percent"], rtol=1e-5)


def test_a_batch_has_repeats_and_a_centre_point_within_the_region_and_its_limits(first):
    table, region = first.next, first.config.proposals.region
    assert table["purpose"].tolist()[:3] == ["repeat", "repeat", "centre"]
    assert (table["status"] == "proposed").all() and table["yield_percent"].isna().all()
    for name in SETTINGS:
        assert set(table[name]) <= set(getattr(region, name))
    assert table["powder_mass_g"].max() <= region.powder_max_g
    assert table["hydrogen_mmol"].max() <= region.hydrogen_max_mmol
    assert (table["lower_percent"] <= table["predicted_percent"]).all()
    assert not table.duplicated(list(SETTINGS)).any()
    # The best run, and its settings.
    best = all_runs().set_index("case").loc[table["repeats"][0]]
    assert best["yield_percent"] == 90 and table["bpr"][0] == best["bpr"] and table["time_h"][0] == best["time_h"]
    centre = table[table["purpose"] == "centre"].iloc[0]
    assert centre[["bpr", "molar_ratio", "time_h", "fill_ratio"]].tolist() == [30, 10, 12.5, 0.10]


@pytest.mark.slow
def test_running_experiments_are_taken_into_account(first, tmp_path):
    """A batch that is running is as good as done: the next one is another, and the model is the same."""
    experiments = first.next.assign(status=RUNNING)
    second = batch(tmp_path, experiments)
    assert training_rows(second.model).equals(training_rows(first.model))
    assert load_averaged(second.model).weights.tolist() == load_averaged(first.model).weights.tolist()
    chosen = [
        set(map(tuple, each.next[each.next["purpose"] != "centre"][list(SETTINGS)].to_numpy()))
        for each in (first, second)
    ]
    assert not chosen[0] & chosen[1]
    assert not set(second.next["case"]) & set(first.next["case"])
    assert not set(second.next["repeats"].dropna()) & set(first.next["repeats"].dropna())
    learned = [each.next.loc[each.next["purpose"] == "learning", "gain"].max() for each in (first, second)]
    assert learned[1] < learned[0]
    # What is only proposed is not under way.
    again = batch(tmp_path / "proposed", first.next)
    assert again.next[list(SETTINGS)].equals(first.next[list(SETTINGS)])


@pytest.mark.slow
def test_done_experiments_train_the_model_with_the_descriptors_of_their_settings(first, tmp_path):
    told = batch(tmp_path, pd.DataFrame([NEW]))
    rows = training_rows(told.model)
    assert len(rows) == 32 and rows["case"].iloc[-1] == "mine" and rows["yield_percent"].iloc[-1] == 93
    region = first.config.proposals.region
    same = region_conditions(region, CASES, MILL).set_index(list(SETTINGS))
    at = same.loc[(40, 10, 17.5, 900, 0.08, 10)]
    for name in ("normal_energy_uJ", "tangential_energy_uJ", "specific_frequency_hz"):
        assert rows[name].iloc[-1] == pytest.approx(at[name], rel=1e-6)
    predicted = [load_averaged(each.model).predict(rows.tail(1))[0] for each in (first, told)]
    assert abs(predicted[1] - 93) < abs(predicted[0] - 93)


def test_a_table_of_experiments_may_still_be_empty(tmp_path):
    write_table(pd.DataFrame([NEW]).head(0), tmp_path / "experiments.tsv")
    assert read_experiments(str(tmp_path / "experiments.tsv"), CASES).empty


def region_rows() -> pd.DataFrame:
    return region_conditions(settings().proposals.region, CASES, MILL)


def test_runs_are_found_at_the_settings_that_they_had():
    rows, region = all_runs(), region_rows()
    places = same_setting(rows, region, 0.03)
    assert (places >= 0).all()
    found = region.iloc[places].reset_index(drop=True)
    assert (found[["bpr", "molar_ratio", "time_h"]] == rows[["bpr", "molar_ratio", "time_h"]]).all(axis=None)
    assert (found["fill_ratio"] == 0.10).all()
    speeds = rows["specific_frequency_hz"].map({400: 600, 533: 800, 667: 1000})
    assert (found["speed_rpm"] == speeds).all()
    assert (same_setting(rows.assign(bpr=33.0), region, 0.03) == -1).all()


def test_repeats_start_with_the_best_run_and_spread_over_the_yields():
    rows, region = all_runs(), region_rows()
    none = region.iloc[:0]
    chosen = [case for _, case in choose_repeats(rows, region, none, 3, 0.03)]
    yields = rows.set_index("case")["yield_percent"]
    assert yields[chosen].tolist()[:2] == [90, 12] and 40 < yields[chosen[2]] < 62
    # What was repeated already, or is being repeated, needs no repeat.
    twice = pd.concat([rows, rows[rows["case"] == "24"].assign(case="again")], ignore_index=True)
    assert "24" not in [case for _, case in choose_repeats(twice, region, none, 3, 0.03)]
    running = region.iloc[same_setting(rows[rows["case"] == "24"], region, 0.03)]
    assert "24" not in [case for _, case in choose_repeats(rows, region, running, 3, 0.03)]


def test_the_centre_is_the_middle_of_the_screening():
    region = region_rows()
    centre = region.iloc[choose_centre(all_runs(), region)]
    assert centre[["bpr", "molar_ratio", "time_h", "speed_rpm"]].tolist() == [30, 10, 12.5, 800]
