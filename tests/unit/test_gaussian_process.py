"""The Gaussian process that every part of the library shares, against scikit-learn's and densities of scipy."""

import numpy as np
import pytest
from scipy.optimize import approx_fprime
from scipy.stats import multivariate_normal
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, DotProduct, Matern, WhiteKernel

from millprint.estimate.gaussian_process import LINEAR, SHAPES, Conditioned, Covariance, Kernel, Likelihood

# The same shapes by another library.
OTHERS = {
    "squared exponential": lambda lengths: RBF(lengths),
    "Matern 3/2": lambda lengths: Matern(lengths, nu=1.5),
    "Matern 5/2": lambda lengths: Matern(lengths, nu=2.5),
}
RNG = np.random.default_rng(5)
INPUTS, TARGET, NEW = RNG.normal(size=(12, 3)), RNG.normal(size=12), RNG.normal(size=(4, 3))
# A curve of two inputs, with one length for both; a curve of all, with lengths of their own; a line in the last.
LENGTHS = np.array([[2, 2, -1], [3, 4, 5], [-1, -1, 0]])
THETA = np.log([1.3, 0.4, 0.9, 1.6, 0.7, 2.2, 0.05])


def kernel_of(shape: str) -> Kernel:
    return Kernel((shape, shape, LINEAR), np.array([0, 1, 0]), LENGTHS, constant=0.3)


def other_kernel(shape: str, inputs: np.ndarray, others: np.ndarray) -> np.ndarray:
    own, lengths = OTHERS[shape], np.exp(THETA)[2:6]
    first = 1.3 * own(lengths[:1].repeat(2))(inputs[:, :2], others[:, :2])
    line = 1.3 * DotProduct(sigma_0=0)(inputs[:, 2:], others[:, 2:])
    return first + 0.4 * own(lengths[1:])(inputs, others) + line + 0.3


@pytest.mark.parametrize("shape", SHAPES)
def test_a_covariance_is_the_sum_of_its_terms(shape):
    covariance = Covariance(kernel_of(shape), THETA)
    np.testing.assert_allclose(covariance(INPUTS, NEW), other_kernel(shape, INPUTS, NEW), rtol=1e-12)
    np.testing.assert_allclose(covariance.diag(NEW), np.diag(other_kernel(shape, NEW, NEW)), rtol=1e-12)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_likelihood_is_the_normal_density_times_the_prior_and_has_its_slope(shape):
    centres, precisions = np.linspace(-1, 1, 7), np.array([0.0, 1.0, 2.0, 0.0, 4.0, 0.5, 1.0])
    likelihood = Likelihood(kernel_of(shape), INPUTS, TARGET, 0.01, centres, precisions)
    covariance = other_kernel(shape, INPUTS, INPUTS) + 0.06 * np.eye(12)
    prior = 0.5 * (precisions * (THETA - centres) ** 2).sum()
    value, slope = likelihood.negative_log(THETA)
    assert value == pytest.approx(prior - multivariate_normal(cov=covariance).logpdf(TARGET), rel=1e-10)
    numerical = approx_fprime(THETA, lambda theta: likelihood.negative_log(theta)[0], 1e-6)
    np.testing.assert_allclose(slope, numerical, rtol=1e-4, atol=1e-4)


def test_a_maximum_and_what_it_predicts_are_those_of_scikit_learn():
    start, bounds = np.log([1.0, 1.0, 1.0, 1.0, 0.1]), np.log([[0.01, 100.0]] * 4 + [[1e-4, 1.0]])
    target = np.sin(INPUTS[:, 0]) + 0.3 * INPUTS[:, 1] - 0.2 * INPUTS[:, 2] ** 2 + 0.2 * TARGET
    kernel = Kernel(("Matern 5/2",), np.array([0]), np.array([[1, 2, 3]]))
    likelihood = Likelihood(kernel, INPUTS, target, 1e-8)
    theta, value = likelihood.maximise([start], bounds)
    # After a single step, searches from several starts have come to different heights: the highest counts.
    starts = [start - 1.0, start, start + 1.0]
    singles = [likelihood.maximise([each], bounds, 1)[1] for each in starts]
    assert likelihood.maximise(starts, bounds, 1)[1] == min(singles) < max(singles)
    ends = [tuple(each) for each in np.exp(bounds)]
    other = ConstantKernel(1.0, ends[0]) * Matern(np.ones(3), ends[1:4], nu=2.5) + WhiteKernel(0.1, ends[4])
    plain = GaussianProcessRegressor(other, alpha=1e-8).fit(INPUTS, target)
    np.testing.assert_allclose(theta, plain.kernel_.theta, atol=1e-4)
    assert value == pytest.approx(-plain.log_marginal_likelihood_value_, abs=1e-6)
    known = Conditioned.fit(Covariance(kernel, theta), INPUTS, target, np.exp(theta[-1]) + 1e-8)
    mean, covariance = plain.predict(NEW, return_cov=True)
    np.testing.assert_allclose(known.with_covariance(NEW)[0], mean, atol=1e-4)
    np.testing.assert_allclose(known.with_covariance(NEW)[1] + np.exp(theta[-1]) * np.eye(4), covariance, atol=1e-4)
    np.testing.assert_allclose(known.with_deviation(NEW)[1] ** 2, np.diag(known.with_covariance(NEW)[1]), atol=1e-9)


def test_each_value_is_left_out_in_closed_form_as_if_it_had_never_been_known():
    covariance = Covariance(kernel_of("Matern 3/2"), THETA)
    means, deviations = Conditioned.fit(covariance, INPUTS, TARGET, 0.05).left_out(TARGET)
    for place in (0, 7):
        kept = np.arange(12) != place
        rest = Conditioned.fit(covariance, INPUTS[kept], TARGET[kept], 0.05)
        mean, deviation = rest.with_deviation(INPUTS[[place]])
        assert means[place] == pytest.approx(mean[0], rel=1e-8)
        assert deviations[place] == pytest.approx(np.sqrt(deviation[0] ** 2 + 0.05), rel=1e-8)


def test_a_covariance_that_is_not_positive_definite_has_no_likelihood():
    twice = np.vstack([INPUTS, INPUTS])
    likelihood = Likelihood(kernel_of("Matern 5/2"), twice, np.tile(TARGET, 2), -0.1)
    assert likelihood.negative_log(np.append(THETA[:-1], -30.0))[0] == np.inf
