"""Roll-outs that are known to be right or wrong, and those in which nothing is learned, made from simulations."""

from dataclasses import replace

import numpy as np

from millprint.thesis.surrogate.rollout import RollOut, simulated
from millprint.thesis.surrogate.scene import Scene
from millprint.thesis.surrogate.trajectory import Trajectory

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


def riding(rollout: RollOut, scene: Scene, power_W: float) -> RollOut:
    """Nothing learned: every ball keeps its place in the jar, and a constant power is dissipated.

    power_W: the mean of the training.
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
