"""Gaussian processes with sums of kernels, fitted by the posterior of their hyper-parameters; and their evidence."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import cho_solve
from scipy.linalg.lapack import dpotrs
from scipy.optimize import minimize

from millprint.config.yields import INPUTS, Priors

# Variance of the unknown mean, for a target of unit variance: large, but finite so that the evidence is defined.
MEAN_VARIANCE = 4.0
JITTER = 1e-9
# Bounds of the log hyper-parameters, in standard deviations of their prior from its median.
REACH = 4.0
# Step of the central differences of the gradient.
STEP = 1e-4


@dataclass(frozen=True)
class Terms:
    """Which inputs each term of a kernel multiplies, (terms, inputs) of ones and zeros, and which terms are linear."""

    factors: np.ndarray
    linear: np.ndarray


def terms_of(structure: str) -> Terms:
    """The terms of a structure.

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
    linear = np.zeros(len(factors), dtype=bool)
    if structure == "trend_product":
        linear[:count] = True
    return Terms(factors, linear)


@dataclass(frozen=True)
class Pairs:
    """Squared differences and products of the inputs of two sets of rows, (k, n, m) each."""

    squares: np.ndarray
    products: np.ndarray

    @classmethod
    def of(cls, left: np.ndarray, right: np.ndarray) -> "Pairs":
        """The pairs of inputs (n, k) with inputs (m, k)."""
        squares = (left[:, None, :] - right[None, :, :]) ** 2
        return cls(np.moveaxis(squares, 2, 0), np.moveaxis(left[:, None, :] * right[None, :, :], 2, 0))

    @classmethod
    def with_itself(cls, rows: np.ndarray) -> "Pairs":
        """Each row of inputs (m, k) paired only with itself, (k, m, 1)."""
        squared = (rows**2).T[:, :, None]
        return cls(np.zeros_like(squared), squared)


def prior_of(terms: Terms, priors: Priors) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard deviation of the normal prior of the log hyper-parameters: length scales, variances, noise."""
    counts = ((priors.length_scale, terms.factors.shape[1]), (priors.variance, len(terms.factors)), (priors.noise, 1))
    mean = np.concatenate([np.full(count, np.log(prior.median)) for prior, count in counts])
    return mean, np.concatenate([np.full(count, prior.log_deviation) for prior, count in counts])


def covariance_terms(logs: np.ndarray, terms: Terms, pairs: Pairs) -> tuple[np.ndarray, np.ndarray]:
    """Covariance of each term, (terms, n, m), and d_j^2 / l_j^2, (k, n, m), for log hyper-parameters `logs`.

    The covariance is v_t exp(-1/2 sum_{j in t} d_j^2 / l_j^2), or v_t x_j x_j' for a linear term.
    """
    count = terms.factors.shape[1]
    scaled = pairs.squares * np.exp(-2 * logs[:count])[:, None, None]
    parts = np.exp(-0.5 * np.tensordot(terms.factors, scaled, axes=1))
    parts[terms.linear] = np.tensordot(terms.factors[terms.linear], pairs.products, axes=1)
    return np.exp(logs[count:-1])[:, None, None] * parts, scaled


@dataclass(frozen=True)
class Posterior:
    """The posterior of the hyper-parameters theta of a process.

    terms, pairs: of the kernel and of the rows with themselves; target: (n,) standardised; prior: mean and deviation
    of theta, the logarithms of length scales, variances and noise.
    """

    terms: Terms
    pairs: Pairs
    target: np.ndarray
    prior: tuple[np.ndarray, np.ndarray]

    @cached_property
    def _squares(self) -> np.ndarray:
        """Squared differences of the rows, (k, n * n)."""
        return self.pairs.squares.reshape(len(self.pairs.squares), -1)

    @cached_property
    def _straight(self) -> np.ndarray:
        """The linear terms for a variance of 1, (linear terms, n * n): they do not depend on theta."""
        linear = self.terms.factors[self.terms.linear]
        return np.dot(linear, self.pairs.products.reshape(len(self.pairs.products), -1))

    @cached_property
    def _constants(self) -> tuple[float, float, float]:
        """What the value holds that does not depend on theta."""
        width, whole = self.prior[1], np.log(2 * np.pi)
        return 0.5 * len(self.target) * whole, np.log(width).sum(), 0.5 * len(width) * whole

    @cached_property
    def _curved(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions of the terms that are not linear, and all factors (terms, k) with those of linear terms at 0."""
        return np.flatnonzero(~self.terms.linear), self.terms.factors * ~self.terms.linear[:, None]

    @cached_property
    def _unit(self) -> np.ndarray:
        """The unit matrix (n, n)."""
        return np.eye(len(self.target))

    def negative_log(self, logs: np.ndarray) -> tuple[float, np.ndarray]:
        """-log p(z | theta) p(theta), thesis Eq. 5.10 with a prior, and its gradient in theta.

        The covariance is that of `covariance_terms`; what does not depend on theta is kept from call to call.
        """
        factors, target, (centre, width) = self.terms.factors, self.target, self.prior
        (count, rows), (positions, curved) = (factors.shape[1], len(target)), self._curved
        scaled = self._squares * np.exp(-2 * logs[:count])[:, None]
        parts = -0.5 * np.dot(factors, scaled)
        parts[positions] = np.exp(parts[positions])
        if len(self._straight):
            parts[self.terms.linear] = self._straight
        parts = np.exp(logs[count:-1])[:, None] * parts
        noise = np.exp(logs[-1])
        covariance = parts.sum(axis=0) + MEAN_VARIANCE
        covariance[:: rows + 1] += noise + JITTER
        factor = np.linalg.cholesky(covariance.reshape(rows, rows))
        # LAPACK is called directly: for some thirty rows, the wrappers of scipy take longer than the factorisation.
        inverse = dpotrs(factor, self._unit, lower=1)[0]
        weights = inverse @ target
        off = (logs - centre) / width
        of_rows, of_widths, of_logs = self._constants
        value = 0.5 * target @ weights + np.log(factor.diagonal()).sum() + of_rows
        value += 0.5 * off @ off + of_widths + of_logs
        slope = inverse - weights[:, None] * weights
        shares = 0.5 * parts * slope.ravel()
        by_length = (curved * (shares @ scaled.T)).sum(axis=0)
        by_noise = 0.5 * noise * slope.trace()
        return float(value), np.concatenate([by_length, shares.sum(axis=1), [by_noise]]) + off / width

    def log_evidence(self, logs: np.ndarray, value: float) -> float:
        """Laplace's approximation of log p(z): -value + d/2 log 2 pi - 1/2 log |H|, H the Hessian at the maximum.

        logs: the maximum; value: of negative_log there. H is the central difference of the gradient. In a direction
        that the data do not determine, its curvature is the precision of the prior. A curvature below a tenth of the
        smallest precision comes from rounding or from a bound, and is set to that tenth. Raises LinAlgError for a
        covariance that is not positive definite.
        """
        count = len(logs)
        hessian = np.empty((count, count))
        for index, step in enumerate(STEP * np.eye(count)):
            ahead, behind = self.negative_log(logs + step)[1], self.negative_log(logs - step)[1]
            hessian[index] = (ahead - behind) / (2 * STEP)
        curvatures = np.linalg.eigvalsh((hessian + hessian.T) / 2)
        floor = 0.1 / np.max(self.prior[1]) ** 2
        return float(-value + 0.5 * count * np.log(2 * np.pi) - 0.5 * np.log(np.maximum(curvatures, floor)).sum())


@dataclass(frozen=True)
class Process:
    """A Gaussian process conditioned on scaled inputs (n, k) and a standardised target (n,)."""

    terms: Terms
    logs: np.ndarray
    inputs: np.ndarray
    target: np.ndarray

    def _prior_covariance(self, pairs: Pairs) -> np.ndarray:
        return covariance_terms(self.logs, self.terms, pairs)[0].sum(axis=0) + MEAN_VARIANCE

    def _covariance(self, right: np.ndarray) -> np.ndarray:
        return self._prior_covariance(Pairs.of(self.inputs, right))

    def _factor(self) -> np.ndarray:
        noise = (np.exp(self.logs[-1]) + JITTER) * np.eye(len(self.target))
        return np.linalg.cholesky(self._covariance(self.inputs) + noise)

    @property
    def noise(self) -> float:
        """Variance of the noise."""
        return float(np.exp(self.logs[-1]))

    def posterior(self, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean (m,) and covariance (m, m) of the target without noise at scaled inputs (m, k), Eqs 5.8 and 5.9."""
        cross, solved = self._solved(right)
        own = self._prior_covariance(Pairs.of(right, right))
        return solved.T @ self.target, own - cross.T @ solved

    def predict(self, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard deviation, (m,) each, of a measurement with noise at scaled inputs (m, k)."""
        cross, solved = self._solved(right)
        # Only the diagonal: the whole covariance of a few thousand rows takes seconds.
        variance = self._prior_covariance(Pairs.with_itself(right))[:, 0] - (cross * solved).sum(axis=0)
        return solved.T @ self.target, np.sqrt(np.maximum(variance, 0) + self.noise)

    def _solved(self, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Covariance (n, m) of the training rows with others, and K^-1 times it."""
        cross = self._covariance(right)
        return cross, cho_solve((self._factor(), True), cross)

    def left_out(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard deviation of each row given the others: z - [K^-1 z]_i / [K^-1]_ii and [K^-1]_ii^(-1/2).

        Rasmussen and Williams (2006), Eq. 5.12; the hyper-parameters are those of all rows.
        """
        inverse = cho_solve((self._factor(), True), np.eye(len(self.target)))
        return self.target - (inverse @ self.target) / np.diag(inverse), 1 / np.sqrt(np.diag(inverse))


def fit_process(inputs: np.ndarray, target: np.ndarray, terms: Terms, priors: Priors) -> tuple[Process, float]:
    """The process at the maximum of the posterior, searched from the medians of the prior, and its log evidence.

    inputs: (n, k) standardised; target: (n,) standardised.
    """
    centre, width = prior_of(terms, priors)
    posterior = Posterior(terms, Pairs.of(inputs, inputs), target, (centre, width))
    bounds = np.stack([centre - REACH * width, centre + REACH * width], axis=1)
    found = minimize(posterior.negative_log, centre, jac=True, method="L-BFGS-B", bounds=bounds)
    return Process(terms, found.x, inputs, target), posterior.log_evidence(found.x, float(found.fun))
