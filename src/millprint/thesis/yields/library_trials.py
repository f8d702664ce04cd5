"""How much the choice of the averaged process's library changes its score, and whether chance could reach that score.

The library before the present one was fixed after some 130 kernels had been compared by leave-one-out, so its score
holds a choice that no fold has seen. Random halves of a library show how far such a choice moves the score. The present
library was declared by argument before any score of it was computed (millprint.config.averaged_process).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from millprint.config.averaged_process import AveragingConfig, LibraryConfig
from millprint.config.yields import LibraryTrialConfig
from millprint.thesis.doe.runs import YIELD
from millprint.thesis.yields.averaging import (
    Candidate,
    Member,
    average,
    evidence_weights,
    fit_described,
    fit_library,
    library,
)
from millprint.thesis.yields.distributions import SCORE_COLUMNS, MixtureYields
from millprint.thesis.yields.evaluation import COMPARED, WHOLE, paired_test
from millprint.thesis.yields.features import describe
from millprint.thesis.yields.held_out import OuterFold
from millprint.thesis.yields.metrics import SPREAD, YieldWeights, jackknife_error, metrics, spread, without_each

DECLARED, EARLIER = "declared", "earlier"
DIFFERENCE = f"{DECLARED} minus {EARLIER}"
SHOWN = ("r2", "rmse")
# What a spread is over.
REPEATS, HALVES = "repeats", "halves"
Tick = Callable[[], None]


def earlier_library(settings: AveragingConfig, earlier: LibraryConfig) -> list[Candidate]:
    """The members of the library that was used before: other links and scales of time."""
    scales = settings.scales | {"time_h": earlier.time_h}
    return library(settings.model_copy(update={"links": earlier.links, "scales": scales}))


@dataclass(frozen=True)
class Refit:
    """Every member, fitted without the runs of a fold: means (members, held) [%], log evidences (members,)."""

    fold: OuterFold
    members: list[Member]
    expected: np.ndarray
    evidence: np.ndarray


def refit_members(
    rows: pd.DataFrame, candidates: Sequence[Candidate], folds: list[OuterFold], settings: AveragingConfig, tick: Tick
) -> list[Refit]:
    """All candidates, fitted in every fold on its training rows only."""
    found = []
    for fold in folds:
        known, unseen = (describe(rows.iloc[part]).to_numpy() for part in (fold.kept, fold.held))
        members = [fit_described(each, known, fold.yields[fold.kept], settings) for each in candidates]
        expected = 100 * np.stack([member.expected(unseen) for member in members])
        found.append(Refit(fold, members, expected, np.array([member.log_evidence for member in members])))
        tick()
    return found


def predict_runs(
    refits: list[Refit], chosen: np.ndarray, settings: AveragingConfig, rows: pd.DataFrame
) -> pd.DataFrame:
    """Held-out predictions of the average over the members at `chosen` positions.

    Columns: scheme, repeat, fold, case, yield_percent, predicted_percent, SCORE_COLUMNS.
    """
    tables = []
    for refit in refits:
        fold, unseen = refit.fold, rows.iloc[refit.fold.held]
        model, truth = average([refit.members[index] for index in chosen], settings), fold.yields[fold.held]
        scores = MixtureYields.of(model.members, model.weights, unseen, settings.margin).scores(truth)
        about = {"scheme": fold.scheme, "repeat": fold.repeat, "fold": fold.number, "case": unseen["case"].to_numpy()}
        found = {"yield_percent": truth, "predicted_percent": model.predict(unseen)}
        tables.append(pd.DataFrame({**about, **found, **dict(zip(SCORE_COLUMNS, scores, strict=True))}))
    return pd.concat(tables, ignore_index=True)


def _collect(refits: list[Refit], by_fold: list[np.ndarray], count: int) -> tuple[np.ndarray, np.ndarray]:
    """Yields and predictions (repeats, cases) [%], from a prediction for the held-out runs of each fold."""
    repeats = 1 + max(refit.fold.repeat for refit in refits)
    predicted, truth = np.full((repeats, count), np.nan), np.full((repeats, count), np.nan)
    for refit, values in zip(refits, by_fold, strict=True):
        predicted[refit.fold.repeat, refit.fold.held] = values
        truth[refit.fold.repeat] = refit.fold.yields
    return truth, predicted


def _mixed(refit: Refit, chosen: np.ndarray, settings: AveragingConfig) -> np.ndarray:
    """Mean yields (held,) [%] of the average over the members at `chosen` positions."""
    return evidence_weights(refit.evidence[chosen], settings.smallest_weight) @ refit.expected[chosen]


def _summary(name: str, scheme: str, members: int, table: pd.DataFrame, weigh: YieldWeights) -> list[dict]:
    """One row for each metric and score of a whole library."""
    wide = table.pivot(index="repeat", columns="case", values=["yield_percent", "predicted_percent"])
    truth, predicted = wide["yield_percent"].to_numpy(), wide["predicted_percent"].to_numpy()
    left, values = without_each(truth.shape[1]), metrics(truth, predicted, weigh)
    parts = metrics(truth[:, left], predicted[:, left], weigh)
    about = {"library": name, "scheme": scheme, "members": members, "over": REPEATS}
    rows = [
        about
        | {"metric": key, "value": float(np.mean(values[key]))}
        | {"error": float(jackknife_error(np.asarray(parts[key]).mean(axis=0)))}
        | spread(values[key])
        for key in SHOWN
    ]
    for key in SCORE_COLUMNS[:2]:
        means = table.groupby("case")[key].mean().to_numpy()
        error = float(jackknife_error(means[left].mean(axis=-1)))
        own = {"metric": key, "value": float(means.mean()), "error": error}
        rows.append(about | own | spread(table.groupby("repeat")[key].mean()))
    return rows


def _halves(
    name: str,
    refits: list[Refit],
    own: np.ndarray,
    settings: AveragingConfig,
    trial: LibraryTrialConfig,
    weigh: YieldWeights,
    scheme: str,
) -> list[dict]:
    """Each metric over random halves of a library: the median, and SPREAD."""
    generator, size = np.random.default_rng(trial.seed), (len(own) + 1) // 2
    scores: dict[str, list[float]] = {key: [] for key in SHOWN}
    for _ in range(trial.sub_libraries):
        chosen = generator.choice(own, size, replace=False)
        count = len(refits[0].fold.yields)
        found = metrics(*_collect(refits, [_mixed(refit, chosen, settings) for refit in refits], count), weigh)
        for key in SHOWN:
            scores[key].append(float(np.mean(found[key])))
    about = {"library": f"random halves of the {name}", "scheme": scheme, "members": size, "over": HALVES}
    return [
        about | {"metric": key, "value": float(np.median(values))} | spread(values) for key, values in scores.items()
    ]


def compare_libraries(
    rows: pd.DataFrame,
    folds: list[OuterFold],
    settings: AveragingConfig,
    trial: LibraryTrialConfig,
    weigh: YieldWeights,
    tick: Tick = lambda: None,
) -> pd.DataFrame:
    """The declared library, the one before it and random halves of both, by leave-one-out and repeated k-fold.

    rows: case, the six conditions, yield_percent. Columns: library, scheme, members, metric, value (a median for
    halves), error (a jackknife, or that of the paired test), p (of the test that both libraries are equal), over (the
    repeats of a library, or random halves of it), SPREAD (over these).
    """
    whole = {DECLARED: library(settings), EARLIER: earlier_library(settings, trial.earlier)}
    candidates = list(dict.fromkeys([*whole[DECLARED], *whole[EARLIER]]))
    places = {name: np.array([candidates.index(each) for each in own]) for name, own in whole.items()}
    table: list[dict] = []
    for scheme in WHOLE:
        refits = refit_members(rows, candidates, [fold for fold in folds if fold.scheme == scheme], settings, tick)
        runs = {name: predict_runs(refits, own, settings, rows) for name, own in places.items()}
        for name, own in places.items():
            table += _summary(name, scheme, len(own), runs[name], weigh)
            table += _halves(name, refits, own, settings, trial, weigh, scheme)
        for metric in COMPARED:
            test = paired_test(runs[DECLARED], runs[EARLIER], scheme, metric)
            kept = {"value": test["difference"], "over": REPEATS} | {key: test[key] for key in ("error", "p", *SPREAD)}
            table.append({"library": DIFFERENCE, "scheme": scheme, "metric": metric, **kept})
    columns = ["library", "scheme", "members", "metric", "value", "error", "p", "over", *SPREAD]
    return pd.DataFrame(table, columns=columns)


def closed_form_r2(rows: pd.DataFrame, yields: np.ndarray, settings: AveragingConfig) -> float:
    """R2 of the average by leave-one-out in closed form; hyper-parameters and weights are those of all rows.

    Not an honest score, since every run has helped to set hyper-parameters and weights, but a fair statistic for a
    permutation test: each shuffle goes through the same. yields: (n,) [%].
    """
    model = average(fit_library(rows, yields, settings), settings)
    predicted = 100 * model.weights @ np.stack([member.left_out() for member in model.members])
    return float(1 - np.sum((yields - predicted) ** 2) / np.sum((yields - yields.mean()) ** 2))


def permute(
    rows: pd.DataFrame, settings: AveragingConfig, trial: LibraryTrialConfig, tick: Tick = lambda: None
) -> pd.DataFrame:
    """closed_form_r2 of the measured yields and of shuffles of them: columns permutation (0: measured), r2.

    Shuffling keeps the yields and the conditions and takes away every relation between them.
    """
    yields, generator = rows[YIELD].to_numpy(float), np.random.default_rng(trial.seed)
    shuffles = [yields, *(generator.permutation(yields) for _ in range(trial.permutations))]
    found = []
    for shuffled in shuffles:
        found.append(closed_form_r2(rows, shuffled, settings))
        tick()
    return pd.DataFrame({"permutation": range(len(found)), "r2": found})


def permutation_p(table: pd.DataFrame) -> pd.DataFrame:
    """One row: measure, measured, permutations, median, highest, p.

    p = (1 + shuffles at least as good) / (1 + shuffles).

    Phipson and Smyth, Stat. Appl. Genet. Mol. Biol. 9 (2010) 39: the measured order is one of the possible ones, so p
    is never 0.
    """
    measured = float(table.loc[table["permutation"] == 0, "r2"].iloc[0])
    shuffled = table.loc[table["permutation"] > 0, "r2"].to_numpy()
    found = {
        "measure": "R2 by leave-one-out in closed form",
        "measured": measured,
        "permutations": len(shuffled),
        "median": float(np.median(shuffled)),
        "highest": float(shuffled.max()),
        "p": float((1 + (shuffled >= measured).sum()) / (1 + len(shuffled))),
    }
    return pd.DataFrame([found])
