"""Everything that was tried for a better model, each by leave-one-out with whatever it chooses chosen in the fold.

Within a run nothing is chosen by these figures. The library itself was not made blind, though: before it was fixed,
some 130 kernels were looked at by leave-one-out, and once fixed it was looked at four times (as it is but for straight
lines, with other mechanical inputs, with hyper-parameters integrated out, with straight lines added), each time with
0.86 to 0.89 for the average. So the best member's figure flatters it, and that of a rule is fair but for what that
looking put into the library.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.optimize import nnls
from sklearn.ensemble import HistGradientBoostingRegressor
from sklearn.linear_model import ARDRegression
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import PolynomialFeatures, StandardScaler

from millprint.config.averaging import INPUTS, AveragingConfig
from millprint.doe.runs import YIELD
from millprint.predict.averaging import average, fit_library, library
from millprint.predict.features import CHEMICAL, TIME
from millprint.predict.inputs import describe
from millprint.predict.links import LINKS, to_conversion
from millprint.predict.metrics import YieldWeights, metrics

# Weight of the condition that stacking weights add up to one.
SUM_TO_ONE = 1e3
FIXED, IN_FOLD = "nothing", "in the fold"


@dataclass(frozen=True)
class Trial:
    """Leave-one-out predictions (n,) [%] of one thing tried, and what it had to choose."""

    kind: str
    name: str
    chosen: str
    predicted: np.ndarray


def stacking_weights(left_out: np.ndarray, yields: np.ndarray) -> np.ndarray:
    """Weights (m,) >= 0 that add up to one and fit left-out predictions (n, m) to yields (n,) best."""
    bound = np.full(left_out.shape[1], SUM_TO_ONE)
    weights = nnls(np.vstack([left_out, bound]), np.append(yields, SUM_TO_ONE))[0]
    return weights / weights.sum()


def _boosted_trees(rows: pd.DataFrame, yields: np.ndarray, asked: pd.DataFrame, rising: bool) -> np.ndarray:
    """Boosted trees at fixed settings on the inputs of the averaged process, `rising`: yields never fall with time."""
    signs = [int(rising and name == TIME) for name in INPUTS]
    model = HistGradientBoostingRegressor(
        max_iter=200, learning_rate=0.1, max_depth=3, min_samples_leaf=2, monotonic_cst=signs, early_stopping=False
    )
    return model.fit(describe(rows).to_numpy(), yields).predict(describe(asked).to_numpy())


def _rising_xgboost(rows: pd.DataFrame, yields: np.ndarray, asked: pd.DataFrame, rising: bool, seed: int) -> np.ndarray:
    from xgboost import XGBRegressor

    signs = tuple(int(rising and name == TIME) for name in INPUTS)
    model = XGBRegressor(
        n_estimators=200, learning_rate=0.1, max_depth=3, monotone_constraints=signs, random_state=seed, n_jobs=1
    )
    return model.fit(describe(rows).to_numpy(), yields).predict(describe(asked).to_numpy()).astype(float)


def _sparse_interactions(
    rows: pd.DataFrame, yields: np.ndarray, asked: pd.DataFrame, link: str, margin: float
) -> np.ndarray:
    """Bayesian linear regression with a relevance of its own for every main effect, square and interaction."""
    names = [*CHEMICAL, "power_per_ball_mW"]
    inputs, others = (np.log(describe(table)[names].to_numpy()) for table in (rows, asked))
    model = make_pipeline(StandardScaler(), PolynomialFeatures(2, include_bias=False), ARDRegression())
    seen = LINKS[link].forward(to_conversion(yields, margin))
    return 100 * LINKS[link].inverse(model.fit(inputs, seen).predict(others))


Rival = Callable[[pd.DataFrame, np.ndarray, pd.DataFrame], np.ndarray]


def rivals(settings: AveragingConfig, seed: int) -> dict[str, Rival]:
    """Models of other kinds, with nothing to choose."""

    def trees(rising: bool) -> Rival:
        return lambda rows, yields, asked: _boosted_trees(rows, yields, asked, rising)

    def boosted(rising: bool) -> Rival:
        return lambda rows, yields, asked: _rising_xgboost(rows, yields, asked, rising, seed)

    def sparse(link: str) -> Rival:
        return lambda rows, yields, asked: _sparse_interactions(rows, yields, asked, link, settings.margin)

    return {
        "histogram boosting": trees(rising=False),
        "histogram boosting, yield rises with time": trees(rising=True),
        "xgboost": boosted(rising=False),
        "xgboost, yield rises with time": boosted(rising=True),
        **{f"ARD regression with squares and interactions, {link}": sparse(link) for link in settings.links},
    }


def try_everything(
    rows: pd.DataFrame, settings: AveragingConfig, seed: int, tick: Callable[[], None] = lambda: None
) -> list[Trial]:
    """Leave-one-out predictions of every member, of every rule that picks or mixes members, and of other models.

    The rules see the training rows of a fold alone: evidence, or left-out predictions in closed form.
    """
    yields, candidates = rows[YIELD].to_numpy(float), library(settings)
    fixed = np.empty((len(rows), len(candidates)))
    rules = {name: np.empty(len(rows)) for name in ("average", "equal", "evidence", "left_out", "stacking")}
    others = rivals(settings, seed)
    rival = {name: np.empty(len(rows)) for name in others}
    for index in range(len(rows)):
        kept, asked, known = rows.drop(index=rows.index[index]), rows.iloc[[index]], np.delete(yields, index)
        members = fit_library(kept, known, settings)
        fixed[index] = [100 * member.expected(describe(asked).to_numpy())[0] for member in members]
        evidence = np.array([member.log_evidence for member in members])
        left_out = np.stack([100 * member.left_out() for member in members], axis=1)
        rules["average"][index] = average(members, settings).predict(asked)[0]
        rules["equal"][index] = fixed[index].mean()
        rules["evidence"][index] = fixed[index, evidence.argmax()]
        rules["left_out"][index] = fixed[index, ((left_out - known[:, None]) ** 2).mean(axis=0).argmin()]
        rules["stacking"][index] = fixed[index] @ stacking_weights(left_out, known)
        for name, predict in others.items():
            rival[name][index] = predict(kept, known, asked)[0]
        tick()
    said = {
        "average": "all members, weighted by evidence (the model of honest.tsv)",
        "equal": "all members, equal weights",
        "evidence": "the member of the largest evidence",
        "left_out": "the member of the smallest left-out error, hyper-parameters of all training rows",
        "stacking": "left-out predictions, non-negative weights",
    }
    trials = [Trial("rule", said[name], FIXED if name == "equal" else IN_FOLD, rules[name]) for name in rules]
    for number, candidate in enumerate(candidates):
        scales = ", ".join(f"{name} {scale}" for name, scale in zip(INPUTS, candidate.scales, strict=True))
        trials.append(Trial("member", f"{candidate.link}, {candidate.structure}; {scales}", FIXED, fixed[:, number]))
    return trials + [Trial("other", name, FIXED, predicted) for name, predicted in rival.items()]


def tabulate_trials(trials: list[Trial], yields: np.ndarray, weigh: YieldWeights) -> pd.DataFrame:
    """Columns: kind, name, chosen, and the metrics by leave-one-out."""
    return pd.DataFrame(
        {"kind": trial.kind, "name": trial.name, "chosen": trial.chosen, **metrics(yields, trial.predicted, weigh)}
        for trial in trials
    )
