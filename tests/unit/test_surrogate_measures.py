"""Measures of a roll-out: closed forms, roll-outs that are known to be right or wrong, and their figures."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from millprint.config.errors import ConfigError
from millprint.estimate.judge import AGREES, DIFFERS, OPEN
from millprint.thesis.surrogate import measures
from millprint.thesis.surrogate.measures import (
    AT_LEAST,
    OF_REFERENCE,
    ablation_table,
    against_baselines,
    is_met,
    join_tables,
    tabulate,
    told_against,
)
from millprint.thesis.surrogate.rollout import (
    RollOut,
    Trajectory,
    blurred,
    mean_power_W,
    riding,
    rms_wall_speed,
    scaled_motion,
    simulated,
    simulated_rollout,
    slowed,
)
from millprint.thesis.surrogate.rollout_evaluation import evaluate, evaluate_at_rest, references_of
from tests.conftest import PRINTED
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
    found = evaluate(rollout, references_of(runs or RUNS, SCENE, rollout.time_s, rollout.start_s), SCENE)
    return tabulate(found.values, found.references, "trained", "thesis").set_index("measure")


def known(run: Trajectory = TRUTH) -> RollOut:
    return simulated_rollout(run, START, LENGTH, FRAME)


def test_position_error_sums_axes():
    truth = np.zeros((1, 1, 2, 3))
    position = truth.copy()
    position[0, 0, 0] = [1.0, 2.0, 2.0]
    assert measures.position_error(position, truth)[0, 0] == pytest.approx(4.5)


def test_centroid_scores_half_of_two_unrelated_runs():
    """Balls drawn from one distribution: 2 sigma^2 an axis apart, and sigma^2 from the centre of mass."""
    first, second = np.random.default_rng(0).normal(size=(2, 200, 1, 500, 3))
    assert measures.position_error(first, second).mean() == pytest.approx(6, rel=0.01)
    assert measures.centroid_error(first).mean() == pytest.approx(3, rel=0.01)
    # Each frame has its own centre: balls that move together are no nearer to it.
    moved = first + 100 * np.arange(200)[:, None, None, None]
    np.testing.assert_allclose(measures.centroid_error(moved), measures.centroid_error(first))


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


def test_the_known_motion_again_is_itself_after_whole_turns_and_scaled_on_a_faster_wall():
    """A mill of 300 rpm turns in 0.2 s: the known 0.2 s follow each other in step."""
    turn = SCENE.turn_s
    assert rms_wall_speed(SCENE) == pytest.approx(AMPLITUDE * OMEGA, rel=1e-4)
    part = simulated_rollout(TRUTH, 0.0, turn, FRAME)
    frames, longer = round(turn / FRAME), round((turn + 0.1) / FRAME) + 1
    empty = np.zeros((longer, *part.position_m.shape[1:]))
    asked = replace(
        part, time_s=FRAME * np.arange(longer), position_m=empty, velocity_m_s=empty, dissipated_J=np.zeros((longer, 1))
    )
    again = scaled_motion(asked, SCENE, part, SCENE)
    np.testing.assert_allclose(again.position_m[1 : frames + 1], part.position_m[1:], atol=1e-12)
    np.testing.assert_allclose(again.position_m[frames + 1 :], part.position_m[1 : round(0.1 / FRAME) + 1], atol=1e-12)
    np.testing.assert_allclose(again.dissipated_J[1 : frames + 1], part.dissipated_J[1:])
    faster = replace(SCENE, wall_position=lambda time_s: 2 * circle(time_s))
    scaled = scaled_motion(asked, faster, part, SCENE)
    np.testing.assert_allclose(scaled.dissipated_J, 4 * again.dissipated_J)
    place = again.position_m - circle(again.time_s)[:, None, None]
    np.testing.assert_allclose(scaled.position_m - 2 * circle(again.time_s)[:, None, None], place, atol=1e-12)
    np.testing.assert_allclose(scaled.velocity_m_s, 2 * again.velocity_m_s, atol=1e-9)


def measured(model: str, training: int, error: float, speed: float, away: str = "no") -> dict:
    row = {"test": "motion1", "motion": "unseen", "model": model, "training": training, "length_s": 15.0}
    sizes = {"dissipation_error_percent": error, "mean_square_speed_ratio": speed, "increments_5ms_r": 0.1}
    return row | (dict.fromkeys(sizes) if away == "yes" else sizes) | {"balls_left": 0, "ran_away": away}


@pytest.mark.parametrize(
    ("errors", "word", "near", "both"),
    [
        ([1.0, 1.2, 1.1, 0.9, 1.0], AGREES, 5, 0),
        ([8.0, 9.0, 7.0, 8.5, 2.9], DIFFERS, 1, 0),
        ([1.0, 1.2, 1.1, 0.9, None], OPEN, 4, 0),
        ([1.0, 1.2, 1.1], OPEN, 3, 0),
        ([None] * 5, DIFFERS, 0, 0),
    ],
)
def test_networks_beat_the_baselines_if_their_mean_is_below_every_one(errors, word, near, both):
    rows = [measured("net", k, error or 0, 0.4, "no" if error else "yes") for k, error in enumerate(errors, 1)]
    rows += [measured("no_network", 1, 40, 0.3), measured("scaled_power", 1, 3.0, 0.3)]
    rows += [measured("scaled_motion", 1, 12.0, 0.9), measured("long_step", 1, 4.0, 1.01)]
    table = against_baselines(pd.DataFrame(rows), "net")
    row = table.iloc[0]
    assert (row["verdict"], row["nearer"], row["nearer_in_speed_too"]) == (word, near, both)
    assert row["scaled_power_percent"] == 3 and row["trainings"] == len(errors)
    assert told_against(table).startswith("No network beats what needs none: ") == (word != AGREES)


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
    names = ("time_s", "position_m", "velocity_m_s", "wall_position_m", "dissipated_J")
    coarse = replace(TRUTH, **{name: getattr(TRUTH, name)[::15] for name in names})
    with pytest.raises(ConfigError, match="snapshot_interval_s must divide"):
        simulated(coarse, SCENE, np.arange(10) * FRAME, np.array([0.03]))


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


def ablations(parts: dict[str, tuple], again: dict[str, list[tuple]] | None = None) -> pd.DataFrame:
    """again: further trainings of some."""
    own, trainings = dict(parts), {name: [name] for name in parts}
    for name, others in (again or {}).items():
        further = {f"{name}_training{number}": values for number, values in enumerate(others, start=2)}
        own |= further
        trainings[name] += further
    metrics = join_tables([ablation(name, *values) for name, values in own.items()])
    history = dict.fromkeys(parts, pd.DataFrame({"epoch": [1, 2], "elapsed_s": [10.0, 20.0]}))
    lengths = dict.fromkeys(parts, 1.0)
    table = ablation_table(metrics, history, dict.fromkeys(parts, "a change"), lengths, pd.Series(PRINTED), trainings)
    return table.set_index("variant")


def ablation(variant: str, stable: int, error: float, power_W: float):
    values = {"stable": stable, "balls_left": 24 * (1 - stable), "mean_square_speed_ratio": 1.0}
    values |= {"position_mse_plateau_m2": 3e-4, "dissipation_error_percent": error, "dissipation_power_W": power_W}
    values |= {"dem_power_W": 0.7, "one_step_dissipation_bias_percent": -3.0}
    return tabulate(values, {"dissipation_error_percent": 0.5}, "trained", variant)


def test_ablations_are_tabulated_with_the_statements_of_the_thesis():
    parts = {"baseline": (1, 5.0, 0.735), "window3": (1, 9.0, 0.76), "window9": (1, 2.0, 0.7)}
    parts |= {"layers2": (1, 120.0, 1.5), "phi_shallow": (1, 8.0, 0.64), "net_force": (1, 8.0, 0.64)}
    table = ablations(parts)
    words = {"window3": AGREES, "window9": DIFFERS, "layers2": AGREES, "phi_shallow": DIFFERS}
    assert table["verdict"].to_dict() == {"baseline": "", "net_force": ""} | words
    assert table["thesis_percent"]["phi_shallow"] == float(PRINTED["A.phi.shallow"])
    assert table["epochs"].eq(2).all() and table["training_s"].eq(20).all()
    runaway = ablations({"baseline": (0, 1e9, 1e9), "window9": (0, 2e9, 2e9)})
    assert runaway["verdict"].to_dict() == {"baseline": "", "window9": OPEN}


def test_an_ablation_within_the_scatter_of_the_baseline_says_nothing():
    parts = {"baseline": (1, 5.0, 0.735), "window3": (1, 9.0, 0.76), "layers2": (1, 120.0, 1.5)}
    parts |= {"window9": (0, 6.0, 0.7), "no_global_loss": (1, 9.0, 0.76), "phi_deep": (1, 60.0, 0.3)}
    again = {"baseline": [(1, 23.0, 0.9), (1, 12.0, 0.8)], "phi_deep": [(1, 50.0, 0.3), (1, 55.0, 0.3)]}
    table = ablations(parts, again)
    # 18 points between two trainings of the baseline; window9 is within them, but no baseline runs away as it does.
    says = {"baseline": "", "window3": "nothing", "layers2": "something", "window9": "something"}
    assert table["says"].to_dict() == says | {"no_global_loss": "nothing", "phi_deep": "something"}
    assert table["baseline_apart_percent"].unique() == pytest.approx([18.0])
    # Of three trainings only the range is known.
    assert tuple(table.loc["phi_deep", ["lower_percent", "upper_percent"]]) == (50.0, 60.0)
    assert set(ablations(parts)["says"]) == {""}
    # With an error of 60 %, it is worse than a baseline of 5 %, and not than one of 61 %.
    for other, word in ((61.0, "nothing"), (6.0, "something")):
        table = ablations({"baseline": (1, 5.0, 0.7), "window3": (1, 60.0, 0.9)}, {"baseline": [(1, other, 0.8)]})
        assert table["says"]["window3"] == word


pytestmark = pytest.mark.usefixtures("close_figures")
