"""The signed-distance graph network: encoder, processor, decoder and global readout (thesis Eqs 6.22 to 6.27)."""

import itertools

import torch
from torch import Tensor, nn
from torch_geometric.nn import MessagePassing
from torch_geometric.utils import scatter

from millprint.config.surrogate import NetworkConfig
from millprint.surrogate.thesis.graphs import Graphs


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
