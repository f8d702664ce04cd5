"""Roll-outs and simulations as series of one form, frame by frame, so that each is measured in the same way."""

from dataclasses import dataclass

import numpy as np

from millprint.errors import ConfigError
from millprint.surrogate.rolled import Rolled
from millprint.surrogate.scene import Scene
from millprint.surrogate.trajectory import Trajectory

# Surfaces nearer than this share of a ball's radius touch: overlaps are smaller, and gaps are as small on no account.
TOUCH = 0.01


@dataclass(frozen=True)
class Series:
    """A batch of trajectories at the frames of a roll-out.

    position_m and velocity_m_s (frames, batch, balls, 3), wall_m (frames, batch, 3), cumulative_J (frames, batch),
    wall_distance_m (frames, batch, balls) of every centre, positive inside.
    """

    time_s: np.ndarray
    position_m: np.ndarray
    velocity_m_s: np.ndarray
    wall_m: np.ndarray
    cumulative_J: np.ndarray
    wall_distance_m: np.ndarray

    def first_trajectory(self) -> "Series":
        """The same with a batch of one, its first."""
        arrays = {name: value[:, :1] for name, value in vars(self).items() if name != "time_s"}
        return Series(time_s=self.time_s, **arrays)

    def speed(self) -> np.ndarray:
        """(frames, batch, balls) [m/s]."""
        return np.linalg.norm(self.velocity_m_s, axis=-1)

    def contacts(self, radius_m: float) -> np.ndarray:
        """Balls and walls that each ball touches, from the places alone, (frames, batch, balls) [-]."""
        first, second = np.triu_indices(self.position_m.shape[2], 1)
        reach = (2 + TOUCH) * radius_m
        count = (self.wall_distance_m <= (1 + TOUCH) * radius_m).astype(int)
        for i in np.unique(first):
            others = second[first == i]
            gap = self.position_m[:, :, others] - self.position_m[:, :, i, None]
            touching = (gap * gap).sum(axis=-1) <= reach**2
            count[:, :, i] += touching.sum(axis=-1)
            count[:, :, others] += touching
        return count


def _series(scene: Scene, **arrays: np.ndarray) -> Series:
    with np.errstate(invalid="ignore", over="ignore"):
        distance, _ = scene.signed_distance(arrays["position_m"], arrays["wall_m"][:, :, None, :])
    return Series(**arrays, wall_distance_m=-distance)


def simulated_series(run: Trajectory, scene: Scene, time_s: np.ndarray, start_s: np.ndarray) -> Series:
    """The simulation at `time_s` (frames,) after each of `start_s` (batch,).

    Raises ConfigError where its snapshots are not at those times.
    """
    wanted = start_s + time_s[:, None]
    start = np.array([run.index(float(moment)) for moment in start_s])
    run.index(float(wanted.max()))
    rows = start + np.rint(time_s / run.interval_s).astype(int)[:, None]
    # Half of a contact's shortest life is far too late to be the same moment.
    late = float(np.abs(run.time_s[rows] - wanted).max())
    if late > 1e-5:
        raise ConfigError(
            f"a simulation has snapshots every {run.interval_s:g} s, {late:.2g} s off the frames of the roll-out: its "
            "snapshot_interval_s must divide surrogate.rollout.frame_interval_s, and starts_s be among its times"
        )
    total = np.cumsum(run.dissipated_J)
    return _series(
        scene,
        time_s=time_s,
        position_m=run.position_m[rows].astype(float),
        velocity_m_s=run.velocity_m_s[rows].astype(float),
        wall_m=run.wall_position_m[rows].astype(float),
        cumulative_J=total[rows] - total[start],
    )


def rolled_series(rollout: Rolled, scene: Scene) -> Series:
    """A roll-out in a scene whose wall moves by itself."""
    return _series(
        scene,
        time_s=rollout.time_s,
        position_m=rollout.position_m,
        velocity_m_s=rollout.velocity_m_s,
        wall_m=scene.wall_position(rollout.start_s + rollout.time_s[:, None]),
        cumulative_J=np.cumsum(rollout.dissipated_J, axis=0),
    )
