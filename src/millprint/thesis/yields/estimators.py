"""Estimators: the Gaussian process of thesis Eqs 5.5 to 5.10, a line with errors, and random forests that share trees.

For some twenty rows, RandomForestRegressor spends nearly all of its time around each tree. The trees here are the same,
to the last bit: each has the seed and the bootstrap that RandomForestRegressor gives it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dpotrf, dtrtri
from scipy.optimize import minimize
from sklearn import config_context
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Kernel, Matern, WhiteKernel
from sklearn.linear_model import LinearRegression
from sklearn.tree import DecisionTreeRegressor
from xgboost import QuantileDMatrix, XGBRegressor, train

from millprint.config.yields import Choices, TrainingConfig
from millprint.thesis.yields.posterior_process import Pairs

# Added to the variance of each row, in the units of the target squared, as scikit-learn does by default.
JITTER = 1e-10


@dataclass(frozen=True)
class MarginalLikelihood:
    """The marginal likelihood, Eq. 5.10, of the kernel C * Matern(nu = 1.5) + noise.

    squares: squared differences of the rows in each feature (k, n * n), or their sum (1, n * n) for one length scale;
    target: (n,). scikit-learn's own differs only by rounding; for some twenty rows, it spends nearly all of its time in
    kernels that build and check themselves again at every step.
    """

    squares: np.ndarray
    target: np.ndarray

    @classmethod
    def of(cls, inputs: np.ndarray, target: np.ndarray, shared: bool) -> "MarginalLikelihood":
        """For inputs (n, k) and a target (n,); shared: whether all features have one length scale."""
        squares = Pairs.of(inputs, inputs).squares.reshape(inputs.shape[1], -1)
        return cls(squares.sum(axis=0, keepdims=True) if shared else squares, target)

    def negative_log(self, theta: np.ndarray) -> tuple[float, np.ndarray]:
        """-log p(y) and its gradient in theta, the logarithms of factor, length scales and noise."""
        factor, scales, noise = np.exp(theta[0]), np.exp(-2 * theta[1:-1]), np.exp(theta[-1])
        target, rows = self.target, len(self.target)
        scaled = self.squares * scales[:, None]
        root = np.sqrt(3 * scaled.sum(axis=0))
        decay = factor * np.exp(-root)
        smooth = (1 + root) * decay
        covariance = smooth.copy()
        covariance[:: rows + 1] += noise + JITTER
        # LAPACK is called directly: for twenty rows, the wrappers of numpy and scipy take longer than the
        # factorisation.
        lower, failed = dpotrf(covariance.reshape(rows, rows), lower=1, clean=1)
        if failed:
            return np.inf, np.zeros_like(theta)
        half = dtrtri(lower, lower=1)[0]
        inverse = half.T @ half
        weights = inverse @ target
        value = -0.5 * target @ weights - np.log(lower.diagonal()).sum() - 0.5 * rows * np.log(2 * np.pi)
        slope = 0.5 * (weights[:, None] * weights - inverse)
        flat = slope.ravel()
        # d k / d ln l_j = 3 C exp(-r) d_j^2 / l_j^2, with r^2 = 3 sum_j d_j^2 / l_j^2.
        by_length = scaled @ (3 * decay * flat)
        return -value, -np.concatenate([[smooth @ flat], by_length, [noise * slope.trace()]])


class GaussianProcess:
    """scikit-learn's process of zero mean at the largest marginal likelihood that is reached from some starts.

    kernel: C * Matern(nu = 1.5) + noise, with its bounds; starts: (s, h) logarithms of its hyper-parameters. The
    likelihood has several maxima: from a single start its maximisation may end at a low one.
    """

    def __init__(self, kernel: Kernel, starts: Sequence[np.ndarray]):
        self.kernel, self.starts = kernel, starts
        self.process = GaussianProcessRegressor(kernel, alpha=JITTER, optimizer=None)

    def fit(self, inputs: np.ndarray, target: np.ndarray) -> "GaussianProcess":
        """Fit on inputs (n, k) and a target (n,)."""
        likelihood = MarginalLikelihood.of(inputs, target, shared=len(self.kernel.theta) == 3)
        found = [
            minimize(likelihood.negative_log, start, jac=True, method="L-BFGS-B", bounds=self.kernel.bounds)
            for start in self.starts
        ]
        return self.condition(min(found, key=lambda each: each.fun).x, inputs, target)

    def condition(self, logs: np.ndarray, inputs: np.ndarray, target: np.ndarray) -> "GaussianProcess":
        """The process of known logarithms of the hyper-parameters on inputs (n, k) and a target (n,)."""
        process = GaussianProcessRegressor(self.kernel.clone_with_theta(logs), alpha=JITTER, optimizer=None)
        self.process = process.fit(inputs, target)
        return self

    @property
    def logs(self) -> np.ndarray:
        """Logarithms of the fitted factor, length scales and noise."""
        return self.process.kernel_.theta

    def predict(self, inputs: np.ndarray) -> np.ndarray:
        """Mean (m,) at inputs (m, k), Eq. 5.8."""
        return self.process.predict(inputs)

    def deviation(self, inputs: np.ndarray) -> np.ndarray:
        """Standard deviation (m,) of a measurement at inputs (m, k): Eq. 5.9, noise included."""
        return self.process.predict(inputs, return_std=True)[1]

    def mean_deviation(self, inputs: np.ndarray) -> np.ndarray:
        """The same without the noise."""
        return np.sqrt(np.maximum(self.deviation(inputs) ** 2 - self.process.kernel_.k2.noise_level, 0))


def matern_kernel(start: dict[str, float], columns: int, choices: Choices) -> Kernel:
    """C * Matern(nu = 1.5) + white noise, Eqs 5.5 and 5.6; columns: number of features.

    start: constant [pp2], length_scale [standard deviations] and noise [pp2].
    """
    shared = choices.length_scales == "shared"
    lengths = start["length_scale"] if shared else np.full(columns, start["length_scale"])
    bounds = tuple(choices.kernel_bounds)
    smooth = ConstantKernel(start["constant"], bounds) * Matern(lengths, bounds, nu=1.5)
    return smooth + WhiteKernel(start["noise"], bounds)


def gaussian_process(parameters: dict[str, float], columns: int, training: TrainingConfig) -> GaussianProcess:
    """The process, not fitted yet; parameters: where its maximisation starts, as `matern_kernel` takes it.

    Without parameters it starts several times, at places that are drawn uniformly within Table 5.2.
    """
    generator, space = np.random.default_rng(training.seed), training.spaces["gpr"]
    drawn = [
        {name: float(generator.uniform(low, high)) for name, (low, high) in space.items()}
        for _ in range(training.kernel_starts)
    ]
    kernels = [matern_kernel(start, columns, training.choices) for start in ([parameters] if parameters else drawn)]
    return GaussianProcess(kernels[0], [kernel.theta for kernel in kernels])


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


LARGEST_SEED = np.iinfo(np.int32).max


class ForestFold:
    """The random forests of every size and shape that a search needs for one fold; each tree is grown once.

    The trees are those of scikit-learn's RandomForestRegressor. The first n of a forest do not depend on how many
    follow, and many sets of hyper-parameters give the same trees: a node of fewer than 2 * min_samples_leaf rows is
    never split, and a tree that has not reached its largest depth is the tree of every larger depth.
    """

    def __init__(
        self, inputs: np.ndarray, target: np.ndarray, held_out: np.ndarray, max_features: float, seed: int, trees: int
    ):
        """inputs (n, k), target (n,) [pp] and held-out inputs (m, k) of a fold; trees: the largest number of trees.

        max_features: the share of the features that every node sees.
        """
        # Trees compare in single precision, as scikit-learn's forests do.
        self._inputs, self._held_out = (np.ascontiguousarray(each, dtype=np.float32) for each in (inputs, held_out))
        self._target, self._max_features = np.ascontiguousarray(target, dtype=float)[:, None], max_features
        generator = np.random.RandomState(seed)
        self._seeds = [generator.randint(LARGEST_SEED) for _ in range(trees)]
        # A new generator takes a hundred times as long as another seed for an old one.
        self._generator = np.random.RandomState(0)
        self._bootstraps: dict[int, np.ndarray] = {}
        # By number of a tree and rows of a node and leaf: the smallest depth limit that gives this tree, and its
        # prediction.
        self._free: dict[tuple[int, int, int], tuple[int, np.ndarray]] = {}
        self._bounded: dict[tuple[int, int, int, int], np.ndarray] = {}

    def predict(self, n_estimators: int, max_depth: int, min_samples_split: int, min_samples_leaf: int) -> np.ndarray:
        """Mean prediction (m,) [pp] of a forest for the held-out rows, Eq. 5.11; n_estimators: at most `trees`."""
        split = max(min_samples_split, 2 * min_samples_leaf)
        # The numbers are finite, and the configuration has checked the parameters.
        with config_context(assume_finite=True, skip_parameter_validation=True):
            trees = [self._predict(index, max_depth, split, min_samples_leaf) for index in range(n_estimators)]
        return np.mean(trees, axis=0)

    def _predict(self, index: int, depth: int, split: int, leaf: int) -> np.ndarray:
        free = self._free.get((index, split, leaf))
        if free is not None and depth >= free[0]:
            return free[1]
        key = (index, depth, split, leaf)
        if key not in self._bounded:
            tree = self._grow(index, depth, split, leaf)
            predicted = tree.predict(self._held_out, check_input=False)
            if tree.get_depth() < depth:
                self._free[index, split, leaf] = tree.get_depth() + 1, predicted
                return predicted
            self._bounded[key] = predicted
        return self._bounded[key]

    def _grow(self, index: int, depth: int, split: int, leaf: int) -> DecisionTreeRegressor:
        """The tree of this number; split: fewest rows of a node that is split; leaf: fewest rows of a leaf."""
        if index not in self._bootstraps:
            rows = len(self._inputs)
            self._generator.seed(self._seeds[index])
            drawn = self._generator.randint(0, rows, rows, dtype=np.int32)
            self._bootstraps[index] = np.bincount(drawn, minlength=rows).astype(float)
        self._generator.seed(self._seeds[index])
        tree = DecisionTreeRegressor(
            max_depth=depth,
            min_samples_split=split,
            min_samples_leaf=leaf,
            max_features=self._max_features,
            random_state=self._generator,
        )
        return tree.fit(self._inputs, self._target, self._bootstraps[index], check_input=False)


class BoostingFold:
    """Trees of many sets of hyper-parameters for one fold, whose data are sorted into bins once."""

    def __init__(self, inputs: np.ndarray, target: np.ndarray, held_out: np.ndarray):
        """inputs (n, k), target (n,) [pp] and held-out inputs (m, k) of a fold."""
        self._data = QuantileDMatrix(inputs, target, nthread=1)
        self._held_out = np.ascontiguousarray(held_out, dtype=float)

    def predict(self, parameters: dict[str, int | float]) -> np.ndarray:
        """Prediction (m,) [pp] for the held-out rows, with these parameters of XGBRegressor."""
        estimator = XGBRegressor(**parameters)
        booster = train(estimator.get_xgb_params(), self._data, estimator.get_num_boosting_rounds())
        return booster.inplace_predict(self._held_out)
