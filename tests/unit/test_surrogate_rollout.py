"""The recursive stage, the scene that it moves in, and its timing."""

from pathlib import Path

import numpy as np
import pytest
import torch
import yaml

from millprint.thesis.surrogate import graph_surrogate
from millprint.thesis.surrogate.dataset import DISTANCE, featurise, graphs_at
from millprint.thesis.surrogate.graph_surrogate import (
    GraphSurrogate,
    euler_step,
    scaled_thresholds,
    simulation_seconds,
    snap_back,
)
from millprint.thesis.surrogate.network import NormalisedNetwork, feature_statistics
from millprint.thesis.surrogate.rollout import read_scene
from tests.conftest import configuration
from tests.unit.surrogate_samples import CONTACTS, STEP, VESSEL, circle, simulate, small_recipe, sphere_scene, write_run

RUN, SCENE = simulate(), sphere_scene()

SNAPSHOTS = featurise(RUN, SCENE)

CPU = torch.device("cpu")


class Free(torch.nn.Module):
    """A model of balls that only fall, and dissipate 1 mJ for each wall edge."""

    def forward(self, graphs):
        acceleration = torch.tensor([0.0, 0.0, -9.81]).expand(graphs.count, graphs.balls, 3)
        graph = graphs.graph_of_ball[graphs.edges.wall]
        return acceleration, 1e-3 * torch.bincount(graph, minlength=graphs.count).float()


def untrained() -> NormalisedNetwork:
    torch.manual_seed(0)
    recipe = small_recipe()
    return NormalisedNetwork(recipe, feature_statistics([(SNAPSHOTS, torch.arange(3, 290))], recipe.graph, None)).eval()


def surrogate(model, snap_back_m=-0.0049) -> GraphSurrogate:
    return GraphSurrogate(model, SCENE, RUN, 4, CONTACTS, snap_back_m, CPU)


def test_euler_step():
    position, velocity = euler_step(np.array([1.0]), np.array([2.0]), np.array([10.0]), 0.1)
    assert position[0] == pytest.approx(1.2)  # with the old velocity, Eq. 6.32
    assert velocity[0] == pytest.approx(3.0)


def test_snap_back_puts_the_ball_at_its_threshold():
    inside = np.array([[0.0, 0.0, 0.01], [0.0, 0.0, VESSEL - 0.0048], [VESSEL + 0.001, 0.0, 0.0]])
    distance, gradient = SCENE.signed_distance(inside, np.zeros(3))
    moved, beyond = snap_back(inside, distance, gradient, -0.0049)
    assert beyond.tolist() == [False, True, True]
    again, _ = SCENE.signed_distance(moved, np.zeros(3))
    np.testing.assert_array_equal(moved[0], inside[0])
    np.testing.assert_allclose(again[1:], -0.0049, rtol=1e-12)


def test_first_state_is_the_training_graph():
    """The roll-out's own graph of a DEM window equals the one that training would see with threshold edges."""
    model = untrained()
    state = surrogate(Free()).first_state([0.02, 0.01])
    own, known = surrogate(model).graphs(state), graphs_at(SNAPSHOTS, torch.tensor([200, 100]), 4, CONTACTS)
    torch.testing.assert_close(own.ball, known.ball)
    torch.testing.assert_close(own.wall, known.wall)
    assert torch.equal(own.edges.pair, known.edges.pair) and torch.equal(own.edges.wall, known.edges.wall)


def test_free_fall():
    state = surrogate(Free()).first_state([0.0])
    rollout = surrogate(Free(), None).run(state, 50, 10)
    start = RUN.time_s[3]
    fall = rollout.position_m[:, 0] - (RUN.position_m[3] + RUN.velocity_m_s[3] * rollout.time_s[:, None, None])
    # Explicit Euler falls by g dt^2 n (n - 1) / 2 in n steps.
    steps = np.arange(0, 51, 10)
    expected = np.repeat((-9.81 * STEP**2 * steps * (steps - 1) / 2)[:, None], RUN.balls, axis=1)
    np.testing.assert_allclose(fall[..., 2], expected, atol=1e-8)
    assert rollout.start_s[0] == pytest.approx(start)


def test_window_slides_and_the_wall_moves():
    sim = surrogate(Free())
    state = surrogate(Free()).first_state([0.01])
    following, _, _ = sim.advance(state, sim.graphs(state))
    np.testing.assert_array_equal(following.ball[:, :, :-1], state.ball[:, :, 1:])
    np.testing.assert_allclose(following.wall[0, -1, :3], circle(0.0101), rtol=1e-6)
    distance, _ = SCENE.signed_distance(following.position_m, circle(0.0101))
    np.testing.assert_allclose(following.ball[:, :, -1, DISTANCE], distance, rtol=1e-5)


@pytest.mark.slow
def test_no_ball_stays_outside_with_snap_back():
    state = surrogate(Free()).first_state([0.0])
    with_snap = surrogate(Free()).run(state, 1200, 100)
    wall = circle(with_snap.start_s[0] + with_snap.time_s)
    far = np.linalg.norm(with_snap.position_m[:, 0] - wall[:, None], axis=-1)
    assert far.max() < VESSEL - 0.0049 + 1e-6
    without = surrogate(Free(), None).run(state, 1200, 100)
    assert np.isfinite(without.crossed_s).all()
    assert 0 < without.crossed_s.min() < 1200 * STEP


def test_dissipation_of_every_step_is_counted():
    state = surrogate(Free()).first_state([0.01])
    coarse, fine = (surrogate(Free()).run(state, 60, stride) for stride in (20, 1))
    np.testing.assert_allclose(coarse.dissipated_J.sum(), fine.dissipated_J.sum())
    np.testing.assert_allclose(fine.dissipated_J.sum(), 60 * 1e-3 * fine.mean_edges["wall"], rtol=1e-6)
    np.testing.assert_array_equal(coarse.position_m[1:], fine.position_m[20::20])


def test_trajectories_of_a_batch_do_not_meet():
    model = untrained()
    alone = [surrogate(model).run(surrogate(Free()).first_state([start]), 30, 10) for start in (0.005, 0.02)]
    batch = surrogate(model).run(surrogate(Free()).first_state([0.005, 0.02]), 30, 10)
    for number, single in enumerate(alone):
        np.testing.assert_allclose(batch.position_m[:, number], single.position_m[:, 0], atol=1e-7)
        np.testing.assert_allclose(batch.dissipated_J[:, number], single.dissipated_J[:, 0], rtol=1e-3, atol=1e-9)


def test_roll_out_that_is_not_finite_ends():
    class Broken(Free):
        def forward(self, graphs):
            acceleration, dissipation = super().forward(graphs)
            return acceleration * float("nan"), dissipation

    rollout = surrogate(Broken()).run(surrogate(Free()).first_state([0.01]), 100, 10)
    assert np.isfinite(rollout.crossed_s).all() and np.isnan(rollout.position_m[-1]).all()


ROOT = Path(__file__).parents[2]
FILES = ("mills/emax.yaml", "contacts/calibrated.yaml")


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    path = tmp_path_factory.mktemp("scene") / "run.h5"
    mill, contact = (yaml.safe_load((ROOT / "config" / name).read_text()) for name in FILES)
    write_run(simulate(3), path, {"mill": mill, "contact": contact, "case": {"ball_diameter_m": 0.01, "speed_hz": 5.0}})
    return read_scene(path)


def test_balls_and_motion(scene):
    assert scene.ball_radius_m == 0.005 and scene.speed_rpm == 300
    assert scene.ball_mass_kg == pytest.approx(7700 * np.pi / 6 * 0.01**3)
    quarter = scene.wall_position(np.array([0.0, 0.05, 0.1]))
    np.testing.assert_allclose(quarter, 0.017 * np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0]]), atol=1e-9)


def test_distance_moves_with_the_wall(scene):
    """5 mm over the floor, and 10 mm under the lid of the 35 mm high jar, wherever the jar is."""
    wall = np.array([[0.017, 0.0, 0.0], [-0.3, 0.2, 0.1]])
    heights = np.array([[0, 0, 0.005], [0, 0, 0.025]])
    distance, gradient = scene.signed_distance(wall + heights, wall)
    np.testing.assert_allclose(distance, [-0.005, -0.010], rtol=1e-9)
    np.testing.assert_allclose(gradient, [[0, 0, -1], [0, 0, 1]], atol=1e-9)


def test_what_is_not_finite_has_no_distance(scene):
    position = np.array([[np.nan, 0, 0], [0, 0, 0.01], [np.inf, 0, 0]])
    distance, gradient = scene.signed_distance(position, np.zeros(3))
    assert np.isnan(distance[[0, 2]]).all() and distance[1] == pytest.approx(-0.01)
    assert np.isfinite(gradient[1]).all()


def test_thresholds_of_smaller_balls_are_at_the_same_gaps():
    rule, snap_back_m = scaled_thresholds(CONTACTS, -0.0049, 0.0025, 0.005)
    assert rule.wall_threshold_m == pytest.approx(-0.0027) and snap_back_m == pytest.approx(-0.0024)
    assert rule.ball_threshold_m == CONTACTS.ball_threshold_m
    assert scaled_thresholds(CONTACTS, None, 0.0025, 0.005)[1] is None


@pytest.mark.slow
def test_the_simulation_is_timed_again(tmp_path, monkeypatch):
    mill, contact = (yaml.safe_load((ROOT / "config" / name).read_text()) for name in FILES)
    case = {"mill": "emax", "contact": "calibrated", "ball_diameter_m": 0.01, "fill_ratio": 0.1, "speed_hz": 5.0}
    case |= {"seed": 0, "settle_s": 0.01, "discard_s": 5.0, "window_s": 1.0, "snapshot_interval_s": 1e-4}
    config = {"mill": mill, "contact": contact, "case": case, "dem": configuration()["dem"]}
    write_run(simulate(3), tmp_path / "run.h5", config)
    timed = []

    class Timed(graph_surrogate.Simulation):
        def __init__(self, *given):
            super().__init__(*given)
            timed.append(self)

    monkeypatch.setattr(graph_surrogate, "Simulation", Timed)
    found = simulation_seconds(tmp_path / "run.h5", 1e-3)
    # Neither the five seconds left out nor the window of the recorded case are simulated.
    assert [own.case.discard_s for own in timed] == [0.0, 0.0]
    assert [own.case.window_s for own in timed] == [1e-3, 1e-3]
    # The kernel's time for a second of the last one, for the 15 s of the thesis.
    steps = timed[-1].settle_steps + timed[-1].window_steps
    assert found == pytest.approx(15 * timed[-1].wall_clock_s / (steps * timed[-1].step))
    assert 0.0 < found < 1e4
