"""Runs of other sources: what is read and refused, and whether a shift between sources is seen."""

import re

import numpy as np
import pandas as pd
import pytest
import yaml
from scripts import split_screening

from millprint.config.yields import OtherSourcesConfig
from millprint.thesis.doe.factorial_designs import YIELD
from millprint.thesis.yields import experiments as tables
from millprint.thesis.yields import groups as sources
from millprint.thesis.yields.experiments import read_rows
from millprint.thesis.yields.features import CONDITIONS
from millprint.thesis.yields.held_out import procedure_of
from tests.conftest import ROOT
from tests.refusals import refusal, refusals
from tests.unit.doe_settings import SCREENING
from tests.unit.doe_settings import settings as doe_settings
from tests.unit.synthetic_mill import fingerprint
from tests.unit.yield_settings import SPLIT, all_runs, settings

PAGE = (ROOT / "docs/how_to/other_sources.md").read_text()
TABLE, KEYS = re.findall(r"^```(?:text|yaml)\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
FILE = "my.yaml"


@pytest.fixture
def example(tmp_path, monkeypatch) -> OtherSourcesConfig:
    """The example of the handbook, with its files in the working folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "config/data").mkdir(parents=True)
    (tmp_path / "config/data/others.tsv").write_text(TABLE)
    fingerprint().write("config/data/south.json")
    return OtherSourcesConfig(**yaml.safe_load(KEYS)["yields"]["other_sources"])


def test_the_handbooks_example_is_read_and_its_energies_are_those_of_the_fingerprint(example):
    runs = tables.read_other_runs(example, {}, FILE)
    assert runs["descriptors"].tolist() == ["given"] * 5 + ["gap_0_03"] * 2
    assert runs[list(CONDITIONS)].notna().all(axis=None)
    model = fingerprint()
    condition = model.condition(speed_hz=700 / 60, ball_diameter_m=0.010, fill_ratio=0.10)
    told = model.predict(condition)
    row = runs.set_index("case").loc["s1"]
    assert row["normal_energy_uJ"] == pytest.approx(1e6 * told.normal_energy_J.value, rel=1e-9)
    assert row["tangential_energy_uJ"] == pytest.approx(1e6 * told.tangential_energy_J.value, rel=1e-9)
    assert row["specific_frequency_hz"] == pytest.approx(told.specific_frequency_hz.value, rel=1e-9)


def test_the_handbooks_example_is_scored(example):
    yields = settings()
    rows = tables.with_other_runs(all_runs(), tables.read_other_runs(example, {}, FILE), example.own)
    procedures = {("linear", "primary"): procedure_of("linear", "primary", yields.training, yields.evaluation, None)}
    predictions = sources.leave_sources_out(rows, procedures, yields.prediction, 0.8)
    table = sources.score_sources(predictions, rows, yields.evaluation, 0.8).set_index("source")
    assert table["runs"].to_dict() == {"thesis": 27, "north": 5, "south": 2}
    assert table["training_runs"].to_dict() == {"thesis": 7, "north": 29, "south": 32}
    assert table.loc["thesis", "reason"] == sources.TOO_FEW_TRAINED
    assert table.loc["south", "reason"] == sources.TOO_FEW_HELD
    assert np.isfinite(table.loc["north", ["r2", "r2_lower", "r2_upper", "skill", "mean_error_pp"]].astype(float)).all()
    assert table.loc["south", "outside_domain"] == 1 and table.loc["north", "outside_domain"] == 0


@pytest.mark.parametrize(("old", "new", "message"), refusals("a_bad_table_is_refused_in_one_line"))
def test_a_bad_table_is_refused_in_one_line(example, tmp_path, old, new, message):
    assert old in TABLE
    text = TABLE.replace(old, new, 1)
    if message is None:
        # Fractions are known by the whole source: one yield below 1 % may be meant.
        text = text.replace("\t78\n", "\t0.78\n")
        message = "column yield_percent, case s2 = 0.78: no value is above 1: is that 78 % or 0.78 %?"
    (tmp_path / example.runs).write_text(text)
    line = refusal(tables.read_other_runs, example, {"screening.tsv": ["14"]}, FILE)
    assert message in line
    assert line.startswith(f"{example.runs}: ")


def two_sources(shift: float) -> pd.DataFrame:
    """The 27 conditions with yields by a smooth rule, and 18 others between them that yield `shift` points more."""
    generator = np.random.default_rng(3)
    own = all_runs()
    others = own.iloc[generator.permutation(len(own))[:18]].reset_index(drop=True)
    others = others.assign(case=[f"o{i}" for i in range(len(others))])
    for name in ("bpr", "molar_ratio", "time_h"):
        others[name] = generator.uniform(own[name].min(), own[name].max(), len(others))

    def truth(rows: pd.DataFrame) -> np.ndarray:
        smooth = 40 + 0.3 * (rows["bpr"] - 30) + 1.6 * (rows["time_h"] - 12.5) + 3 * (rows["molar_ratio"] - 10)
        return smooth.to_numpy(float) + generator.normal(0, 2, len(rows))

    own = own.assign(**{YIELD: truth(own)})
    others = others.assign(source="other", **{YIELD: truth(others) + shift})
    return tables.with_other_runs(own, others, "own")


def scored(rows: pd.DataFrame, model: str) -> tuple[pd.DataFrame, pd.DataFrame]:
    yields = settings()
    procedures = {
        (model, "primary"): procedure_of(model, "primary", yields.training, yields.evaluation, yields.averaging)
    }
    predictions = sources.leave_sources_out(rows, procedures, yields.prediction, 0.8)
    table = sources.score_sources(predictions, rows, yields.evaluation, 0.8)
    return table.set_index("source"), predictions


def test_scores_of_a_source_have_the_interval_of_their_mean():
    truth, error = np.linspace(10, 70, 40), 3 + 4 * np.sin(np.arange(40.0))
    held = pd.DataFrame({"source": "a", YIELD: truth, "predicted_percent": truth + error, "outside": ""})
    held = held.assign(model="m", strategy="primary", climatology_percent=50.0, lower_percent=0.0, upper_percent=60.0)
    rows = pd.DataFrame({"source": ["a"] * 40 + ["b"] * 30})
    budget = settings().evaluation.model_copy(update={"resamples": 20_000})
    row = sources.score_sources(held, rows, budget, 0.8).set_index("source").loc["a"]
    assert row["mean_error_pp"] == pytest.approx(error.mean())
    assert row["mean_error_pp_upper"] - row["mean_error_pp_lower"] == pytest.approx(
        2 * 1.96 * error.std() / np.sqrt(40), rel=0.03
    )
    assert row["skill"] == pytest.approx(1 - (error**2).mean() / ((50 - truth) ** 2).mean())
    assert row["rank_correlation"] == pytest.approx(pd.Series(truth).corr(pd.Series(truth + error), method="spearman"))
    assert row["covered"] == (truth <= 60).mean() and row["training_runs"] == 30


def test_a_source_whose_yields_do_not_vary_decides_nothing():
    held = pd.DataFrame({"source": "a", YIELD: 50.0, "predicted_percent": np.linspace(40, 70, 8), "outside": ""})
    held = held.assign(model="m", strategy="primary", climatology_percent=40.0, lower_percent=0.0, upper_percent=60.0)
    rows = pd.DataFrame({"source": ["a"] * 8 + ["b"] * 30})
    row = sources.score_sources(held, rows, settings().evaluation, 0.8).set_index("source").loc["a"]
    assert np.isnan(row["r2"])
    assert (row["verdict"], row["reason"]) == ("open", sources.NO_SCORE)


@pytest.mark.parametrize("model", ["linear", "averaged_gpr"])
@pytest.mark.slow
def test_without_a_shift_yields_transfer(model):
    table, predictions = scored(two_sources(0.0), model)
    assert table["reason"].tolist() == [sources.TRANSFERS] * 2
    assert (table["skill_lower"] > 0).all() and (table["r2"] > 0.7).all()
    assert (table["mean_error_pp"].abs() < 5).all()
    assert len(predictions) == 45 and predictions["case"].is_unique


@pytest.mark.parametrize("model", ["linear", "averaged_gpr"])
def test_a_shift_between_sources_is_seen_in_both_directions(model):
    table, _ = scored(two_sources(30.0), model)
    assert table["reason"].tolist() == [sources.ORDER_ONLY] * 2
    assert (table["r2_upper"] < 0).all()
    # Predicted less measured: the other source yields 30 points more.
    assert table["mean_error_pp"].tolist() == pytest.approx([30, -30], abs=5)
    assert table.loc["other", "mean_error_pp_upper"] < -25
    # The reason why the skill does not decide.
    assert (table["skill"] > 0).all()


def test_yields_of_another_order_do_not_transfer():
    rows = two_sources(0.0)
    other = rows["source"] == "other"
    rows.loc[other, YIELD] = 2 * rows.loc[other, YIELD].mean() - rows.loc[other, YIELD]
    table, _ = scored(rows, "linear")
    assert table["reason"].tolist() == [sources.FAILS] * 2
    assert (table["rank_correlation_upper"] < 0).all() and (table["skill"] < 0).all()


def test_a_source_is_predicted_without_any_of_its_own_runs():
    """Poisoned yields of a source must change the predictions of the other one only."""
    rows = two_sources(0.0)
    other = (rows["source"] == "other").to_numpy()
    _, before = scored(rows, "linear")
    _, after = scored(rows.assign(**{YIELD: np.where(other, 1.0, rows[YIELD])}), "linear")
    changed = before["predicted_percent"].to_numpy() != after["predicted_percent"].to_numpy()
    assert (changed == (before["source"] == "own")).all()


@pytest.mark.parametrize("in_training", [False, True])
def test_others_join_the_training_rows_only_if_told_and_never_the_test_rows(example, tmp_path, in_training):
    factors = doe_settings().factors
    told = OtherSourcesConfig(**{**example.model_dump(), "in_training": in_training})
    split_screening.main(str(SCREENING), str(SPLIT), "train.tsv", "test.tsv", factors, told)
    train, test = (read_rows(str(tmp_path / f"{part}.tsv")) for part in ("train", "test"))
    assert test["case"].tolist() == ["9", "14", "10", "22", "1", "12"]
    assert train["case"].tolist()[21:] == (["n1", "n2", "n3", "n4", "n5", "s1", "s2"] if in_training else [])
