"""A roll-out in one call: coarse steps, and what is kept of them."""

from typing import NamedTuple

import numpy as np

from millprint.dem import state
from millprint.dem.advance import all_works
from millprint.kernel import kernel
from millprint.surrogate.contact.step import run_steps


class Frames(NamedTuple):
    """What is kept of a roll-out; `works` and `ended` count from its start."""

    position: np.ndarray  # (frames, n, 3) [m]
    rate: np.ndarray  # (frames, n, 6) velocity [m/s] and angular velocity [rad/s]
    works: np.ndarray  # (frames, TOTALS) see millprint.dem.state [J]
    ended: np.ndarray  # (frames,) contacts that have ended


def make_frames(frames: int, balls: int) -> Frames:
    """Room for `frames` states; what is never written stays not a number."""
    return Frames(
        position=np.full((frames, balls, 3), np.nan),
        rate=np.full((frames, balls, 6), np.nan),
        works=np.full((frames, state.TOTALS), np.nan),
        ended=np.full(frames, np.nan),
    )


@kernel()
def run_frames(balls, candidates, contacts, laws, walls, clock, totals, counters, table, coarse, per_frame, frames, at):
    """Run until the frames from `at` on are written, `per_frame` steps apart; returns how many of them were."""
    for frame in range(at, frames.position.shape[0]):
        run_steps(
            balls, candidates, contacts, laws, walls, clock, coarse, totals, counters, table,
            counters[state.STEP] + per_frame - 1,
        )  # fmt: skip
        if counters[state.STATUS] != state.RUNNING:
            return frame - at
        for i in range(balls.species.size):
            for c in range(3):
                frames.position[frame, i, c] = balls.position[i, c]
            for c in range(6):
                frames.rate[frame, i, c] = balls.rate[i, c]
        all_works(contacts, counters, totals, frames.works[frame])
        frames.ended[frame] = coarse.ended[0]
    return frames.position.shape[0] - at
