"""XGBoost for some twenty rows: the trees of XGBRegressor, without what it does around each of them."""

import numpy as np
from xgboost import Booster, QuantileDMatrix, XGBRegressor

Parameters = dict[str, int | float]


def quantile_matrix(inputs: np.ndarray, target: np.ndarray) -> QuantileDMatrix:
    """The training data (n, k) and target (n,) in the form that XGBRegressor makes of them."""
    return QuantileDMatrix(inputs, target, nthread=1)


def boost(parameters: Parameters, data: QuantileDMatrix) -> Booster:
    """The trees that XGBRegressor(**parameters) grows on `data`; parameters: as in Table 5.5, with seed and threads."""
    estimator = XGBRegressor(**parameters)
    booster = Booster(estimator.get_xgb_params(), [data])
    for number in range(estimator.get_num_boosting_rounds()):
        booster.update(data, number)
    return booster


class Boosting:
    """Boosted trees, Eqs 5.14 to 5.16, by XGBoost."""

    def __init__(self, **parameters: int | float):
        """parameters: as in Table 5.5, with random_state and n_jobs."""
        self.parameters = parameters
        self.booster = Booster()

    def fit(self, inputs: np.ndarray, target: np.ndarray) -> "Boosting":
        """Fit on inputs (n, k) and a target (n,)."""
        self.booster = boost(self.parameters, quantile_matrix(inputs, target))
        return self

    def predict(self, inputs: np.ndarray) -> np.ndarray:
        """Prediction (m,) for inputs (m, k)."""
        return self.booster.inplace_predict(np.ascontiguousarray(inputs, dtype=float))


class BoostingFold:
    """Trees of many sets of hyper-parameters for one fold, whose data are sorted into bins once."""

    def __init__(self, inputs: np.ndarray, target: np.ndarray, held_out: np.ndarray):
        """inputs (n, k), target (n,) [pp] and held-out inputs (m, k) of a fold."""
        self._data = quantile_matrix(inputs, target)
        self._held_out = np.ascontiguousarray(held_out, dtype=float)

    def predict(self, parameters: Parameters) -> np.ndarray:
        """Prediction (m,) [pp] for the held-out rows, with these hyper-parameters, seed and threads."""
        return boost(parameters, self._data).inplace_predict(self._held_out)
