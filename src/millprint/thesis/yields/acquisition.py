"""The value of an experiment: expected improvement of the yield, and reduction of the model's variance."""

import numpy as np
import pandas as pd

from millprint.thesis.yields.averaging import LINKS, NODE_WEIGHTS, NODES, AveragedModel
from millprint.thesis.yields.features import describe

# Added to a covariance before it is factorised, in units of its largest variance.
JITTER = 1e-8
# Step in the link of the central difference that gives the slope of its inverse.
SLOPE_STEP = 1e-4


def expected_improvement(model: AveragedModel, rows: pd.DataFrame, best: float) -> np.ndarray:
    """Expected improvement E[max(yield - best, 0)], (n,) [pp], of one measurement at each row.

    rows: n rows with the six conditions; best: the highest yield so far [%].
    """
    inputs, total = describe(rows).to_numpy(), np.zeros(len(rows))
    for member, weight in zip(model.members, model.weights, strict=True):
        mean, deviation = member.latent(inputs)
        yields = 100 * LINKS[member.candidate.link].inverse(mean[:, None] + deviation[:, None] * NODES)
        total += weight * (np.maximum(np.clip(yields, 0, 100) - best, 0) @ NODE_WEIGHTS)
    return total


def joint_draws(model: AveragedModel, rows: pd.DataFrame, draws: int, generator: np.random.Generator) -> np.ndarray:
    """Joint draws of the yields without noise, (s, n) [%], with s about `draws`; each member gives its share of them.

    rows: n rows with the six conditions. Raises LinAlgError for a covariance that is not positive definite.
    """
    inputs, found = describe(rows).to_numpy(), []
    for member, weight in zip(model.members, model.weights, strict=True):
        count = round(weight * draws)
        mean, covariance = member.process.posterior(member.standard(inputs))
        covariance = covariance + JITTER * covariance.diagonal().max() * np.eye(len(rows))
        latent = mean + generator.standard_normal((count, len(rows))) @ np.linalg.cholesky(covariance).T
        found.append(100 * LINKS[member.candidate.link].inverse(member.mean + member.spread * latent))
    return np.clip(np.concatenate(found), 0, 100)


def choose_for_yield(
    draws: np.ndarray, best: float, runs: int, waiting: np.ndarray | None = None, smallest: float = 0.0
) -> list[tuple[int, float]]:
    """The batch of the largest joint expected improvement, chosen one by one: (column, gain [pp]) in order.

    draws: (s, n) joint draws [%]; best: highest yield so far [%]. The improvement of a batch is that of its best run:
    the mean of max(best, y_1, ..., y_q) - best over the draws (Ginsbourger et al. 2010). A run close to one that is
    already chosen therefore adds little. The gain of a run is what it adds to the runs chosen before it, and to those
    whose yields are awaited: waiting, (s, m), has their joint draws [%]. A run that adds less than `smallest` [pp] ends
    the batch.
    """
    reached = np.full(len(draws), best)
    if waiting is not None and waiting.shape[1]:
        reached = np.maximum(reached, waiting.max(axis=1))
    chosen: list[tuple[int, float]] = []
    for _ in range(min(runs, draws.shape[1])):
        gains = np.maximum(draws - reached[:, None], 0).mean(axis=0)
        gains[[column for column, _ in chosen]] = -1.0
        column = int(gains.argmax())
        if gains[column] < smallest:
            break
        chosen.append((column, float(gains[column])))
        reached = np.maximum(reached, draws[:, column])
    return chosen


def choose_for_learning(
    model: AveragedModel,
    rows: pd.DataFrame,
    reference: np.ndarray,
    runs: int,
    given: np.ndarray | None = None,
    candidates: np.ndarray | None = None,
) -> list[tuple[int, float]]:
    """The batch that reduces the integrated variance most, chosen one by one: (position, share of the variance).

    rows: n rows with the six conditions; reference: positions (m,) of the rows over which the variance of the yield is
    summed. A measurement at row j lowers the variance at row r by cov(r, j)^2 / (var(j) + noise), whatever its result.
    So each run is chosen as if those before it were done, and the rows at the positions `given`, whose yields are
    awaited. candidates: positions that may be chosen; None for all. A bounded link is replaced by its tangent at the
    mean. A share is of the variance before anything is done.
    """
    inputs = describe(rows).to_numpy()
    states: list[tuple[np.ndarray, float]] = []
    weights, total = [], 0.0
    for member, weight in zip(model.members, model.weights, strict=True):
        mean, covariance = member.process.posterior(member.standard(inputs))
        inverse, latent = LINKS[member.candidate.link].inverse, member.mean + member.spread * mean
        slope = (inverse(latent + SLOPE_STEP) - inverse(latent - SLOPE_STEP)) / (2 * SLOPE_STEP)
        scale = weight * (100 * member.spread * slope[reference]) ** 2
        total += float(scale @ covariance.diagonal()[reference])
        states.append((covariance, member.process.noise))
        weights.append(scale)
    for position in [] if given is None else given:
        states = [(_measured(covariance, noise, int(position)), noise) for covariance, noise in states]
    offered = np.arange(len(rows)) if candidates is None else candidates
    barred = np.ones(len(rows), dtype=bool)
    barred[offered] = False
    chosen: list[tuple[int, float]] = []
    for _ in range(min(runs, len(offered))):
        gains = np.zeros(len(rows))
        for (covariance, noise), scale in zip(states, weights, strict=True):
            gains += scale @ covariance[reference] ** 2 / (covariance.diagonal() + noise)
        gains[barred] = -1.0
        best = int(gains.argmax())
        chosen.append((best, float(gains[best] / total)))
        barred[best] = True
        states = [(_measured(covariance, noise, best), noise) for covariance, noise in states]
    return chosen


def _measured(covariance: np.ndarray, noise: float, position: int) -> np.ndarray:
    """The covariance (n, n) after a measurement at one position, whatever its result."""
    column = covariance[:, position]
    return covariance - np.outer(column, column) / (covariance[position, position] + noise)
