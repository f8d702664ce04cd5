"""Graphs of balls and the wall: batches of nodes, edges and targets (thesis Sec. 6.2.2)."""

from dataclasses import dataclass

import torch
from torch import Tensor

from millprint.config.surrogate import EdgeConfig
from millprint.thesis.surrogate.network.dataset import DISTANCE, GRADIENT, Snapshots

# By the reading of r_c: how many radii lie between two centres where r_c is zero.
RADII_BETWEEN_CENTRES = {"surface_gap": 2, "centre_distance": 0}


@dataclass(frozen=True)
class Edges:
    """Edges of a batch, with balls numbered through the batch.

    pair (2, p): source and target of each ball-ball edge, both directions; pair_vector (p, 3) = X_source - X_target
    (Eq. 6.20, r_ij of the message into i); wall (w,): balls with a wall edge; wall_vector (w, 3) = phi times the
    unit normal (Eq. 6.21).
    """

    pair: Tensor
    pair_vector: Tensor
    wall: Tensor
    wall_vector: Tensor


@dataclass(frozen=True)
class Graphs:
    """A batch of graphs, of the same number of balls each.

    ball (graphs * balls, window * 7), wall (graphs, window * 7), both ordered from the oldest snapshot to the newest.
    """

    ball: Tensor
    wall: Tensor
    edges: Edges
    balls: int

    @property
    def count(self) -> int:
        """How many graphs there are."""
        return len(self.wall)

    @property
    def graph_of_ball(self) -> Tensor:
        """The graph (graphs * balls,) that each ball belongs to."""
        return torch.arange(self.count, device=self.ball.device).repeat_interleave(self.balls)


def wall_vector(distance: Tensor, gradient: Tensor) -> Tensor:
    """Signed distance times the unit normal, Eq. 6.21: (n,), (n, 3) to (n, 3)."""
    length = torch.linalg.vector_norm(gradient, dim=-1, keepdim=True)
    return distance[:, None] * gradient / length.clamp_min(torch.finfo(gradient.dtype).tiny)


def join(first: Tensor, second: Tensor, at_wall: Tensor, position: Tensor, ball: Tensor) -> Edges:
    """Edges in both directions for pairs of balls, and one for each ball at the wall.

    first, second (p,) and at_wall (w,) number the balls of the batch; position (n, 3), ball (n, 7) newest features.
    """
    pair = torch.stack([torch.cat([second, first]), torch.cat([first, second])])
    return Edges(
        pair=pair,
        pair_vector=position[pair[0]] - position[pair[1]],
        wall=at_wall,
        wall_vector=wall_vector(ball[at_wall, DISTANCE], ball[at_wall, GRADIENT]),
    )


def ball_reach(rule: EdgeConfig, radius: float) -> float:
    """Distance of two centres up to which they get an edge [m].

    `rule.ball_threshold_reading` says whether r_c bounds the gap between two surfaces or, as printed, the distance of
    two centres, which 10 mm balls never meet at 1.5 mm.
    """
    return rule.ball_threshold_m + RADII_BETWEEN_CENTRES[rule.ball_threshold_reading] * radius


def threshold_edges(position: Tensor, ball: Tensor, rule: EdgeConfig, radius: float) -> Edges:
    """Edges of a roll-out: phi >= phi_pw to the wall, and distance <= r_c between balls (step 6 of the recursion).

    position (graphs, balls, 3), ball (graphs, balls, 7).
    """
    graphs, balls, _ = position.shape
    reach = ball_reach(rule, radius)
    # All pairs: at the ball counts of a jar this is cheaper than a cell list.
    first, second = torch.triu_indices(balls, balls, offset=1, device=position.device)
    gap = position[:, second] - position[:, first]
    graph, pair = torch.nonzero((gap * gap).sum(-1) <= reach**2, as_tuple=True)
    at_wall = torch.nonzero(ball[..., DISTANCE].reshape(-1) >= rule.wall_threshold_m).squeeze(1)
    shift = graph * balls
    flat_position, flat_ball = position.reshape(-1, 3), ball.reshape(graphs * balls, -1)
    return join(first[pair] + shift, second[pair] + shift, at_wall, flat_position, flat_ball)


def contact_edges(run: Snapshots, rows: Tensor) -> Edges:
    """Edges from the contacts that the DEM reports at the snapshots `rows` (graphs,)."""
    balls = run.ball.shape[1]
    graph, contact = _ragged(run.pair_offset, rows)
    first, second = run.pair[:, contact] + graph * balls
    graph, contact = _ragged(run.wall_offset, rows)
    at_wall = run.at_wall[contact] + graph * balls
    return join(first, second, at_wall, run.position[rows].reshape(-1, 3), run.ball[rows].reshape(-1, 7))


def _ragged(offset: Tensor, rows: Tensor) -> tuple[Tensor, Tensor]:
    """For each entry of the ragged rows: which of `rows` it belongs to, and its place."""
    start, length = offset[rows], offset[rows + 1] - offset[rows]
    graph = torch.arange(len(rows), device=rows.device).repeat_interleave(length)
    first = torch.cumsum(length, 0) - length
    place = torch.arange(len(graph), device=rows.device) - first[graph] + start[graph]
    return graph, place


def edges_at(run: Snapshots, rows: Tensor, rule: EdgeConfig | None) -> Edges:
    """Edges at the snapshots `rows`: DEM contacts, or by the thresholds of `rule` if it is given."""
    if rule is None:
        return contact_edges(run, rows)
    return threshold_edges(run.position[rows], run.ball[rows], rule, run.radius)


def graphs_at(run: Snapshots, rows: Tensor, window: int, rule: EdgeConfig | None) -> Graphs:
    """Graphs whose newest snapshots are `rows` (graphs,), each at least `window - 1`.

    Edges as in `edges_at`.
    """
    history = rows[:, None] + torch.arange(1 - window, 1, device=rows.device)
    balls = run.ball.shape[1]
    ball = run.ball[history].transpose(1, 2).reshape(len(rows) * balls, -1)
    wall = run.wall[history].reshape(len(rows), -1)
    return Graphs(ball, wall, edges_at(run, rows, rule), balls)
