"""The network's weights as the kernels take them."""

from typing import NamedTuple

import numpy as np

INPUTS = 13
OUTPUTS = 8


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
    """No network: every contact is expected to go on as it ended the last step."""
    return make_weights([np.zeros(shape) for shape in (
        (0, 1, INPUTS), (0, 1), (0, 1, 1), (0, 1), (0, OUTPUTS, 1), (0, OUTPUTS),
    )])  # fmt: skip
