"""Estimators: the Gaussian process of thesis Eqs 5.5 to 5.10, a line with errors, and random forests that share trees.

For some twenty rows, RandomForestRegressor spends nearly all of its time around each tree. The trees here are the same,
to the last bit: each has the seed and the bootstrap that RandomForestRegressor gives it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import cho_solve, cholesky
from scipy.linalg.lapack import dpotrf, dtrtri
from scipy.optimize import OptimizeResult, minimize
from sklearn import config_context
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Kernel, Matern, WhiteKernel
from sklearn.linear_model import LinearRegression
from sklearn.tree import DecisionTreeRegressor
from xgboost import Booster, QuantileDMatrix, XGBRegressor

from millprint.config.yields import Choices, TrainingConfig
from millprint.thesis.yields.posterior_process import Pairs

# Added to the variance of each row, in the units of the target squared, as scikit-learn does by default.
JITTER = 1e-10


def squared_differences(left: np.ndarray, right: np.ndarray, shared: bool) -> np.ndarray:
    """Squared differences of inputs (n, k) and (m, k) in each feature (k, n * m); shared: their sum (1, n * m)."""
    squares = Pairs.of(left, right).squares.reshape(left.shape[1], -1)
    return squares.sum(axis=0, keepdims=True) if shared else squares


def matern(theta: np.ndarray, squares: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """C * Matern(nu = 1.5) of pairs, Eq. 5.5: d^2 / l^2 (k, pairs), C exp(-r) and (1 + r) C exp(-r), (pairs,) each.

    theta: logarithms of factor, length scales and noise; squares: of `squared_differences`.
    """
    scaled = squares * np.exp(-2 * theta[1:-1])[:, None]
    root = np.sqrt(3 * scaled.sum(axis=0))
    decay = np.exp(theta[0]) * np.exp(-root)
    return scaled, decay, (1 + root) * decay


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
        return cls(squared_differences(inputs, inputs, shared), target)

    def negative_log(self, theta: np.ndarray) -> tuple[float, np.ndarray]:
        """-log p(y) and its gradient in theta, the logarithms of factor, length scales and noise."""
        noise, target, rows = np.exp(theta[-1]), self.target, len(self.target)
        scaled, decay, smooth = matern(theta, self.squares)
        # LAPACK is called directly: for twenty rows, the wrappers of numpy and scipy take longer than factorising.
        lower, failed = dpotrf(self._covariance(smooth, noise), lower=1, clean=1)
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

    def maximise(self, start: np.ndarray, bounds: np.ndarray) -> OptimizeResult:
        """The maximum that is reached from `start`, within bounds (h, 2); all logarithms."""
        return minimize(self.negative_log, start, jac=True, method="L-BFGS-B", bounds=bounds)

    def weights(self, theta: np.ndarray) -> np.ndarray:
        """K^-1 y (n,) of Eq. 5.8."""
        covariance = self._covariance(matern(theta, self.squares)[2], np.exp(theta[-1]))
        return cho_solve((cholesky(covariance, lower=True), True), self.target)

    def _covariance(self, smooth: np.ndarray, noise: float) -> np.ndarray:
        """K (n, n), from its part without noise (n * n,)."""
        rows = len(self.target)
        covariance = smooth.copy()
        covariance[:: rows + 1] += noise + JITTER
        return covariance.reshape(rows, rows)


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
        found = [likelihood.maximise(start, self.kernel.bounds) for start in self.starts]
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


class ProcessFold:
    """Processes from many starts for one fold. The distances of its rows are calculated once.

    For some twenty rows, scikit-learn spends a third of a search in kernels that build and check themselves again. The
    predictions are its own, but for rounding.
    """

    def __init__(self, inputs: np.ndarray, target: np.ndarray, held_out: np.ndarray, choices: Choices):
        """inputs (n, k), target (n,) [pp] and held-out inputs (m, k) of a fold."""
        shared, self._kernel_bounds = choices.length_scales == "shared", choices.kernel_bounds
        self._likelihood = MarginalLikelihood.of(inputs, target, shared)
        self._across = squared_differences(held_out, inputs, shared)

    def predict(self, start: dict[str, float]) -> np.ndarray:
        """Mean (m,) [pp] at the held-out inputs, Eq. 5.8, of the process that is reached from a start of Table 5.2."""
        lengths = np.full(len(self._likelihood.squares), start["length_scale"])
        logs = np.log(np.concatenate([[start["constant"]], lengths, [start["noise"]]]))
        bounds = np.tile(np.log(self._kernel_bounds), (len(logs), 1))
        theta = self._likelihood.maximise(logs, bounds).x
        weights = self._likelihood.weights(theta)
        return matern(theta, self._across)[2].reshape(-1, len(weights)) @ weights


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


class Trees:
    """The trees of scikit-learn's RandomForestRegressor for some rows, grown one by one.

    inputs (n, k), target (n,) [pp]; max_features: the share of the features that every node sees; count: the largest
    number of trees.
    """

    def __init__(self, inputs: np.ndarray, target: np.ndarray, max_features: float, seed: int, count: int):
        self._inputs, self._max_features = single(inputs), max_features
        self._target = np.ascontiguousarray(target, dtype=float)[:, None]
        generator = np.random.RandomState(seed)
        self._seeds = [generator.randint(LARGEST_SEED) for _ in range(count)]
        # A new generator takes a hundred times as long as another seed for an old one.
        self._generator = np.random.RandomState(0)
        self._bootstraps: dict[int, np.ndarray] = {}

    def grow(self, index: int, depth: int, split: int, leaf: int) -> DecisionTreeRegressor:
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
        # The numbers are finite, and the configuration has checked the parameters.
        with config_context(assume_finite=True, skip_parameter_validation=True):
            return tree.fit(self._inputs, self._target, self._bootstraps[index], check_input=False)


def single(inputs: np.ndarray) -> np.ndarray:
    """Inputs in single precision, in which trees compare, as scikit-learn's forests do."""
    return np.ascontiguousarray(inputs, dtype=np.float32)


@dataclass
class Forest:
    """A random forest, Eq. 5.11; the parameters are those of Table 5.3."""

    n_estimators: int
    max_depth: int
    min_samples_split: int = 2
    min_samples_leaf: int = 1
    max_features: float = 1.0
    seed: int = 0
    trees: list[DecisionTreeRegressor] = field(init=False, default_factory=list)

    def fit(self, inputs: np.ndarray, target: np.ndarray) -> "Forest":
        """Fit on inputs (n, k) and a target (n,)."""
        trees = Trees(inputs, target, self.max_features, self.seed, self.n_estimators)
        shape = (self.max_depth, self.min_samples_split, self.min_samples_leaf)
        self.trees = [trees.grow(index, *shape) for index in range(self.n_estimators)]
        return self

    def predict(self, inputs: np.ndarray) -> np.ndarray:
        """Mean (m,) over the trees at inputs (m, k)."""
        rows = single(inputs)
        return np.mean([tree.predict(rows, check_input=False) for tree in self.trees], axis=0)


class ForestFold:
    """The random forests of every size and shape that a search needs for one fold; each tree is grown once.

    The first n trees of a forest do not depend on how many follow, and many sets of hyper-parameters give the same
    trees: a node of fewer than 2 * min_samples_leaf rows is never split, and a tree that has not reached its largest
    depth is the tree of every larger depth.
    """

    def __init__(self, trees: Trees, held_out: np.ndarray):
        """held_out: inputs (m, k) of a fold, of whose other rows the trees are."""
        self._trees, self._held_out = trees, single(held_out)
        # By number of a tree and rows of a node and leaf: the smallest depth limit that gives this tree, and its
        # prediction.
        self._free: dict[tuple[int, int, int], tuple[int, np.ndarray]] = {}
        self._bounded: dict[tuple[int, int, int, int], np.ndarray] = {}

    def predict(self, n_estimators: int, max_depth: int, min_samples_split: int, min_samples_leaf: int) -> np.ndarray:
        """Mean prediction (m,) [pp] of a forest for the held-out rows, Eq. 5.11."""
        split = max(min_samples_split, 2 * min_samples_leaf)
        trees = [self._predict(index, max_depth, split, min_samples_leaf) for index in range(n_estimators)]
        return np.mean(trees, axis=0)

    def _predict(self, index: int, depth: int, split: int, leaf: int) -> np.ndarray:
        free = self._free.get((index, split, leaf))
        if free is not None and depth >= free[0]:
            return free[1]
        key = (index, depth, split, leaf)
        if key not in self._bounded:
            tree = self._trees.grow(index, depth, split, leaf)
            predicted = tree.predict(self._held_out, check_input=False)
            if tree.get_depth() < depth:
                self._free[index, split, leaf] = tree.get_depth() + 1, predicted
                return predicted
            self._bounded[key] = predicted
        return self._bounded[key]


class BoostingFold:
    """Trees of many sets of hyper-parameters for one fold, whose data are sorted into bins once."""

    def __init__(self, inputs: np.ndarray, target: np.ndarray, held_out: np.ndarray):
        """inputs (n, k), target (n,) [pp] and held-out inputs (m, k) of a fold."""
        self._data = QuantileDMatrix(inputs, target, nthread=1)
        self._held_out = np.ascontiguousarray(held_out, dtype=float)

    def predict(self, parameters: dict[str, int | float]) -> np.ndarray:
        """Prediction (m,) [pp] for the held-out rows, with these parameters of XGBRegressor."""
        estimator = XGBRegressor(**parameters)
        # What xgboost.train does, but for its callbacks, which take a third of the time for some twenty rows.
        booster = Booster(estimator.get_xgb_params(), [self._data])
        for number in range(estimator.get_num_boosting_rounds()):
            booster.update(self._data, number)
        return booster.inplace_predict(self._held_out)
