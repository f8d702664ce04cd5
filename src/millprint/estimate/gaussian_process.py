"""Gaussian processes: covariances as sums of terms, their likelihood with its gradient, and what they predict.

A term is v f(d), with d^2 = sum_j (x_j - x_j')^2 / l_j^2 and f a shape, or v sum_j x_j x_j' where it is linear. The
parameters theta are logarithms: of variances v, of lengths l, and last of the variance of the noise
(Rasmussen, Williams, Gaussian Processes for Machine Learning, 2006).
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import groupby

import numpy as np
from scipy.linalg import cho_solve, cholesky, solve_triangular
from scipy.linalg.lapack import dpotrf, dtrtri
from scipy.spatial.distance import cdist


def _squared_exponential(squares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    value = np.exp(-0.5 * squares)
    return value, -0.5 * value


def _matern_3_2(squares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    root = np.sqrt(3.0 * squares)
    decay = np.exp(-root)
    return (1.0 + root) * decay, -1.5 * decay


def _matern_5_2(squares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    root = np.sqrt(5.0 * squares)
    decay, line = np.exp(-root), 1.0 + root
    return (line + root**2 / 3.0) * decay, -5.0 / 6.0 * line * decay


LINEAR = "linear"
# f and its derivative by d^2, both as functions of d^2.
SHAPES = {"squared exponential": _squared_exponential, "Matern 3/2": _matern_3_2, "Matern 5/2": _matern_5_2}


@dataclass(frozen=True)
class Kernel:
    """The terms of a covariance.

    shapes (t,): a name of SHAPES or LINEAR; variances (t,): the place in theta of each term's variance; lengths (t, k):
    that of its length of each input, -1 for an input that it does not depend on; of a linear term, any place from 0 on
    says that the input counts; constant: the variance of an unknown mean.
    """

    shapes: tuple[str, ...]
    variances: np.ndarray
    lengths: np.ndarray
    constant: float = 0.0

    @cached_property
    def runs(self) -> list[tuple[str, slice]]:
        """The shapes, each with the places of terms of it that follow each other."""
        groups = [(shape, len(list(group))) for shape, group in groupby(self.shapes)]
        ends = np.cumsum([count for _, count in groups]).tolist()
        return [(shape, slice(end - count, end)) for (shape, count), end in zip(groups, ends, strict=True)]

    @cached_property
    def scales(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Every length that an input is divided by: the input (u,), the place in theta (u,), and its terms (t, u)."""
        is_curved = np.array([shape != LINEAR for shape in self.shapes])[:, None]
        own = np.where(is_curved, self.lengths, -1)
        pairs = sorted({(j, int(place)) for row in own for j, place in enumerate(row) if place >= 0})
        inputs, places = np.array(pairs, dtype=int).reshape(-1, 2).T
        return inputs, places, (own[:, inputs] == places).astype(float)


@dataclass(frozen=True)
class Covariance:
    """The covariance without noise of a kernel with known parameters theta."""

    kernel: Kernel
    theta: np.ndarray

    def __call__(self, inputs: np.ndarray, others: np.ndarray | None = None) -> np.ndarray:
        """The covariance (n, m) of inputs (n, k) with others (m, k), or with themselves (n, n)."""
        others = inputs if others is None else others
        total = np.full((len(inputs), len(others)), self.kernel.constant)
        for shape, variance, places in self._terms():
            used = places >= 0
            if shape == LINEAR:
                total += variance * (inputs[:, used] @ others[:, used].T)
            else:
                lengths = np.exp(self.theta[places[used]])
                squares = cdist(inputs[:, used] / lengths, others[:, used] / lengths, "sqeuclidean")
                total += variance * SHAPES[shape](squares)[0]
        return total

    def diag(self, inputs: np.ndarray) -> np.ndarray:
        """The variances (n,) of inputs (n, k)."""
        total = np.full(len(inputs), self.kernel.constant)
        for shape, variance, places in self._terms():
            total += variance * ((inputs[:, places >= 0] ** 2).sum(axis=1) if shape == LINEAR else 1.0)
        return total

    def _terms(self) -> Iterable[tuple[str, float, np.ndarray]]:
        return zip(self.kernel.shapes, np.exp(self.theta[self.kernel.variances]), self.kernel.lengths, strict=True)


@dataclass(frozen=True)
class Likelihood:
    """The likelihood of theta for inputs (n, k) and a target of zero mean (n,), times a prior.

    known: the variance of each value in addition to the noise (n,) or one for all, at least a jitter; centres and
    precisions (p,): of independent normal priors of theta, a precision of 0 for none; one 0 for none at all.
    """

    kernel: Kernel
    inputs: np.ndarray
    target: np.ndarray
    known: np.ndarray | float
    centres: np.ndarray | float = 0.0
    precisions: np.ndarray | float = 0.0

    @cached_property
    def _places(self) -> np.ndarray:
        """The places in theta of every variance and every length (t + u,)."""
        return np.concatenate([self.kernel.variances, self.kernel.scales[1]])

    @cached_property
    def _squares(self) -> np.ndarray:
        """Squared differences (u, n * n) of the input of every length."""
        rows = self.inputs.T[self.kernel.scales[0]]
        return ((rows[:, :, None] - rows[:, None, :]) ** 2).reshape(len(rows), -1)

    @cached_property
    def _parts(self) -> tuple[np.ndarray, np.ndarray]:
        """The terms (t, n * n) for variances of 1, and their slopes by d^2; the linear ones stay as they are."""
        parts = np.zeros((2, len(self.kernel.shapes), len(self.target) ** 2))
        for place, shape in enumerate(self.kernel.shapes):
            if shape == LINEAR:
                own = self.inputs[:, self.kernel.lengths[place] >= 0]
                parts[0, place] = (own @ own.T).ravel()
        return parts[0], parts[1]

    def negative_log(self, theta: np.ndarray) -> tuple[float, np.ndarray]:
        """-log p(target | theta) - log p(theta), without what does not depend on theta in the prior, and its gradient.

        Infinite, without a slope, for a covariance that is not positive definite.
        """
        kernel, rows = self.kernel, len(self.target)
        _, places, members = kernel.scales
        scaled = self._squares * np.exp(-2 * theta[places])[:, None]
        (parts, slopes), variances, squares = self._parts, np.exp(theta[kernel.variances]), members @ scaled
        for shape, own in kernel.runs:
            if shape != LINEAR:
                parts[own], slopes[own] = SHAPES[shape](squares[own])
        covariance = variances @ parts + kernel.constant
        noise = math.exp(theta[-1])
        covariance[:: rows + 1] += noise + self.known
        # LAPACK is called directly: for some thirty rows, wrappers take longer than the factorisation.
        lower, failed = dpotrf(covariance.reshape(rows, rows), lower=1, clean=1, overwrite_a=1)
        if failed:
            return np.inf, np.zeros_like(theta)
        half = dtrtri(lower, lower=1)[0]
        inverse = half.T @ half
        weights = inverse @ self.target
        value = 0.5 * self.target @ weights + np.log(lower.diagonal()).sum() + 0.5 * rows * math.log(2 * math.pi)
        slope = 0.5 * (inverse - weights[:, None] * weights)
        flat = slope.ravel()
        by_term = (-2 * variances)[:, None] * ((slopes * flat) @ scaled.T)
        parts_of = np.concatenate([variances * (parts @ flat), (members * by_term).sum(axis=0)])
        found = np.bincount(self._places, parts_of, len(theta))
        found[-1] += noise * slope.trace()
        if np.ndim(self.precisions) == 0:
            return float(value), found
        pull = self.precisions * (theta - self.centres)
        return float(value + 0.5 * pull @ (theta - self.centres)), found + pull

    def maximise(
        self, starts: Sequence[np.ndarray] | np.ndarray, bounds: np.ndarray, steps: int | None = None
    ) -> tuple[np.ndarray, float]:
        """theta within bounds (p, 2) at the highest maximum that is reached from the starts, and negative_log there.

        steps: the most of each search; by default it goes on until it is done.
        """
        from scipy.optimize import minimize

        # One value and its gradient are kept, for less than scipy takes to keep them.
        known = lru_cache(1)(lambda theta: self.negative_log(np.frombuffer(theta)))
        search = {"jac": lambda theta: known(theta.tobytes())[1], "method": "L-BFGS-B", "bounds": bounds}
        search["options"] = {"maxiter": steps} if steps else {}
        found = [minimize(lambda theta: known(theta.tobytes())[0], start, **search) for start in starts]
        best = min(found, key=lambda each: each.fun)
        return best.x, float(best.fun)


@dataclass(frozen=True)
class Conditioned:
    """A process whose values are known at some inputs (algorithm 2.1).

    inputs (n, k); lower (n, n): the root of their covariance with noise; weights (n,).
    """

    covariance: Covariance
    inputs: np.ndarray
    lower: np.ndarray
    weights: np.ndarray

    @classmethod
    def fit(
        cls, covariance: Covariance, inputs: np.ndarray, values: np.ndarray, noise: np.ndarray | float
    ) -> "Conditioned":
        """From inputs (n, k), values about their mean (n,) and the variances of their noise, (n,) or one for all."""
        own = covariance(inputs)
        own[np.diag_indices_from(own)] += noise
        lower = cholesky(own, lower=True, overwrite_a=True)
        return cls(covariance, inputs, lower, cho_solve((lower, True), values))

    def mean(self, inputs: np.ndarray) -> np.ndarray:
        """Values (m,) at inputs (m, k), Eq. 2.25."""
        return self.covariance(inputs, self.inputs) @ self.weights

    def with_deviation(self, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values (m,) at inputs (m, k), and their standard deviations (m,) without noise, Eq. 2.26."""
        mean, known = self._told(inputs)
        variance = self.covariance.diag(inputs) - np.einsum("ij,ji->i", known.T, known)
        return mean, np.sqrt(np.maximum(variance, 0.0))

    def with_covariance(self, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values (m,) at inputs (m, k), and their covariance (m, m) without noise."""
        mean, known = self._told(inputs)
        return mean, self.covariance(inputs) - known.T @ known

    def _told(self, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values (m,), and the covariance with the known inputs, whitened (n, m)."""
        shared = self.covariance(inputs, self.inputs)
        return shared @ self.weights, solve_triangular(self.lower, shared.T, lower=True)

    def inverse(self) -> "Inverse":
        """The inverse of the covariance of the known values, noise included."""
        root, failed = dtrtri(self.lower, lower=1)
        if failed:
            raise np.linalg.LinAlgError(f"the covariance of {len(self.lower)} values cannot be inverted")
        return Inverse(root)

    def left_out(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard deviation (n,) of each known value given the others, noise included, Eq. 5.12.

        y_i - [K^-1 y]_i / [K^-1]_ii and [K^-1]_ii^(-1/2); theta is that of all. values: (n,), as for `fit`.
        """
        own = (self.inverse().root ** 2).sum(axis=0)
        return values - self.weights / own, 1 / np.sqrt(own)


@dataclass(frozen=True)
class Inverse:
    """The inverse R^T R of a covariance, from R, the inverse (n, n) of its lower Cholesky factor."""

    root: np.ndarray

    def times(self, vector: np.ndarray) -> np.ndarray:
        """The inverse times a vector (n,)."""
        return self.root.T @ (self.root @ vector)

    def block(self, places: np.ndarray) -> np.ndarray:
        """Its rows and columns at some places (j, j)."""
        own = self.root[:, places]
        return own.T @ own
