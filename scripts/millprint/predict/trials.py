"""Leave-one-out scores of alternative yield models; a model that chooses something chooses it within each fold.

The program chooses nothing by these scores. The authors have seen such scores, though. Before the earlier library was
fixed, about 130 kernels were compared by leave-one-out. Afterwards it was evaluated four times: without the straight
lines, with other mechanical inputs, with hyper-parameters integrated out, and with the straight lines. Each time the
average reached an R2 of 0.86 to 0.89. The present library was declared by argument, before any score of it was
computed; but structures, inputs and priors are still those of the earlier one. The score of the best member is
therefore too high. That of a rule is fair, except for what these comparisons contributed. libraries.tsv shows how far
that may go (millprint.predict.library_trials).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import nnls
from sklearn.ensemble import HistGradientBoostingRegressor
from sklearn.linear_model import ARDRegression
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import PolynomialFeatures, StandardScaler

from millprint.config.averaging import INPUTS, AveragingConfig
from millprint.doe.runs import YIELD
from millprint.predict.averaging import LINKS, average, fit_library, library, to_conversion
from millprint.predict.features import CHEMICAL, POWER, TIME, describe
from millprint.predict.metrics import YieldWeights, metrics

# Weight, in the least squares, of the condition that stacking weights add up to one.
SUM_TO_ONE = 1e3
FIXED, IN_FOLD = "nothing", "in the fold"
# How each rule combines the members, and where it chooses.
RULES = {
    "average": ("all members, weighted by evidence (the model of honest.tsv)", IN_FOLD),
    "equal": ("all members, equal weights", FIXED),
    "evidence": ("the member of the largest evidence", IN_FOLD),
    "left_out": ("the member of the smallest left-out error, hyper-parameters of all training rows", IN_FOLD),
    "stacking": ("left-out predictions, non-negative weights", IN_FOLD),
}


@dataclass(frozen=True)
class Trial:
    """Leave-one-out predictions (n,) [%] of one model, and whether it chooses something in the fold."""

    kind: str
    name: str
    chosen: str
    predicted: np.ndarray


def stacking_weights(left_out: np.ndarray, yields: np.ndarray) -> np.ndarray:
    """Weights (m,) >= 0 that add up to one and fit left-out predictions (n, m) to yields (n,) best."""
    bound = np.full(left_out.shape[1], SUM_TO_ONE)
    weights = nnls(np.vstack([left_out, bound]), np.append(yields, SUM_TO_ONE))[0]
    return weights / weights.sum()


# Training rows, their yields (n,) [%] and the rows to predict.
Predict = Callable[[pd.DataFrame, np.ndarray, pd.DataFrame], np.ndarray]


def _on_inputs(model: Any) -> Predict:
    """A function that fits an estimator on the inputs of the averaged process, and predicts."""
    return lambda rows, yields, unseen: (
        model.fit(describe(rows).to_numpy(), yields).predict(describe(unseen).to_numpy()).astype(float)
    )


def _sparse_interactions(
    rows: pd.DataFrame, yields: np.ndarray, unseen: pd.DataFrame, link: str, margin: float
) -> np.ndarray:
    """Bayesian linear regression with a separate prior width for every main effect, square and interaction."""
    names = [*CHEMICAL, POWER]
    inputs, others = (np.log(describe(table)[names].to_numpy()) for table in (rows, unseen))
    model = make_pipeline(StandardScaler(), PolynomialFeatures(2, include_bias=False), ARDRegression())
    latent = LINKS[link].forward(to_conversion(yields, margin))
    return 100 * LINKS[link].inverse(model.fit(inputs, latent).predict(others))


def other_models(settings: AveragingConfig, seed: int) -> dict[str, Predict]:
    """Models of other kinds, at fixed settings; in some the yield cannot fall with time."""
    from xgboost import XGBRegressor

    free, rising = (0,) * len(INPUTS), tuple(int(name == TIME) for name in INPUTS)
    size = {"learning_rate": 0.1, "max_depth": 3}
    histogram = partial(HistGradientBoostingRegressor, max_iter=200, min_samples_leaf=2, early_stopping=False, **size)
    xgboost = partial(XGBRegressor, n_estimators=200, random_state=seed, n_jobs=1, **size)
    return {
        "histogram boosting": _on_inputs(histogram(monotonic_cst=free)),
        "histogram boosting, yield rises with time": _on_inputs(histogram(monotonic_cst=rising)),
        "xgboost": _on_inputs(xgboost(monotone_constraints=free)),
        "xgboost, yield rises with time": _on_inputs(xgboost(monotone_constraints=rising)),
        **{
            f"ARD regression with squares and interactions, {link}": partial(
                _sparse_interactions, link=link, margin=settings.margin
            )
            for link in settings.links
        },
    }


def run_trials(
    rows: pd.DataFrame, settings: AveragingConfig, seed: int, tick: Callable[[], None] = lambda: None
) -> list[Trial]:
    """Leave-one-out predictions of every member, of every rule that picks or mixes members, and of other models.

    rows: the six conditions and yield_percent. The rules see the training rows of a fold alone: evidence, or left-out
    predictions in closed form. tick: called after each fold.
    """
    yields, candidates, others = rows[YIELD].to_numpy(float), library(settings), other_models(settings, seed)
    by_member = np.empty((len(rows), len(candidates)))
    by_rule = {name: np.empty(len(rows)) for name in RULES}
    by_other = {name: np.empty(len(rows)) for name in others}
    for index in range(len(rows)):
        kept, unseen, known = rows.drop(index=rows.index[index]), rows.iloc[[index]], np.delete(yields, index)
        members = fit_library(kept, known, settings)
        inputs = describe(unseen).to_numpy()
        by_member[index] = [100 * member.expected(inputs)[0] for member in members]
        evidence = np.array([member.log_evidence for member in members])
        left_out = np.stack([100 * member.left_out() for member in members], axis=1)
        by_rule["average"][index] = average(members, settings).predict(unseen)[0]
        by_rule["equal"][index] = by_member[index].mean()
        by_rule["evidence"][index] = by_member[index, evidence.argmax()]
        by_rule["left_out"][index] = by_member[index, ((left_out - known[:, None]) ** 2).mean(axis=0).argmin()]
        by_rule["stacking"][index] = by_member[index] @ stacking_weights(left_out, known)
        for name, predict in others.items():
            by_other[name][index] = predict(kept, known, unseen)[0]
        tick()
    trials = [Trial("rule", title, chosen, by_rule[name]) for name, (title, chosen) in RULES.items()]
    for candidate, predicted in zip(candidates, by_member.T, strict=True):
        scales = ", ".join(f"{name} {scale}" for name, scale in zip(INPUTS, candidate.scales, strict=True))
        trials.append(Trial("member", f"{candidate.link}, {candidate.structure}; {scales}", FIXED, predicted))
    return trials + [Trial("other", name, FIXED, predicted) for name, predicted in by_other.items()]


def trial_table(trials: list[Trial], yields: np.ndarray, weigh: YieldWeights) -> pd.DataFrame:
    """Columns: kind, name, chosen, and the metrics by leave-one-out; yields: (n,) [%]."""
    return pd.DataFrame(
        {"kind": trial.kind, "name": trial.name, "chosen": trial.chosen, **metrics(yields, trial.predicted, weigh)}
        for trial in trials
    )
