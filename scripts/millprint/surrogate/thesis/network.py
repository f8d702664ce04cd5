"""The signed-distance graph network (thesis Eqs 6.22 to 6.27), and the normalisation of features and targets."""

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch
from sklearn.preprocessing import StandardScaler
from torch import Tensor, nn
from torch_geometric.nn import MessagePassing
from torch_geometric.utils import scatter

from millprint.config.surrogate import EdgeConfig, GraphConfig, NetworkConfig, Recipe
from millprint.surrogate.checkpoint import read_tensors
from millprint.surrogate.thesis.dataset import BALL_CHANNELS, VELOCITY, WALL_CHANNELS, Snapshots
from millprint.surrogate.thesis.graphs import Graphs, edges_at

# What is normalised, and its number of channels.
CHANNELS = {
    "ball": BALL_CHANNELS,
    "wall": WALL_CHANNELS,
    "pair": 3,
    "wall_edge": 3,
    "acceleration": 3,
    "dissipation": 1,
}


def mlp(inputs: int, width: int, outputs: int, layers: int) -> nn.Sequential:
    """A multi-layer perceptron of `layers` linear layers with ReLU between them.

    Weights start as He et al. (2015) have them for ReLU. The default of torch shrinks the signal by 0.4 a layer, and
    after the twelve layers between input and output nothing of it is left to learn from.
    """
    sizes = [inputs, *[width] * (layers - 1), outputs]
    modules: list[nn.Module] = []
    for size, following in itertools.pairwise(sizes):
        linear = nn.Linear(size, following)
        nn.init.kaiming_normal_(linear.weight, nonlinearity="relu")
        nn.init.zeros_(linear.bias)
        modules += [linear, nn.ReLU()]
    return nn.Sequential(*modules[:-1])


class InteractionLayer(MessagePassing):
    """One round of message passing with mean aggregation (Eqs 6.24 to 6.26)."""

    def __init__(self, width: int, layers: int):
        super().__init__(aggr="mean")
        self.message_mlp = mlp(3 * width, width, width, layers)
        self.node_mlp = mlp(2 * width, width, width, layers)

    def forward(self, node: Tensor, edge_index: Tensor, edge: Tensor) -> Tensor:
        """node (n, width), edge_index (2, e) source and target, edge (e, width); returns (n, width)."""
        received = self.propagate(edge_index, node=node, edge=edge, size=(len(node), len(node)))
        return self.node_mlp(torch.cat([node, received], dim=1))

    def message(self, node_i: Tensor, node_j: Tensor, edge: Tensor) -> Tensor:
        """Message into node i from node j, Eq. 6.24."""
        return self.message_mlp(torch.cat([node_i, node_j, edge], dim=1))


class SignedDistanceNetwork(nn.Module):
    """Normalised graphs to the normalised acceleration of each ball and dissipation of each graph.

    One MLP encodes balls and walls, one both kinds of edges, as in Eqs 6.22 and 6.23. A wall edge carries messages
    both ways; the wall's own output is not used, so nothing is sent to it in the last round.
    """

    def __init__(self, window: int, size: NetworkConfig):
        super().__init__()
        width, layers = size.width, size.mlp_layers
        self.node_encoder = mlp(7 * window, width, width, layers)
        self.edge_encoder = mlp(3, width, width, layers)
        self.processor = nn.ModuleList(InteractionLayer(width, layers) for _ in range(size.interaction_layers))
        self.decoder = mlp(width, width, 3, layers)
        self.readout = mlp(width, width, 1, layers)

    def forward(self, graphs: Graphs) -> tuple[Tensor, Tensor]:
        """Normalised acceleration (graphs * balls, 3) and dissipation (graphs,)."""
        edges, balls = graphs.edges, len(graphs.ball)
        graph_of_ball = graphs.graph_of_ball
        node = self.node_encoder(torch.cat([graphs.ball, graphs.wall]))
        pair, at_wall = self.edge_encoder(torch.cat([edges.pair_vector, edges.wall_vector])).split(
            [len(edges.pair_vector), len(edges.wall_vector)]
        )
        wall = graph_of_ball[edges.wall] + balls
        into_balls = torch.cat([edges.pair, torch.stack([wall, edges.wall])], dim=1)
        into_walls = torch.stack([edges.wall, wall])
        for layer in self.processor[:-1]:
            node = layer(node, torch.cat([into_balls, into_walls], dim=1), torch.cat([pair, at_wall, at_wall]))
        node = self.processor[-1](node, into_balls, torch.cat([pair, at_wall]))[:balls]
        return self.decoder(node), self._dissipation(node, into_balls[1], graph_of_ball, graphs.count)

    def _dissipation(self, node: Tensor, touched: Tensor, graph_of_ball: Tensor, graphs: int) -> Tensor:
        """Mean of the balls with an edge, through the readout; a graph without any pools to zero."""
        has_edge = torch.zeros(len(node), dtype=torch.bool, device=node.device)
        has_edge[touched] = True
        pooled = scatter(node[has_edge], graph_of_ball[has_edge], dim=0, dim_size=graphs, reduce="mean")
        return self.readout(pooled).squeeze(1)


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


def weights_content(model: NormalisedNetwork, recipe: Recipe) -> dict:
    """Content of a weights file: the weights, with the recipe that gives them a shape."""
    state = {name: value.cpu() for name, value in model.state_dict().items()}
    return {"recipe": recipe.model_dump(mode="json"), "state": state}


def read_weights(path: str | Path, device: torch.device) -> tuple[NormalisedNetwork, Recipe]:
    """The model with its weights, ready to predict, and its recipe. Raises ConfigError for a damaged file."""
    content = read_tensors(path, device)
    recipe = Recipe(**content["recipe"])
    model = NormalisedNetwork(recipe)
    model.load_state_dict(content["state"])
    return model.to(device).eval(), recipe
