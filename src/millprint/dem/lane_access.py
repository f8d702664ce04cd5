"""Access to the lanes and to the present rows, two arrays that are declared to the compiler as never overlapping.

A loop becomes vector instructions only if no number that it writes can be one that it reads later. Within one row the
compiler sees that by itself; for two arrays it needs the scopes of LLVM's metadata (`alias.scope` and
`noalias` in https://llvm.org/docs/LangRef.html). Rows and columns are not checked and count from the front.
"""

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array


def _scope(module: ir.Module, name: str) -> ir.MDValue:
    """A list of one scope, in the form that instructions refer to."""
    domain = module.add_metadata(["millprint"])
    return module.add_metadata([module.add_metadata([name, domain])])


def _place(context, builder, signature, arguments):
    """The address of a number, by the row and the column in the second and third argument."""
    array = make_array(signature.args[0])(context, builder, arguments[0])
    indices = [
        context.cast(builder, index, kind, types.intp)
        for index, kind in zip(arguments[1:3], signature.args[1:3], strict=True)
    ]
    return cgutils.get_item_pointer(context, builder, signature.args[0], array, indices, wraparound=False)


def _mark(builder, instruction, own, other):
    """Declare that an instruction reads or writes the memory `own` and not `other`."""
    instruction.set_metadata("alias.scope", _scope(builder.module, own))
    instruction.set_metadata("noalias", _scope(builder.module, other))
    return instruction


def _access(own: str, other: str):
    """Two functions for kernels, to read a number of an array and to write one."""

    @intrinsic
    def load(typing, array, line, column):
        def code(context, builder, signature, arguments):
            place = _place(context, builder, signature, arguments)
            return _mark(builder, builder.load(place), own, other)

        return array.dtype(array, line, column), code

    @intrinsic
    def store(typing, array, line, column, value):
        def code(context, builder, signature, arguments):
            place = _place(context, builder, signature, arguments)
            number = context.cast(builder, arguments[3], signature.args[3], signature.args[0].dtype)
            _mark(builder, builder.store(number, place), own, other)
            return context.get_dummy_value()

        return types.void(array, line, column, value), code

    return load, store


load_lane, store_lane = _access("lanes", "present")
load_present, store_present = _access("present", "lanes")
