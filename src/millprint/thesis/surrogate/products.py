"""Matrix products without zeros, and layers of a perceptron, as kernels.

Of the numbers that a ReLU hands on, half to three quarters are zero. The others of a row are marked in a word, one bit
for each number. Their products are added up in registers, PANEL columns of the result at a time, and the sum is added
to the value in memory. In single precision, a sum of 256 numbers loses less by rounding if it is taken in parts.
Columns are taken PANEL at a time: arrays are filled up to whole panels with columns of zeros.
"""

from typing import Any

import numpy as np
from llvmlite import binding, ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from millprint.run.kernel import inlined, inner

LANES = 16
# Eight vectors fill a quarter of the 32 registers of AVX-512, enough to wait for none; others have 16, half as long.
VECTORS = 8 if binding.get_host_cpu_features().get("avx512f") else 4
PANEL = VECTORS * LANES
# Numbers of a row that a word marks. This number of rows of a panel fits into the processor's first cache.
WORD = 64

# A product and a sum as one instruction where the processor has it.
_FUSED = ("contract",)
_INDEX = ir.IntType(64)
_VECTOR = ir.VectorType(ir.FloatType(), LANES)
_ALIGNED = 4
_MATRIX = types.Array(types.float32, 2, "C")


@inlined()
def mark(x, row, first, count):
    """A word for the numbers x[row, first : first + count], WORD of them at most: a bit for each that is not zero.

    NaN has a bit. With fewer than WORD numbers, all have a bit.
    """
    if count == WORD:
        return mark_whole(x, row, first)
    return (np.uint64(1) << np.uint64(count)) - np.uint64(1)


@intrinsic
def mark_whole(typing: Any, x: Any, row: Any, first: Any) -> Any:
    """The word of the WORD numbers from x[row, first] on; see `mark`. Nothing is checked."""
    del typing, x, row, first
    return types.uint64(_MATRIX, types.intp, types.intp), _compare


def _compare(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> Any:
    """The instructions of `mark_whole`."""
    x = context.make_array(signature.args[0])(context, builder, arguments[0])
    vector = ir.VectorType(ir.FloatType(), WORD)
    place = builder.bitcast(_at(builder, x, *arguments[1:]), vector.as_pointer())
    # The unordered comparison is true of what is not a number.
    marks = builder.fcmp_unordered("!=", builder.load(place, align=_ALIGNED), vector(None))
    return builder.bitcast(marks, _INDEX)


@intrinsic
def add_terms(typing: Any, out: Any, weight: Any, x: Any, word: Any, row: Any, column: Any, first: Any) -> Any:
    """out[row, column:] += the sum of x[row, first + k] weight[first + k] over the bits k of a word, PANEL columns.

    All in single precision and contiguous: out (rows, columns), weight (inputs, PANEL), x (rows, inputs). Nothing is
    checked: rows and columns must be there.
    """
    del typing, word, row, column, first
    if {out, weight, x} != {_MATRIX}:
        raise TypeError(f"add_terms takes contiguous float32 matrices, not {out}, {weight}, {x}")
    return types.void(*[_MATRIX] * 3, types.uint64, *[types.intp] * 3), _generate


def _generate(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> Any:
    """The instructions of `add_terms`."""
    matrix = context.make_array(signature.args[0])
    out, weight, x = (matrix(context, builder, value) for value in arguments[:3])
    word, row, column, first = arguments[3:]

    def vectors(matrix: Any, line: Any, place: Any) -> list[Any]:
        corner = _at(builder, matrix, line, place)
        places = (builder.gep(corner, [_INDEX(part * LANES)]) for part in range(VECTORS))
        return [builder.bitcast(at, _VECTOR.as_pointer()) for at in places]

    numbers = _at(builder, x, row, first)
    before, loop, after = builder.block, builder.append_basic_block("term"), builder.append_basic_block("summed")
    builder.cbranch(builder.icmp_unsigned("!=", word, word.type(0)), loop, after)

    builder.position_at_end(loop)
    left = builder.phi(word.type)
    sums = [builder.phi(_VECTOR) for _ in range(VECTORS)]
    k = builder.cttz(left, ir.IntType(1)(1))
    factor = _repeated(builder, builder.load(builder.gep(numbers, [k])))
    weights = vectors(weight, builder.add(first, k), _INDEX(0))
    added = [
        builder.fadd(total, builder.fmul(factor, builder.load(at, align=_ALIGNED), flags=_FUSED), flags=_FUSED)
        for total, at in zip(sums, weights, strict=True)
    ]
    rest = builder.and_(left, builder.sub(left, left.type(1)))
    left.add_incoming(word, before)
    left.add_incoming(rest, loop)
    for total, of_loop in zip(sums, added, strict=True):
        total.add_incoming(_VECTOR(None), before)
        total.add_incoming(of_loop, loop)
    builder.cbranch(builder.icmp_unsigned("!=", rest, rest.type(0)), loop, after)

    builder.position_at_end(after)
    totals = [builder.phi(_VECTOR) for _ in added]
    for total, of_loop in zip(totals, added, strict=True):
        total.add_incoming(_VECTOR(None), before)
        total.add_incoming(of_loop, loop)
    for total, at in zip(totals, vectors(out, row, column), strict=True):
        builder.store(builder.fadd(builder.load(at, align=_ALIGNED), total), at, align=_ALIGNED)
    return context.get_dummy_value()


def _at(builder: ir.IRBuilder, matrix: Any, line: Any, place: Any) -> Any:
    """Address of a number in a contiguous matrix."""
    width = cgutils.unpack_tuple(builder, matrix.shape)[1]
    return builder.gep(matrix.data, [builder.add(builder.mul(line, width), place)])


def _repeated(builder: ir.IRBuilder, number: Any) -> Any:
    """A vector of the same number in all lanes."""
    nowhere = ir.Constant(_VECTOR, ir.Undefined)
    one = builder.insert_element(nowhere, number, ir.IntType(32)(0))
    return builder.shuffle_vector(one, nowhere, ir.Constant(ir.VectorType(ir.IntType(32), LANES), None))


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
    """out += x weight, with weight (panels, inputs, PANEL) as `compiled.packed` packs it; zeros of x are left out.

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


@inner()
def enter(layers, x, hidden, hidden_sum, rows):
    """x through the first layer of a perceptron and its hidden ones; hidden_sum: what these are before their ReLU."""
    begin(hidden_sum, layers.first_bias, rows)
    add_product(hidden_sum, layers.first, x, rows)
    rectify(hidden, hidden_sum, rows)
    through(layers.hidden.weight, layers.hidden.bias, hidden, hidden_sum, rows)
