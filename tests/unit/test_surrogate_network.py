"""Graphs, the network, its loss and its training."""

import re
from dataclasses import replace

import numpy as np
import pytest
import torch
import yaml
from snakemake.utils import update_config

from millprint.config.errors import TrainingError
from millprint.config.load import check_model
from millprint.config.surrogate import NetworkConfig
from millprint.config.workflow import WorkflowConfig
from millprint.thesis.surrogate import device
from millprint.thesis.surrogate.dataset import (
    DISTANCE,
    GRADIENT,
    VELOCITY,
    Graphs,
    TrainingRun,
    contact_edges,
    featurise,
    graphs_at,
    read_dataset,
    threshold_edges,
    write_dataset,
)
from millprint.thesis.surrogate.network import (
    InteractionLayer,
    NormalisedNetwork,
    SignedDistanceNetwork,
    feature_statistics,
    read_weights,
    write_weights,
)
from millprint.thesis.surrogate.rollout import read_trajectory
from millprint.thesis.surrogate.training import Trainer, draw_epoch, losses
from tests.conftest import ROOT, configuration
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


SAMPLE = TrainingRun("sample", SNAPSHOTS, 230, 299)


def trained(steps: int | None = None, **changes) -> Trainer:
    trainer = Trainer([SAMPLE], small_recipe(**changes), CPU)
    trainer.train(max_steps=steps)
    return trainer


def test_huber_closed_form():
    settings, still = small_recipe().training, torch.zeros(1, 3)

    def huber(error: float) -> float:
        return losses((still, torch.tensor([error])), (still, torch.zeros(1)), settings)["dissipation"].item()

    errors = [-5.0, -2.0, -0.5, 0.0, 1.0, 2.0, 7.0]
    assert list(map(huber, errors)) == pytest.approx([4.0, 1.0, 0.0625, 0.0, 0.25, 1.0, 6.0])
    below, above = huber(2 - 1e-4), huber(2 + 1e-4)
    assert above - below == pytest.approx(2e-4, rel=1e-2)  # slope 1 on both sides of delta


def test_total_loss_is_weighted():
    settings = small_recipe().training
    terms = losses((torch.ones(4, 3), torch.tensor([3.0, 0.0])), (torch.zeros(4, 3), torch.zeros(2)), settings)
    assert terms["acceleration"].item() == pytest.approx(0.25)
    assert terms["dissipation"].item() == pytest.approx(1.0)  # (|3| - 1 + 0) / 2
    assert terms["total"].item() == pytest.approx(3 * 0.25 + 1.0)


def test_mean_aggregation():
    torch.manual_seed(0)
    layer = InteractionLayer(4, 2)
    node, edge = torch.randn(3, 4), torch.randn(2, 4)
    into_first = torch.tensor([[1, 2], [0, 0]])
    message = [layer.message_mlp(torch.cat([node[0], node[j], edge[k]])) for k, j in ((0, 1), (1, 2))]
    expected = layer.node_mlp(torch.cat([node[0], (message[0] + message[1]) / 2]))
    out = layer(node, into_first, edge)
    torch.testing.assert_close(out[0], expected)
    torch.testing.assert_close(out[1], layer.node_mlp(torch.cat([node[1], torch.zeros(4)])))


def as_printed(network: SignedDistanceNetwork, graphs: Graphs) -> tuple[torch.Tensor, torch.Tensor]:
    """Eqs 6.22 to 6.27 word by word: every perceptron on what is joined for each edge and node."""
    edges, balls = graphs.edges, len(graphs.ball)
    node = network.node_encoder(torch.cat([graphs.ball, graphs.wall]))
    pair, at_wall = network.edge_encoder(edges.pair_vector), network.edge_encoder(edges.wall_vector)
    wall = balls + edges.wall // graphs.balls
    source, target = torch.cat([edges.pair[0], wall, edges.wall]), torch.cat([edges.pair[1], edges.wall, wall])
    edge = torch.cat([pair, at_wall, at_wall])
    for layer in network.processor:
        message = layer.message_mlp(torch.cat([node[target], node[source], edge], dim=1))
        mean = torch.stack([message[target == i].sum(0) / max(1, int((target == i).sum())) for i in range(len(node))])
        node = layer.node_mlp(torch.cat([node, mean], dim=1))
    node, touched = node[:balls], torch.isin(torch.arange(balls), target).view(graphs.count, -1)
    rows = zip(node.view(graphs.count, graphs.balls, -1), touched, strict=True)
    pooled = torch.stack([own[with_edge].sum(0) / max(1, int(with_edge.sum())) for own, with_edge in rows])
    return network.decoder(node), network.readout(pooled).squeeze(1)


@pytest.mark.parametrize("layers", [2, 4])
@pytest.mark.parametrize("rounds", [1, 3])
def test_values_and_gradients_are_those_of_the_printed_equations(rounds, layers):
    """In double precision, with graphs with and without edges and with biases, which are zero at the start."""
    torch.manual_seed(3)
    network = SignedDistanceNetwork(4, NetworkConfig(width=16, mlp_layers=layers, interaction_layers=rounds)).double()
    for name, value in network.named_parameters():
        if name.endswith("bias"):
            torch.nn.init.normal_(value, std=0.3)
    single = graphs_at(SNAPSHOTS, torch.tensor([3, 150, 230]), 4, None)
    edges = replace(
        single.edges, pair_vector=single.edges.pair_vector.double(), wall_vector=single.edges.wall_vector.double()
    )
    graphs = replace(single, ball=single.ball.double(), wall=single.wall.double(), edges=edges)
    assert edges.pair.numel() and edges.wall.numel() and not (edges.wall < graphs.balls).any()
    found = []
    for values in (network(graphs), as_printed(network, graphs)):
        total = values[0].square().sum() + 3 * values[1].square().sum()
        found.append((*values, *torch.autograd.grad(total, tuple(network.parameters()))))
    assert any(gradient.abs().max() > 1e-3 for gradient in found[1][2:])
    for new, printed in zip(*found, strict=True):
        torch.testing.assert_close(new, printed, rtol=1e-9, atol=1e-9 * printed.detach().abs().max().item())


def test_every_snapshot_is_drawn_once():
    rows = [torch.arange(3, 40), torch.arange(10, 30)]
    batches = draw_epoch(rows, 1000, 8, seed=5)
    for number, part in enumerate(rows):
        drawn = torch.cat([batch for run, batch in batches if run == number])
        assert torch.equal(drawn.sort().values, part)
    assert sum(len(batch) for _, batch in draw_epoch(rows, 20, 8, seed=5)) == 20


@pytest.fixture
def products():
    """The choice of products as in a job, which a test leaves as it was."""
    device.choose_products()
    yield
    torch.set_float32_matmul_precision("highest")


def test_products_are_single_precision_on_any_processor(products, monkeypatch):
    assert device.has_single_products()
    for processor, single, chosen in (
        ("znver5", True, "medium"),
        ("znver9", False, "highest"),  # one that would round the factors
        ("icelake-client", True, "highest"),
    ):
        monkeypatch.setattr(device.binding, "get_host_cpu_name", lambda name=processor: name)
        monkeypatch.setattr(device, "has_single_products", lambda single=single: single)
        device.choose_products()
        assert torch.get_float32_matmul_precision() == chosen, processor


@pytest.mark.slow
def test_resumed_training_is_the_uninterrupted_one(tmp_path, products):
    whole = trained(velocity_noise=0.1)
    part = trained(steps=11, velocity_noise=0.1)
    part.save(tmp_path / "checkpoint.pt")
    again = Trainer([SAMPLE], small_recipe(velocity_noise=0.1), CPU)
    torch.rand(100)  # the global generator must not matter
    assert again.resume(tmp_path / "checkpoint.pt", CPU) and again.cursor == 3 and again.epoch == 1
    assert again.train()
    for name, value in whole.model.state_dict().items():
        assert torch.equal(value, again.model.state_dict()[name]), name
    losses_of = [trainer.history_table().drop(columns="elapsed_s") for trainer in (whole, again)]
    assert losses_of[0].equals(losses_of[1])


def test_checkpoint_of_another_recipe_is_not_resumed(tmp_path):
    trained(steps=2).save(tmp_path / "checkpoint.pt")
    assert not Trainer([SAMPLE], small_recipe(seed=4), CPU).resume(tmp_path / "checkpoint.pt", CPU)
    assert Trainer([SAMPLE], small_recipe(wall_time_max_s=200), CPU).resume(tmp_path / "checkpoint.pt", CPU)
    assert not Trainer([SAMPLE], small_recipe(), CPU).resume(tmp_path / "absent.pt", CPU)


def test_the_training_on_a_graphics_card_runs_at_a_small_budget_and_says_its_cost(caplog):
    """The settings of config/graphics_card.yaml on top of the thesis's, with fewer snapshots and epochs."""
    content = configuration()
    update_config(content, yaml.safe_load((ROOT / "config/graphics_card.yaml").read_text()))
    settings = check_model(content, WorkflowConfig, "config.yaml").surrogate
    variant = settings.variant("thesis")
    assert variant.training.epochs * variant.training.snapshots_per_epoch == 90e6 and variant.rollout.length_s == 15
    assert settings.trainings == 5
    small = {"epochs": 2, "snapshots_per_epoch": 64}
    recipe = variant.recipe().model_copy(update={"training": variant.training.model_copy(update=small)})
    trainer = Trainer([SAMPLE], recipe, CPU)
    with caplog.at_level("INFO", logger="millprint"):
        assert trainer.train()
    pace_s = trainer.history[0]["elapsed_s"]
    assert re.search(r"s an epoch on cpu: 2 epochs take \S+ h; training.wall_time_max_s = 2700 allows 2", caplog.text)
    assert 0 < pace_s <= trainer.elapsed_s and trainer.history[-1]["epoch"] == 2


@pytest.mark.parametrize("field", ["ball", "position", "finite_difference", "dissipation"])
def test_data_that_are_not_finite_are_refused_before_a_training(field):
    values = getattr(SNAPSHOTS, field).clone()
    values[120] = float("nan")
    poisoned = replace(SAMPLE, snapshots=replace(SNAPSHOTS, **{field: values}))
    with pytest.raises(TrainingError, match=f"before epoch 1, run sample: {field} of snapshot 120 is not a finite"):
        Trainer([SAMPLE, poisoned], small_recipe(), CPU)


def test_a_training_that_runs_away_stops_and_names_epoch_and_run(tmp_path):
    trainer = Trainer([SAMPLE], small_recipe(learning_rate=100.0, final_learning_rate=100.0, epochs=3), CPU)
    with pytest.raises(TrainingError, match=r"epoch 1, step \d, run sample: \w+ is nan.*learning_rate = 100 may be"):
        trainer.train(tmp_path / "checkpoint.pt")
    assert not list(tmp_path.iterdir())


def test_weights_load_without_code(tmp_path):
    trainer = trained(steps=3)
    write_weights(tmp_path / "weights.pt", trainer.model, trainer.recipe)
    assert set(torch.load(tmp_path / "weights.pt", weights_only=True)) == {"recipe", "state"}
    model, recipe = read_weights(tmp_path / "weights.pt", CPU)
    assert recipe == trainer.recipe
    graphs = graphs_at(SNAPSHOTS, torch.tensor([100]), 4, None)
    with torch.inference_mode():
        for first, second in zip(model(graphs), trainer.model(graphs), strict=True):
            assert torch.equal(first, second)


@pytest.mark.slow
def test_learns_a_small_set():
    """Forty snapshots by heart: the loss falls at least tenfold, and accelerations are explained."""
    recipe = small_recipe(
        width=64, epochs=60, batch_size=10, velocity_noise=0.0, snapshots_per_epoch=40, final_learning_rate=3e-4
    )
    few = TrainingRun("few", SNAPSHOTS, 43, 60)
    torch.manual_seed(0)
    trainer = Trainer([few], recipe, CPU)
    trainer.train()
    history = trainer.history_table()["training_total"]
    assert history.iloc[-5:].mean() < history.iloc[0] / 10
    graphs = graphs_at(SNAPSHOTS, torch.arange(3, 43), 4, None)
    with torch.inference_mode():
        predicted = trainer.model(graphs)[0].numpy()
    truth = SNAPSHOTS.finite_difference[3:43].numpy()
    assert 1 - ((predicted - truth) ** 2).sum() / ((truth - truth.mean()) ** 2).sum() > 0.9
    assert np.isfinite(predicted).all()
