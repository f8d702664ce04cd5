"""A faster version of scikit-learn's Gaussian process, and a line with errors."""

import warnings
from typing import Any

import numpy as np
from scipy.linalg.lapack import dpotrf, dtrtri
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Hyperparameter, Matern, WhiteKernel
from sklearn.linear_model import LinearRegression

from millprint.config.yields import Choices, TrainingConfig
from millprint.predict.structured import Pairs


class _OneHyperparameter:
    """A kernel that names its only hyper-parameter.

    scikit-learn would look for it among all attributes of the kernel, several times at every step that maximises the
    marginal likelihood. That takes an eighth of the time of a fit.
    """

    varied: str

    @property
    def hyperparameters(self) -> list[Hyperparameter]:
        """The same list that scikit-learn finds."""
        return [getattr(self, f"hyperparameter_{self.varied}")]


class Factor(_OneHyperparameter, ConstantKernel):
    """The factor C of Eq. 5.5."""

    varied = "constant_value"


class Smoothness(_OneHyperparameter, Matern):
    """The Matern kernel of Eq. 5.6."""

    varied = "length_scale"


class Noise(_OneHyperparameter, WhiteKernel):
    """The variance of the noise."""

    varied = "noise_level"


class QuickProcess(GaussianProcessRegressor):
    """scikit-learn's process for the kernel Factor * Smoothness + Noise, with a quick marginal likelihood.

    scikit-learn's own differs by rounding alone. For some twenty rows, nearly all of its time goes into kernels that
    build and check themselves again at every step of the maximisation.
    """

    def log_marginal_likelihood(self, theta: Any = None, eval_gradient: bool = False, clone_kernel: bool = True) -> Any:
        """Eq. 5.10 and, on request, its gradient in theta: the logarithms of factor, length scales and noise."""
        if theta is None or not eval_gradient:
            return super().log_marginal_likelihood(theta, eval_gradient, clone_kernel)
        factor, scales, noise = np.exp(theta[0]), np.exp(-2 * theta[1:-1]), np.exp(theta[-1])
        squares, target = self._squares(), self.y_train_
        rows = len(target)
        scaled = squares * scales[:, None]
        root = np.sqrt(3 * scaled.sum(axis=0))
        decay = factor * np.exp(-root)
        smooth = (1 + root) * decay
        covariance = smooth.copy()
        covariance[:: rows + 1] += noise + self.alpha
        # LAPACK itself: what surrounds it in numpy and scipy takes longer than the twenty rows.
        lower, failed = dpotrf(covariance.reshape(rows, rows), lower=1, clean=1)
        if failed:
            return -np.inf, np.zeros_like(theta)
        half = dtrtri(lower, lower=1)[0]
        inverse = half.T @ half
        weights = inverse @ target
        value = -0.5 * target @ weights - np.log(lower.diagonal()).sum() - 0.5 * rows * np.log(2 * np.pi)
        slope = 0.5 * (weights[:, None] * weights - inverse)
        flat = slope.ravel()
        # d k / d ln l_j = 3 C exp(-r) d_j^2 / l_j^2, with r^2 = 3 sum_j d_j^2 / l_j^2.
        by_length = scaled @ (3 * decay * flat)
        return value, np.concatenate([[smooth @ flat], by_length, [noise * slope.trace()]])

    def _squares(self) -> np.ndarray:
        """Squared differences of the training rows in each feature, (k, n * n); their sum (1, n * n) for one length."""
        if getattr(self, "_rows", None) is not self.X_train_:
            self._rows = self.X_train_
            squares = Pairs.of(self.X_train_, self.X_train_).squares.reshape(self.X_train_.shape[1], -1)
            shared = len(self.kernel_.theta) == 3
            self._differences = squares.sum(axis=0, keepdims=True) if shared else squares
        return self._differences


class ManyStarts(QuickProcess):
    """A process that maximises the marginal likelihood from several starts, and keeps the largest.

    starts: (s, h) logarithms of the kernel's hyper-parameters. From a single start the maximisation may end in a local
    maximum. A search by cross-validation picks the start by its errors on a few rows; the marginal likelihood needs no
    rows held back.
    """

    kernel: Any
    optimizer: Any

    def __init__(self, kernel: Any = None, starts: Any = (), *, optimizer: Any = "fmin_l_bfgs_b") -> None:
        super().__init__(kernel, optimizer=optimizer)
        self.starts = starts

    def fit(self, X: np.ndarray, y: np.ndarray) -> "ManyStarts":
        """Fit on inputs (n, k) and a target (n,); without an optimizer, as the kernel is."""
        if self.optimizer is None:
            return super().fit(X, y)
        first, found = self.kernel, []
        for start in self.starts:
            self.kernel = first.clone_with_theta(np.asarray(start))
            super().fit(X, y)
            found.append((self.log_marginal_likelihood_value_, self.kernel_.theta))
        self.kernel, self.optimizer = first.clone_with_theta(max(found, key=lambda each: each[0])[1]), None
        super().fit(X, y)
        self.kernel, self.optimizer = first, "fmin_l_bfgs_b"
        return self


def gaussian_process_of_starts(columns: int, training: TrainingConfig) -> ManyStarts:
    """The process of Eqs 5.5 to 5.10 from starts that are drawn uniformly within Table 5.2; it is not fitted yet.

    columns: number of features.
    """
    kernel = gaussian_process({"constant": 1.0, "length_scale": 1.0, "noise": 1.0}, columns, training.choices).kernel
    generator, space = np.random.default_rng(training.seed), training.spaces.gpr
    lengths = len(kernel.theta) - 2
    starts = []
    for _ in range(training.kernel_starts):
        constant, length, noise = (
            generator.uniform(low, high) for low, high in (space.constant, space.length_scale, space.noise)
        )
        starts.append(np.log([constant, *[length] * lengths, noise]))
    return ManyStarts(kernel, starts)


def gaussian_process(parameters: dict[str, float], columns: int, choices: Choices) -> GaussianProcessRegressor:
    """A process of zero mean with the kernel C * Matern(nu = 1.5) + white noise, Eqs 5.5 to 5.10; it is not fitted yet.

    parameters: constant [pp2], length_scale [standard deviations] and noise [pp2], where the maximisation of the
    marginal likelihood starts; columns: number of features. The local maximum that is found depends on the start, so
    the search of Table 5.2 is a search for the start.
    """
    shared = choices.length_scales == "shared"
    lengths = parameters["length_scale"] if shared else np.full(columns, parameters["length_scale"])
    bounds = tuple(choices.kernel_bounds)
    kernel = Factor(parameters["constant"], bounds) * Smoothness(lengths, bounds, nu=1.5)
    return QuickProcess(kernel + Noise(parameters["noise"], bounds))


def fit_quietly(estimator: Any, inputs: np.ndarray, target: np.ndarray) -> Any:
    """Fit on inputs (n, k) and a target (n,) without the warning that a length scale has reached its bound.

    Such a fit is valid: with a length scale at its upper bound the kernel ignores a feature.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        return estimator.fit(inputs, target)


class LeastSquares(LinearRegression):
    """scikit-learn's least squares, with the covariance of its line."""

    def fit(self, X: np.ndarray, y: np.ndarray, sample_weight: None = None) -> "LeastSquares":
        """Fit on inputs (n, k) and a target (n,)."""
        super().fit(X, y)
        design = np.column_stack([np.ones(len(X)), X])
        errors = y - self.predict(X)
        self.covariance_ = np.linalg.pinv(design.T @ design) * (errors @ errors) / max(len(X) - design.shape[1], 1)
        return self

    def mean_deviation(self, inputs: np.ndarray) -> np.ndarray:
        """Standard deviation (m,) of the line at inputs (m, k), without the scatter of a measurement."""
        design = np.column_stack([np.ones(len(inputs)), inputs])
        return np.sqrt(np.einsum("ij,jk,ik->i", design, self.covariance_, design))
