"""Snapshots of a simulation as the surrogate reads them."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from millprint.errors import ConfigError
from millprint.hdf5 import open_hdf5

DATASETS = (
    "time_s",
    "position_m",
    "velocity_m_s",
    "contact_force_N",
    "normal_J",
    "tangential_J",
    "body_position_m",
    "contact_offset",
    "contact_first",
    "contact_second",
)


@dataclass(frozen=True)
class Trajectory:
    """Snapshots at a constant interval, from the start of motion.

    time_s (n,), position_m (n, balls, 3), velocity_m_s (n, balls, 3), force_N (n, balls, 3) net contact force,
    dissipated_J (n,) normal plus tangential since the snapshot before, wall_position_m (n, 3), and the contacts
    as ragged rows: those of snapshot k are `contact_offset[k]:contact_offset[k + 1]` of `first` (a ball) and
    `second` (a ball, or negative for a facet of the wall).
    """

    time_s: np.ndarray
    position_m: np.ndarray
    velocity_m_s: np.ndarray
    force_N: np.ndarray
    dissipated_J: np.ndarray
    wall_position_m: np.ndarray
    contact_offset: np.ndarray
    first: np.ndarray
    second: np.ndarray

    @property
    def interval_s(self) -> float:
        """Time between snapshots [s]."""
        return float(self.time_s[-1] - self.time_s[0]) / (len(self.time_s) - 1)

    @property
    def balls(self) -> int:
        """How many balls there are."""
        return self.position_m.shape[1]

    def index(self, time_s: float) -> int:
        """Row of the snapshot at `time_s`, to the nearest; raises ConfigError outside the recorded time."""
        row = round((time_s - float(self.time_s[0])) / self.interval_s)
        if not 0 <= row < len(self.time_s):
            raise ConfigError(
                f"no snapshot at {time_s:g} s: recorded are {self.time_s[0]:g} to {self.time_s[-1]:g} s of motion"
            )
        return row


def read_trajectory(path: str | Path, from_s: float = 0.0, until_s: float = np.inf) -> Trajectory:
    """Read the snapshots with from_s <= time <= until_s from a run.

    Raises ConfigError for a run without snapshots, with a data set missing, or with fewer than two in that time.
    """
    with open_hdf5(path) as file:
        if "snapshots" not in file:
            raise ConfigError(f"{path}: no snapshots: the sweep of this case wants snapshot_interval_s")
        group = file["snapshots"]
        for name in DATASETS:
            if name not in group:
                raise ConfigError(f"{path}: snapshots/{name} is missing")
        time_s = group["time_s"][:]
        # Times are sums of steps: half a microsecond decides which snapshot belongs to a bound.
        rows = slice(*np.searchsorted(time_s, [from_s - 5e-7, until_s + 5e-7]))
        if rows.stop - rows.start < 2:
            raise ConfigError(f"{path}: fewer than two snapshots from {from_s:g} s to {until_s:g} s of motion")
        offset = group["contact_offset"][rows.start : rows.stop + 1]
        contacts = slice(int(offset[0]), int(offset[-1]))
        return Trajectory(
            time_s=time_s[rows],
            position_m=group["position_m"][rows],
            velocity_m_s=group["velocity_m_s"][rows],
            force_N=group["contact_force_N"][rows],
            dissipated_J=group["normal_J"][rows] + group["tangential_J"][rows],
            wall_position_m=group["body_position_m"][rows],
            contact_offset=offset - offset[0],
            first=group["contact_first"][contacts],
            second=group["contact_second"][contacts],
        )


def read_attributes(path: str | Path) -> dict:
    """The configuration that a run carries: `case`, `mill`, `contact` and `dem` as mappings."""
    with open_hdf5(path) as file:
        return json.loads(file.attrs["config"])


def read_rows(path: str | Path, names: tuple[str, ...], rows: slice) -> list[np.ndarray]:
    """Some rows of data sets of the snapshots of a run; raises ConfigError for one that is missing."""
    with open_hdf5(path) as file:
        for name in names:
            if name not in file.get("snapshots", {}):
                raise ConfigError(f"{path}: snapshots/{name} is missing")
        return [file["snapshots"][name][rows] for name in names]
