"""The distributions of millprint.estimate.quantiles are those of scipy.stats, to the last bit."""

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from millprint.estimate import quantiles

SHARES = np.array([
    0.0, 1e-300, 1e-30, 1e-12, 1e-6, 0.001, 0.025, 0.05, 0.1, 1 / 3, 0.5, 0.683, 0.9, 0.95, 0.975, 0.99, 0.995,
    1 - 1e-6, 1 - 1e-12, 1.0, -0.1, 1.1, np.nan,
])  # fmt: skip
VALUES = np.array(
    [-np.inf, -1e300, -40.0, -9.0, -1.3, -1e-9, 0.0, 1e-300, 1e-9, 0.4, 1.96, 8.5, 38.0, 1e5, 1e300, np.inf, np.nan]
)
FREEDOM = np.array([-1.0, 0.0, 0.1, 0.5, 1, 2, 2.7, 3, 5, 17.25, 30, 100, 1000, 1e6, 1e10, np.nan])
INSIDE = SHARES[(SHARES > 0) & (SHARES < 1)]
NORMAL, STUDENT, F, CHI_SQUARED = (), (FREEDOM,), (FREEDOM[:, None], FREEDOM), (FREEDOM,)
PAIRS = [
    (quantiles.normal_quantile, stats.norm.ppf, SHARES, NORMAL),
    (quantiles.normal_exceeded, stats.norm.isf, SHARES, NORMAL),
    (quantiles.normal_below, stats.norm.cdf, VALUES, NORMAL),
    (quantiles.student_quantile, stats.t.ppf, INSIDE, STUDENT),
    (quantiles.student_exceeded, stats.t.isf, INSIDE, STUDENT),
    (quantiles.student_above, stats.t.sf, VALUES, STUDENT),
    (quantiles.f_quantile, stats.f.ppf, SHARES, F),
    (quantiles.f_exceeded, stats.f.isf, SHARES, F),
    (quantiles.f_above, stats.f.sf, VALUES, F),
    (quantiles.chi_squared_quantile, stats.chi2.ppf, SHARES, CHI_SQUARED),
    (quantiles.chi_squared_exceeded, stats.chi2.isf, SHARES, CHI_SQUARED),
    (quantiles.chi_squared_above, stats.chi2.sf, VALUES, CHI_SQUARED),
]
IDS = [ours.__name__ for ours, *_ in PAIRS]


def is_same(found, expected):
    """Whether two results are equal to the last bit, with the sign of zeros, and of one kind."""
    assert type(found) is type(expected)
    found, expected = np.asarray(found), np.asarray(expected)
    assert found.shape == expected.shape and found.dtype == expected.dtype
    both_nan = np.isnan(found) & np.isnan(expected)
    return bool(np.all(both_nan | (found == expected) & (np.signbit(found) == np.signbit(expected))))


@pytest.mark.parametrize(("ours", "theirs", "at", "rest"), PAIRS, ids=IDS)
def test_arrays_are_those_of_scipy_stats(ours, theirs, at, rest):
    at = at.reshape(-1, *[1] * max((np.ndim(each) for each in rest), default=0))
    assert is_same(ours(at, *rest), theirs(at, *rest))


@pytest.mark.parametrize(("ours", "theirs", "at", "rest"), PAIRS, ids=IDS)
def test_numbers_are_those_of_scipy_stats(ours, theirs, at, rest):
    for value in at.tolist():
        for freedom in (0, 1, 4, 7.5, 123):
            assert is_same(ours(value, *[freedom] * len(rest)), theirs(value, *[freedom] * len(rest)))


def test_a_column_gives_an_array():
    """As scipy.stats does: the index of the column is not kept."""
    column = pd.Series([0.1, 0.5, np.nan], index=[5, 7, 9])
    freedom = pd.Series([1, 2, 3], index=[5, 7, 9])
    assert is_same(quantiles.f_exceeded(column, freedom, 6.0), stats.f.isf(column, freedom, 6.0))
    assert is_same(quantiles.student_above(column, freedom), stats.t.sf(column, freedom))
    assert is_same(quantiles.normal_density(column), stats.norm.pdf(column))


@pytest.mark.parametrize("shape", [(), (7,), (61, 40)])
def test_densities_are_those_of_scipy_stats(shape):
    random = np.random.default_rng(0)
    value, mean = random.normal(0, 30, shape), random.normal(0, 5, shape)
    deviation = np.exp(random.normal(0, 3, shape))
    assert is_same(quantiles.normal_density(value), stats.norm.pdf(value))
    for ours, theirs in ((quantiles.normal_density, stats.norm.pdf), (quantiles.normal_log_density, stats.norm.logpdf)):
        assert is_same(ours(value, mean, deviation), theirs(value, mean, deviation))
        assert is_same(
            ours(value.T[..., ::2] if shape else value, 1.5, 0.3),
            theirs(value.T[..., ::2] if shape else value, 1.5, 0.3),
        )
