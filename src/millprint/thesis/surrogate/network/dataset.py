"""Node features, targets and contacts of every snapshot of a simulation (thesis Table 6.2), and their file."""

from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import torch
from torch import Tensor

from millprint.run.hdf5 import open_hdf5, whole_hdf5
from millprint.thesis.surrogate.scene import Scene
from millprint.thesis.surrogate.trajectory import Trajectory

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

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
