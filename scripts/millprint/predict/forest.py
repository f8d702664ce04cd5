"""Random forests for the search: the same trees as scikit-learn's, each grown once."""

import numpy as np
import sklearn
from sklearn.tree import DecisionTreeRegressor


class ForestFold:
    """One fold's forests of every size and shape that the search asks for.

    The first n trees of a forest do not depend on how many follow, and many sets of hyper-parameters give the same
    trees: a node of fewer than 2 * min_samples_leaf rows is never split, and n rows make no tree deeper than n - 1.
    So trees are kept and shared between evaluations. They are bit for bit those of
    RandomForestRegressor(random_state=seed), grown without that class's overhead, which for 17 rows is most of its
    time.
    """

    def __init__(
        self, inputs: np.ndarray, target: np.ndarray, held_out: np.ndarray, max_features: float, seed: int, most: int
    ):
        """inputs (n, k) and target (n,) of the fold, inputs held out (m, k), and the largest number of trees."""
        # Trees compare in single precision, as scikit-learn's do.
        self._inputs = np.ascontiguousarray(inputs, dtype=np.float32)
        self._held_out = np.ascontiguousarray(held_out, dtype=np.float32)
        self._target = np.ascontiguousarray(target, dtype=float)
        self._max_features = max_features
        generator = np.random.RandomState(seed)
        self._seeds = [generator.randint(np.iinfo(np.int32).max) for _ in range(most)]
        self._bootstraps = [self._bootstrap(seed) for seed in self._seeds]
        self._predictions: dict[tuple[int, int, int], list[np.ndarray]] = {}

    def _bootstrap(self, seed: int) -> np.ndarray:
        """How often each row is drawn for the tree of this seed, (n,)."""
        rows = len(self._target)
        drawn = np.random.RandomState(seed).randint(0, rows, rows, dtype=np.int32)
        return np.bincount(drawn, minlength=rows).astype(float)

    def predict(self, n_estimators: int, max_depth: int, min_samples_split: int, min_samples_leaf: int) -> np.ndarray:
        """Mean prediction of the forest for the rows held out, (m,), Eq. 5.11."""
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
