"""The signed-distance graph network (thesis Eqs 6.22 to 6.27), its normalisation, and files of its weights."""

import io
import itertools
import pickle
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import cast

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn.functional import linear
from torch_geometric.nn import MessagePassing
from torch_geometric.utils import scatter

from millprint.config.errors import ConfigError
from millprint.config.surrogate import EdgeConfig, GraphConfig, NetworkConfig, Recipe
from millprint.run.files import whole_file
from millprint.thesis.surrogate.dataset import (
    BALL_CHANNELS,
    VELOCITY,
    WALL_CHANNELS,
    Graphs,
    Snapshots,
    edges_at,
)

# What is normalised, and its number of channels.
CHANNELS = {
    "ball": BALL_CHANNELS,
    "wall": WALL_CHANNELS,
    "pair": 3,
    "wall_edge": 3,
    "acceleration": 3,
    "dissipation": 1,
}


class Perceptron(nn.Sequential):
    """A multi-layer perceptron of `layers` linear layers with ReLU between them.

    Weights start as He et al. (2015) have them for ReLU. The default of torch shrinks the signal by 0.4 a layer, and
    after the twelve layers between input and output too little is left to learn from.
    """

    def __init__(self, inputs: int, width: int, outputs: int, layers: int):
        super().__init__()
        for inner, outer in itertools.pairwise([inputs, *[width] * (layers - 1), outputs]):
            layer = nn.Linear(inner, outer)
            nn.init.kaiming_normal_(layer.weight, nonlinearity="relu")
            nn.init.zeros_(layer.bias)
            self.extend([layer, nn.ReLU(inplace=True)])
        del self[-1]

    @property
    def first(self) -> nn.Linear:
        """The first linear layer."""
        return cast(nn.Linear, self[0])

    @property
    def last(self) -> nn.Linear:
        """The last linear layer."""
        return cast(nn.Linear, self[-1])

    def between(self, values: Tensor) -> Tensor:
        """From what the first linear layer gives, which is overwritten, to what the last one takes: (n, width)."""
        for module in list(self)[1:-1]:
            values = module(values)
        return values


def in_one(first: nn.Linear, second: nn.Linear, values: Tensor) -> Tensor:
    """Values (n, inputs) through two linear layers without a ReLU between them, whose weights are multiplied first."""
    bias = torch.addmv(second.bias, second.weight, first.bias)
    return linear(values, second.weight @ first.weight, bias)


class InteractionLayer(MessagePassing):
    """One round of message passing with mean aggregation (Eqs 6.24 to 6.26).

    The first linear layer of a message, on [v_i, v_j, e_ij], is W_i v_i + W_j v_j + W_e e_ij: what nodes add is
    computed once a node. No ReLU follows the last one, so the mean over messages is taken before it. The same holds
    for what a node and its messages add to its new values: a node without messages is given none.
    """

    def __init__(self, width: int, layers: int):
        super().__init__(aggr="mean")
        self.message_mlp = Perceptron(3 * width, width, width, layers)
        self.node_mlp = Perceptron(2 * width, width, width, layers)

    def forward(self, node: Tensor, edge_index: Tensor, edge: Tensor) -> Tensor:
        """node (n, width), edge_index (2, e) source and target, edge (e, width); returns (n, width)."""
        return self.node_mlp.last(self.hidden(node, edge_index, edge, len(node)))

    def hidden(self, node: Tensor, edge_index: Tensor, edge: Tensor, updated: int) -> Tensor:
        """What the last linear layer of the nodes takes, of the first `updated` nodes; no others receive messages."""
        message, update = self.message_mlp, self.node_mlp
        to_target, to_source, along = message.first.weight.chunk(3, dim=1)
        own, received = update.first.weight.chunk(2, dim=1)
        (sources, source), (targets, target) = (torch.unique(ends, return_inverse=True) for ends in edge_index)
        mean = self.propagate(
            torch.stack([source, target]),
            node=(linear(node[sources], to_source), linear(node[targets], to_target)),
            edge=linear(edge, along, message.first.bias),
            size=(len(sources), len(targets)),
        )
        values = linear(node[:updated], own, update.first.bias)
        values.index_add_(0, targets, linear(message.last(mean), received))
        return update.between(values)

    def message(self, node_i: Tensor, node_j: Tensor, edge: Tensor) -> Tensor:
        """Hidden values of the message into node i from node j, Eq. 6.24, from what both and the edge add to it."""
        return self.message_mlp.between(node_i + node_j + edge)


class SignedDistanceNetwork(nn.Module):
    """Normalised graphs to the normalised acceleration of each ball and dissipation of each graph.

    One MLP encodes balls and walls, one both kinds of edges, as in Eqs 6.22 and 6.23. A wall edge carries messages
    both ways; the wall's own output is not used, so nothing is sent to it in the last round.
    """

    def __init__(self, window: int, size: NetworkConfig):
        super().__init__()
        width, layers = size.width, size.mlp_layers
        self.node_encoder = Perceptron(7 * window, width, width, layers)
        self.edge_encoder = Perceptron(3, width, width, layers)
        self.processor = nn.ModuleList(InteractionLayer(width, layers) for _ in range(size.interaction_layers))
        self.decoder = Perceptron(width, width, 3, layers)
        self.readout = Perceptron(width, width, 1, layers)

    def forward(self, graphs: Graphs) -> tuple[Tensor, Tensor]:
        """Normalised acceleration (graphs * balls, 3) and dissipation (graphs,)."""
        edges, balls = graphs.edges, len(graphs.ball)
        *earlier, last = cast(Iterable[InteractionLayer], self.processor)
        node = self.node_encoder(torch.cat([graphs.ball, graphs.wall]))
        edge = self.edge_encoder(torch.cat([edges.pair_vector, edges.wall_vector]))
        wall = graphs.graph_of_ball[edges.wall] + balls
        into_balls = torch.cat([edges.pair, torch.stack([wall, edges.wall])], dim=1)
        into_walls = torch.stack([edges.wall, wall])
        for layer in earlier:
            both_ways = torch.cat([edge, edge[len(edges.pair_vector) :]])
            node = layer(node, torch.cat([into_balls, into_walls], dim=1), both_ways)
        hidden = last.hidden(node, into_balls, edge, balls)
        decoder, update = self.decoder, last.node_mlp.last
        acceleration = decoder.last(decoder.between(in_one(update, decoder.first, hidden)))
        return acceleration, self._dissipation(hidden, update, into_balls[1], graphs)

    def _dissipation(self, hidden: Tensor, update: nn.Linear, touched: Tensor, graphs: Graphs) -> Tensor:
        """Mean of the balls with an edge, through the readout; a graph without any pools to zero."""
        balls = touched.unique()
        graph = graphs.graph_of_ball[balls]
        pooled = update(scatter(hidden[balls], graph, dim_size=graphs.count, reduce="mean"))
        any_edge = torch.zeros(graphs.count, 1, dtype=torch.bool, device=hidden.device)
        any_edge[graph] = True
        return self.readout(torch.where(any_edge, pooled, 0)).squeeze(1)


def target(run: Snapshots, graph: GraphConfig) -> Tensor:
    """The acceleration that the network is asked for, (n, balls, 3) [m/s2]."""
    return getattr(run, graph.acceleration)


def feature_statistics(
    parts: list[tuple[Snapshots, Tensor]], graph: GraphConfig, rule: EdgeConfig | None
) -> dict[str, Tensor]:
    """Mean and standard deviation of each kind of quantity over the given rows of each run, and no others.

    Returns `KIND_mean` and `KIND_std` for the keys of CHANNELS. A channel that does not vary (the wall's speed, its
    padding) keeps a deviation of 1, so that nothing is divided by zero.
    """
    from sklearn.preprocessing import StandardScaler

    samples: dict[str, list[Tensor]] = {kind: [] for kind in CHANNELS}
    for run, rows in parts:
        edges = edges_at(run, rows, rule)
        nodes, edge_vectors = (run.ball[rows], run.wall[rows]), (edges.pair_vector, edges.wall_vector)
        seen = (*nodes, *edge_vectors, target(run, graph)[rows], run.dissipation[rows])
        for kind, value in zip(CHANNELS, seen, strict=True):
            samples[kind].append(value)
    statistics = {}
    for kind, values in samples.items():
        table = torch.cat([part.reshape(-1, CHANNELS[kind]) for part in values]).double().numpy()
        # Where no two balls ever touch there are no pairs: their mean is 0 and their deviation 1.
        scaler = StandardScaler().fit(table if len(table) else np.zeros((1, CHANNELS[kind])))
        statistics[f"{kind}_mean"] = torch.from_numpy(scaler.mean_).float()
        statistics[f"{kind}_std"] = torch.from_numpy(scaler.scale_).float()
    return statistics


class NormalisedNetwork(nn.Module):
    """The network with its normalisation: features and targets in physical units outside, normalised inside."""

    def __init__(self, recipe: Recipe, statistics: dict[str, Tensor] | None = None):
        super().__init__()
        self.window = recipe.graph.window
        self.network = SignedDistanceNetwork(recipe.graph.window, recipe.network)
        for kind, channels in CHANNELS.items():
            for name, blank in ((f"{kind}_mean", torch.zeros(channels)), (f"{kind}_std", torch.ones(channels))):
                self.register_buffer(name, statistics[name] if statistics else blank)

    def normalised(self, values: Tensor, kind: str) -> Tensor:
        """Values less their mean, over their standard deviation; a window repeats both for each snapshot."""
        mean, deviation = getattr(self, f"{kind}_mean"), getattr(self, f"{kind}_std")
        repeats = values.shape[-1] // len(mean)
        return (values - mean.repeat(repeats)) / deviation.repeat(repeats)

    def normalise(self, graphs: Graphs, velocity_noise: Tensor | None = None) -> Graphs:
        """Normalised features; `velocity_noise` (graphs * balls, window, 3) is added to normalised velocities."""
        ball = self.normalised(graphs.ball, "ball")
        if velocity_noise is not None:
            ball = ball.view(len(ball), -1, BALL_CHANNELS)
            ball[..., VELOCITY] += velocity_noise
            ball = ball.view(len(ball), -1)
        edges = replace(
            graphs.edges,
            pair_vector=self.normalised(graphs.edges.pair_vector, "pair"),
            wall_vector=self.normalised(graphs.edges.wall_vector, "wall_edge"),
        )
        return Graphs(ball, self.normalised(graphs.wall, "wall"), edges, graphs.balls)

    def forward(self, graphs: Graphs) -> tuple[Tensor, Tensor]:
        """Acceleration (graphs, balls, 3) [m/s2] and dissipation of the step (graphs,) [J]."""
        acceleration, dissipation = self.network(self.normalise(graphs))
        acceleration = acceleration * self.acceleration_std + self.acceleration_mean
        dissipation = dissipation * self.dissipation_std + self.dissipation_mean
        return acceleration.view(graphs.count, graphs.balls, 3), dissipation


def as_bytes(content: dict) -> bytes:
    """The bytes that torch writes. In a file they would contain the file's name, with a process number."""
    memory = io.BytesIO()
    torch.save(content, memory)
    return memory.getvalue()


def write_weights(path: str | Path, model: NormalisedNetwork, recipe: Recipe) -> None:
    """Write finished weights, with the recipe that gives them a shape, readable by `torch.load` with weights_only."""
    state = {name: value.cpu() for name, value in model.state_dict().items()}
    with whole_file(path) as partial:
        partial.write_bytes(as_bytes({"recipe": recipe.model_dump(mode="json"), "state": state}))


def read_weights(path: str | Path, device: torch.device) -> tuple[NormalisedNetwork, Recipe]:
    """The model with its weights, ready to predict, and its recipe. Raises ConfigError for a damaged file."""
    try:
        content = torch.load(path, map_location=device, weights_only=True)
    except (OSError, ValueError, RuntimeError, EOFError, pickle.UnpicklingError) as error:
        what = str(error).split("\n", 1)[0][:100]
        raise ConfigError(f"{path}: truncated or damaged ({what}); delete it and run the same command again") from None
    recipe = Recipe(**content["recipe"])
    model = NormalisedNetwork(recipe)
    model.load_state_dict(content["state"])
    return model.to(device).eval(), recipe
