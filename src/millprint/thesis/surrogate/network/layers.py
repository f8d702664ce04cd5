"""Linear layers and ReLU as kernels, in single precision, for the few rows of a roll-out's graph.

Rows are nodes or edges, (rows, width). Columns are taken PANEL at a time: arrays are filled up to whole
panels with columns of zeros.
"""

import numpy as np

from millprint.run.kernel import inner
from millprint.thesis.surrogate.network.terms import PANEL, WORD, add_terms, mark

ZERO = np.float32(0.0)


@inner()
def begin(out, bias, rows):
    """out = bias in every row."""
    for r in range(rows):
        for c in range(bias.size):
            out[r, c] = bias[c]


@inner()
def clear(out, rows):
    """out = 0 in every row."""
    for r in range(rows):
        for c in range(out.shape[1]):
            out[r, c] = ZERO


@inner()
def add_product(out, weight, x, rows):
    """out += x weight, with weight (panels, inputs, PANEL) as `folded` packs it; zeros of x are left out.

    WORD inputs of a panel stay in the processor's first cache while all rows pass over them.
    """
    inputs = weight.shape[1]
    for number in range(weight.shape[0]):
        panel = weight[number]
        for first in range(0, inputs, WORD):
            count = min(WORD, inputs - first)
            for row in range(rows):
                add_terms(out, panel, x, mark(x, row, first, count), row, number * PANEL, first)


@inner()
def rectify(x, z, rows):
    """x = ReLU(z); what is not a number stays so."""
    for r in range(rows):
        for c in range(z.shape[1]):
            value = z[r, c]
            x[r, c] = ZERO if value < ZERO else value


@inner()
def through(weight, bias, x, z, rows):
    """x through hidden layers, each with a ReLU; z: what it is before that."""
    for layer in range(weight.shape[0]):
        begin(z, bias[layer], rows)
        add_product(z, weight[layer], x, rows)
        rectify(x, z, rows)
