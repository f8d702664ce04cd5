"""The training set on disk: features and targets of every snapshot, and where training ends."""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from millprint.hdf5 import open_hdf5, whole_hdf5
from millprint.surrogate.thesis.features import Snapshots


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

    def to(self, device: torch.device) -> "TrainingRun":
        """The same run on another device."""
        values = {field.name: getattr(self.snapshots, field.name) for field in fields(Snapshots)}
        moved: dict[str, Any] = {
            name: value.to(device) if isinstance(value, Tensor) else value for name, value in values.items()
        }
        return TrainingRun(self.case, Snapshots(**moved), self.train_end, self.validation_end)


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
    """Read what `write_dataset` wrote."""
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
