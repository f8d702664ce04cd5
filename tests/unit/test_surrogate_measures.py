"""Measures of a roll-out: closed forms, and roll-outs that are known to be right or wrong."""

from dataclasses import replace

import h5py
import numpy as np
import pandas as pd
import pytest

from millprint.config.errors import ConfigError
from millprint.run.files import write_table
from millprint.thesis.claims.tabulate import collect_findings, tabulate_claims
from millprint.thesis.surrogate import measures
from millprint.thesis.surrogate.measure_tables import (
    AT_LEAST,
    OF_REFERENCE,
    STATEMENTS,
    ablation_table,
    baseline_rows,
    baseline_table,
    is_met,
    join_tables,
    scatter_in_words,
    tabulate,
    with_machine,
)
from millprint.thesis.surrogate.rollout import RollOut, blurred, riding, simulated, simulated_rollout, slowed
from millprint.thesis.surrogate.rollout_evaluation import distribution_table, error_table, evaluate, evaluate_at_rest
from millprint.thesis.surrogate.scene import Trajectory, mean_power_W
from tests.conftest import PRINTED, ROOT
from tests.unit.surrogate_samples import (
    AMPLITUDE,
    OMEGA,
    RADIUS,
    STEP,
    VESSEL,
    circle,
    simulate,
    sphere_scene,
    write_run,
)

SCENE = sphere_scene()
START, LENGTH, FRAME = 0.02, 0.2, 1e-3
TRUTH, SEED = simulate(2300), simulate(2300, seed=1)
RUNS = {"dem": TRUTH, "other_seed": SEED}


def table_of(rollout: RollOut, runs: dict[str, Trajectory] | None = None):
    found = evaluate(rollout, runs or RUNS, SCENE)
    return tabulate(found.values, found.references, "trained", "thesis").set_index("measure")


def known(run: Trajectory = TRUTH) -> RollOut:
    return simulated_rollout(run, SCENE, START, LENGTH, FRAME)


def test_position_error_sums_axes():
    truth = np.zeros((1, 1, 2, 3))
    position = truth.copy()
    position[0, 0, 0] = [1.0, 2.0, 2.0]
    assert measures.position_error(position, truth)[0, 0] == pytest.approx(4.5)


def test_centroid_scores_half_of_two_unrelated_runs():
    """Balls drawn from one distribution: 2 sigma^2 an axis apart, and sigma^2 from the centre of mass."""
    generator = np.random.default_rng(0)
    first, second = generator.normal(size=(2, 200, 1, 500, 3))
    assert measures.position_error(first, second).mean() == pytest.approx(6, rel=0.01)
    assert measures.centroid_error(first).mean() == pytest.approx(3, rel=0.01)


def test_pearson_of_cumulative_curves_is_empty_and_that_of_increments_is_not():
    generator = np.random.default_rng(1)
    first, second = np.cumsum(generator.exponential(size=(2, 2000, 1)), axis=1)
    assert measures.correlation(first, second) > 0.999
    assert abs(measures.correlation(measures.increments(first, 5), measures.increments(second, 5))) < 0.2
    assert measures.correlation(measures.increments(first, 5), measures.increments(first, 5)) == pytest.approx(1)


def test_relative_error_horizon_and_growth_time():
    truth = np.linspace(0, 2, 11)[:, None]
    assert measures.relative_error_percent(1.1 * truth, truth) == pytest.approx(10)
    time_s = np.linspace(0, 1, 1001)
    error = 1e-8 * np.exp(20 * time_s)[:, None]
    assert measures.horizon(time_s, error, 1e-2) == pytest.approx(np.log(1e6) / 20, abs=1.1e-3)
    assert measures.growth_time(time_s, error, 1e-6, 1e-2) == pytest.approx(np.log(1e4) / 20, abs=2e-3)
    assert measures.horizon(time_s, 0 * error, 0.2) == 1.0
    assert np.isnan(measures.growth_time(time_s, 0 * error, 1e-6, 1e-2))


def test_distribution_distance_is_the_shift_of_a_shifted_sample():
    sample = np.random.default_rng(2).exponential(size=4000)
    assert measures.distribution_distance(sample + 0.3, sample) == pytest.approx(0.3)
    assert measures.distribution_distance(1.1 * sample, sample) == pytest.approx(0.1 * sample.mean())


def test_contacts_are_counted_on_both_sides():
    """Two balls that touch, one of them the wall too, and a third a tenth of a radius away."""
    places = np.array([[VESSEL - RADIUS, 0, 0], [VESSEL - 3 * RADIUS, 0, 0], [VESSEL - 5.1 * RADIUS, 0, 0]])
    position = places[None, None]
    rollout = RollOut(np.zeros(1), position, 0 * position, np.zeros((1, 1)), np.full((1, 3), np.inf), np.zeros(1))
    with pytest.raises(ValueError, match="has no wall_distance_m"):
        rollout.contacts(RADIUS)
    placed = rollout.in_scene(SCENE, np.zeros((1, 1, 3)))
    assert placed.contacts(RADIUS)[0, 0].tolist() == [2, 1, 0]


def test_the_simulation_as_roll_out_has_no_error_and_meets_every_aim():
    table = table_of(known())
    for name in ("position_mse_plateau_m2", "dissipation_error_percent", "balls_left", *OF_REFERENCE):
        if name not in AT_LEAST:
            assert table["value"][name] == pytest.approx(0, abs=1e-12), name
    assert table["value"]["stable"] == 1 and table["value"]["horizon_s"] == pytest.approx(LENGTH)
    aimed = table[table["aim"].notna()]
    assert len(aimed) >= 6
    assert all(is_met(name, row["value"], row["aim"]) for name, row in aimed.iterrows())
    assert (table["dem_reference"].dropna() != 0).any()


def test_another_seed_scores_its_own_reference_and_meets_the_aims_of_statistics():
    table = table_of(known(SEED))
    for name in set(OF_REFERENCE) - AT_LEAST:
        assert table["value"][name] == pytest.approx(table["dem_reference"][name])
        assert is_met(name, table["value"][name], table["aim"][name])
    assert table["value"]["cumulative_pearson_r"] == pytest.approx(table["dem_reference"]["cumulative_pearson_r"])


def test_a_blurred_roll_out_fails_though_its_plateau_and_its_r_are_better_than_a_simulation_s():
    table = table_of(blurred(known()))
    for name in ("position_mse_plateau_m2", "cumulative_pearson_r"):
        better = table["value"][name] - table["dem_reference"][name]
        assert better * (1 if name.endswith("_r") else -1) > 0
    for name in ("wall_distance_wasserstein_m", "contacts_wasserstein"):
        assert not is_met(name, table["value"][name], table["aim"][name]), name


def test_a_slowed_roll_out_fails_in_dissipation_and_parts():
    rollout = slowed(known(), SCENE, 0.7)
    np.testing.assert_allclose(rollout.position_m[0], known().position_m[0])
    np.testing.assert_allclose(
        np.cumsum(rollout.dissipated_J)[-1], np.cumsum(known().dissipated_J)[round(0.7 * LENGTH / FRAME)], rtol=1e-6
    )
    table = table_of(rollout)
    assert not is_met("dissipation_error_percent", *table.loc["dissipation_error_percent", ["value", "aim"]])
    assert table["value"]["horizon_s"] < known().time_s[-1]


def test_balls_that_ride_with_the_jar_dissipate_a_constant_power(tmp_path):
    write_run(TRUTH, tmp_path / "run.h5")
    power_W = mean_power_W(tmp_path / "run.h5", 0.1)
    assert power_W == pytest.approx(TRUTH.dissipated_J[1:1001].sum() / 0.1)
    rollout = riding(known(), SCENE, power_W)
    wall = circle(START + rollout.time_s)[:, None, None]
    np.testing.assert_allclose(
        rollout.position_m - wall, np.broadcast_to(rollout.position_m[0] - wall[0], (201, 1, 6, 3))
    )
    np.testing.assert_allclose(rollout.speed()[1:-1], AMPLITUDE * OMEGA, rtol=1e-3)
    table = table_of(rollout)
    assert rollout.cumulative_J[-1, 0] == pytest.approx(power_W * LENGTH)
    assert table["value"]["balls_left"] == 0 and np.isnan(table["value"]["increments_5ms_r"])


def nudged(run: Trajectory, after_s: float) -> Trajectory:
    """The same run, with places that part exponentially from a moment on."""
    gone = np.maximum(run.time_s - after_s, 0)
    return replace(run, position_m=run.position_m + (1e-9 * np.expm1(120 * gone))[:, None, None])


def test_growth_is_held_against_the_twin_and_statistics_against_the_seed():
    table = table_of(known(nudged(TRUTH, START)), RUNS | {"twin": nudged(TRUTH, START)})
    for name in ("horizon_s", "position_mse_10ms_m2", "position_mse_100ms_m2", "error_growth_time_s"):
        assert table["value"][name] == pytest.approx(table["dem_reference"][name])
    assert 0 < table["value"]["horizon_s"] < LENGTH
    assert table["aim"]["horizon_s"] == pytest.approx(table["value"]["horizon_s"] / 2)
    alone = table_of(known(nudged(TRUTH, START)))
    assert np.isnan(alone["dem_reference"]["horizon_s"]) and np.isnan(alone["aim"]["horizon_s"])


def test_a_roll_out_that_is_not_finite_fails_without_an_error():
    rollout = known()
    lost = np.where(rollout.time_s[:, None, None, None] > 0.1, np.nan, rollout.position_m)
    crossed = np.full_like(rollout.crossed_s, 0.1)
    table = table_of(
        replace(rollout, position_m=lost, velocity_m_s=lost, dissipated_J=lost[..., 0, 0], crossed_s=crossed)
    )
    assert table["value"]["stable"] == 0 and table["value"]["balls_left"] == TRUTH.balls
    assert np.isinf(table["value"][["position_mse_plateau_m2", "dissipation_error_percent"]]).all()
    for name in OF_REFERENCE:
        if name not in AT_LEAST:
            assert not is_met(name, table["value"][name], table["aim"][name])


def test_frames_that_the_simulation_lacks_are_refused():
    coarse = replace(TRUTH, **{name: getattr(TRUTH, name)[::15] for name in ("time_s", "position_m", "velocity_m_s")})
    coarse = replace(coarse, wall_position_m=TRUTH.wall_position_m[::15], dissipated_J=TRUTH.dissipated_J[::15])
    with pytest.raises(ConfigError, match="snapshot_interval_s must divide"):
        simulated(coarse, SCENE, np.arange(10) * FRAME, np.array([0.03]))


def test_roll_out_and_simulation_stand_in_the_same_place():
    rollout = known()
    recorded, placed = simulated(TRUTH, SCENE, rollout.time_s, rollout.start_s), rollout.in_scene(SCENE)
    np.testing.assert_allclose(placed.known("wall_distance_m"), recorded.known("wall_distance_m"), atol=1e-12)
    np.testing.assert_allclose(placed.cumulative_J, recorded.cumulative_J, rtol=1e-12)


def at_rest(lift_m: float, dissipated_J: float) -> RollOut:
    """Balls of which one rises and sinks again, in a jar that stands still."""
    time_s = np.arange(201) * FRAME
    place = np.repeat(TRUTH.position_m[None, None, 0], len(time_s), axis=0)
    place[100, 0, 2, 2] += lift_m
    energy = np.full((len(time_s), 1), dissipated_J / 200)
    energy[0] = 0
    return RollOut(time_s, place, 0 * place, energy, np.full((1, 6), np.inf), np.zeros(1))


def test_energy_from_nothing_is_a_share_of_the_driven_case():
    still = replace(
        TRUTH, position_m=np.repeat(TRUTH.position_m[:1], 2300, axis=0), velocity_m_s=0 * TRUTH.velocity_m_s
    )
    still = replace(still, dissipated_J=0 * TRUTH.dissipated_J)
    runs = {"dem": still, "other_seed": still, "driven": TRUTH}
    scene = replace(SCENE, wall_position=lambda time_s: np.broadcast_to(circle(0.0), (*np.shape(time_s), 3)))
    driven_W = TRUTH.dissipated_J[1:].sum() / (2299 * STEP)
    found = evaluate_at_rest(at_rest(2e-4, 0.03 * 0.2 * driven_W), runs, scene)
    assert found.values["rest_dissipation_share_percent"] == pytest.approx(3)
    assert found.values["rest_highest_lift_m"] == pytest.approx(2e-4)
    table = tabulate(found.values, found.references, "rest", "thesis").set_index("measure")
    assert table["dem_reference"]["rest_dissipation_share_percent"] == 0
    assert not is_met("rest_highest_lift_m", *table.loc["rest_highest_lift_m", ["value", "aim"]])
    # What is given and taken back was made from nothing too.
    taken = at_rest(0.0, 0.0)
    taken.dissipated_J[1::2], taken.dissipated_J[2::2] = 1e-4, -1e-4
    share = evaluate_at_rest(taken, runs, scene).values["rest_dissipation_share_percent"]
    assert share == pytest.approx(100 * 200 * 1e-4 / (0.2 * driven_W))


def test_densities_integrate_to_one_and_errors_have_a_twin():
    found = evaluate(known(), RUNS | {"twin": TRUTH}, SCENE)
    table = distribution_table(found.rollouts, RADIUS, "trained")
    for _, part in table.groupby("quantity"):
        area = part["dem"] * (part["high"] - part["low"])
        assert area.sum() == pytest.approx(1, abs=0.02)
    errors = error_table(found.rollouts, "trained")
    assert errors["twin_m2"].max() == 0 and errors["other_seed_m2"].min() > 0


def test_a_file_without_the_starts_is_not_a_roll_out(tmp_path):
    rollout, path = known(), tmp_path / "rollout.h5"
    with h5py.File(path, "w") as file:
        for name in ("time_s", "position_m", "velocity_m_s", "dissipated_J", "crossed_s"):
            file[name] = getattr(rollout, name)
    with pytest.raises(ConfigError, match="start_s is missing"):
        RollOut.read(path)


def control(rollout: str, test: str, error: float, out: int = 0) -> pd.DataFrame:
    values = {"dissipation_error_percent": error, "mean_square_speed_ratio": 9.0 if out else 0.5, "balls_left": out}
    values |= {"increments_5ms_r": -0.1, "horizon_s": 1.0}
    table = tabulate(values, {"dissipation_error_percent": 0.7}, test, rollout, length_s=1.5)
    return table.drop(columns="thesis").rename(columns={"variant": "rollout"}).assign(met="")


def test_every_training_stands_beside_what_needs_no_network():
    known_rollouts = ("dem", "other_seed", "long_step", "no_network", "blurred")
    controls = pd.concat([control(name, test, 1.0) for test in ("trained", "post") for name in known_rollouts])
    draws = ((1, "trained", 5.0, 0), (2, "trained", 1e20, 3), (1, "post", 8.0, 0))
    trainings = pd.concat(
        [
            control("thesis", test, error, out).rename(columns={"rollout": "variant"}).assign(training=number)
            for number, test, error, out in draws
        ]
    )
    table = baseline_table(trainings, controls, {"trained": 2.78}, "trained")
    assert set(baseline_rows(controls)["variant"]) == {"no_network", "long_step"}
    trained = table[table["test"] == "trained"]
    assert trained["model"].tolist() == ["thesis", "thesis", "long_step", "no_network", "other_seed"]
    assert trained["dissipation_error_percent"].tolist()[2:] == [1.0, 1.0, 0.7]
    assert (table["length_s"] == 1.5).all() and (trained["thesis_percent"] == 2.78).all()
    assert trained["ran_away"].tolist() == ["no", "yes", "no", "no", "no"]
    assert np.isnan(trained["dissipation_error_percent"].iloc[1]) and trained["balls_left"].iloc[1] == 3
    assert table[table["test"] == "post"]["thesis_percent"].isna().all()
    assert set(trained["motion"]) == {"of the training"} and set(table["motion"][table["test"] == "post"]) == {"unseen"}
    stored = with_machine(with_machine(table.assign(measured_on="a"), trained, "b"), table, "b")
    assert stored["measured_on"].tolist() == ["a"] * 9 + ["b"] * 9


def ablations(parts: dict[str, tuple], again: dict[str, list[tuple]] | None = None) -> pd.DataFrame:
    """again: further trainings of some."""
    trainings = {name: [name] for name in parts}
    own = list(parts.items())
    for name, others in (again or {}).items():
        for number, values in enumerate(others, start=2):
            trainings[name].append(f"{name}_training{number}")
            own.append((trainings[name][-1], values))
    metrics = join_tables([ablation(name, *values) for name, values in own])
    history = pd.DataFrame({"epoch": [1, 2], "elapsed_s": [10.0, 20.0]})
    changes = {name: f"what of {name}" for name in parts}
    table = ablation_table(
        metrics, dict.fromkeys(parts, history), changes, dict.fromkeys(parts, 1.0), pd.Series(PRINTED), trainings
    )
    return table.set_index("variant")


def ablation(variant: str, stable: int, error: float, power_W: float):
    values = {"stable": stable, "balls_left": 24 * (1 - stable), "mean_square_speed_ratio": 1.0}
    values |= {"position_mse_plateau_m2": 3e-4, "dissipation_error_percent": error, "dissipation_power_W": power_W}
    values |= {"dem_power_W": 0.7, "one_step_dissipation_bias_percent": -3.0}
    return tabulate(values, {"dissipation_error_percent": 0.5}, "trained", variant)


def test_ablations_are_tabulated_with_the_statements_of_the_thesis():
    parts = {
        "baseline": (1, 5.0, 0.735),
        "window3": (1, 9.0, 0.76),
        "window9": (1, 2.0, 0.7),
        "layers2": (1, 120.0, 1.5),
        "phi_shallow": (1, 8.0, 0.64),
        "net_force": (1, 8.0, 0.64),
    }
    table = ablations(parts)
    words = {"baseline": "", "window3": "yes", "window9": "no", "layers2": "yes", "phi_shallow": "no", "net_force": ""}
    assert table["holds"].to_dict() == words
    assert table["thesis_percent"]["phi_shallow"] == float(PRINTED["A.phi.shallow"])
    assert table["thesis_percent"]["baseline"] == float(PRINTED["6.energy"])
    assert table["epochs"].eq(2).all() and table["training_s"].eq(20).all()
    assert set(STATEMENTS) >= set(parts) - {"net_force"}


def test_an_ablation_within_the_scatter_of_the_baseline_says_nothing():
    parts = {
        "baseline": (1, 5.0, 0.735),
        "window3": (1, 9.0, 0.76),
        "layers2": (1, 120.0, 1.5),
        "window9": (0, 6.0, 0.7),
        "no_global_loss": (1, 9.0, 0.76),
        "phi_deep": (1, 60.0, 0.3),
    }
    again = {"baseline": [(1, 23.0, 0.9), (1, 12.0, 0.8)], "phi_deep": [(1, 50.0, 0.3), (1, 55.0, 0.3)]}
    table = ablations(parts, again)
    # 18 points between two trainings of the baseline; window9 is within them, but no baseline runs away as it does.
    says = {"baseline": "", "window3": "nothing", "layers2": "something", "window9": "something"}
    assert table["says"].to_dict() == says | {"no_global_loss": "nothing", "phi_deep": "something"}
    assert table["baseline_apart_percent"].unique() == pytest.approx([18.0])
    assert table["trainings"].tolist() == [3, 1, 1, 1, 1, 3]
    low, high = table.loc["phi_deep", ["lower_percent", "upper_percent"]]
    # Of three trainings only the range is known.
    assert (low, high) == (50.0, 60.0) and high < table["upper_percent"]["layers2"]
    assert scatter_in_words(table.reset_index()) == (
        "2 of 5 ablations say nothing (window3, no_global_loss): two trainings of the baseline are up to 18 "
        "points of the dissipation error apart."
    )
    once = ablations(parts)
    assert set(once["says"]) == {""} and scatter_in_words(once.reset_index()) == ""


def test_a_statement_on_which_trainings_of_the_baseline_disagree_says_nothing():
    """With an error of 60 %, it is worse than a baseline of 5 %, and not than one of 61 %."""
    table = ablations({"baseline": (1, 5.0, 0.7), "window3": (1, 60.0, 0.9)}, {"baseline": [(1, 61.0, 0.8)]})
    assert table["says"]["window3"] == "nothing"
    table = ablations({"baseline": (1, 5.0, 0.7), "window3": (1, 60.0, 0.9)}, {"baseline": [(1, 6.0, 0.8)]})
    assert table["says"]["window3"] == "something"


def test_the_claims_of_appendix_a_say_where_a_row_says_nothing(tmp_path):
    parts = {"baseline": (1, 5.0, 0.735), "window3": (1, 9.0, 0.76), "layers2": (1, 120.0, 1.5)}
    table = ablations(parts, {"baseline": [(1, 23.0, 0.9)]}).reset_index()
    write_table(table, tmp_path / "surrogate/ablations.tsv")
    claims = ROOT / "config/data/claims.tsv"
    found = tabulate_claims(claims, collect_findings(tmp_path, claims)).set_index("id")
    assert found["verdict"]["A.window3"] == found["verdict"]["A.layers2"] == "agrees"
    # Two trainings of the baseline are too few for an interval to decide anything.
    assert found["interval_verdict"]["A.window3"] == found["interval_verdict"]["A.layers2"] == "open"
    assert "so this row says nothing" in found["explanation"]["A.window3"]
    assert found.loc["A.window3", ["lower", "upper", "interval_from"]].tolist() == [
        "no", "yes", "trainings of the baseline"
    ]  # fmt: skip


def test_nothing_follows_from_an_ablation_whose_baseline_runs_away_too():
    table = ablations({"baseline": (0, 1e9, 1e9), "window9": (0, 2e9, 2e9), "net_force": (1, 8.0, 0.6)})
    assert table["holds"].to_dict() == {"baseline": "", "window9": "open", "net_force": ""}
