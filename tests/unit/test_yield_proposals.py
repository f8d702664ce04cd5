"""The next experiments: the region, the value of a run, and the test on the runs that were done."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm

from millprint.config.errors import ConfigError
from millprint.config.load import load_named
from millprint.config.mill import MillConfig
from millprint.config.yields import RegionConfig
from millprint.observables.condition import Condition
from millprint.thesis.curves.regimes import read_regimes
from millprint.thesis.yields.averaging import AveragedModel, Candidate, fit_member
from millprint.thesis.yields.experiments import Mill, check_region, region_conditions
from millprint.thesis.yields.features import describe
from millprint.thesis.yields.groups import (
    leave_regimes_out,
    reference_of_mill,
    regime_rows,
    summarise_regimes,
    without_regime,
)
from millprint.thesis.yields.held_out import Prediction
from millprint.thesis.yields.posterior_process import Process
from millprint.thesis.yields.proposals import (
    choose_for_learning,
    choose_for_yield,
    expected_improvement,
    joint_draws,
    shortlist,
)
from millprint.thesis.yields.retrospective import (
    STRATEGIES,
    chance,
    draw_starts,
    search_best,
    search_table,
    smaller_library,
    summarise_search,
    without_best,
)
from tests.conftest import ROOT
from tests.unit.yield_settings import all_runs, settings

MILLS = ROOT / "config/mills"
REGIMES = ROOT / "config/data/regimes.tsv"
REFERENCE = Condition(0.10, speed_hz=10.0, ball_diameter_m=0.01, density_kg_m3=7700.0, amplitude_m=17 * 1e-3)
MILL = Mill(density=7700.0, amplitude=0.017, volume=125e-6)
REGION = {
    "bpr": [10, 30],
    "molar_ratio": [10],
    "time_h": [12.5, 20],
    "speed_rpm": [600, 1000],
    "fill_ratio": [0.06, 0.10],
    "ball_diameter_mm": [10],
}
SCALES = ("linear", "linear", "log", "log", "linear")


@pytest.mark.parametrize("name", ["emax", "emax_smooth"])
def test_the_amplitude_of_the_emax_is_its_own_to_the_last_bit(name):
    """Half the longest travel of a wall is the amplitude A of a circular motion, as the thesis uses it."""
    mill = load_named(MILLS, name, MillConfig, "mill")
    cases = read_regimes(str(REGIMES))
    assert reference_of_mill(cases, mill, reference_speed=10.0, density=7700.0, diameter=0.01) == REFERENCE


def test_a_mill_without_an_amplitude_of_its_own_has_that_of_its_walls():
    planetary = load_named(MILLS, "planetary", MillConfig, "mill")
    cases = read_regimes(str(REGIMES))
    reference = reference_of_mill(cases, planetary, reference_speed=5.0, density=7700.0, diameter=0.01)
    # The wall moves as far as the radii of the sun wheel and of the jar together.
    assert reference.amplitude_m == pytest.approx((70.5 + 37.5) * 1e-3, rel=1e-3)


def conditions() -> pd.DataFrame:
    return region_conditions(RegionConfig(**REGION), read_regimes(str(REGIMES)), MILL)


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
        check_region(region, read_regimes(str(REGIMES)), "config.yaml")


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
            process.terms, process.logs, np.vstack([process.inputs, inputs[index]]), np.append(process.target, 0)
        )
        after.append(np.trace(grown.posterior(inputs)[1]))
    assert position == int(np.argmin(after))
    assert share == pytest.approx(1 - min(after) / before, rel=1e-3)
    assert second != position


def test_shortlist_is_half_merit_and_half_chance():
    merit = np.arange(50.0)
    chosen, random_half = shortlist(merit, 10, np.random.default_rng(0))
    assert chosen[:5].tolist() == [49, 48, 47, 46, 45] and len(set(chosen)) == 10
    assert random_half.tolist() == [5, 6, 7, 8, 9] and max(chosen[random_half]) < 45


def test_chance_is_drawing_without_replacement():
    found = chance(27, 8, 1)
    np.testing.assert_allclose(found, np.arange(20) / 19)
    generator, two = np.random.default_rng(0), chance(10, 4, 2)
    firsts = np.array([np.sort(generator.permutation(6)[:2])[0] + 1 for _ in range(20000)])
    np.testing.assert_allclose(two, [(firsts <= done).mean() for done in range(7)], atol=0.015)


@pytest.mark.slow
def test_search_ends_with_the_best_run_and_uses_the_yields_of_known_runs_only():
    rows, config = all_runs(), settings()
    yields = rows["yield_percent"].to_numpy(float)
    starts = draw_starts(yields, config.retrospective)
    assert all(yields[start].max() < yields.max() and len(set(start)) == 8 for start in starts)
    averaging = smaller_library(config.averaging, config.retrospective)
    reached = {
        name: [search_best(rows, start, strategy, averaging) for start in starts]
        for name, strategy in STRATEGIES.items()
    }
    for paths in reached.values():
        for path in paths:
            assert path[-1] == yields.max() and (np.diff(path) >= 0).all() and (path[:-1] < yields.max()).all()
    # A choice uses the yields of known runs only, so it stays the same if the other yields are changed.
    hidden = np.setdiff1d(np.arange(27), [*starts[0], int(yields.argmax())])
    wrong = rows.copy()
    wrong.loc[hidden, "yield_percent"] = 1.0
    for name in ("highest_mean", "least_squares", "most_balls_longest_time"):
        first, other = (search_best(table, starts[0], STRATEGIES[name], averaging) for table in (rows, wrong))
        assert first[0] == other[0]
    table = search_table(reached, yields, 8, 0.95)
    summary = summarise_search([table, table], [reached, reached], ["24", "again"], 0.95).set_index(
        ["target", "strategy"]
    )
    assert summary.loc[("24", "random"), "mean_runs"] == pytest.approx(18)
    lengths = {name: np.mean([7 + len(path) for path in reached[name]]) for name in STRATEGIES}
    for name in STRATEGIES:
        assert summary.loc[("24", name), "mean_runs"] == pytest.approx(lengths[name])
        # The same target twice: no spread between targets.
        assert summary.loc[("all", name), "upper"] == pytest.approx(lengths[name])
    fewer = summary.loc[("all", "random"), "fewer_than_search"]
    assert fewer == pytest.approx(lengths["expected_improvement"] - 18)
    assert "more runs" in summary.loc[("all", "random"), "conclusion"]
    assert (table["lower"] <= table["found"]).all() and (table["found"] <= table["upper"]).all()


def test_the_rule_takes_the_most_balls_and_then_the_longest_time():
    rows, config = all_runs(), settings()
    merit = STRATEGIES["most_balls_longest_time"](rows, np.zeros(27), rows, config.averaging, np.random.default_rng(0))
    ranked = rows.iloc[np.argsort(-merit)]
    assert (np.diff(ranked["bpr"]) <= 0).all() and ranked["bpr"].iloc[8] == 50
    assert (np.diff(ranked["time_h"].iloc[:9]) <= 0).all()
    assert sorted(merit) == list(range(27))
    # Ties fall differently for other seeds.
    firsts = {
        int(STRATEGIES["most_balls_longest_time"](rows, None, rows, None, np.random.default_rng(seed)).argmax())
        for seed in range(20)
    }
    assert len(firsts) == 3


def test_a_linear_yield_is_ranked_right_by_least_squares_and_by_ridge():
    rows, config = all_runs(), settings()
    yields = describe(rows)["bpr"].to_numpy() + 2 * describe(rows)["time_h"].to_numpy()
    for name in ("least_squares", "ridge"):
        merit = STRATEGIES[name](rows.iloc[:12], yields[:12], rows, config.averaging, np.random.default_rng(0))
        assert np.corrcoef(merit, yields)[0, 1] > 0.999


def test_without_the_best_runs_the_next_is_the_target():
    rows = all_runs()
    left = without_best(rows, 2)
    assert len(left) == 25 and left["yield_percent"].max() == sorted(rows["yield_percent"])[-3]
    assert without_best(rows, 0)["case"].tolist() == rows["case"].tolist()


def test_regime_rows_are_those_of_table_5_7():
    rows = regime_rows(read_regimes(str(REGIMES)), REFERENCE).set_index("case")
    assert "reference" not in rows.index and len(rows) == 4
    names = ["normal_energy_uJ", "tangential_energy_uJ", "specific_frequency_hz"]
    np.testing.assert_allclose(rows.loc["speed.tangential", names].astype(float), [73, 238, 700], rtol=0.01)
    np.testing.assert_allclose(rows.loc["power.tangential", names].astype(float), [126, 411, 920], rtol=0.01)
    assert rows.loc["power.normal", "regime"] == "fill 0.17"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("\t94", "\t140", "column yield_percent, case power.tangential = 140: must be above 0 and at most 100"),
        ("\t94", "\tmuch", "column yield_percent, case power.tangential = 'much'"),
        ("speed.normal", "power.normal", "column case = power.normal appears twice"),
        ("molar_ratio", "ratio", "column molar_ratio is missing"),
    ],
)
def test_bad_regimes_are_refused_in_one_line(tmp_path, old, new, message):
    table = tmp_path / "regimes.tsv"
    table.write_text(REGIMES.read_text().replace(old, new))
    with pytest.raises(ConfigError) as caught:
        read_regimes(str(table))
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_without_regime_keeps_the_energy_and_hides_the_share():
    rows = pd.concat([all_runs(), regime_rows(read_regimes(str(REGIMES)), REFERENCE)], ignore_index=True)
    hidden = without_regime(rows)
    np.testing.assert_allclose(describe(hidden)["power_per_ball_mW"], describe(rows)["power_per_ball_mW"])
    assert describe(hidden)["tangential_share"].std() < 1e-12 < describe(rows)["tangential_share"].std()


def test_regimes_left_out_are_not_in_the_training():
    screening, regimes = all_runs(), regime_rows(read_regimes(str(REGIMES)), REFERENCE)
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
