"""Roll-outs that are known to be right or wrong, made from simulations: what the measures must tell apart."""

import numpy as np

from millprint.surrogate.rolled import Rolled
from millprint.surrogate.scene import Scene
from millprint.surrogate.trajectory import Trajectory

SLOWED = 0.9


def simulated_rollout(run: Trajectory, start_s: float, length_s: float, interval_s: float) -> Rolled:
    """A simulation in the place of a surrogate, with a frame every `interval_s`."""
    every = max(1, round(interval_s / run.interval_s))
    rows = np.arange(run.index(start_s), run.index(start_s + length_s) + 1, every)
    cumulative = np.cumsum(run.dissipated_J, dtype=float)[rows, None]
    return Rolled(
        time_s=run.time_s[rows] - run.time_s[rows[0]],
        position_m=run.position_m[rows, None].astype(float),
        velocity_m_s=run.velocity_m_s[rows, None].astype(float),
        dissipated_J=np.diff(cumulative, axis=0, prepend=cumulative[:1]),
        crossed_s=np.full((1, run.balls), np.inf),
        start_s=np.array([start_s]),
    )


def blurred(rollout: Rolled) -> Rolled:
    """Every ball at the centre of mass, with the dissipation left right: the best that a mean square error asks for."""
    centre, drift = (
        np.broadcast_to(array.mean(axis=2, keepdims=True), array.shape)
        for array in (rollout.position_m, rollout.velocity_m_s)
    )
    return Rolled(**(vars(rollout) | {"position_m": centre, "velocity_m_s": drift}))


def slowed(rollout: Rolled, scene: Scene, rate: float = SLOWED) -> Rolled:
    """What the balls do relative to the jar, at another rate, in a jar that moves as it should."""
    moment = rollout.time_s * rate
    frame = np.searchsorted(rollout.time_s, moment, side="right") - 1
    following = np.minimum(frame + 1, len(moment) - 1)
    step = rollout.time_s[1] - rollout.time_s[0]
    share = ((moment - rollout.time_s[frame]) / step)[:, None, None, None]
    wall = scene.wall_position(rollout.start_s + rollout.time_s[:, None])[:, :, None, :]
    drift = np.gradient(wall, step, axis=0)
    place, motion = rollout.position_m - wall, rollout.velocity_m_s - drift
    cumulative = np.cumsum(rollout.dissipated_J, axis=0)
    late = (1 - share[..., 0, 0]) * cumulative[frame] + share[..., 0, 0] * cumulative[following]
    return Rolled(
        time_s=rollout.time_s,
        position_m=wall + (1 - share) * place[frame] + share * place[following],
        velocity_m_s=drift + rate * ((1 - share) * motion[frame] + share * motion[following]),
        dissipated_J=np.diff(late, axis=0, prepend=0),
        crossed_s=rollout.crossed_s,
        start_s=rollout.start_s,
    )
