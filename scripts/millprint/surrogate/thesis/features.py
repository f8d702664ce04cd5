"""Node features, targets and contacts of every snapshot of a simulation (thesis Table 6.2)."""

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from millprint.surrogate.scene import Scene
from millprint.surrogate.trajectory import Trajectory

BALL_CHANNELS = 7
WALL_CHANNELS = 7
VELOCITY = slice(0, 3)
DISTANCE = 3
GRADIENT = slice(4, 7)


@dataclass(frozen=True)
class Snapshots:
    """What the network may see of a simulation, snapshot by snapshot.

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
        net_force=_single(run.force_N / scene.ball_mass_kg + scene.gravity_m_s2),
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
