"""The weights of the network and the scratch arrays of a coarse step."""

from typing import NamedTuple

import numpy as np

from millprint.config.contact_surrogate import WIDTH_MAX
from millprint.dem.lanes import LANES
from millprint.surrogate.contact import pair


class Weights(NamedTuple):
    """Two hidden layers for each round of messages (rounds first in every shape)."""

    first: np.ndarray  # (rounds, width, pair.INPUTS)
    first_bias: np.ndarray  # (rounds, width)
    second: np.ndarray  # (rounds, width, width)
    second_bias: np.ndarray  # (rounds, width)
    last: np.ndarray  # (rounds, pair.OUTPUTS, width)
    last_bias: np.ndarray  # (rounds, pair.OUTPUTS)


def make_weights(layers: list[np.ndarray]) -> Weights:
    """Weights of the arrays first, first_bias, second, second_bias, last, last_bias; single precision."""
    arrays = [np.ascontiguousarray(layer, dtype=np.float32) for layer in layers]
    return Weights(*arrays)


def no_weights() -> Weights:
    """No network: every contact is predicted to continue as at the end of the last step."""
    return make_weights([np.zeros(shape) for shape in (
        (0, 1, pair.INPUTS), (0, 1), (0, 1, 1), (0, 1), (0, pair.OUTPUTS, 1), (0, pair.OUTPUTS),
    )])  # fmt: skip


# Largest increase of the approach speed in a step for which contacts are opened in advance [m/s].
MARGIN_M_S = 0.1


class Scratch(NamedTuple):
    """Scratch arrays of a coarse step, and its constants."""

    substeps: int  # of a pair's local problem
    margin: float  # a contact is foreseen that stays this far from touch at the present velocities [m]
    weights: Weights  # of the network; those of an untrained one expect what was at the end of the last step
    work: np.ndarray  # (blocks, pair.LOCAL_QUANTITIES * LANES)
    load: np.ndarray  # (n, 12) forces [N] and torques [N m] expected of all contacts of a ball, and their slopes
    moved: np.ndarray  # (n, 9) impulses, moments and twists of all contacts of a ball
    wall_velocity: np.ndarray  # (bodies, 6) velocities at the end of the step
    ended: np.ndarray  # (1,) contacts that touched and have ended
    first_row: np.ndarray  # numbers of one layer of the network for all lanes, one neuron after the other
    second_row: np.ndarray  # and of the next


def make_scratch(balls: int, bodies: int, blocks: int, step: float, substeps: int) -> Scratch:
    """Scratch for `balls` in `bodies` with room for `blocks` of contacts, without a network; step: coarse [s]."""
    work = np.zeros((blocks, pair.LOCAL_QUANTITIES * LANES))
    # Two balls side by side: what is computed of a free lane is finite.
    work[:, pair.AWAY * LANES : (pair.AWAY + 1) * LANES] = 1.0
    work[:, pair.INVERSE_MASS * LANES : (pair.INVERSE_MASS + 1) * LANES] = 1.0
    return Scratch(
        substeps=substeps,
        margin=MARGIN_M_S * step,
        weights=no_weights(),
        work=work,
        load=np.zeros((balls, 12)),
        moved=np.zeros((balls, 9)),
        wall_velocity=np.zeros((bodies, 6)),
        ended=np.zeros(1),
        first_row=np.zeros(WIDTH_MAX * blocks * LANES, dtype=np.float32),
        second_row=np.zeros(WIDTH_MAX * blocks * LANES, dtype=np.float32),
    )
