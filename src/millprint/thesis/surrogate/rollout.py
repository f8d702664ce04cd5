"""A roll-out: frames of a batch of trajectories, by a surrogate or by a simulation in its place, and its file."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from millprint.config.errors import ConfigError
from millprint.run.hdf5 import open_hdf5, whole_hdf5
from millprint.thesis.surrogate.scene import Scene
from millprint.thesis.surrogate.trajectory import Trajectory

# Units of the arrays that a file holds, each in the data set of its name.
UNITS = {
    "time_s": "s", "position_m": "m", "velocity_m_s": "m/s", "dissipated_J": "J", "crossed_s": "s", "start_s": "s",
}  # fmt: skip
EDGES = ("wall", "pair")
# Surfaces nearer than this share of a ball's radius touch: overlaps are smaller, and gaps are rarely that small.
TOUCH = 0.01


@dataclass(frozen=True)
class RollOut:
    """Frames of a batch of trajectories.

    Of every roll-out: time_s (frames,) since the start; position_m and velocity_m_s (frames, batch, balls, 3);
    dissipated_J (frames, batch) since the frame before; crossed_s (batch, balls): when a centre first crossed the wall
    or stopped being a finite number, infinity if never; start_s (batch,) since the mill was started. mean_edges: mean
    number of `wall` and of `pair` edges of a graph, of graph networks.

    None where it is not known: recorded_J (frames, batch): cumulative dissipation as a simulation recorded it.
    wall_distance_m (frames, batch, balls): of every centre, positive inside; see `in_scene`.
    """

    time_s: np.ndarray
    position_m: np.ndarray
    velocity_m_s: np.ndarray
    dissipated_J: np.ndarray
    crossed_s: np.ndarray
    start_s: np.ndarray
    mean_edges: dict[str, float] = field(default_factory=dict)
    recorded_J: np.ndarray | None = None
    wall_distance_m: np.ndarray | None = None

    def known(self, name: str) -> np.ndarray:
        """An optional array by its name; raises ValueError where this roll-out does not have it."""
        values = getattr(self, name)
        if values is None:
            raise ValueError(f"this roll-out has no {name}")
        return values

    @property
    def cumulative_J(self) -> np.ndarray:
        """Dissipation since the start, (frames, batch) [J]."""
        return np.cumsum(self.dissipated_J, axis=0) if self.recorded_J is None else self.recorded_J

    @property
    def length_s(self) -> float:
        """Time from the first frame to the last [s]."""
        return float(self.time_s[-1])

    def in_scene(self, scene: Scene, wall_m: np.ndarray | None = None) -> "RollOut":
        """The same with wall distances; wall_m (frames, batch, 3): as recorded, or else as the scene's wall moves."""
        wall_m = scene.wall_position(self.start_s + self.time_s[:, None]) if wall_m is None else wall_m
        with np.errstate(invalid="ignore", over="ignore"):
            distance, _ = scene.signed_distance(self.position_m, wall_m[:, :, None, :])
        return replace(self, wall_distance_m=-distance)

    def first_trajectory(self) -> "RollOut":
        """The same arrays for only the first trajectory: a batch of one."""
        names = ("position_m", "velocity_m_s", "dissipated_J", "recorded_J", "wall_distance_m")
        first = {name: values[:, :1] for name in names if (values := getattr(self, name)) is not None}
        return RollOut(time_s=self.time_s, crossed_s=self.crossed_s[:1], start_s=self.start_s[:1], **first)

    def speed(self) -> np.ndarray:
        """Speed of every ball, (frames, batch, balls) [m/s]."""
        return np.linalg.norm(self.velocity_m_s, axis=-1)

    def contacts(self, radius_m: float) -> np.ndarray:
        """How many balls and walls each ball touches, from positions only, (frames, batch, balls) [-]."""
        first, second = np.triu_indices(self.position_m.shape[2], 1)
        reach = (2 + TOUCH) * radius_m
        count = (self.known("wall_distance_m") <= (1 + TOUCH) * radius_m).astype(int)
        for i in np.unique(first):
            others = second[first == i]
            gap = self.position_m[:, :, others] - self.position_m[:, :, i, None]
            touching = (gap * gap).sum(axis=-1) <= reach**2
            count[:, :, i] += touching.sum(axis=-1)
            count[:, :, others] += touching
        return count

    def write(self, path: str | Path, case: str) -> None:
        """Write the arrays of UNITS; case: the simulation that gave the first states."""
        with whole_hdf5(path) as file:
            file.attrs["case"] = case
            for kind, number in self.mean_edges.items():
                file.attrs[f"mean_{kind}_edges"] = number
            for name, unit in UNITS.items():
                dataset = file.create_dataset(name, data=getattr(self, name))
                dataset.attrs["units"] = unit

    @classmethod
    def read(cls, path: str | Path) -> "RollOut":
        """Read a file, in double precision. Raises ConfigError where a data set that every roll-out has is missing."""
        with open_hdf5(path) as file:
            for name in UNITS:
                if name not in file:
                    raise ConfigError(f"{path}: {name} is missing: not a roll-out, or one of another version")
            arrays = {name: file[name][:].astype(float) for name in UNITS}
            edges = {kind: float(file.attrs[key]) for kind in EDGES if (key := f"mean_{kind}_edges") in file.attrs}
            return cls(**arrays, mean_edges=edges)


def simulated(run: Trajectory, scene: Scene, time_s: np.ndarray, start_s: np.ndarray) -> RollOut:
    """A simulation as a roll-out: at `time_s` (frames,) after each of `start_s` (batch,), with walls and energies as
    recorded.

    Raises ConfigError where its snapshots are not at those times.
    """
    moments_s = start_s + time_s[:, None]
    first = np.array([run.index(float(moment)) for moment in start_s])
    run.index(float(moments_s.max()))
    rows = first + np.rint(time_s / run.interval_s).astype(int)[:, None]
    # A later frame would not show the same contacts.
    late = float(np.abs(run.time_s[rows] - moments_s).max())
    if late > 1e-5:
        raise ConfigError(
            f"a simulation has snapshots every {run.interval_s:g} s, {late:.2g} s off the frames of the roll-out: its "
            "snapshot_interval_s must divide surrogate.rollout.frame_interval_s, and starts_s be among its times"
        )
    total = np.cumsum(run.dissipated_J, dtype=float)
    return RollOut(
        time_s=time_s,
        position_m=run.position_m[rows].astype(float),
        velocity_m_s=run.velocity_m_s[rows].astype(float),
        dissipated_J=np.diff(total[rows], axis=0, prepend=total[rows][:1]),
        crossed_s=np.full((len(start_s), run.balls), np.inf),
        start_s=start_s,
        recorded_J=total[rows] - total[first],
    ).in_scene(scene, run.wall_position_m[rows].astype(float))
