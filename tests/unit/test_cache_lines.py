"""Arrays begin with a cache line, wherever numpy puts them."""

import numpy as np
import pytest

from millprint.run.cache_lines import CACHE_LINE_BYTES, aligned


@pytest.mark.parametrize("dtype", [np.uint8, np.float32, np.float64])
@pytest.mark.parametrize("count", [1, 15, 1000, 100_000])
def test_a_copy_begins_with_a_cache_line_and_has_the_values(dtype, count):
    values = np.arange(2 * count).astype(dtype).reshape(2, count)
    # Several at once, which lie at different places.
    for copy in [aligned(each) for each in (values, values.T, values[:, ::-1])]:
        assert copy.ctypes.data % CACHE_LINE_BYTES == 0 and copy.flags.c_contiguous and copy.dtype == dtype
        assert not np.shares_memory(copy, values)
    np.testing.assert_array_equal(aligned(values.T), values.T)
