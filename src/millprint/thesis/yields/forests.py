"""Random forests of scikit-learn for some twenty rows: trees of DecisionTreeRegressor, which forests share.

For so few rows, RandomForestRegressor spends nearly all of its time around each tree. The trees here are the same, to
the last bit: each has the seed and the bootstrap that RandomForestRegressor gives it.
"""

from contextlib import AbstractContextManager

import numpy as np
from sklearn import config_context
from sklearn.tree import DecisionTreeRegressor

LARGEST_SEED = np.iinfo(np.int32).max


class Grower:
    """The trees of a random forest of a seed, on inputs (n, k) and a target (n,)."""

    def __init__(self, inputs: np.ndarray, target: np.ndarray, max_features: float, seed: int, trees: int):
        """trees: the largest number of trees; max_features: the share of the features that every node sees."""
        # Trees compare in single precision, as scikit-learn's forests do.
        self._inputs = np.ascontiguousarray(inputs, dtype=np.float32)
        self._target = np.ascontiguousarray(target, dtype=float)[:, None]
        self._max_features = max_features
        generator = np.random.RandomState(seed)
        self._seeds = [generator.randint(LARGEST_SEED) for _ in range(trees)]
        # A new generator takes a hundred times as long as another seed for an old one.
        self._generator = np.random.RandomState(0)
        self._bootstraps: dict[int, np.ndarray] = {}

    def _bootstrap(self, index: int) -> np.ndarray:
        """How often each row is drawn for a tree, (n,)."""
        if index not in self._bootstraps:
            rows = len(self._inputs)
            self._generator.seed(self._seeds[index])
            drawn = self._generator.randint(0, rows, rows, dtype=np.int32)
            self._bootstraps[index] = np.bincount(drawn, minlength=rows).astype(float)
        return self._bootstraps[index]

    def grow(self, index: int, depth: int, split: int, leaf: int) -> DecisionTreeRegressor:
        """The tree of this number; split: fewest rows of a node that is split; leaf: fewest rows of a leaf."""
        weights = self._bootstrap(index)
        self._generator.seed(self._seeds[index])
        tree = DecisionTreeRegressor(
            max_depth=depth,
            min_samples_split=split,
            min_samples_leaf=leaf,
            max_features=self._max_features,
            random_state=self._generator,
        )
        return tree.fit(self._inputs, self._target, weights, check_input=False)


def few_checks() -> AbstractContextManager:
    """Skip scikit-learn's checks of each tree: numbers are finite, parameters checked by the configuration."""
    return config_context(assume_finite=True, skip_parameter_validation=True)


class ForestFold:
    """The random forests of every size and shape that a search needs for one fold; each tree is grown once.

    The first n trees of a forest do not depend on how many follow, and many sets of hyper-parameters give the same
    trees: a node of fewer than 2 * min_samples_leaf rows is never split, and a tree that has not reached its largest
    depth is the tree of every larger depth. So forests share trees.
    """

    def __init__(
        self, inputs: np.ndarray, target: np.ndarray, held_out: np.ndarray, max_features: float, seed: int, trees: int
    ):
        """inputs (n, k), target (n,) [pp] and held-out inputs (m, k) of a fold; trees: the largest number of trees."""
        self._grower = Grower(inputs, target, max_features, seed, trees)
        self._held_out = np.ascontiguousarray(held_out, dtype=np.float32)
        # By number of a tree and rows of a node and leaf: the smallest depth limit that gives this tree, and its
        # prediction.
        self._free: dict[tuple[int, int, int], tuple[int, np.ndarray]] = {}
        self._bounded: dict[tuple[int, int, int, int], np.ndarray] = {}

    def predict(self, n_estimators: int, max_depth: int, min_samples_split: int, min_samples_leaf: int) -> np.ndarray:
        """Mean prediction (m,) [pp] of a forest for the held-out rows, Eq. 5.11; n_estimators: at most `trees`."""
        split = max(min_samples_split, 2 * min_samples_leaf)
        with few_checks():
            trees = [self._predict(index, max_depth, split, min_samples_leaf) for index in range(n_estimators)]
        return np.mean(trees, axis=0)

    def _predict(self, index: int, depth: int, split: int, leaf: int) -> np.ndarray:
        free = self._free.get((index, split, leaf))
        if free is not None and depth >= free[0]:
            return free[1]
        bounded = self._bounded.get((index, depth, split, leaf))
        if bounded is not None:
            return bounded
        tree = self._grower.grow(index, depth, split, leaf)
        predicted = tree.predict(self._held_out, check_input=False)
        if tree.get_depth() < depth:
            self._free[index, split, leaf] = tree.get_depth() + 1, predicted
        else:
            self._bounded[index, depth, split, leaf] = predicted
        return predicted


class Forest:
    """A random forest, Eq. 5.11: the trees of scikit-learn's RandomForestRegressor, and its prediction."""

    def __init__(
        self,
        n_estimators: int,
        max_depth: int,
        max_features: float,
        seed: int,
        min_samples_split: int = 2,
        min_samples_leaf: int = 1,
    ):
        """As in Table 5.3; max_features: the share of the features that every node sees [-]."""
        self.shape = max_depth, min_samples_split, min_samples_leaf
        self.count, self.max_features, self.seed = n_estimators, max_features, seed
        self.trees: list[DecisionTreeRegressor] = []

    def fit(self, inputs: np.ndarray, target: np.ndarray) -> "Forest":
        """Grow the trees on inputs (n, k) and a target (n,)."""
        grower = Grower(inputs, target, self.max_features, self.seed, self.count)
        with few_checks():
            self.trees = [grower.grow(index, *self.shape) for index in range(self.count)]
        return self

    def predict(self, inputs: np.ndarray) -> np.ndarray:
        """Mean prediction (m,) of the trees for inputs (m, k)."""
        inputs, total = np.ascontiguousarray(inputs, dtype=np.float32), np.zeros(len(inputs))
        with few_checks():
            for tree in self.trees:
                total += tree.predict(inputs, check_input=False)
        return total / len(self.trees)
