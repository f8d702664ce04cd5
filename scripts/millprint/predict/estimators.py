"""Faster versions of two estimators of scikit-learn: the Gaussian process, and the random forests of a search."""

import warnings
from typing import Any

import numpy as np
import sklearn
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Hyperparameter, Matern, WhiteKernel
from sklearn.tree import DecisionTreeRegressor

from millprint.config.yields import Choices


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
    return GaussianProcessRegressor(kernel + Noise(parameters["noise"], bounds))


def fit_quietly(estimator: Any, inputs: np.ndarray, target: np.ndarray) -> Any:
    """Fit on inputs (n, k) and a target (n,) without the warning that a length scale has reached its bound.

    Such a fit is valid: with a length scale at its upper bound the kernel ignores a feature.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        return estimator.fit(inputs, target)


class ForestFold:
    """The random forests of every size and shape that a search needs for one fold; each tree is grown once.

    The first n trees of a forest do not depend on how many follow, and many sets of hyper-parameters give the same
    trees: a node of fewer than 2 * min_samples_leaf rows is never split, and n rows make no tree deeper than n - 1. So
    forests share trees. The trees are bit for bit those of RandomForestRegressor(random_state=seed), without the
    overhead of that class, which for 17 rows takes most of the time.
    """

    def __init__(
        self, inputs: np.ndarray, target: np.ndarray, held_out: np.ndarray, max_features: float, seed: int, trees: int
    ):
        """inputs (n, k), target (n,) [pp] and held-out inputs (m, k) of a fold; trees: the largest number of trees."""
        # Trees compare in single precision, as scikit-learn's do.
        self._inputs = np.ascontiguousarray(inputs, dtype=np.float32)
        self._held_out = np.ascontiguousarray(held_out, dtype=np.float32)
        self._target = np.ascontiguousarray(target, dtype=float)
        self._max_features = max_features
        generator = np.random.RandomState(seed)
        self._seeds = [generator.randint(np.iinfo(np.int32).max) for _ in range(trees)]
        self._bootstraps = [self._bootstrap(seed) for seed in self._seeds]
        self._predictions: dict[tuple[int, int, int], list[np.ndarray]] = {}

    def _bootstrap(self, seed: int) -> np.ndarray:
        """How often each row is drawn for the tree of this seed, (n,)."""
        rows = len(self._target)
        drawn = np.random.RandomState(seed).randint(0, rows, rows, dtype=np.int32)
        return np.bincount(drawn, minlength=rows).astype(float)

    def predict(self, n_estimators: int, max_depth: int, min_samples_split: int, min_samples_leaf: int) -> np.ndarray:
        """Mean prediction (m,) [pp] of a forest for the held-out rows, Eq. 5.11; n_estimators: at most `trees`."""
        depth = min(max_depth, len(self._target) - 1)
        shape = (depth, max(min_samples_split, 2 * min_samples_leaf), min_samples_leaf)
        grown = self._predictions.setdefault(shape, [])
        with sklearn.config_context(skip_parameter_validation=True, assume_finite=True):
            for index in range(len(grown), n_estimators):
                grown.append(self._grow(index, *shape))
        return np.mean(grown[:n_estimators], axis=0)

    def _grow(self, index: int, depth: int, split: int, leaf: int) -> np.ndarray:
        tree = DecisionTreeRegressor(
            max_depth=depth,
            min_samples_split=split,
            min_samples_leaf=leaf,
            max_features=self._max_features,
            random_state=self._seeds[index],
        )
        tree.fit(self._inputs, self._target, sample_weight=self._bootstraps[index], check_input=False)
        return tree.predict(self._held_out, check_input=False)
