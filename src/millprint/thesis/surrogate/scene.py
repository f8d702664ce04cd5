"""Snapshots of a simulation as the surrogate reads them, and the scene of a roll-out: walls, motion, balls."""

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np

from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.mill.distance import SignedDistance
from millprint.mill.motion import motion_from_law
from millprint.mill.vessel import build_vessel
from millprint.run.hdf5 import open_hdf5

# Arrays of Trajectory with a row a snapshot, and their data sets.
OF_SNAPSHOTS = {
    "time_s": "time_s",
    "position_m": "position_m",
    "velocity_m_s": "velocity_m_s",
    "force_N": "contact_force_N",
    "wall_position_m": "body_position_m",
}


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
            raise ConfigError(f"{path}: no snapshots: the sweep of this case needs snapshot_interval_s")
        time_s, offset = (_dataset(file, name, path)[:] for name in ("time_s", "contact_offset"))
        # Times are sums of steps: a tolerance of half a microsecond decides whether a snapshot at a bound belongs.
        rows = slice(*np.searchsorted(time_s, [from_s - 5e-7, until_s + 5e-7]))
        if rows.stop - rows.start < 2:
            raise ConfigError(f"{path}: fewer than two snapshots from {from_s:g} s to {until_s:g} s of motion")
        offset = offset[rows.start : rows.stop + 1]
        first, second = (
            _dataset(file, name, path)[int(offset[0]) : int(offset[-1])] for name in ("contact_first", "contact_second")
        )
        arrays = {name: _dataset(file, dataset, path)[rows] for name, dataset in OF_SNAPSHOTS.items()}
        dissipated_J = _dataset(file, "normal_J", path)[rows] + _dataset(file, "tangential_J", path)[rows]
    offset = offset - offset[0]
    return Trajectory(**arrays, dissipated_J=dissipated_J, contact_offset=offset, first=first, second=second)


def read_attributes(path: str | Path) -> dict:
    """The configuration that a run carries: `case`, `mill`, `contact` and `dem` as mappings.

    Raises ConfigError for balls of several sizes, which the surrogates do not know.
    """
    with open_hdf5(path) as file:
        attributes = json.loads(file.attrs["config"])
    mixture = attributes["case"].get("mixture")
    if mixture:
        raise ConfigError(f"{path}: charge {mixture['name']} has several ball sizes; the surrogate knows balls of one")
    return attributes


def read_rows(path: str | Path, names: tuple[str, ...], rows: slice) -> list[np.ndarray]:
    """Some rows of data sets of the snapshots of a run; raises ConfigError for one that is missing."""
    with open_hdf5(path) as file:
        return [_dataset(file, name, path)[rows] for name in names]


def mean_power_W(path: str | Path, until_s: float) -> float:
    """Dissipated energy of a run over time, from its first snapshot to the one at `until_s` [s] of motion [W]."""
    time_s, normal, tangential = read_rows(path, ("time_s", "normal_J", "tangential_J"), slice(None))
    end = int(np.searchsorted(time_s, until_s + 5e-7))
    return float((normal + tangential)[1:end].sum(dtype=float) / (time_s[end - 1] - time_s[0]))


def _dataset(file: h5py.File, name: str, path: str | Path) -> h5py.Dataset:
    """A data set of the snapshots; raises ConfigError where it is missing."""
    if name not in file.get("snapshots", {}):
        raise ConfigError(f"{path}: snapshots/{name} is missing")
    return file["snapshots"][name]


AXES = "xyz"
Distance = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Scene:
    """A vessel that moves without turning, and the balls in it.

    distance: points (n, 3) in the body frame to their signed distances (n,), negative inside, and gradients (n, 3);
    wall_position: times (...) to positions of the body frame (..., 3); bounds_m (2, 3): lower and upper corner of the
    vessel in its frame.
    """

    ball_radius_m: float
    ball_mass_kg: float
    speed_rpm: float
    bounds_m: np.ndarray
    distance: Distance
    wall_position: Callable[[np.ndarray], np.ndarray]
    gravity_m_s2: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, -9.81]))

    @property
    def turn_s(self) -> float:
        """Time of a turn of the mill [s]."""
        return 60.0 / self.speed_rpm

    def signed_distance(self, position: np.ndarray, wall: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Signed distance (...) and gradient (..., 3) at `position` (..., 3) with the vessel at `wall` (..., 3).

        The vessel only translates, so the gradient is the same in the laboratory frame.
        """
        relative = np.asarray(position - wall, dtype=float)
        points = relative.reshape(-1, 3)
        # A roll-out may run away: positions that are not finite have no distance.
        finite = np.isfinite(points).all(axis=1)
        distance, gradient = np.full(len(points), np.nan), np.full(points.shape, np.nan)
        distance[finite], gradient[finite] = self.distance(points[finite])
        return distance.reshape(relative.shape[:-1]), gradient.reshape(relative.shape)

    def section(self, normal: str, at_m: float, points: int = 161) -> dict:
        """Signed distance on the plane `normal` = at_m of the body frame, not a number outside (thesis Fig. 6.3).

        normal: x, y or z. Returns `title`, `axes` (two names), `first_m` (a,), `second_m` (b,), `distance_m` (b, a).
        """
        across = [axis for axis in range(3) if axis != AXES.index(normal)]
        low, high = self.bounds_m
        lines = [np.linspace(low[axis], high[axis], points) for axis in across]
        grid = np.full((points, points, 3), at_m)
        grid[..., across[0]], grid[..., across[1]] = np.meshgrid(*lines)
        distance, _ = self.signed_distance(grid, np.zeros(3))
        axes = tuple(AXES[axis] for axis in across)
        return {
            "title": f"{axes[0]}{axes[1]} plane, {normal} = {1e3 * at_m:.3g} mm",
            "axes": axes,
            "first_m": lines[0],
            "second_m": lines[1],
            "distance_m": np.where(distance < 0, distance, np.nan),
        }


def read_scene(run: str | Path) -> Scene:
    """The scene of a simulation, from the configuration that its file carries.

    Raises ConfigError for a vessel that turns or has inserts, whose features this network does not have.
    """
    attributes = read_attributes(run)
    mill, case, contact = attributes["mill"], attributes["case"], attributes["contact"]
    config = MillConfig(**mill)
    motion = motion_from_law(config.motion, case["speed_hz"])
    if motion.turns:
        raise ConfigError(f"{run}: mill {config.name} turns; the surrogate knows vessels that only translate")
    if config.inserts:
        raise ConfigError(f"{run}: mill {config.name} has inserts; the surrogate knows the walls of one vessel")
    vessel = build_vessel(config)
    radius = case["ball_diameter_m"] / 2
    return Scene(
        ball_radius_m=radius,
        ball_mass_kg=contact["density_kg_m3"] * 4 / 3 * np.pi * radius**3,
        speed_rpm=60 * case["speed_hz"],
        bounds_m=vessel.bounds,
        distance=SignedDistance(vessel),
        wall_position=motion.position,
    )
