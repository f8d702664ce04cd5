"""A roll-out: frames of a batch of trajectories, by a surrogate or by a simulation in its place, and its file."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from millprint.config.errors import ConfigError
from millprint.config.surrogate import EdgeConfig
from millprint.run.hdf5 import open_hdf5, whole_hdf5
from millprint.thesis.surrogate.scene import Scene, Trajectory

if TYPE_CHECKING:
    # A second to import, and jobs that only name a surrogate need no torch.
    import torch


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


SLOWED_RATE = 0.9


def simulated_rollout(run: Trajectory, scene: Scene, start_s: float, length_s: float, interval_s: float) -> RollOut:
    """A simulation in the place of a surrogate: frames every `interval_s` [s], without what a surrogate cannot record.

    Raises ConfigError outside the recorded time.
    """
    every = max(1, round(interval_s / run.interval_s))
    time_s = run.time_s[run.index(start_s) : run.index(start_s + length_s) + 1 : every]
    recorded = simulated(run, scene, time_s - time_s[0], np.array([start_s]))
    return replace(recorded, recorded_J=None, wall_distance_m=None)


def blurred(rollout: RollOut) -> RollOut:
    """Every ball at the centre of mass, with the right dissipation: a low mean square error, and no motion at all."""
    centre, drift = (
        np.broadcast_to(array.mean(axis=2, keepdims=True), array.shape)
        for array in (rollout.position_m, rollout.velocity_m_s)
    )
    return replace(rollout, position_m=centre, velocity_m_s=drift)


def rms_wall_speed(scene: Scene) -> float:
    """Root mean square speed of the wall over a turn of the mill [m/s]."""
    time_s = np.linspace(0.0, scene.turn_s, 2001)
    velocity = np.gradient(scene.wall_position(time_s), time_s, axis=0)
    return float(np.sqrt((velocity[:-1] ** 2).sum(axis=-1).mean()))


def scaled_motion(rollout: RollOut, scene: Scene, known: RollOut, known_scene: Scene) -> RollOut:
    """The nearest known motion, again and again, in step with the mill and at the speed of this wall.

    Every ball has its place in the known jar, its velocity in the jar times the ratio v of both rms wall speeds, and
    what is dissipated is v^2 times the known, as a power goes with the square of a speed at the same turns a second.
    known: frames as far apart as those of the roll-out, and one trajectory.
    """
    step = rollout.time_s[1] - rollout.time_s[0]
    turn = round(scene.turn_s / step)
    # Of whole turns, if there is one, so that the motion begins again in step.
    frames = max((len(known.time_s) - 1) // turn * turn, min(turn, len(known.time_s) - 1))
    first = round((float(rollout.start_s[0] - known.start_s[0]) % scene.turn_s) / step)
    rows = 1 + (first - 1 + np.arange(len(rollout.time_s))) % frames
    walls = [
        of.wall_position(part.start_s + part.time_s[:, None])[:, :, None, :]
        for of, part in ((known_scene, known), (scene, rollout))
    ]
    there, here = ((wall, np.gradient(wall, step, axis=0)) for wall in walls)
    ratio = rms_wall_speed(scene) / rms_wall_speed(known_scene)
    dissipated = ratio**2 * known.dissipated_J[rows]
    dissipated[0] = 0
    shape = rollout.position_m.shape
    return replace(
        rollout,
        position_m=np.broadcast_to((known.position_m - there[0])[rows] + here[0], shape),
        velocity_m_s=np.broadcast_to(ratio * (known.velocity_m_s - there[1])[rows] + here[1], shape),
        dissipated_J=np.broadcast_to(dissipated, rollout.dissipated_J.shape),
    )


def riding(rollout: RollOut, scene: Scene, power_W: float) -> RollOut:
    """Nothing learned: every ball keeps its place in the jar, and a constant power is dissipated.

    power_W: the mean of the training, or that times the ratio of the squares of both rms wall speeds.
    """
    wall = scene.wall_position(rollout.start_s + rollout.time_s[:, None])[:, :, None, :]
    step = rollout.time_s[1] - rollout.time_s[0]
    dissipated = np.full_like(rollout.dissipated_J, power_W * step)
    dissipated[0] = 0
    return replace(
        rollout,
        position_m=rollout.position_m[:1] + wall - wall[:1],
        velocity_m_s=np.broadcast_to(np.gradient(wall, step, axis=0), rollout.velocity_m_s.shape),
        dissipated_J=dissipated,
    )


def slowed(rollout: RollOut, scene: Scene, rate: float = SLOWED_RATE) -> RollOut:
    """The motion of the balls relative to the jar at another rate, in a jar that moves at the right rate."""
    moment = rollout.time_s * rate
    frame = np.searchsorted(rollout.time_s, moment, side="right") - 1
    following = np.minimum(frame + 1, len(moment) - 1)
    step = rollout.time_s[1] - rollout.time_s[0]
    share = ((moment - rollout.time_s[frame]) / step)[:, None, None, None]
    wall = scene.wall_position(rollout.start_s + rollout.time_s[:, None])[:, :, None, :]
    drift = np.gradient(wall, step, axis=0)
    place, motion = rollout.position_m - wall, rollout.velocity_m_s - drift
    late = (1 - share[..., 0, 0]) * rollout.cumulative_J[frame] + share[..., 0, 0] * rollout.cumulative_J[following]
    return replace(
        rollout,
        position_m=wall + (1 - share) * place[frame] + share * place[following],
        velocity_m_s=drift + rate * ((1 - share) * motion[frame] + share * motion[following]),
        dissipated_J=np.diff(late, axis=0, prepend=0),
    )


@dataclass(frozen=True)
class Setting:
    """What a surrogate is opened with: its weights, the simulation that gives scene and first states, and its rules.

    edges: which nodes of a graph are joined. snap_back_m: signed distance above which a ball is put back to it [m];
    None for never. until_s: first states are taken up to this time of motion [s].
    """

    weights: str | Path
    run: str | Path
    edges: EdgeConfig
    snap_back_m: float | None
    device: "torch.device"
    until_s: float
