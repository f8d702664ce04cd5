"""XGBoost for some twenty rows: the same trees, without what its Python interface does around each of them."""

from ctypes import c_int

import numpy as np
from xgboost import Booster, QuantileDMatrix, XGBRegressor
from xgboost.core import _LIB, _check_call


def quantile_matrix(inputs: np.ndarray, target: np.ndarray) -> QuantileDMatrix:
    """The training data (n, k) and target (n,) in the form that XGBRegressor makes of them."""
    return QuantileDMatrix(inputs, target, nthread=1)


def boost(estimator: XGBRegressor, data: QuantileDMatrix) -> Booster:
    """The trees of an estimator that is not fitted, grown on `data`, as `estimator.fit` grows them.

    xgboost.train looks at the names of features, at evaluations and at callbacks before and after each tree, which for
    so few rows takes longer than the tree; here its C interface grows them.
    """
    booster = Booster(estimator.get_xgb_params(), [data])
    for number in range(estimator.get_num_boosting_rounds()):
        _check_call(_LIB.XGBoosterUpdateOneIter(booster.handle, c_int(number), data.handle))
    return booster


class QuickBoosting(XGBRegressor):
    """XGBRegressor with a quick fit on numbers, with one thread and without any of its other arguments."""

    def fit(self, X: np.ndarray, y: np.ndarray) -> "QuickBoosting":
        """Fit on inputs (n, k) and a target (n,)."""
        self._Booster = boost(self, quantile_matrix(X, y))
        return self


class BoostingFold:
    """Trees of many sets of hyper-parameters for one fold, whose data are sorted into bins once."""

    def __init__(self, inputs: np.ndarray, target: np.ndarray, held_out: np.ndarray):
        """inputs (n, k), target (n,) [pp] and held-out inputs (m, k) of a fold."""
        self._data = quantile_matrix(inputs, target)
        self._held_out = np.ascontiguousarray(held_out, dtype=float)

    def predict(self, estimator: XGBRegressor) -> np.ndarray:
        """Prediction (m,) [pp] of an estimator that is not fitted yet for the held-out rows."""
        return boost(estimator, self._data).inplace_predict(self._held_out)
