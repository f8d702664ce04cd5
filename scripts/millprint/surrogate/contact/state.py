"""What a coarse step needs besides the state of a simulation."""

from typing import NamedTuple

import numpy as np

from millprint.config.contact_surrogate import WIDTH_MAX
from millprint.dem.lanes import LANES
from millprint.surrogate.contact import pair
from millprint.surrogate.contact.weights import Weights, no_weights

# By how much faster than at present two bodies may near each other in a step, to be foreseen [m/s].
MARGIN_M_S = 0.1


class Coarse(NamedTuple):
    """Scratch of a coarse step, and what is set once."""

    substeps: int  # of a pair's local problem
    margin: float  # a contact is foreseen that stays this far from touch at the present velocities [m]
    weights: Weights  # of the network; those of an untrained one expect what was at the end of the last step
    work: np.ndarray  # (blocks, pair.QUANTITIES * LANES)
    push: np.ndarray  # (n, 12) forces [N] and torques [N m] expected of all contacts of a ball, and their slopes
    moved: np.ndarray  # (n, 9) impulses, moments and twists of all contacts of a ball
    wall_velocity: np.ndarray  # (bodies, 6) velocities at the end of the step
    ended: np.ndarray  # (1,) contacts that touched and have ended
    first_row: np.ndarray  # numbers of one layer of the network for all lanes, one neuron after the other
    second_row: np.ndarray  # and of the next


def make_coarse(
    balls: int, bodies: int, blocks: int, step: float, substeps: int, weights: Weights | None = None
) -> Coarse:
    """Scratch for `balls` in `bodies` with room for `blocks` of contacts."""
    work = np.zeros((blocks, pair.QUANTITIES * LANES))
    # Two balls side by side: what is computed of a free lane is finite.
    work[:, pair.AWAY * LANES : (pair.AWAY + 1) * LANES] = 1.0
    work[:, pair.INVERSE_MASS * LANES : (pair.INVERSE_MASS + 1) * LANES] = 1.0
    return Coarse(
        substeps=substeps,
        margin=MARGIN_M_S * step,
        weights=no_weights(),
        work=work,
        push=np.zeros((balls, 12)),
        moved=np.zeros((balls, 9)),
        wall_velocity=np.zeros((bodies, 6)),
        ended=np.zeros(1),
        first_row=np.zeros(WIDTH_MAX * blocks * LANES, dtype=np.float32),
        second_row=np.zeros(WIDTH_MAX * blocks * LANES, dtype=np.float32),
    )
