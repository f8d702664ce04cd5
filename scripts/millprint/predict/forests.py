"""Random forests of scikit-learn for some twenty rows: its own trees, without what it does around each of them.

For so few rows, checks of the input and new generators of random numbers take ten times as long as growing a tree. So
the trees are grown by scikit-learn's builder itself. They are those of RandomForestRegressor, bit for bit.
"""

import numpy as np
from sklearn.ensemble import RandomForestRegressor
from sklearn.tree import DecisionTreeRegressor
from sklearn.tree._criterion import MSE
from sklearn.tree._splitter import BestSplitter
from sklearn.tree._tree import DepthFirstTreeBuilder, Tree

OUTPUTS = np.ones(1, dtype=np.intp)
LARGEST_SEED = np.iinfo(np.int32).max


class Grower:
    """The trees of a random forest of a seed, on inputs (n, k) and a target (n,)."""

    def __init__(self, inputs: np.ndarray, target: np.ndarray, max_features: float, seed: int, trees: int):
        """trees: the largest number of trees; max_features: the share of the features that every node sees."""
        # Trees compare in single precision, as scikit-learn's do.
        self._inputs = np.ascontiguousarray(inputs, dtype=np.float32)
        self._target = np.ascontiguousarray(target, dtype=float)[:, None]
        rows, self._columns = self._inputs.shape
        self._seen = max(1, int(max_features * self._columns))
        self._criterion = MSE(1, rows)
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

    def grow(self, index: int, depth: int, split: int, leaf: int) -> Tree:
        """The tree of this number; split: the rows that a node needs, at least 2 * leaf; leaf: those of a leaf."""
        weights = self._bootstrap(index)
        self._generator.seed(self._seeds[index])
        splitter = BestSplitter(self._criterion, self._seen, leaf, 0.0, self._generator, None)
        tree = Tree(self._columns, OUTPUTS, 1)
        builder = DepthFirstTreeBuilder(splitter, split, leaf, 0.0, depth, 0.0)
        builder.build(tree, self._inputs, self._target, weights, None)
        return tree


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
        # By number of a tree and rows of a node and leaf: the smallest depth that it stands for, and its prediction.
        self._free: dict[tuple[int, int, int], tuple[int, np.ndarray]] = {}
        self._bounded: dict[tuple[int, int, int, int], np.ndarray] = {}

    def predict(self, n_estimators: int, max_depth: int, min_samples_split: int, min_samples_leaf: int) -> np.ndarray:
        """Mean prediction (m,) [pp] of a forest for the held-out rows, Eq. 5.11; n_estimators: at most `trees`."""
        split = max(min_samples_split, 2 * min_samples_leaf)
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
        predicted = tree.predict(self._held_out).ravel()
        if tree.max_depth < depth:
            self._free[index, split, leaf] = tree.max_depth + 1, predicted
        else:
            self._bounded[index, depth, split, leaf] = predicted
        return predicted


class QuickForest(RandomForestRegressor):
    """scikit-learn's random forest, grown and asked without what surrounds each tree: the same trees and the same bits.

    For some twenty rows, the threads and checks of RandomForestRegressor take most of its time.
    """

    def fit(self, X: np.ndarray, y: np.ndarray, sample_weight: None = None) -> "QuickForest":
        """Grow the trees on inputs (n, k) and a target (n,)."""
        grower = Grower(X, y, self.max_features, self.random_state, self.n_estimators)
        split = max(self.min_samples_split, 2 * self.min_samples_leaf)
        self.estimator_, self.estimators_, self.n_outputs_ = DecisionTreeRegressor(), [], 1
        self.n_features_in_ = np.shape(X)[1]
        for index in range(self.n_estimators):
            tree = DecisionTreeRegressor()
            tree.tree_ = grower.grow(index, self.max_depth, split, self.min_samples_leaf)
            tree.n_features_in_, tree.n_outputs_ = self.n_features_in_, 1
            self.estimators_.append(tree)
        return self

    def predict(self, X: np.ndarray) -> np.ndarray:
        """Mean prediction (m,) of the trees for inputs (m, k), Eq. 5.11."""
        inputs = np.ascontiguousarray(X, dtype=np.float32)
        total = np.zeros(len(inputs))
        for tree in self.estimators_:
            total += tree.tree_.predict(inputs).ravel()
        return total / len(self.estimators_)
