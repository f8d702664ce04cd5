"""Features, targets and contacts of every snapshot (thesis Table 6.2), their file, and batches of graphs of them."""

from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import torch
from torch import Tensor

from millprint.mill.gravity import GRAVITY
from millprint.run.hdf5 import open_hdf5, whole_hdf5
from millprint.thesis.surrogate.rollout import Scene, Trajectory

if TYPE_CHECKING:
    from _typeshed import DataclassInstance
from millprint.config.surrogate import EdgeConfig

BALL_CHANNELS = 7
WALL_CHANNELS = 7
VELOCITY = slice(0, 3)
DISTANCE = 3
GRADIENT = slice(4, 7)


Record = TypeVar("Record", bound="DataclassInstance")


@dataclass(frozen=True)
class Snapshots:
    """The data of a simulation for the network, snapshot by snapshot.

    ball (n, balls, 7): velocity, signed distance and its gradient; wall (n, 7): position, speed, zeros;
    position (n, balls, 3); finite_difference and net_force (n, balls, 3) [m/s2], and dissipation (n,) [J], belong
    to the step from each snapshot to the next, so the last row of finite_difference and dissipation is not a
    number. Pairs of balls in contact are `pair` (2, pairs), each once; balls at the wall are `at_wall`; the rows
    of snapshot k lie between the offsets k and k + 1.
    """

    ball: Tensor
    wall: Tensor
    position: Tensor
    finite_difference: Tensor
    net_force: Tensor
    dissipation: Tensor
    pair_offset: Tensor
    pair: Tensor
    wall_offset: Tensor
    at_wall: Tensor
    radius: float
    interval: float


def on_device(record: Record, device: torch.device) -> Record:
    """A record of tensors, and of such records, on another device."""

    def moved(value: Any) -> Any:
        if isinstance(value, Tensor):
            return value.to(device)
        return on_device(value, device) if is_dataclass(value) and not isinstance(value, type) else value

    return replace(record, **{field.name: moved(getattr(record, field.name)) for field in fields(record)})


def ball_features(velocity: np.ndarray, distance: np.ndarray, gradient: np.ndarray) -> np.ndarray:
    """Features of balls in one snapshot, Eq. 6.19: (..., 3), (...), (..., 3) to (..., 7)."""
    return np.concatenate([velocity, distance[..., None], gradient], axis=-1)


def wall_features(position: np.ndarray, speed_rpm: float) -> np.ndarray:
    """Features of the wall in one snapshot, padded with zeros to the length of a ball's: (..., 3) to (..., 7)."""
    features = np.zeros((*position.shape[:-1], WALL_CHANNELS))
    features[..., :3] = position
    features[..., 3] = speed_rpm
    return features


def featurise(run: Trajectory, scene: Scene) -> Snapshots:
    """Features and targets of every snapshot.

    Accelerations are (v[n+1] - v[n]) / dt, what the integrator of Eq. 6.31 needs, and Eq. 6.1's F / m + g at the
    instant; dissipation is the normal and tangential energy of the step that follows.
    """
    distance, gradient = scene.signed_distance(run.position_m, run.wall_position_m[:, None, :])
    difference = np.full_like(run.velocity_m_s, np.nan)
    difference[:-1] = np.diff(run.velocity_m_s, axis=0) / run.interval_s
    dissipation = np.append(run.dissipated_J[1:], np.nan)
    pair_offset, pair, wall_offset, at_wall = _split_contacts(run)
    return Snapshots(
        ball=_single(ball_features(run.velocity_m_s, distance, gradient)),
        wall=_single(wall_features(run.wall_position_m, scene.speed_rpm)),
        position=_single(run.position_m),
        finite_difference=_single(difference),
        net_force=_single(run.force_N / scene.ball_mass_kg + [0.0, 0.0, -GRAVITY]),
        dissipation=_single(dissipation),
        pair_offset=pair_offset,
        pair=pair,
        wall_offset=wall_offset,
        at_wall=at_wall,
        radius=scene.ball_radius_m,
        interval=run.interval_s,
    )


def _single(values: np.ndarray) -> Tensor:
    return torch.from_numpy(np.asarray(values, dtype=np.float32))


def _split_contacts(run: Trajectory) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Ragged rows of ball pairs and of balls at the wall; a ball that touches several facets is there once."""
    snapshots = len(run.time_s)
    row = np.repeat(np.arange(snapshots), np.diff(run.contact_offset))
    between_balls = run.second >= 0
    pair = np.stack([run.first[between_balls], run.second[between_balls]]).astype(np.int64)
    code = np.unique(row[~between_balls] * run.balls + run.first[~between_balls])
    pair_offset = np.searchsorted(row[between_balls], np.arange(snapshots + 1))
    wall_offset = np.searchsorted(code // run.balls, np.arange(snapshots + 1))
    return (
        torch.from_numpy(pair_offset),
        torch.from_numpy(pair),
        torch.from_numpy(wall_offset),
        torch.from_numpy(code % run.balls),
    )


def wall_contact_distances(run: Snapshots, end: int) -> np.ndarray:
    """Signed distance of each ball at the wall, in each snapshot before `end` (contacts,) [m]."""
    rows = np.repeat(np.arange(end), np.diff(run.wall_offset[: end + 1].numpy()))
    balls = run.at_wall[: int(run.wall_offset[end])].numpy()
    return run.ball[..., DISTANCE].numpy()[rows, balls].astype(float)


@dataclass(frozen=True)
class TrainingRun:
    """Snapshots of one simulation. Targets of training reach no further than snapshot `train_end`."""

    case: str
    snapshots: Snapshots
    train_end: int
    validation_end: int

    def training_rows(self, window: int) -> Tensor:
        """Rows with a full window behind them whose step ends at `train_end` or before."""
        return torch.arange(window - 1, self.train_end)

    def validation_rows(self, window: int) -> Tensor:
        """Rows whose whole window and step lie after `train_end`."""
        return torch.arange(self.train_end + window - 1, self.validation_end)


def write_dataset(runs: list[TrainingRun], path: str | Path) -> None:
    """Write the runs as groups `0`, `1`, ... of an HDF5 file, a data set for each field of Snapshots."""
    with whole_hdf5(path) as file:
        for number, run in enumerate(runs):
            group = file.create_group(str(number))
            group.attrs.update(case=run.case, train_end=run.train_end, validation_end=run.validation_end)
            for field in fields(Snapshots):
                value = getattr(run.snapshots, field.name)
                if isinstance(value, Tensor):
                    group[field.name] = value.numpy()
                else:
                    group.attrs[field.name] = value


def read_dataset(path: str | Path) -> list[TrainingRun]:
    """Read a file of `write_dataset`."""
    runs = []
    with open_hdf5(path) as file:
        for number in range(len(file)):
            group = file[str(number)]
            values: dict[str, Any] = {
                field.name: torch.from_numpy(np.asarray(group[field.name]))
                if field.name in group
                else float(group.attrs[field.name])
                for field in fields(Snapshots)
            }
            ends = (int(group.attrs[key]) for key in ("train_end", "validation_end"))
            runs.append(TrainingRun(str(group.attrs["case"]), Snapshots(**values), *ends))
    return runs


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
