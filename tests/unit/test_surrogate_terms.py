"""Matrix products without their zeros against numpy."""

import numpy as np
import pytest

from millprint.run.kernel import array_maker
from millprint.thesis.surrogate.compiled import packed
from millprint.thesis.surrogate.products import PANEL, WORD, add_product, add_terms


@array_maker()
def product(out, weight, x, rows):
    """`add_product`, which only kernels may call."""
    add_product(out, weight, x, rows)


@pytest.mark.parametrize("rows", [1, 7, 64])
@pytest.mark.parametrize(("inputs", "outputs"), [(1, 1), (3, 16), (49, PANEL), (256, 256), (70, 100)])
@pytest.mark.parametrize("zeros", [0.0, 0.6, 1.0])
def test_a_product_equals_numpy(rows, inputs, outputs, zeros):
    random = np.random.default_rng(rows + inputs)
    width = outputs + -outputs % PANEL
    # Inputs stand in rows that are wider than what the layer takes, and in more rows than count.
    x = random.normal(size=(rows + 2, inputs + 5)).astype(np.float32)
    x[random.random(x.shape) < zeros] = 0.0
    weight, start = random.normal(size=(inputs, outputs)), random.normal(size=(rows + 2, width)).astype(np.float32)
    out = start.copy()
    product(out, packed("weight", weight), x, rows)
    expected = start[:rows, :outputs] + x[:rows, :inputs].astype(float) @ weight.astype(np.float32).astype(float)
    scale = np.abs(x[:rows, :inputs]) @ np.abs(weight)
    assert (np.abs(out[:rows, :outputs] - expected) < 3e-7 * (scale + np.abs(expected))).all()
    np.testing.assert_array_equal(out[:rows, outputs:], start[:rows, outputs:])
    np.testing.assert_array_equal(out[rows:], start[rows:])


def test_what_is_not_a_number_reaches_its_row_and_no_other():
    x, out = np.zeros((3, WORD), dtype=np.float32), np.zeros((3, PANEL), dtype=np.float32)
    x[1, 5] = np.nan
    product(out, packed("weight", np.ones((WORD, PANEL))), x, 3)
    assert np.isnan(out[1]).all() and not out[[0, 2]].any()


def test_numbers_of_another_precision_raise():
    @array_maker()
    def wrong(out, weight, x):
        add_terms(out, weight, x, np.uint64(1), 0, 0, 0)

    double = np.zeros((WORD, PANEL))
    with pytest.raises(Exception, match="float32"):
        wrong(double, double, double)
