"""Eight contacts at a time, in arrays that never overlap: gathered from the balls into lanes, and spread back.

A loop becomes vector instructions only if no number that it writes can be one that it reads later. Within one row the
compiler sees that by itself; for two arrays it needs the scopes of LLVM's metadata (`alias.scope` and
`noalias` in https://llvm.org/docs/LangRef.html). Rows and columns are not checked and count from the front.

A block of lanes is one row of numbers, LANES for each quantity, so that the compiler knows that quantities never
overlap and makes vector instructions of the loop over the lanes. A lane that is free keeps the numbers of an earlier
contact, or IDLE ones: they cost nothing, and their results are not read.

Quantities of one step only are in separate rows (layout.PresentColumns), GROUP of them, which all blocks use in
turn: so they stay in the processor's nearest memory, however many contacts there are.
"""

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from millprint.dem.layout import LANE, LANES, PRESENT
from millprint.mill.kernel_columns import span_of, width_of
from millprint.run.kernel import inlined


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


# Content of a free lane: two steel balls of 10 mm in contact.
IDLE = np.zeros(width_of(LANE))
IDLE[span_of(LANE.law)] = 1.0
IDLE[LANE.law.reach] = 10e-3
IDLE_PRESENT = np.zeros(width_of(PRESENT))
IDLE_PRESENT[PRESENT.away.x] = 9.99e-3


@inlined()
def get(lanes, block, quantity, m):
    """A quantity of a lane."""
    return load_lane(lanes, block, quantity * LANES + m)


@inlined()
def put(lanes, block, quantity, m, value):
    """Set a quantity of a lane."""
    store_lane(lanes, block, quantity * LANES + m, value)


@inlined()
def get_vector(lanes, block, quantity, m):
    """A vector of a lane, of which `quantity` names the three columns: they follow each other."""
    at = quantity.x * LANES + m
    return load_lane(lanes, block, at), load_lane(lanes, block, at + LANES), load_lane(lanes, block, at + 2 * LANES)


@inlined()
def put_vector(lanes, block, quantity, m, vector):
    """Set a vector of a lane."""
    at = quantity.x * LANES + m
    store_lane(lanes, block, at, vector[0])
    store_lane(lanes, block, at + LANES, vector[1])
    store_lane(lanes, block, at + 2 * LANES, vector[2])


@inlined()
def get_present(present, at, quantity, m):
    """A vector of lane m in row `at` of the present rows."""
    c = quantity.x * LANES + m
    return load_present(present, at, c), load_present(present, at, c + LANES), load_present(present, at, c + 2 * LANES)


@inlined()
def put_present(present, at, quantity, m, vector):
    """Set a vector of lane m in row `at` of the present rows."""
    c = quantity.x * LANES + m
    store_present(present, at, c, vector[0])
    store_present(present, at, c + LANES, vector[1])
    store_present(present, at, c + 2 * LANES, vector[2])


@inlined()
def add_to(lanes, block, quantity, m, value):
    """Add to a quantity of a lane."""
    put(lanes, block, quantity, m, get(lanes, block, quantity, m) + value)


@inlined()
def raise_to(lanes, block, quantity, m, value):
    """Set a quantity of a lane to a value that is larger."""
    old = get(lanes, block, quantity, m)
    put(lanes, block, quantity, m, value if value > old else old)


@inlined()
def get_of(contacts, lane, quantity):
    """A quantity of the contact in a lane, by the number of the lane among all."""
    return get(contacts.lanes, lane // LANES, quantity, lane % LANES)


@inlined()
def put_of(contacts, lane, quantity, value):
    """Set a quantity of the contact in a lane, by the number of the lane among all."""
    put(contacts.lanes, lane // LANES, quantity, lane % LANES, value)
