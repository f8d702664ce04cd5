"""The inner loop of a matrix product as vector instructions, which numba's compiler does not find by itself.

A tile of the result, ROWS rows of PANEL numbers, stays in registers while TERMS products are added up. Then it is added
to what stands in memory: a sum of 256 numbers in single precision loses less in sums of 32 than in one after the other.
"""

from typing import Any

from llvmlite import binding, ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

LANES, ROWS, TERMS = 16, 4, 32
# Four vectors for each of four rows fill half of the 32 registers of AVX-512; other processors have 16, half as long.
VECTORS = 4 if binding.get_host_cpu_features().get("avx512f") else 1
PANEL = VECTORS * LANES

_VECTOR = ir.VectorType(ir.FloatType(), LANES)
# A product and a sum as one instruction where the processor has it.
_FUSED = ("contract",)
_ALIGNED = 4


@intrinsic
def add_tile(typing: Any, out: Any, weight: Any, x: Any, row: Any, column: Any, first: Any, after: Any) -> Any:
    """out[row:, column:] += x[row:, first:after] weight[first:after], for ROWS rows and PANEL columns.

    All in single precision and contiguous: out (rows, columns), weight (inputs, PANEL), x (rows, inputs). Nothing is
    checked: the rows and columns must be there.
    """
    del typing
    matrix = types.Array(types.float32, 2, "C")
    if (out, weight, x) != (matrix, matrix, matrix):
        raise TypeError(f"add_tile takes contiguous float32 matrices, not {out}, {weight}, {x}")
    return types.void(matrix, matrix, matrix, types.intp, types.intp, types.intp, types.intp), _generate


def _generate(context: Any, builder: ir.IRBuilder, signature: Any, arguments: Any) -> Any:
    """The instructions of `add_tile`."""
    out, weight, x = (
        context.make_array(kind)(context, builder, value)
        for kind, value in zip(signature.args[:3], arguments[:3], strict=True)
    )
    row, column, first, after = arguments[3:]

    def at(matrix: Any, line: Any, place: Any) -> Any:
        columns = cgutils.unpack_tuple(builder, matrix.shape)[1]
        return builder.gep(matrix.data, [builder.add(builder.mul(line, columns), place)])

    def vectors(start: Any) -> list[Any]:
        places = (builder.gep(start, [ir.Constant(ir.IntType(64), number * LANES)]) for number in range(VECTORS))
        return [builder.bitcast(place, _VECTOR.as_pointer()) for place in places]

    lines = [builder.add(row, row.type(number)) for number in range(ROWS)]
    sums = [[cgutils.alloca_once_value(builder, _VECTOR(None)) for _ in range(VECTORS)] for _ in lines]
    starts = [at(x, line, row.type(0)) for line in lines]
    with cgutils.for_range(builder, after, start=first) as loop:
        factors = [builder.load(place, align=_ALIGNED) for place in vectors(at(weight, loop.index, row.type(0)))]
        for start, of_line in zip(starts, sums, strict=True):
            number = _repeated(builder, builder.load(builder.gep(start, [loop.index])))
            for factor, total in zip(factors, of_line, strict=True):
                product = builder.fmul(number, factor, flags=_FUSED)
                builder.store(builder.fadd(builder.load(total), product, flags=_FUSED), total)
    for line, of_line in zip(lines, sums, strict=True):
        for place, total in zip(vectors(at(out, line, column)), of_line, strict=True):
            builder.store(builder.fadd(builder.load(place, align=_ALIGNED), builder.load(total)), place, align=_ALIGNED)
    return context.get_dummy_value()


def _repeated(builder: ir.IRBuilder, number: Any) -> Any:
    """A vector of the same number in all lanes."""
    one = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), number, ir.Constant(ir.IntType(32), 0))
    nowhere = ir.Constant(_VECTOR, ir.Undefined)
    return builder.shuffle_vector(one, nowhere, ir.Constant(ir.VectorType(ir.IntType(32), LANES), None))
