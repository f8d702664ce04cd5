"""The covariance of many conditions from a few of them, chosen so that what is left out is small against the noise.

The covariance K (n, n) of a smooth process is nearly of low rank. A Cholesky factorisation that takes the condition of
largest remaining variance next stops once no condition has more than LEFT_OUT of the noise's variance left:
    K = V^T V + E, V (m, n), E positive semidefinite with a diagonal d of at most LEFT_OUT times the noise
(Harbrecht, Peters, Schneider, Applied Numerical Mathematics 62 (2012) 428). The remainder d is added to the noise, so
that intervals hold it (Snelson, Ghahramani, Adv. Neural Inf. Process. Syst. 18 (2006) 1257). Time grows with n m^2, not
with n^3.
"""

import math
from dataclasses import dataclass
from functools import reduce

import numpy as np
from scipy.linalg import cho_solve, cholesky, get_lapack_funcs, solve_triangular
from scipy.spatial.distance import cdist, pdist, squareform

# Above this number of conditions the process is reduced; the thesis's fingerprints have fewer.
WHOLE_MAX = 500
# The largest part of a condition's variance that may be left out, over the noise variance [-]; and the largest number
# of conditions taken.
LEFT_OUT, TAKEN_MAX = 1e-5, 2000
TRIANGLES = ("corner", "lower")


@dataclass(frozen=True)
class Covariance:
    """A sum of Matern 5/2 processes: with r the distance over the lengths, v (1 + sqrt5 r + 5 r^2 / 3) exp(-sqrt5 r).

    variances v (c,) of the components, and lengths (c, k) of every input in each. As sklearn's kernel with these
    parameters, to the last digit: a fit needs that one, and a prediction need not wait a second for its import.
    """

    variances: np.ndarray
    lengths: np.ndarray

    @classmethod
    def of(cls, theta: np.ndarray, components: int) -> "Covariance":
        """From sklearn's parameters of a sum of components: the logarithms of a variance and k lengths of each."""
        rows = theta.reshape(components, -1)
        return cls(np.array([np.exp(row[0]) for row in rows]), np.array([np.exp(row[1:]) for row in rows]))

    def __call__(self, inputs: np.ndarray, others: np.ndarray | None = None) -> np.ndarray:
        """The covariance (n, m) of inputs (n, k) with others (m, k), or with themselves (n, n)."""
        parts = []
        for variance, lengths in zip(self.variances, self.lengths, strict=True):
            scaled = inputs / lengths
            apart = math.sqrt(5) * (pdist(scaled) if others is None else cdist(scaled, others / lengths))
            part = (1.0 + apart + apart**2 / 3.0) * np.exp(-apart)
            if others is None:
                part = squareform(part)
                np.fill_diagonal(part, 1)
            parts.append(variance * part)
        return reduce(np.add, parts)

    def diag(self, inputs: np.ndarray) -> np.ndarray:
        """The variances (n,) of inputs (n, k)."""
        return np.full(len(inputs), reduce(np.add, self.variances))


@dataclass(frozen=True)
class Reduced:
    """A process of n conditions, reduced to m of them.

    taken: the chosen inputs (m, k); corner (m, m): the lower triangle whose square is their covariance; factor (m, n):
    V; noise (n,): variances with what is left out; lower (m, m): the root of 1 + V noise^-1 V^T; weights (m,).
    """

    kernel: Covariance
    taken: np.ndarray
    corner: np.ndarray
    factor: np.ndarray
    noise: np.ndarray
    lower: np.ndarray
    weights: np.ndarray

    @classmethod
    def fit(cls, kernel: Covariance, inputs: np.ndarray, values: np.ndarray, noise: np.ndarray) -> "Reduced":
        """From inputs (n, k), values about their mean (n,) and the variances of their noise (n,)."""
        factor, order, left = pivoted(kernel, inputs, LEFT_OUT * float(noise.min()))
        total = noise + left
        scaled = factor / np.sqrt(total)
        lower = cholesky(np.eye(len(order)) + scaled @ scaled.T, lower=True)
        weights = solve_triangular(lower, factor @ (values / total), lower=True)
        return cls(kernel, inputs[order], factor[:, order].T, factor, total, lower, weights)

    def mean(self, inputs: np.ndarray) -> np.ndarray:
        """Values (j,) at inputs (j, k)."""
        return self._told(inputs)[0]

    def with_deviation(self, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values (j,) at inputs (j, k), and their standard deviations (j,) without noise."""
        mean, known, told = self._told(inputs)
        variance = self.kernel.diag(inputs) - (known**2).sum(axis=0) + (told**2).sum(axis=0)
        return mean, np.sqrt(np.maximum(variance, 0.0))

    def with_covariance(self, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values (j,) at inputs (j, k), and their covariance (j, j) without noise."""
        mean, known, told = self._told(inputs)
        return mean, self.kernel(inputs) - known.T @ known + told.T @ told

    def _told(self, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Values (j,), and the covariance with the conditions taken, whitened without noise and with noise (m, j)."""
        known = solve_triangular(self.corner, self.kernel(self.taken, inputs), lower=True)
        told = solve_triangular(self.lower, known, lower=True)
        return self.weights @ told, known, told

    def to_dict(self) -> dict:
        """What predictions need, as plain values; triangles row by row, without what is above the diagonal."""
        rows = {name: [own[: k + 1].tolist() for k, own in enumerate(getattr(self, name))] for name in TRIANGLES}
        return {"taken": self.taken.tolist(), "weights": self.weights.tolist(), **rows}

    def inverse(self) -> "ReducedInverse":
        """The inverse of the covariance of all values, noise included."""
        return ReducedInverse(1 / self.noise, solve_triangular(self.lower, self.factor / self.noise, lower=True))


def pivoted(kernel: Covariance, inputs: np.ndarray, enough: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """V (m, n), the places of the conditions taken (m,), and the variance that each condition has left (n,).

    enough: the largest variance that may be left; with TAKEN_MAX conditions taken, more may be.
    """
    left = kernel.diag(inputs).copy()
    rows = np.empty((min(TAKEN_MAX, len(inputs)), len(inputs)))
    order: list[int] = []
    while len(order) < len(rows) and left.max() > enough:
        place, done = int(left.argmax()), len(order)
        row = kernel(inputs[place : place + 1], inputs)[0] - rows[:done, place] @ rows[:done]
        rows[done] = row / np.sqrt(left[place])
        # Exactly zero for the conditions taken before, so that rounding leaves no trace in the corner.
        rows[done, order] = 0.0
        left = np.maximum(left - rows[done] ** 2, 0.0)
        order.append(place)
        left[order] = 0.0
    return rows[: len(order)].copy(), np.array(order), left


@dataclass(frozen=True)
class Whole:
    """A process of all its conditions, with the methods of Reduced (Rasmussen, Williams, 2006, algorithm 2.1).

    inputs (n, k); lower (n, n): the root of their covariance with noise; weights (n,).
    """

    kernel: Covariance
    inputs: np.ndarray
    lower: np.ndarray
    weights: np.ndarray

    @classmethod
    def fit(cls, kernel: Covariance, inputs: np.ndarray, values: np.ndarray, noise: np.ndarray) -> "Whole":
        """From inputs (n, k), values about their mean (n,) and the variances of their noise (n,)."""
        covariance = kernel(inputs)
        covariance[np.diag_indices_from(covariance)] += noise
        lower = cholesky(covariance, lower=True)
        return cls(kernel, inputs, lower, cho_solve((lower, True), values))

    def mean(self, inputs: np.ndarray) -> np.ndarray:
        """Values (j,) at inputs (j, k)."""
        return self.kernel(inputs, self.inputs) @ self.weights

    def with_deviation(self, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values (j,) at inputs (j, k), and their standard deviations (j,) without noise."""
        mean, known = self._told(inputs)
        variance = self.kernel.diag(inputs) - np.einsum("ij,ji->i", known.T, known)
        return mean, np.sqrt(np.maximum(variance, 0.0))

    def with_covariance(self, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values (j,) at inputs (j, k), and their covariance (j, j) without noise."""
        mean, known = self._told(inputs)
        return mean, self.kernel(inputs) - known.T @ known

    def _told(self, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values (j,), and the covariance with the known conditions, whitened (n, j)."""
        shared = self.kernel(inputs, self.inputs)
        return shared @ self.weights, solve_triangular(self.lower, shared.T, lower=True)


@dataclass(frozen=True)
class ReducedInverse:
    """diag(precision) - W^T W, with precision (n,) and W (m, n)."""

    precision: np.ndarray
    root: np.ndarray

    def times(self, vector: np.ndarray) -> np.ndarray:
        """The inverse times a vector (n,)."""
        return self.precision * vector - self.root.T @ (self.root @ vector)

    def block(self, places: np.ndarray) -> np.ndarray:
        """Its rows and columns at some places (j, j)."""
        own = self.root[:, places]
        return np.diag(self.precision[places]) - own.T @ own


@dataclass(frozen=True)
class WholeInverse:
    """The inverse R^T R of a covariance, from R, the inverse (n, n) of its lower Cholesky factor."""

    root: np.ndarray

    @classmethod
    def of(cls, covariance: np.ndarray) -> "WholeInverse":
        """From a covariance (n, n), which is overwritten; inverts its triangular factor, in a third of the steps."""
        lower = cholesky(covariance, lower=True, overwrite_a=True)
        (invert,) = get_lapack_funcs(("trtri",), (lower,))
        root, failed = invert(lower, lower=1, overwrite_c=1)
        if failed:
            raise np.linalg.LinAlgError(f"the covariance of {len(lower)} conditions cannot be inverted")
        return cls(root)

    def times(self, vector: np.ndarray) -> np.ndarray:
        """The inverse times a vector (n,)."""
        return self.root.T @ (self.root @ vector)

    def block(self, places: np.ndarray) -> np.ndarray:
        """Its rows and columns at some places (j, j)."""
        own = self.root[:, places]
        return own.T @ own
