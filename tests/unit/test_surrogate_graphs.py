"""Features, edges and statistics of the surrogate's graphs."""

import numpy as np
import pytest
import torch

from millprint.config.errors import ConfigError
from millprint.thesis.surrogate.dataset import (
    DISTANCE,
    GRADIENT,
    VELOCITY,
    TrainingRun,
    contact_edges,
    featurise,
    graphs_at,
    read_dataset,
    threshold_edges,
    wall_contact_distances,
    write_dataset,
)
from millprint.thesis.surrogate.measure_tables import covered_share, wall_contact_table
from millprint.thesis.surrogate.network import NormalisedNetwork, feature_statistics
from millprint.thesis.surrogate.scene import read_trajectory
from millprint.thesis.surrogate.training import Trainer
from tests.unit.surrogate_samples import (
    CONTACTS,
    GRAVITY,
    MASS,
    RADIUS,
    simulate,
    small_recipe,
    sphere_scene,
    write_run,
)

RUN, SCENE = simulate(), sphere_scene()
SNAPSHOTS = featurise(RUN, SCENE)
CPU = torch.device("cpu")


def test_features_of_a_snapshot():
    distance, gradient = SCENE.signed_distance(RUN.position_m[7], RUN.wall_position_m[7])
    ball = SNAPSHOTS.ball[7].numpy()
    np.testing.assert_allclose(ball[:, VELOCITY], RUN.velocity_m_s[7], rtol=1e-6)
    np.testing.assert_allclose(ball[:, DISTANCE], distance, rtol=1e-6)
    np.testing.assert_allclose(ball[:, GRADIENT], gradient, atol=1e-6)
    np.testing.assert_allclose(SNAPSHOTS.wall[7], [*RUN.wall_position_m[7], 300, 0, 0, 0], rtol=1e-6)


def test_both_targets_agree_where_the_force_is_constant_over_the_step():
    """The sample's integrator holds the force over a step, so (v[n+1] - v[n]) / dt is F / m + g of the instant."""
    np.testing.assert_allclose(SNAPSHOTS.net_force, RUN.force_N / MASS + GRAVITY, rtol=1e-5, atol=1e-4)
    np.testing.assert_allclose(SNAPSHOTS.finite_difference[:-1], SNAPSHOTS.net_force[:-1], atol=0.02)
    assert torch.isnan(SNAPSHOTS.finite_difference[-1]).all()


def test_dissipation_belongs_to_the_step_that_follows():
    np.testing.assert_allclose(SNAPSHOTS.dissipation[:-1], RUN.dissipated_J[1:], rtol=1e-6)


def test_window_is_ordered_from_old_to_new():
    rows = torch.tensor([20, 50])
    graphs = graphs_at(SNAPSHOTS, rows, 7, None)
    assert graphs.ball.shape == (2 * RUN.balls, 49) and graphs.wall.shape == (2, 49)
    windows = graphs.ball.view(2, RUN.balls, 7, 7)
    assert torch.equal(windows[1, 3, 0], SNAPSHOTS.ball[44, 3])
    assert torch.equal(windows[1, 3, -1], SNAPSHOTS.ball[50, 3])


def _brute_force(rows, reach, wall_threshold):
    pairs, at_wall = set(), set()
    for graph, row in enumerate(rows):
        shift = graph * RUN.balls
        for i in range(RUN.balls):
            if SNAPSHOTS.ball[row, i, DISTANCE] >= wall_threshold:
                at_wall.add(shift + i)
            for j in range(RUN.balls):
                far = np.linalg.norm(RUN.position_m[row, j] - RUN.position_m[row, i])
                if i != j and far <= reach:
                    pairs.add((shift + j, shift + i))
    return pairs, at_wall


@pytest.mark.parametrize("reading, extra", [("surface_gap", 2 * RADIUS), ("centre_distance", 0.0)])
def test_threshold_edges_against_brute_force(reading, extra):
    rows = torch.arange(0, 300, 7)
    rule = CONTACTS.model_copy(update={"ball_threshold_reading": reading})
    edges = threshold_edges(SNAPSHOTS.position[rows], SNAPSHOTS.ball[rows], rule, RADIUS)
    pairs, at_wall = _brute_force(rows.tolist(), 0.0015 + extra, -0.0052)
    assert {tuple(pair) for pair in edges.pair.T.tolist()} == pairs
    assert sorted(edges.wall.tolist()) == sorted(at_wall)
    assert bool(pairs) == (reading == "surface_gap")


def test_contact_edges_are_the_reported_contacts():
    rows = torch.tensor([40, 230, 299])
    edges = contact_edges(SNAPSHOTS, rows)
    pairs, at_wall = _brute_force(rows.tolist(), 2 * RADIUS, -RADIUS)
    assert pairs and at_wall
    assert {tuple(pair) for pair in edges.pair.T.tolist()} == pairs
    # Two facets of the wall are one edge.
    assert sorted(edges.wall.tolist()) == sorted(at_wall)


def test_edge_vectors():
    rows = torch.tensor([230])
    edges = contact_edges(SNAPSHOTS, rows)
    source, target = edges.pair.numpy()
    expected = RUN.position_m[230, source] - RUN.position_m[230, target]
    np.testing.assert_allclose(edges.pair_vector, expected, atol=1e-8)
    distance, gradient = SCENE.signed_distance(RUN.position_m[230], RUN.wall_position_m[230])
    np.testing.assert_allclose(edges.wall_vector, (distance[:, None] * gradient)[edges.wall.numpy()], atol=1e-8)


def test_statistics_come_from_training_rows_only():
    recipe = small_recipe()
    spoiled = simulate()
    spoiled.velocity_m_s[202:] += 100.0
    spoiled.dissipated_J[202:] += 50.0
    clean, dirty = (
        Trainer([TrainingRun("a", featurise(run, SCENE), 200, 299)], recipe, CPU).model for run in (RUN, spoiled)
    )
    for name, value in clean.named_buffers():
        assert torch.equal(value, dict(dirty.named_buffers())[name]), name
    rows = torch.arange(3, 200)
    expected = SNAPSHOTS.ball[rows].reshape(-1, 7).double()
    torch.testing.assert_close(clean.ball_mean, expected.mean(0).float())
    torch.testing.assert_close(clean.ball_std, expected.std(0, correction=0).float())


def test_statistics_are_kept_apart_and_make_unit_deviation():
    rows = torch.arange(3, 250)
    recipe = small_recipe()
    model = NormalisedNetwork(recipe, feature_statistics([(SNAPSHOTS, rows)], recipe.graph, None))
    graphs = model.normalise(graphs_at(SNAPSHOTS, rows, 4, None))
    newest = graphs.ball.view(-1, 4, 7)[:, -1]
    for values in (newest, graphs.edges.pair_vector, graphs.edges.wall_vector):
        torch.testing.assert_close(values.mean(0), torch.zeros(values.shape[1]), atol=1e-3, rtol=0)
        torch.testing.assert_close(values.std(0, correction=0), torch.ones(values.shape[1]), atol=1e-3, rtol=0)
    # The wall's speed and padding never vary: they become zero, and a later change of them stays finite.
    wall = graphs.wall.view(-1, 4, 7)[:, -1]
    torch.testing.assert_close(wall[:, 2:], torch.zeros(len(wall), 5))


def test_dataset_on_disk_is_the_same(tmp_path):
    write_run(RUN, tmp_path / "run.h5")
    run = featurise(read_trajectory(tmp_path / "run.h5"), SCENE)
    write_dataset([TrainingRun("a/b/c", run, 200, 299)], tmp_path / "dataset.h5")
    (again,) = read_dataset(tmp_path / "dataset.h5")
    assert (again.case, again.train_end, again.validation_end) == ("a/b/c", 200, 299)
    rows = torch.tensor([30, 211])
    first, second = graphs_at(SNAPSHOTS, rows, 7, None), graphs_at(again.snapshots, rows, 7, None)
    assert torch.equal(first.ball, second.ball) and torch.equal(first.edges.pair, second.edges.pair)
    assert torch.equal(again.snapshots.dissipation[:-1], SNAPSHOTS.dissipation[:-1])


def test_part_of_a_run(tmp_path):
    write_run(RUN, tmp_path / "run.h5")
    part = read_trajectory(tmp_path / "run.h5", 0.005, 0.02)
    assert len(part.time_s) == 151 and part.index(0.0101) == 51
    np.testing.assert_array_equal(part.position_m[51], RUN.position_m[101])
    rows = slice(RUN.contact_offset[200], RUN.contact_offset[201])
    np.testing.assert_array_equal(part.first[part.contact_offset[150] : part.contact_offset[151]], RUN.first[rows])
    with pytest.raises(ConfigError, match=r"no snapshot at 0\.05 s"):
        part.index(0.05)
    with pytest.raises(ConfigError, match="fewer than two snapshots"):
        read_trajectory(tmp_path / "run.h5", 5.0)


def test_share_of_wall_contacts():
    table = wall_contact_table(np.array([-0.00525, -0.00515, -0.005, -0.00495]))
    assert table["contacts"].sum() == 4
    assert covered_share(table, -0.0052) == 0.75 and covered_share(table, -0.0053) == 1.0
    assert covered_share(wall_contact_table(wall_contact_distances(SNAPSHOTS, 300)), -0.0052) == 1.0
