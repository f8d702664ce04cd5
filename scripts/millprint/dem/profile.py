"""Where the time of a step goes: ticks of the processor's clock by part, compiled in only when it is measured.

`advance` with None in place of the array of ticks is compiled without any of this. Reading the clock takes about 10 ns
and holds up what the processor would have done at the same time, so the parts add up to more than a step takes without
it; their shares are what counts.
"""

from typing import NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from millprint.columns import number_columns, width_of
from millprint.kernel import inlined


class ProfileColumns(NamedTuple):
    """Ticks spent in each part of the step loop, and the clock at the end of the part before."""

    lists: int  # poses of the bodies; checks of the lists and of the overlaps, rebuilds
    look: int  # the list of the candidates that are near
    candidates: int  # their checks, and contacts that open
    gather: int  # states of both partners into the lanes; contacts that close
    law: int
    scatter: int  # forces and torques back to the partners; work of the walls
    records: int
    move: int  # kick and drift
    last: int


PROFILE = number_columns(ProfileColumns)
PARTS = ProfileColumns._fields[:-1]


def make_profile() -> np.ndarray:
    """No ticks yet (width,)."""
    return np.zeros(width_of(PROFILE), dtype=np.int64)


@intrinsic
def ticks(context):
    """The processor's clock, as LLVM reads it [ticks]; 64 bits with sign."""

    def code(context, builder, signature, arguments):
        name = "llvm.readcyclecounter"
        return builder.call(builder.module.declare_intrinsic(name, fnty=ir.FunctionType(ir.IntType(64), [])), [])

    return types.int64(), code


@inlined()
def lap(profile, part):
    """Add the time since the last lap to a part; nothing where `profile` is None."""
    if profile is not None:
        now = ticks()
        profile[part] += now - profile[PROFILE.last]
        profile[PROFILE.last] = now
