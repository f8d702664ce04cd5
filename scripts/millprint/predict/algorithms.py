"""The five algorithms of thesis Sec. 5.2.6 as estimators of scikit-learn's kind."""

import warnings
from typing import Any

import numpy as np
from sklearn.ensemble import RandomForestRegressor
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Hyperparameter, Matern, WhiteKernel
from sklearn.linear_model import LinearRegression
from sklearn.svm import SVR

from millprint.config.yields import Choices

SCALED = ("linear", "gpr", "svr")  # these see standardised features, Eq. 5.2; the trees see them as they are


def make_estimator(
    algorithm: str, parameters: dict[str, float], features: int, choices: Choices, seed: int, threads: int = 1
) -> Any:
    """An estimator that is not fitted yet.

    parameters: hyper-parameters by the names of the search space (Tables 5.2 to 5.5); none for `linear`.
    features: number of columns, which the kernel needs.
    """
    if algorithm == "linear":
        return LinearRegression()
    if algorithm == "gpr":
        return _gaussian_process(parameters, features, choices)
    if algorithm == "rf":
        return RandomForestRegressor(
            **parameters, max_features=float(choices.max_features), random_state=seed, n_jobs=threads
        )
    if algorithm == "svr":
        return SVR(kernel="rbf", **parameters)
    # Imported here: the other algorithms do without it, and it takes a second.
    from xgboost import XGBRegressor

    return XGBRegressor(**parameters, random_state=seed, n_jobs=threads)


class _OneHyperparameter:
    """A kernel that names its only hyper-parameter. scikit-learn looks for them among all names of the object.

    It does so several times at every step of a climb of the marginal likelihood, an eighth of the time of a fit.
    """

    varied: str

    @property
    def hyperparameters(self) -> list[Hyperparameter]:
        """The hyper-parameters that scikit-learn would find, in its order: of one there is only one."""
        return [getattr(self, f"hyperparameter_{self.varied}")]


class Scaling(_OneHyperparameter, ConstantKernel):
    """The factor C of Eq. 5.5."""

    varied = "constant_value"


class Smoothness(_OneHyperparameter, Matern):
    """The Matern kernel of Eq. 5.6."""

    varied = "length_scale"


class Noise(_OneHyperparameter, WhiteKernel):
    """The variance of the noise."""

    varied = "noise_level"


def _gaussian_process(parameters: dict[str, float], features: int, choices: Choices) -> GaussianProcessRegressor:
    """Zero mean and C * Matern(nu = 1.5) + white noise, Eqs 5.5 to 5.10.

    The parameters are where the climb of the marginal likelihood starts: it ends in a local maximum that depends on
    them, which is what the search of Table 5.2 decides.
    """
    shared = choices.length_scales == "shared"
    lengths = parameters["length_scale"] if shared else np.full(features, parameters["length_scale"])
    bounds = tuple(choices.kernel_bounds)
    kernel = Scaling(parameters["constant"], bounds) * Smoothness(lengths, bounds, nu=1.5)
    return GaussianProcessRegressor(kernel + Noise(parameters["noise"], bounds))


def quiet_fit(estimator: Any, inputs: np.ndarray, target: np.ndarray) -> Any:
    """Fit without scikit-learn's warnings of a kernel's length scale at its bound.

    There they are no fault: a length scale that grows to its bound is how the kernel drops a feature.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        return estimator.fit(inputs, target)
