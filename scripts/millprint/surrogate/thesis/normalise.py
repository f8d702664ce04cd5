"""Means and standard deviations of features and targets, from training rows alone, and the model that carries them."""

from dataclasses import replace

import torch
from torch import Tensor, nn

from millprint.config.surrogate import EdgeConfig, GraphConfig, Recipe
from millprint.surrogate.thesis.features import BALL_CHANNELS, VELOCITY, WALL_CHANNELS, Snapshots
from millprint.surrogate.thesis.graphs import Graphs, edges_at
from millprint.surrogate.thesis.network import SignedDistanceNetwork

KINDS = {"ball": BALL_CHANNELS, "wall": WALL_CHANNELS, "pair": 3, "wall_edge": 3, "acceleration": 3, "dissipation": 1}


def target(run: Snapshots, graph: GraphConfig) -> Tensor:
    """The acceleration that the network is asked for, (n, balls, 3) [m/s2]."""
    return getattr(run, graph.acceleration)


def measure(parts: list[tuple[Snapshots, Tensor]], graph: GraphConfig, rule: EdgeConfig | None) -> dict[str, Tensor]:
    """Mean and standard deviation of each kind of quantity over the given rows of each run, and no others.

    Returns `KIND_mean` and `KIND_std` for the keys of KINDS. A channel that does not vary (the wall's speed, its
    padding) keeps a deviation of 1, so that it becomes zero and not a division by zero.
    """
    samples: dict[str, list[Tensor]] = {kind: [] for kind in KINDS}
    for run, rows in parts:
        edges = edges_at(run, rows, rule)
        samples["ball"].append(run.ball[rows])
        samples["wall"].append(run.wall[rows])
        samples["pair"].append(edges.pair_vector)
        samples["wall_edge"].append(edges.wall_vector)
        samples["acceleration"].append(target(run, graph)[rows])
        samples["dissipation"].append(run.dissipation[rows])
    statistics = {}
    for kind, values in samples.items():
        table = torch.cat([part.reshape(-1, KINDS[kind]) for part in values]).double()
        mean = table.mean(0) if len(table) else torch.zeros(KINDS[kind])
        deviation = table.std(0, correction=0) if len(table) else torch.ones(KINDS[kind])
        still = deviation <= 1e-6 * mean.abs() + torch.finfo(torch.float32).tiny
        statistics[f"{kind}_mean"] = mean.float()
        statistics[f"{kind}_std"] = torch.where(still, 1.0, deviation).float()
    return statistics


class Surrogate(nn.Module):
    """The network with its normalisation: features and targets in physical units outside, normalised inside."""

    def __init__(self, recipe: Recipe, statistics: dict[str, Tensor] | None = None):
        super().__init__()
        self.window = recipe.graph.window
        self.network = SignedDistanceNetwork(recipe.graph.window, recipe.network)
        for kind, channels in KINDS.items():
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
