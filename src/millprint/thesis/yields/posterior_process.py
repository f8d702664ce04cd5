"""Gaussian processes with sums of kernels, fitted by the posterior of their hyper-parameters; and their evidence."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from millprint.config.yields import INPUTS, Priors
from millprint.estimate.gaussian_process import LINEAR, Conditioned, Covariance, Kernel, Likelihood

# Variance of the unknown mean, for a target of unit variance: large, but finite so that the evidence is defined.
MEAN_VARIANCE = 4.0
JITTER = 1e-9
# Bounds of the log hyper-parameters, in standard deviations of their prior from its median.
REACH = 4.0
# Step of the central differences of the gradient.
STEP = 1e-4


def kernel_of(structure: str) -> Kernel:
    """The kernel of a structure; theta: logarithms of length scales, which all terms share, variances, and the noise.

    product: one term over all inputs. mains_product: one for each input, and the product. time_product: time, and the
    product, which are the two steps of thesis Sec. 5.2.5 in one model. trend_product: a straight line in each input,
    and the product. Raises KeyError for an unknown structure.
    """
    count = len(INPUTS)
    mains, everything = np.eye(count), np.ones((1, count))
    factors = {
        "product": everything,
        "mains_product": np.vstack([mains, everything]),
        "time_product": np.vstack([mains[[INPUTS.index("time_h")]], everything]),
        "trend_product": np.vstack([mains, everything]),
    }[structure]
    shapes = ["squared exponential"] * len(factors)
    if structure == "trend_product":
        shapes[:count] = [LINEAR] * count
    lengths = np.where(factors > 0, np.arange(count), -1)
    return Kernel(tuple(shapes), count + np.arange(len(factors)), lengths, MEAN_VARIANCE)


def prior_of(kernel: Kernel, priors: Priors) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard deviation of the normal prior of theta: length scales, variances, noise."""
    terms, inputs = kernel.lengths.shape
    counts = ((priors.length_scale, inputs), (priors.variance, terms), (priors.noise, 1))
    mean = np.concatenate([np.full(count, np.log(prior.median)) for prior, count in counts])
    return mean, np.concatenate([np.full(count, prior.log_deviation) for prior, count in counts])


def posterior_of(inputs: np.ndarray, target: np.ndarray, kernel: Kernel, priors: Priors) -> Likelihood:
    """The posterior of theta, thesis Eq. 5.10 with a prior, for standardised inputs (n, k) and target (n,)."""
    centre, width = prior_of(kernel, priors)
    return Likelihood(kernel, inputs, target, JITTER, centre, width**-2.0)


def log_evidence(posterior: Likelihood, theta: np.ndarray, value: float) -> float:
    """Laplace's approximation of log p(z): log p(z | theta) p(theta) + d/2 log 2 pi - 1/2 log |H|, H the Hessian.

    theta: the maximum; value: of `posterior.negative_log` there, which lacks the constants of the prior. H is the
    central difference of the gradient. In a direction that the data do not determine, its curvature is the precision of
    the prior. A curvature below a tenth of the smallest precision comes from rounding or from a bound, and is set to
    that tenth.
    """
    count = len(theta)
    hessian = np.empty((count, count))
    for index, step in enumerate(STEP * np.eye(count)):
        ahead, behind = posterior.negative_log(theta + step)[1], posterior.negative_log(theta - step)[1]
        hessian[index] = (ahead - behind) / (2 * STEP)
    curvatures = np.maximum(np.linalg.eigvalsh((hessian + hessian.T) / 2), 0.1 * np.min(posterior.precisions))
    # The d/2 log 2 pi of the approximation and of the prior cancel.
    return float(-value + 0.5 * np.log(posterior.precisions).sum() - 0.5 * np.log(curvatures).sum())


@dataclass(frozen=True)
class Process:
    """A Gaussian process conditioned on scaled inputs (n, k) and a standardised target (n,); logs: its theta."""

    kernel: Kernel
    logs: np.ndarray
    inputs: np.ndarray
    target: np.ndarray

    @cached_property
    def _known(self) -> Conditioned:
        return Conditioned.fit(Covariance(self.kernel, self.logs), self.inputs, self.target, self.noise + JITTER)

    @property
    def noise(self) -> float:
        """Variance of the noise."""
        return float(np.exp(self.logs[-1]))

    def posterior(self, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean (m,) and covariance (m, m) of the target without noise at scaled inputs (m, k), Eqs 5.8 and 5.9."""
        return self._known.with_covariance(right)

    def predict(self, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard deviation, (m,) each, of a measurement with noise at scaled inputs (m, k)."""
        mean, deviation = self._known.with_deviation(right)
        return mean, np.sqrt(deviation**2 + self.noise)

    def left_out(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard deviation (n,) of each row given the others; the hyper-parameters are those of all rows."""
        return self._known.left_out(self.target)


def fit_process(inputs: np.ndarray, target: np.ndarray, kernel: Kernel, priors: Priors) -> tuple[Process, float]:
    """The process at the maximum of the posterior, searched from the medians of the prior, and its log evidence.

    inputs: (n, k) standardised; target: (n,) standardised.
    """
    centre, width = prior_of(kernel, priors)
    posterior = posterior_of(inputs, target, kernel, priors)
    bounds = np.stack([centre - REACH * width, centre + REACH * width], axis=1)
    theta, value = posterior.maximise([centre], bounds)
    return Process(kernel, theta, inputs, target), log_evidence(posterior, theta, value)
