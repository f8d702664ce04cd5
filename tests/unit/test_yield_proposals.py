"""The next experiments: the region and its safety, the value of a run, and batches."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm

import predict_yields
import train_averaged_models
from millprint.config.doe import ChemistryConfig
from millprint.config.errors import ConfigError
from millprint.config.included import load_mill
from millprint.config.yields import RegionConfig
from millprint.run.files import read_table, write_table
from millprint.thesis.doe.chemistry import hydrogen_released
from millprint.thesis.yields.averaging import AveragedModel, Candidate, fit_averaged
from millprint.thesis.yields.estimators import Process
from millprint.thesis.yields.experiments import (
    DONE,
    SETTINGS,
    check_region,
    read_experiments,
    read_rows,
    region_conditions,
    safety_warnings,
    with_hydrogen,
)
from millprint.thesis.yields.features import describe
from millprint.thesis.yields.groups import (
    leave_regimes_out,
    reference_of_mill,
    regime_rows,
    summarise_regimes,
    without_regime,
)
from millprint.thesis.yields.held_out import Prediction
from millprint.thesis.yields.new_conditions import MillCurves, predict_conditions
from millprint.thesis.yields.proposals import (
    choose_centre,
    choose_for_learning,
    choose_for_yield,
    choose_repeats,
    count_reasons,
    expected_improvement,
    joint_draws,
    same_setting,
    shortlist,
    split_region,
)
from millprint.thesis.yields.stored_models import load_averaged, training_rows
from tests.unit.doe_settings import settings as doe_settings
from tests.unit.yield_settings import CASES, CURVES, MILL, REFERENCE, SCALES, all_runs, fit_member, parts, settings

REGION = {
    "bpr": [10, 30],
    "molar_ratio": [10],
    "time_h": [12.5, 20],
    "speed_rpm": [600, 1000],
    "fill_ratio": [0.06, 0.10],
    "ball_diameter_mm": [10],
}


def test_a_mill_without_an_amplitude_of_its_own_has_that_of_its_walls():
    planetary = load_mill("planetary")
    reference = reference_of_mill(CASES, planetary, reference_speed=5.0, density=7700.0, diameter=0.01)
    # The wall moves as far as the radii of the sun wheel and of the jar together.
    assert reference.amplitude_m == pytest.approx((70.5 + 37.5) * 1e-3, rel=1e-3)


def conditions() -> pd.DataFrame:
    return region_conditions(RegionConfig(**REGION), CASES, MILL)


def one_member(link: str = "identity") -> tuple[AveragedModel, pd.DataFrame]:
    rows = all_runs()
    member = fit_member(
        Candidate(link, SCALES, "product"), rows, rows["yield_percent"].to_numpy(float), settings().averaging
    )
    return AveragedModel([member], np.array([1.0])), rows


def test_region_is_every_combination_with_the_descriptors_of_the_screening():
    table = conditions().set_index(["bpr", "time_h", "speed_rpm", "fill_ratio"])
    assert len(table) == 16
    row = table.loc[(30, 12.5, 600, 0.10)]
    assert row["normal_energy_uJ"] == pytest.approx(221, rel=0.002)
    assert row["tangential_energy_uJ"] == pytest.approx(500, rel=0.003)
    assert row["specific_frequency_hz"] == pytest.approx(400, rel=1e-9)
    # 24 balls of 10 mm at 7700 kg/m3 over a ball-to-powder ratio of 30.
    assert row["balls"] == 24 and row["powder_mass_g"] == pytest.approx(24 * 7.7 * np.pi / 6 / 30)


def test_region_outside_the_curves_is_refused_in_one_line():
    region = RegionConfig(**(REGION | {"fill_ratio": [0.10, 0.40]}))
    with pytest.raises(ConfigError, match=r"region\.fill_ratio = 0\.4: the master curves cover 0\.06 to 0\.17"):
        check_region(region, CASES, "config.yaml")


def test_expected_improvement_is_that_of_a_normal():
    model, _ = one_member()
    table = conditions()
    best = 60.0
    mean, deviation = (100 * each for each in model.members[0].latent(describe(table).to_numpy()))
    u = (mean - best) / deviation
    exact = deviation * (u * norm.cdf(u) + norm.pdf(u))
    low = mean + 4 * deviation < 100  # where the limit of 100 % has no effect
    assert low.any()
    np.testing.assert_allclose(expected_improvement(model, table, best)[low], exact[low], atol=0.25)


def test_draws_have_the_mean_and_the_correlation_of_the_process():
    model, _ = one_member()
    table = conditions().iloc[[0, 1, 5]]
    drawn = joint_draws(model, table, 40000, np.random.default_rng(0))
    member = model.members[0]
    mean, covariance = member.process.posterior(member.standard(describe(table).to_numpy()))
    inside = (drawn > 0) & (drawn < 100)
    assert inside.mean() > 0.98
    np.testing.assert_allclose(drawn.mean(axis=0), 100 * (member.mean + member.spread * mean), atol=0.8)
    scale = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(np.corrcoef(drawn.T), covariance / np.outer(scale, scale), atol=0.06)


def test_a_copy_of_the_first_run_adds_nothing_to_the_batch():
    generator = np.random.default_rng(2)
    first, other = generator.normal(60, 10, 5000), generator.normal(58, 10, 5000)
    draws = np.column_stack([first, first, other])
    batch = choose_for_yield(draws, 55.0, 3)
    assert [column for column, _ in batch] == [0, 2, 1]
    assert batch[0][1] == pytest.approx(np.maximum(first - 55, 0).mean())
    assert batch[2][1] == 0
    joint = np.maximum(np.maximum(first, other), 55).mean() - 55
    assert batch[0][1] + batch[1][1] == pytest.approx(joint)


def test_what_is_awaited_counts_as_done_and_a_small_gain_ends_the_batch():
    generator = np.random.default_rng(2)
    first, other = generator.normal(60, 10, 5000), generator.normal(50, 4, 5000)
    draws = np.column_stack([first, other])
    alone = choose_for_yield(draws, 55.0, 2)
    awaited = choose_for_yield(draws, 55.0, 2, waiting=first[:, None])
    assert alone[0][0] == 0 and awaited[0][0] == 1
    assert awaited[0][1] == pytest.approx(alone[1][1])
    assert choose_for_yield(draws, 55.0, 2, smallest=alone[1][1] + 0.1) == alone[:1]
    assert choose_for_yield(draws, 55.0, 2, smallest=100.0) == []


def test_learning_beside_an_awaited_row_is_learning_after_it():
    model, _ = one_member()
    table, everywhere = conditions(), np.arange(16)
    (first, _), second = choose_for_learning(model, table, everywhere, 2)
    (after,) = choose_for_learning(model, table, everywhere, 1, given=np.array([first]))
    assert after == (second[0], pytest.approx(second[1]))
    offered = np.array([3, 7])
    chosen = choose_for_learning(model, table, everywhere, 4, candidates=offered)
    assert sorted(place for place, _ in chosen) == [3, 7]


def test_learning_picks_the_row_that_reduces_the_variance_most():
    model, _ = one_member()
    table = conditions()
    everywhere = np.arange(len(table))
    (position, share), (second, _) = choose_for_learning(model, table, everywhere, 2)
    member = model.members[0]
    process, inputs = member.process, member.standard(describe(table).to_numpy())
    before = np.trace(process.posterior(inputs)[1])
    after = []
    for index in everywhere:
        grown = Process(
            process.kernel, process.logs, np.vstack([process.inputs, inputs[index]]), np.append(process.target, 0)
        )
        after.append(np.trace(grown.posterior(inputs)[1]))
    assert position == int(np.argmin(after))
    assert share == pytest.approx(1 - min(after) / before, rel=1e-3)
    assert second != position


def test_a_shortlist_is_half_the_best_and_half_drawn():
    merit = np.array([1.0, 9, 3, 8, 2, 7, 0, 4, 5, 6])
    chosen, drawn = shortlist(merit, 5, np.random.default_rng(0))
    assert chosen[:3].tolist() == [1, 3, 5] and drawn.tolist() == [3, 4]
    assert len(set(chosen)) == len(chosen) == 5
    chosen, drawn = shortlist(merit, 30, np.random.default_rng(0))
    assert sorted(chosen) == list(range(10)) and drawn.tolist() == list(range(10))


def test_regime_rows_are_those_of_table_5_7():
    rows = regime_rows(CASES, REFERENCE).set_index("case")
    assert "reference" not in rows.index and len(rows) == 4
    names = ["normal_energy_uJ", "tangential_energy_uJ", "specific_frequency_hz"]
    np.testing.assert_allclose(rows.loc["speed.tangential", names].astype(float), [73, 238, 700], rtol=0.01)
    np.testing.assert_allclose(rows.loc["power.tangential", names].astype(float), [126, 411, 920], rtol=0.01)
    assert rows.loc["power.normal", "regime"] == "fill 0.17"


def test_without_regime_keeps_the_energy_and_hides_the_share():
    rows = pd.concat([all_runs(), regime_rows(CASES, REFERENCE)], ignore_index=True)
    hidden = without_regime(rows)
    np.testing.assert_allclose(describe(hidden)["power_per_ball_mW"], describe(rows)["power_per_ball_mW"])
    assert describe(hidden)["tangential_share"].std() < 1e-12 < describe(rows)["tangential_share"].std()


def test_regimes_left_out_are_not_in_the_training():
    screening, regimes = all_runs(), regime_rows(CASES, REFERENCE)
    seen = []

    def spy(rows, yields, unseen, levels):
        seen.append((set(rows["case"]), set(unseen["case"])))
        return Prediction(np.full(len(unseen), 50.0), {"cv_plus": np.tile([0.0, 100.0], (len(unseen), 1, 1))}, None)

    table = leave_regimes_out(screening, regimes, {("spy", "none"): (spy, False)}, 0.95)
    assert all(not known & unseen and len(known) >= 27 for known, unseen in seen)
    nothing = [known for known, unseen in seen if len(known) == 27]
    assert len(nothing) == 2 and all(known == set(screening["case"]) for known in nothing)
    summary = summarise_regimes(table).set_index("added")
    yields = regimes["yield_percent"].to_numpy(float)
    assert summary.loc["nothing", "rmse_pp"] == pytest.approx(np.sqrt(np.mean((50 - yields) ** 2)))
    assert (summary["covered"] == 1).all() and (summary["predictions"] == 4).all()


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
    given, made = SimpleNamespace(**paths), SimpleNamespace(rows=paths["rows"], mill=mill)
    train_averaged_models.collect(given, made, CASES, CASES, REFERENCE, "emax", 125e-6, proposals)
    train_averaged_models.main(paths["rows"], model, config.averaging)
    given = SimpleNamespace(proposing=model, mill=mill)
    output = SimpleNamespace(proposals=paths["next"], left_out=paths["left_out"], reasons=paths["reasons"])
    predict_yields.propose_experiments(given, output, 125e-6, proposals, config.prediction, CHEMISTRY)
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
    # No yield is over 100, so that what is left above the best run is the most that any can add.
    most = 100 - training_rows(first.model)["yield_percent"].max()
    assert first.next["expected_improvement_pp"].between(0, most).all() and most < 10


def test_a_batch_has_repeats_and_a_centre_point_within_the_region_and_its_limits(first):
    table, region = first.next, first.config.proposals.region
    assert table["purpose"].tolist()[:3] == ["repeat", "repeat", "centre"]
    # Of both purposes a batch has twice `runs`: what is left of one goes to the other.
    assert table["purpose"].isin(["yield", "learning"]).sum() == 2 * first.config.proposals.runs == 4
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


def test_the_best_run_is_repeated_first_and_then_the_farthest_from_those_chosen():
    """0.5 is 0.4 away from both ends, 0.46 less; 0.95 was run twice, and 0.99 runs again."""
    known = all_runs().iloc[[0, 1, 2, 3, 4, 4, 5, 6]].reset_index(drop=True)
    known["yield_percent"] = [0.1, 0.85, 0.9, 0.5, 0.95, 0.95, 0.46, 0.99]
    chosen = choose_repeats(known, region_rows(), known.tail(1), 3, 0.03)
    assert chosen == [(same_setting(known, region_rows(), 0.03)[run], known["case"][run]) for run in (2, 0, 3)]


def test_the_centre_is_nearest_in_deviations_and_in_units_of_what_does_not_vary():
    """Times of 10 and 20 h deviate by 5 h: 20 h are one away from the mean, and a ratio of 1.2 more than all is 1.2."""
    one = all_runs().iloc[[0, 0]].reset_index(drop=True)
    known, ratio = one.assign(time_h=[10.0, 20.0]), one["bpr"] + [1.2, 0.0]
    assert choose_centre(known, one.assign(time_h=[15.0, 20.0], bpr=ratio)) == 1
    assert choose_centre(known, one.assign(time_h=[15.0, 22.0], bpr=ratio)) == 0


@pytest.mark.parametrize(
    ("limiting", "reductant", "ratio", "released"),
    [
        ("NaBO2.4H2O", "MgH2", 6, 8),  # NaBO2.4H2O + 6 MgH2 -> NaBH4 + 6 MgO + 8 H2
        ("NaBO2.2H2O", "MgH2", 4, 4),  # NaBO2.2H2O + 4 MgH2 -> NaBH4 + 4 MgO + 4 H2
        ("NaBO2", "MgH2", 2, 0),  # NaBO2 + 2 MgH2 -> NaBH4 + 2 MgO
        ("NaBO2.4H2O", "Mg", 6, 2),  # NaBO2.4H2O + 6 Mg -> NaBH4 + 6 MgO + 2 H2
    ],
)
def test_the_hydrogen_of_a_reaction_is_what_its_balance_leaves(limiting, reductant, ratio, released):
    reaction = ChemistryConfig(limiting=limiting, reductant=reductant, stoichiometric_ratio=ratio, gas_per_mole=4)
    assert hydrogen_released(reaction) == released


def charged(**limits) -> tuple[pd.DataFrame, RegionConfig]:
    region = RegionConfig(**(REGION | limits))
    return with_hydrogen(region_conditions(region, CASES, MILL), region, CHEMISTRY, MILL.volume), region


def test_amount_and_pressure_follow_from_the_masses_by_hand():
    table, _ = charged()
    row = table[(table["fill_ratio"] == 0.10) & (table["bpr"] == 10)].iloc[0]
    # 9.68 g of NaBO2.4H2O (137.86 g/mol) with 10 mol of MgH2 (26.32 g/mol) hold 24.1 mmol of borate, and give 8 H2.
    powder = 24 * 7700 * np.pi / 6 * 0.01**3 / 10
    assert row["powder_mass_g"] == pytest.approx(1e3 * powder)
    borate = powder / (0.13786 + 10 * 0.026321)
    assert row["hydrogen_mmol"] == pytest.approx(8e3 * borate, rel=1e-3)
    free = 125e-6 - 24 * np.pi / 6 * 0.01**3 - powder / 1500
    assert row["hydrogen_pressure_bar"] == pytest.approx(8 * borate * 8.314463 * 298.15 / free / 1e5, rel=1e-3)


def test_the_pressure_goes_with_the_temperature_and_impure_borate_gives_less():
    cold, region = charged()
    hot, _ = charged(gas_temperature_k=2 * region.gas_temperature_k)
    np.testing.assert_allclose(hot["hydrogen_pressure_bar"], 2 * cold["hydrogen_pressure_bar"])
    impure = CHEMISTRY.model_copy(update={"limiting_purity": 0.5})
    conditions = region_conditions(region, CASES, MILL)
    assert (with_hydrogen(conditions, region, impure, MILL.volume)["hydrogen_mmol"] < cold["hydrogen_mmol"]).all()
    # A jar that balls and powder fill has no pressure, and no run.
    full = with_hydrogen(conditions, region, CHEMISTRY, 1e-6)
    assert full["hydrogen_pressure_bar"].isna().all()
    assert all("balls and powder fill the jar" in text for text in safety_warnings(full, region))


def test_limits_are_on_by_default_and_each_can_be_set_and_switched_off():
    table, region = charged()
    assert region.powder_max_g is not None and region.hydrogen_max_mmol is not None
    told = pd.Series(safety_warnings(table, region))
    assert (told[table["powder_mass_g"] > region.powder_max_g] != "").all()
    assert (told[(table["powder_mass_g"] <= 6) & (table["hydrogen_mmol"] <= 75)] == "").all()
    assert "powder_mass_g = 9.68 is above 6 (yields.proposals.region.powder_max_g)" in told.str.cat()
    off = {"powder_max_g": None, "hydrogen_max_mmol": None}
    assert set(safety_warnings(*charged(**off))) == {""}
    table, region = charged(**off, pressure_max_bar=10)
    broken = np.array(safety_warnings(table, region)) != ""
    assert 0 < broken.sum() < len(table)
    np.testing.assert_array_equal(broken, table["hydrogen_pressure_bar"] > 10)


def test_what_breaks_a_limit_is_not_proposed_and_the_table_says_why():
    rows, config = all_runs(), settings()
    model = fit_averaged(rows, rows["yield_percent"].to_numpy(float), config.averaging)

    def split(**limits):
        region = RegionConfig(**(REGION | limits))
        own, at = config.proposals.model_copy(update={"region": region}), region_conditions(region, CASES, MILL)
        return split_region(model, rows, at, own, config.prediction, CHEMISTRY, MILL, CURVES)

    allowed, left_out = split()
    assert len(allowed) + len(left_out) == 16
    assert allowed["powder_mass_g"].max() <= 6 and allowed["hydrogen_mmol"].max() <= 75
    # A fill ratio of 6 % is safe, and too far from these runs of 10 %.
    assert left_out.loc[left_out["fill_ratio"] == 0.06, "reason"].str.contains("tangential_share").all()
    counted = count_reasons(left_out, 16).set_index("reason")["conditions"]
    assert counted["powder_mass_g"] == 4 and counted["tangential_share"] == 8
    assert split(hydrogen_max_mmol=65)[0]["hydrogen_mmol"].max() <= 65
    with pytest.raises(ConfigError, match="none of its 16 conditions may be proposed"):
        split(hydrogen_max_mmol=1)
