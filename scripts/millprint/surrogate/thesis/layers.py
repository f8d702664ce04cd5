"""Linear layers and ReLU as kernels, in single precision, for the few rows of a roll-out's graph.

Rows are nodes or edges, (rows, width). Two dozen rows are too few for a library's matrix product to be worth its start.
Rows are taken ROWS at a time: arrays have so many more at the end, whose numbers mean nothing.
"""

import numpy as np

from millprint.kernel import inner

ROWS = 4
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
    """out += x weight, with weight (inputs, outputs) and a multiple of four inputs.

    Four rows and four inputs at a time: sixteen numbers of x stay in registers, and each weight is loaded once for
    four rows. The loop over outputs becomes vector instructions.
    """
    inputs, outputs = weight.shape
    for r in range(0, rows, ROWS):
        x0, x1, x2, x3 = x[r], x[r + 1], x[r + 2], x[r + 3]
        out0, out1, out2, out3 = out[r], out[r + 1], out[r + 2], out[r + 3]
        for k in range(0, inputs, 4):
            w0, w1, w2, w3 = weight[k], weight[k + 1], weight[k + 2], weight[k + 3]
            a0, a1, a2, a3 = x0[k], x0[k + 1], x0[k + 2], x0[k + 3]
            b0, b1, b2, b3 = x1[k], x1[k + 1], x1[k + 2], x1[k + 3]
            c0, c1, c2, c3 = x2[k], x2[k + 1], x2[k + 2], x2[k + 3]
            d0, d1, d2, d3 = x3[k], x3[k + 1], x3[k + 2], x3[k + 3]
            for c in range(outputs):
                u0, u1, u2, u3 = w0[c], w1[c], w2[c], w3[c]
                # One after the other, each a single fused instruction.
                out0[c] = out0[c] + a0 * u0 + a1 * u1 + a2 * u2 + a3 * u3
                out1[c] = out1[c] + b0 * u0 + b1 * u1 + b2 * u2 + b3 * u3
                out2[c] = out2[c] + c0 * u0 + c1 * u1 + c2 * u2 + c3 * u3
                out3[c] = out3[c] + d0 * u0 + d1 * u1 + d2 * u2 + d3 * u3


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
