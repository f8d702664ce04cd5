"""The network, its loss and its training."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from millprint.config.errors import TrainingError
from millprint.config.surrogate import NetworkConfig
from millprint.thesis.surrogate.dataset import Graphs, TrainingRun, featurise, graphs_at
from millprint.thesis.surrogate.network import (
    SignedDistanceNetwork,
    read_weights,
    weights_content,
    write_tensors,
)
from millprint.thesis.surrogate.training import Trainer, draw_epoch, huber, losses
from tests.unit.surrogate_samples import simulate, small_recipe, sphere_scene

CPU = torch.device("cpu")
SNAPSHOTS = featurise(simulate(), sphere_scene())
RUN = TrainingRun("sample", SNAPSHOTS, 230, 299)


def trained(steps: int | None = None, **changes) -> Trainer:
    trainer = Trainer([RUN], small_recipe(**changes), CPU)
    trainer.train(max_steps=steps)
    return trainer


def test_huber_closed_form():
    error = torch.tensor([-5.0, -2.0, -0.5, 0.0, 1.0, 2.0, 7.0])
    torch.testing.assert_close(huber(error, 2.0), torch.tensor([4.0, 1.0, 0.0625, 0.0, 0.25, 1.0, 6.0]))
    below, above = huber(torch.tensor([2 - 1e-4, 2 + 1e-4]), 2.0)
    assert above - below == pytest.approx(2e-4, rel=1e-2)  # slope 1 on both sides of delta


def test_total_loss_is_weighted():
    settings = small_recipe().training
    terms = losses((torch.ones(4, 3), torch.tensor([3.0, 0.0])), (torch.zeros(4, 3), torch.zeros(2)), settings)
    assert terms["acceleration"].item() == pytest.approx(0.25)
    assert terms["dissipation"].item() == pytest.approx(1.0)  # (|3| - 1 + 0) / 2
    assert terms["total"].item() == pytest.approx(3 * 0.25 + 1.0)


def test_number_of_weights_of_the_published_network():
    """Table 6.3: six MLPs of four linear layers, 256 wide; 49 node and 3 edge inputs, 3 and 1 outputs."""
    network = SignedDistanceNetwork(7, NetworkConfig(width=256, mlp_layers=4, interaction_layers=1))

    def linear(inputs: int, outputs: int) -> int:
        return (inputs + 1) * outputs

    hidden = 2 * linear(256, 256)
    expected = sum(
        linear(inputs, 256) + hidden + linear(256, outputs)
        for inputs, outputs in ((49, 256), (3, 256), (3 * 256, 256), (2 * 256, 256), (256, 3), (256, 1))
    )
    assert sum(value.numel() for value in network.parameters()) == expected


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


@pytest.mark.slow
def test_resumed_training_is_the_uninterrupted_one(tmp_path):
    whole = trained(velocity_noise=0.1)
    part = trained(steps=11, velocity_noise=0.1)
    part.save(tmp_path / "checkpoint.pt")
    again = Trainer([RUN], small_recipe(velocity_noise=0.1), CPU)
    torch.rand(100)  # the global generator must not matter
    assert again.resume(tmp_path / "checkpoint.pt", CPU) and again.cursor == 3 and again.epoch == 1
    assert again.train()
    for name, value in whole.model.state_dict().items():
        assert torch.equal(value, again.model.state_dict()[name]), name
    losses_of = [trainer.history_table().drop(columns="elapsed_s") for trainer in (whole, again)]
    assert losses_of[0].equals(losses_of[1])


def test_checkpoint_of_another_recipe_is_not_resumed(tmp_path):
    trained(steps=2).save(tmp_path / "checkpoint.pt")
    assert not Trainer([RUN], small_recipe(seed=4), CPU).resume(tmp_path / "checkpoint.pt", CPU)
    assert Trainer([RUN], small_recipe(wall_time_max_s=200), CPU).resume(tmp_path / "checkpoint.pt", CPU)
    assert not Trainer([RUN], small_recipe(), CPU).resume(tmp_path / "absent.pt", CPU)


def test_wall_time_ends_a_training():
    trainer = Trainer([RUN], small_recipe(epochs=100_000, wall_time_max_s=0.3), CPU)
    assert not trainer.train()
    assert 0.3 <= trainer.elapsed_s < 3 and len(trainer.history) >= 1


@pytest.mark.parametrize("field", ["ball", "position", "finite_difference", "dissipation"])
def test_data_that_are_not_finite_are_refused_before_a_training(field):
    values = getattr(SNAPSHOTS, field).clone()
    values[120] = float("nan")
    poisoned = replace(RUN, snapshots=replace(SNAPSHOTS, **{field: values}))
    with pytest.raises(TrainingError, match=f"before epoch 1, run sample: {field} of snapshot 120 is not a finite"):
        Trainer([RUN, poisoned], small_recipe(), CPU)


def test_a_training_that_runs_away_stops_and_names_epoch_and_run(tmp_path):
    trainer = Trainer([RUN], small_recipe(learning_rate=100.0, final_learning_rate=100.0, epochs=3), CPU)
    with pytest.raises(TrainingError, match=r"epoch 1, step \d, run sample: \w+ is nan.*learning_rate = 100 may be"):
        trainer.train(tmp_path / "checkpoint.pt")
    assert not list(tmp_path.iterdir())


def test_weights_load_without_code(tmp_path):
    trainer = trained(steps=3)
    write_tensors(tmp_path / "weights.pt", weights_content(trainer.model, trainer.recipe))
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
