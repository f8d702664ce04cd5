"""Matrix products in tiles against numpy."""

import numpy as np
import pytest

from millprint.kernel import array_maker
from millprint.surrogate.thesis.folded import packed
from millprint.surrogate.thesis.layers import add_product
from millprint.surrogate.thesis.tiles import PANEL, ROWS, add_tile


@array_maker()
def product(out, weight, x, rows):
    """`add_product`, which only kernels may call."""
    add_product(out, weight, x, rows)


@pytest.mark.parametrize("rows", [1, ROWS, 7, 64])
@pytest.mark.parametrize(("inputs", "outputs"), [(1, 1), (3, 16), (49, PANEL), (256, 256), (70, 100)])
def test_a_product_in_tiles_equals_numpy(rows, inputs, outputs):
    random = np.random.default_rng(rows + inputs)
    height, width = rows + -rows % ROWS, outputs + -outputs % PANEL
    # Inputs stand in rows that are wider than what the layer takes, and in more rows than count.
    x = random.normal(size=(height, inputs + 5)).astype(np.float32)
    weight, start = random.normal(size=(inputs, outputs)), random.normal(size=(height, width)).astype(np.float32)
    out = start.copy()
    product(out, packed("weight", weight), x, rows)
    expected = start[:rows, :outputs] + x[:rows, :inputs].astype(float) @ weight.astype(np.float32).astype(float)
    scale = np.abs(x[:rows, :inputs]) @ np.abs(weight)
    assert (np.abs(out[:rows, :outputs] - expected) < 3e-7 * (scale + np.abs(expected))).all()
    np.testing.assert_array_equal(out[:rows, outputs:], start[:rows, outputs:])


def test_numbers_of_another_precision_raise():
    @array_maker()
    def wrong(out, weight, x):
        add_tile(out, weight, x, 0, 0, 0, 1)

    double = np.zeros((ROWS, PANEL))
    with pytest.raises(Exception, match="float32"):
        wrong(double, double, double)
