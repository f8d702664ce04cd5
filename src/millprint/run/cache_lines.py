"""Arrays that begin with a cache line of the processor.

A vector of the processor that lies on two lines is loaded in two steps, and an array of numpy begins anywhere.
"""

import numpy as np

CACHE_LINE_BYTES = 64


def aligned(values: np.ndarray) -> np.ndarray:
    """A contiguous copy that begins with a cache line, as does each of its rows that is a whole number of lines."""
    room = np.empty(values.size + CACHE_LINE_BYTES // values.itemsize, dtype=values.dtype)
    start = -room.ctypes.data % CACHE_LINE_BYTES // room.itemsize
    copy = room[start : start + values.size].reshape(values.shape)
    copy[...] = values
    return copy
