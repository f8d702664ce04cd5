"""The weights of the network and the scratch arrays of a coarse step."""

from typing import NamedTuple

import numpy as np

from millprint.columns import Vector, number_columns, width_of
from millprint.config.contact_surrogate import WIDTH_MAX
from millprint.dem.layout import LANES, RATE_WIDTH, LoadColumns
from millprint.surrogate.contact.pair import INPUTS, OUTPUTS, PAIR, PAIR_WIDTH


class Weights(NamedTuple):
    """Two hidden layers for each round of messages (rounds first in every shape)."""

    first: np.ndarray  # (rounds, width, INPUTS)
    first_bias: np.ndarray  # (rounds, width)
    second: np.ndarray  # (rounds, width, width)
    second_bias: np.ndarray  # (rounds, width)
    last: np.ndarray  # (rounds, OUTPUTS, width)
    last_bias: np.ndarray  # (rounds, OUTPUTS)


def make_weights(layers: list[np.ndarray]) -> Weights:
    """Weights of the arrays first, first_bias, second, second_bias, last, last_bias; single precision."""
    arrays = [np.ascontiguousarray(layer, dtype=np.float32) for layer in layers]
    return Weights(*arrays)


def no_weights() -> Weights:
    """No network: every contact is predicted to continue as at the end of the last step."""
    return make_weights([np.zeros(shape) for shape in (
        (0, 1, INPUTS), (0, 1), (0, 1, 1), (0, 1), (0, OUTPUTS, 1), (0, OUTPUTS),
    )])  # fmt: skip


# Largest increase of the approach speed in a step for which contacts are opened in advance [m/s].
MARGIN_M_S = 0.1


class ExpectedLoadColumns(NamedTuple):
    """Loads expected of the contacts of a ball."""

    mean: LoadColumns  # over the step
    tilt: LoadColumns  # by how much they are more at its end, and less at its start


class MovedColumns(NamedTuple):
    """What the contacts of a ball hand to it in a step."""

    impulse: Vector  # [N s]
    moment: Vector  # of the impulse [N s2]
    twist: Vector  # impulse of the torque [N m s]


EXPECTED_LOAD = number_columns(ExpectedLoadColumns)
MOVED = number_columns(MovedColumns)


class Scratch(NamedTuple):
    """Scratch arrays of a coarse step, and its constants."""

    substeps: int  # of a pair's local problem
    margin: float  # a contact is foreseen that stays this far from touch at the present velocities [m]
    weights: Weights  # of the network; those of an untrained one expect what was at the end of the last step
    work: np.ndarray  # (blocks, PAIR_WIDTH * LANES)
    load: np.ndarray  # (n, width) ExpectedLoadColumns, of all contacts of a ball
    moved: np.ndarray  # (n, width) MovedColumns, of all contacts of a ball
    wall_velocity: np.ndarray  # (bodies, width) layout.RateColumns at the end of the step
    ended: np.ndarray  # (1,) contacts that touched and have ended
    first_row: np.ndarray  # numbers of one layer of the network for all lanes, one neuron after the other
    second_row: np.ndarray  # and of the next


def make_scratch(balls: int, bodies: int, blocks: int, step: float, substeps: int) -> Scratch:
    """Scratch for `balls` in `bodies` with room for `blocks` of contacts, without a network; step: coarse [s]."""
    work = np.zeros((blocks, PAIR_WIDTH * LANES))
    # Two balls side by side: what is computed of a free lane is finite.
    for quantity in (PAIR.away.x, PAIR.inverse_mass):
        work[:, quantity * LANES : (quantity + 1) * LANES] = 1.0
    return Scratch(
        substeps=substeps,
        margin=MARGIN_M_S * step,
        weights=no_weights(),
        work=work,
        load=np.zeros((balls, width_of(EXPECTED_LOAD))),
        moved=np.zeros((balls, width_of(MOVED))),
        wall_velocity=np.zeros((bodies, RATE_WIDTH)),
        ended=np.zeros(1),
        first_row=np.zeros(WIDTH_MAX * blocks * LANES, dtype=np.float32),
        second_row=np.zeros(WIDTH_MAX * blocks * LANES, dtype=np.float32),
    )
