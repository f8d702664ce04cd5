"""Estimators: the Gaussian process of thesis Eqs 5.5 to 5.10, a line with errors, and random forests that share trees.

For some twenty rows, RandomForestRegressor spends nearly all of its time around each tree. The trees here are the same,
to the last bit: each has the seed and the bootstrap that RandomForestRegressor gives it.

Gaussian processes with sums of kernels, fitted by the posterior of their hyper-parameters; and their evidence.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from sklearn.tree import DecisionTreeRegressor
from sklearn.utils import Tags
from xgboost import Booster, QuantileDMatrix, XGBRegressor

from millprint.config.yields import INPUTS, Priors, TrainingConfig
from millprint.estimate.gaussian_process import LINEAR, Conditioned, Covariance, Kernel, Likelihood

# Added to the variance of each row, in the units of the target squared, as scikit-learn does by default.
JITTER = 1e-10
# Bounds of the process of the thesis in the marginal likelihood: those of scikit-learn.
KERNEL_BOUNDS = (1e-5, 1e5)


class GaussianProcess:
    """A process of zero mean at the largest marginal likelihood, Eq. 5.10, that is reached from some starts.

    Its kernel is C * Matern(nu = 1.5) + noise, Eqs 5.5 and 5.6. starts (s, p): logarithms of factor [pp2], length
    scales [standard deviations], one for each feature or one for all, and noise [pp2]. The likelihood has several
    maxima: from a single start its maximisation may end at a low one.
    """

    def __init__(self, starts: np.ndarray):
        self.starts, self.bounds = starts, np.tile(np.log(KERNEL_BOUNDS), (starts.shape[1], 1))

    def fit(self, inputs: np.ndarray, target: np.ndarray) -> "GaussianProcess":
        """Fit on inputs (n, k) and a target (n,)."""
        likelihood = Likelihood(self.kernel(inputs), inputs, target, JITTER)
        return self.condition(likelihood.maximise(self.starts, self.bounds)[0], inputs, target)

    def condition(self, logs: np.ndarray, inputs: np.ndarray, target: np.ndarray) -> "GaussianProcess":
        """The process of known logarithms of the hyper-parameters on inputs (n, k) and a target (n,)."""
        self.logs, self.noise = logs, float(np.exp(logs[-1]))
        self._known = Conditioned.fit(Covariance(self.kernel(inputs), logs), inputs, target, self.noise + JITTER)
        return self

    def kernel(self, inputs: np.ndarray) -> Kernel:
        """The kernel for inputs (n, k)."""
        columns, scales = inputs.shape[1], self.starts.shape[1] - 2
        return Kernel(("Matern 3/2",), np.array([0]), 1 + np.arange(columns)[None] % scales)

    def predict(self, inputs: np.ndarray) -> np.ndarray:
        """Mean (m,) at inputs (m, k), Eq. 5.8."""
        return self._known.mean(inputs)

    def deviation(self, inputs: np.ndarray) -> np.ndarray:
        """Standard deviation (m,) of a measurement at inputs (m, k): Eq. 5.9, noise included."""
        return np.sqrt(self.mean_deviation(inputs) ** 2 + self.noise)

    def mean_deviation(self, inputs: np.ndarray) -> np.ndarray:
        """The same without the noise."""
        return self._known.with_deviation(inputs)[1]


def start_of(parameters: Mapping[str, float], columns: int, length_scales: str) -> np.ndarray:
    """Where a maximisation starts: logarithms of the parameters of Table 5.2; columns: number of features."""
    count = 1 if length_scales == "shared" else columns
    return np.log([parameters["constant"], *[parameters["length_scale"]] * count, parameters["noise"]])


def gaussian_process(parameters: dict[str, float], columns: int, training: TrainingConfig) -> GaussianProcess:
    """The process, not fitted yet; parameters: where its maximisation starts, as `start_of` takes it.

    Without parameters it starts several times, at places that are drawn uniformly within Table 5.2.
    """
    generator, space = np.random.default_rng(training.seed), training.spaces["gpr"]
    chosen = (
        [parameters]
        if parameters
        else [
            {name: float(generator.uniform(low, high)) for name, (low, high) in space.items()}
            for _ in range(training.kernel_starts)
        ]
    )
    starts = [start_of(each, columns, training.length_scales) for each in chosen]
    return GaussianProcess(np.array(starts))


LARGEST_SEED = np.iinfo(np.int32).max
TAGS = DecisionTreeRegressor().__sklearn_tags__()


class OneTree(DecisionTreeRegressor):
    """A tree whose tags, for which every fit asks five times, are made once."""

    def __sklearn_tags__(self) -> Tags:
        """Those of any such tree."""
        return TAGS


class Trees:
    """The trees of scikit-learn's RandomForestRegressor for some rows, grown one by one.

    Every node sees all features. inputs (n, k), target (n,) [pp]; count: the largest number of trees.
    """

    def __init__(self, inputs: np.ndarray, target: np.ndarray, seed: int, count: int):
        self._inputs = single(inputs)
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
        tree = OneTree(
            max_depth=depth,
            min_samples_split=split,
            min_samples_leaf=leaf,
            random_state=self._generator,
        )
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
    seed: int = 0
    trees: list[DecisionTreeRegressor] = field(init=False, default_factory=list)

    def fit(self, inputs: np.ndarray, target: np.ndarray) -> "Forest":
        """Fit on inputs (n, k) and a target (n,)."""
        trees = Trees(inputs, target, self.seed, self.n_estimators)
        shape = (self.max_depth, self.min_samples_split, self.min_samples_leaf)
        self.trees = [trees.grow(index, *shape) for index in range(self.n_estimators)]
        return self

    def predict(self, inputs: np.ndarray) -> np.ndarray:
        """Mean (m,) over the trees at inputs (m, k)."""
        rows = single(inputs)
        return np.mean([tree.tree_.predict(rows)[:, 0] for tree in self.trees], axis=0)


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
            predicted = tree.tree_.predict(self._held_out)[:, 0]
            if tree.tree_.max_depth < depth:
                self._free[index, split, leaf] = tree.tree_.max_depth + 1, predicted
                return predicted
            self._bounded[key] = predicted
        return self._bounded[key]


class BinnedRows(QuantileDMatrix):
    """Rows sorted into bins, once for many sets of hyper-parameters; their features have no names."""

    feature_names = feature_types = None


class Boosted(Booster):
    """Trees of features without names: XGBoost would ask for their names at each of some hundred trees."""

    feature_names = feature_types = None


class Boosting:
    """Boosted trees; the parameters are those of XGBRegressor, and so is every bit.

    Its callbacks take more time than the trees for some twenty rows.
    """

    def __init__(self, **parameters: int | float):
        self._settings = XGBRegressor(**parameters)

    def fit(self, inputs: np.ndarray, target: np.ndarray) -> "Boosting":
        """Fit on inputs (n, k) and a target (n,) [pp]."""
        return self.learn(BinnedRows(inputs, target, nthread=1))

    def learn(self, rows: BinnedRows) -> "Boosting":
        """The same on rows that are sorted into bins."""
        self.booster = Boosted(self._settings.get_xgb_params(), [rows])
        for number in range(self._settings.get_num_boosting_rounds()):
            self.booster.update(rows, number)
        return self

    def predict(self, inputs: np.ndarray) -> np.ndarray:
        """Prediction (m,) [pp] at inputs (m, k)."""
        return self.booster.inplace_predict(np.ascontiguousarray(inputs, dtype=float))


# Variance of the unknown mean, for a target of unit variance: large, but finite so that the evidence is defined.
MEAN_VARIANCE = 4.0
FIT_JITTER = 1e-9
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
    return Likelihood(kernel, inputs, target, FIT_JITTER, centre, width**-2.0)


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
        return Conditioned.fit(Covariance(self.kernel, self.logs), self.inputs, self.target, self.noise + FIT_JITTER)

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
