"""The regressors: one record each, which holds everything that depends on which regressor it is.

To add one: its record here, and in `TRAININGS` of millprint.config.yields what of it is searched; then `make
reference`. Snakemake reads this module with the Snakefile, so a library is imported only where it is used.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from millprint.config.yields import TABLE_5_6, TRAININGS, Training, TrainingConfig

if TYPE_CHECKING:
    import numpy as np

# The averaged Gaussian process (millprint.thesis.yields.averaging), which averages many fits and is not a regressor.
AVERAGED = "averaged_gpr"
# The yields of the training rows as the prediction for every condition: the reference of all scores.
CLIMATOLOGY = "climatology"
# Six parameters on the logit of the yield (millprint.thesis.yields.averaging).
SURFACE = "response_surface"
# What a learned model must beat: nothing of them is searched, and they are not stored.
BASELINES = (CLIMATOLOGY, SURFACE)

Parameters = dict[str, Any]
# Predicts the held-out rows (m,) [pp] of a fold, by its number, for some hyper-parameters.
FoldPredictor = Callable[[int, Parameters], "np.ndarray"]


@dataclass(frozen=True)
class Regressor:
    """What the yield models, their files, tables and figures need to know about a regressor.

    title: its name in figures.
    settled: how the choices that the thesis leaves open were settled, for the report.
    make(parameters, columns, training, threads): an estimator like those of scikit-learn, not fitted yet; parameters:
    by their names in the search space; columns: number of features.
    scaled: whether its features are standardised (Eq. 5.2).
    forest: whether it is a mean over `n_estimators` trees that do not depend on each other.
    primary_features: the features of its single step; all of them if left out.
    seeded: whether its fit depends on a seed.
    keep(estimator): what its file stores of a fit; restore(estimator, kept, inputs, target): the fitted estimator from
    that and from the training rows, inputs (n, k) and target (n,). Without them it is fitted again, which is exact.
    explain(estimator, inputs): SHAP values (n, k) [pp] and the mean prediction [pp]; None if it cannot be explained.
    deviation(estimator, inputs): standard deviation (n,) [pp] of a measurement; None if it gives no distribution.
    mean_deviation(estimator, inputs): the same of what is predicted, without the scatter of a measurement; the first of
    two steps needs it.
    fold_predictor(inputs, target, folds, training): a faster cross-validation than a fit for each evaluation.
    """

    title: str
    settled: str
    make: Callable[[Parameters, int, TrainingConfig, int], Any]
    scaled: bool = False
    forest: bool = False
    primary_features: tuple[str, ...] = ()
    seeded: bool = False
    keep: Callable[[Any], dict] = lambda estimator: {}
    restore: Callable[[Any, dict, np.ndarray, np.ndarray], Any] = lambda own, kept, x, y: own.fit(x, y)
    explain: Callable[[Any, np.ndarray], tuple[np.ndarray, float]] | None = None
    deviation: Callable[[Any, np.ndarray], np.ndarray] | None = None
    mean_deviation: Callable[[Any, np.ndarray], np.ndarray] | None = None
    fold_predictor: Callable[[np.ndarray, np.ndarray, list, TrainingConfig], FoldPredictor] | None = None

    def __post_init__(self) -> None:
        """Check that two steps have a distribution if one has. Raises ValueError."""
        if self.deviation and not self.mean_deviation:
            raise ValueError(f"{self.title}: a regressor of two steps with a deviation needs a mean_deviation too")


def _make_linear(parameters: Parameters, columns: int, training: TrainingConfig, threads: int) -> Any:
    from sklearn.linear_model import LinearRegression

    return LinearRegression()


def _restore_linear(estimator: Any, kept: dict, inputs: np.ndarray, target: np.ndarray) -> Any:
    import numpy as np

    estimator.fit(inputs, target)
    estimator.coef_, estimator.intercept_ = np.array(kept["coefficients"]), kept["intercept"]
    return estimator


def _make_gpr(parameters: Parameters, columns: int, training: TrainingConfig, threads: int) -> Any:
    from millprint.thesis.yields.estimators import gaussian_process

    return gaussian_process(parameters, columns, training)


def _restore_gpr(estimator: Any, kept: dict, inputs: np.ndarray, target: np.ndarray) -> Any:
    import numpy as np

    return estimator.condition(np.array(kept["log_kernel_parameters"]), inputs, target)


def _make_forest(parameters: Parameters, columns: int, training: TrainingConfig, threads: int) -> Any:
    from millprint.thesis.yields.estimators import Forest

    return Forest(**parameters, seed=training.seed)


def _forest_folds(inputs: np.ndarray, target: np.ndarray, folds: list, training: TrainingConfig) -> FoldPredictor:
    from millprint.thesis.yields.estimators import ForestFold, Trees

    most = int(training.spaces["rf"]["n_estimators"][1])
    forests = [ForestFold(Trees(inputs[kept], target[kept], training.seed, most), inputs[held]) for kept, held in folds]
    return lambda fold, parameters: forests[fold].predict(**parameters)


def _explain_trees(estimator: Any, inputs: np.ndarray) -> tuple[np.ndarray, float]:
    import numpy as np

    # The colour maps of shap warn of a future matplotlib.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PendingDeprecationWarning)
        from shap import TreeExplainer
    explainer = TreeExplainer(estimator)
    return explainer.shap_values(inputs), float(np.ravel(explainer.expected_value)[0])


def _explain_forest(estimator: Any, inputs: np.ndarray) -> tuple[np.ndarray, float]:
    """The mean over the trees: SHAP values of a sum are sums."""
    import numpy as np

    values, bases = zip(*(_explain_trees(tree, inputs) for tree in estimator.trees), strict=True)
    return np.mean(values, axis=0), float(np.mean(bases))


def _make_svr(parameters: Parameters, columns: int, training: TrainingConfig, threads: int) -> Any:
    from sklearn.svm import SVR

    return SVR(kernel="rbf", **parameters)


def _make_xgb(parameters: Parameters, columns: int, training: TrainingConfig, threads: int) -> Any:
    from millprint.thesis.yields.estimators import Boosting

    return Boosting(**parameters, random_state=training.seed, n_jobs=threads)


def _boosting_folds(inputs: np.ndarray, target: np.ndarray, folds: list, training: TrainingConfig) -> FoldPredictor:
    from millprint.thesis.yields.estimators import BinnedRows

    binned = [BinnedRows(inputs[kept], target[kept], nthread=1) for kept, _ in folds]
    return lambda fold, parameters: (
        _make_xgb(parameters, inputs.shape[1], training, threads=1).learn(binned[fold]).predict(inputs[folds[fold][1]])
    )


def _restore_xgb(estimator: Any, kept: dict, inputs: np.ndarray, target: np.ndarray) -> Any:
    from xgboost import Booster

    estimator.booster = Booster(model_file=bytearray(kept["booster"], "utf-8"))
    return estimator


def _explain_xgb(estimator: Any, inputs: np.ndarray) -> tuple[np.ndarray, float]:
    """By XGBoost's own implementation of the same algorithm, which knows its base score exactly."""
    from xgboost import DMatrix

    values = estimator.booster.predict(DMatrix(inputs), pred_contribs=True)
    return values[:, :-1].astype(float), float(values[0, -1])


# What every Gaussian process of Eqs 5.5 to 5.10 has, however its start is found.
OF_A_PROCESS: dict[str, Any] = {
    "scaled": True,
    "keep": lambda estimator: {"log_kernel_parameters": estimator.logs.tolist()},
    "restore": _restore_gpr,
    "deviation": lambda estimator, inputs: estimator.deviation(inputs),
    "mean_deviation": lambda estimator, inputs: estimator.mean_deviation(inputs),
}
REGRESSORS = {
    "linear": Regressor(
        title="linear",
        settled="Least squares on three features; found by its printed row, as is the split.",
        make=_make_linear,
        scaled=True,
        primary_features=("bpr", "molar_ratio", "time_h"),
        keep=lambda fit: {"coefficients": fit.coef_.tolist(), "intercept": float(fit.intercept_)},
        restore=_restore_linear,
    ),
    "gpr": Regressor(
        title="GPR",
        settled="The search sets where the marginal likelihood starts, with a length scale for each feature; both read "
        "off the printed row.",
        make=_make_gpr,
        **OF_A_PROCESS,
    ),
    "rf": Regressor(
        title="random forest",
        settled="Every node sees all features; one seed for everything, not chosen.",
        make=_make_forest,
        forest=True,
        seeded=True,
        explain=_explain_forest,
        fold_predictor=_forest_folds,
    ),
    "svr": Regressor(
        title="SVR",
        settled="One seed for everything, not chosen.",
        make=_make_svr,
        scaled=True,
    ),
    "xgb": Regressor(
        title="XGBoost",
        settled="One seed for everything, not chosen; seeds.tsv shows what other seeds of the trees do.",
        make=_make_xgb,
        seeded=True,
        keep=lambda estimator: {"booster": estimator.booster.save_raw("json").decode()},
        restore=_restore_xgb,
        explain=_explain_xgb,
        fold_predictor=_boosting_folds,
    ),
    "gpr_starts": Regressor(
        title="GPR, several starts",
        settled="Not of the thesis. Nothing is searched: of several starts within Table 5.2, the one that ends at the "
        "largest marginal likelihood.",
        make=_make_gpr,
        **OF_A_PROCESS,
    ),
}
# Names of the models in figures.
TITLES = {name: record.title for name, record in REGRESSORS.items()} | {
    AVERAGED: "averaged GPR",
    CLIMATOLOGY: "climatology",
    SURFACE: "response surface",
}


def regressor(name: str) -> Regressor:
    """The record of a regressor. Raises ValueError for an unknown name."""
    if name not in REGRESSORS:
        raise ValueError(f"{name!r}: no such regressor; known: {', '.join(REGRESSORS)}")
    return REGRESSORS[name]


def training_of(name: str) -> Training:
    """How a regressor is trained. Raises ValueError for an unknown name."""
    regressor(name)
    return TRAININGS[name]


def models_of(names: Sequence[str]) -> list[tuple[str, str]]:
    """Regressor and strategy of every model of the named regressors, in order. Raises ValueError for an unknown one."""
    return [(name, strategy) for name in names for strategy in training_of(name).strategies]


# The nine models of Table 5.6.
MODELS = models_of(TABLE_5_6)


def other_seed(settings: TrainingConfig) -> TrainingConfig:
    """The settings with another seed of folds, search and trees, for the scatter of a trained model."""
    return settings.model_copy(update={"seed": settings.seed + 1})
