"""A test of the proposals on the runs that were done: how soon the best of them is found."""

from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd
from sklearn.base import RegressorMixin
from sklearn.linear_model import LinearRegression, RidgeCV
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from millprint.config.yields import AveragingConfig, RetrospectiveConfig
from millprint.estimate.estimates import mean_of
from millprint.thesis.doe.runs import YIELD
from millprint.thesis.yields.averaging import AveragedModel, fit_averaged
from millprint.thesis.yields.features import TIME, describe
from millprint.thesis.yields.proposals import expected_improvement

IMPROVEMENT, GREEDY, CHANCE = "expected_improvement", "highest_mean", "random"
LEAST_SQUARES, RIDGE, RULE = "least_squares", "ridge", "most_balls_longest_time"
# Penalties that ridge regression chooses from by leave-one-out, for standardised inputs.
PENALTIES = np.logspace(-2, 2, 9)
# The rows of the summary over every target.
ALL_TARGETS = "all"
# Known runs, their yields [%], the runs to choose from, the library, and random numbers for ties: the merit of each.
Strategy = Callable[[pd.DataFrame, np.ndarray, pd.DataFrame, AveragingConfig, np.random.Generator], np.ndarray]


def _averaged(merit: Callable[[AveragedModel, pd.DataFrame, float], np.ndarray]) -> Strategy:
    """By a merit of the averaged process of the known runs."""
    return lambda known, yields, left, library, _: merit(fit_averaged(known, yields, library), left, yields.max())


def _linear(make: Callable[[], RegressorMixin]) -> Strategy:
    """By the prediction of a linear model in the standardised inputs of the averaged process."""

    def merit(
        known: pd.DataFrame, yields: np.ndarray, left: pd.DataFrame, _: AveragingConfig, __: np.random.Generator
    ) -> np.ndarray:
        return make_pipeline(StandardScaler(), make()).fit(describe(known), yields).predict(describe(left))

    return merit


def rule_merit(left: pd.DataFrame, generator: np.random.Generator) -> np.ndarray:
    """The rank by ball-to-powder ratio, then by milling time; what is equal in both is in random order."""
    order = np.lexsort((generator.random(len(left)), left[TIME], left["bpr"]))
    return np.argsort(order)


STRATEGIES: dict[str, Strategy] = {
    IMPROVEMENT: _averaged(expected_improvement),
    GREEDY: _averaged(lambda model, rows, best: model.predict(rows)),
    LEAST_SQUARES: _linear(LinearRegression),
    RIDGE: _linear(lambda: RidgeCV(PENALTIES)),
    RULE: lambda known, yields, left, library, generator: rule_merit(left, generator),
}


def smaller_library(averaging: AveragingConfig, settings: RetrospectiveConfig) -> AveragingConfig:
    """The library with only the links and structures of the test, to save time: every step fits the library again."""
    return averaging.model_copy(update={"links": settings.links, "structures": [*settings.structures]})


def without_best(rows: pd.DataFrame, count: int) -> pd.DataFrame:
    """The rows without the `count` runs of the highest yields, so that the best of the others becomes the target."""
    kept = rows[YIELD].sort_values(ascending=False, kind="stable").index[count:]
    return rows.loc[rows.index.isin(kept)].reset_index(drop=True)


def draw_starts(yields: np.ndarray, settings: RetrospectiveConfig) -> list[np.ndarray]:
    """Positions (start_runs,) of the runs known at each start, never with a run of the highest yield.

    yields: (n,) [%]. Raises ValueError if there are too few other runs.
    """
    generator, others = np.random.default_rng(settings.seed), np.flatnonzero(yields < yields.max())
    return [generator.choice(others, settings.start_runs, replace=False) for _ in range(settings.starts)]


def search_best(
    rows: pd.DataFrame, start: np.ndarray, strategy: Strategy, averaging: AveragingConfig, seed: int = 0
) -> np.ndarray:
    """Best yield known after each run, (runs,) [%], from the start until the best run of all is found.

    rows: the six conditions and yield_percent. At each step the run with the largest merit among the others becomes
    known; the merit sees the yields of known runs only. start: positions of the runs known at first; seed: of ties.
    """
    yields, generator = rows[YIELD].to_numpy(float), np.random.default_rng(seed)
    known, reached = list(start), [float(yields[start].max())]
    while reached[-1] < yields.max():
        left = np.setdiff1d(np.arange(len(rows)), known)
        merit = strategy(rows.iloc[known], yields[known], rows.iloc[left], averaging, generator)
        known.append(int(left[merit.argmax()]))
        reached.append(max(reached[-1], yields[known[-1]]))
    return np.array(reached)


def chance(count: int, start_runs: int, best: int) -> np.ndarray:
    """Probability that the first n of `count` runs in random order include one of the `best` best runs.

    An array for n = start_runs .. count. None of the best is among the first `start_runs`: 1 - C(left - best, k) /
    C(left, k) for k further runs of `left`.
    """
    left = count - start_runs
    missed = [1.0]
    for done in range(left):
        missed.append(missed[-1] * max(left - best - done, 0) / (left - done))
    return 1 - np.array(missed)


def search_table(
    reached: dict[str, list[np.ndarray]], yields: np.ndarray, start_runs: int, level: float
) -> pd.DataFrame:
    """Share of starts that have found the best run after n runs: strategy, runs, found, lower, upper, best_percent.

    The interval is Clopper and Pearson's over starts; that of chance is exact and has no width. best_percent is the
    mean of the best yield known; it is NaN for chance.
    """
    from statsmodels.stats.proportion import proportion_confint

    runs = np.arange(start_runs, len(yields) + 1)
    tables = []
    for strategy, paths in reached.items():
        known = np.array([np.pad(path, (0, len(runs) - len(path)), mode="edge") for path in paths])
        hits, starts = (known >= yields.max()).sum(axis=0), len(paths)
        lower, upper = proportion_confint(hits, starts, alpha=1 - level, method="beta")
        columns = {"found": hits / starts, "lower": lower, "upper": upper, "best_percent": known.mean(axis=0)}
        tables.append(pd.DataFrame({"strategy": strategy, "runs": runs, **columns}))
    exact = chance(len(yields), start_runs, int((yields == yields.max()).sum()))
    columns = {"found": exact, "lower": exact, "upper": exact, "best_percent": np.nan}
    tables.append(pd.DataFrame({"strategy": CHANCE, "runs": runs, **columns}))
    return pd.concat(tables, ignore_index=True)


def _columns(values: np.ndarray, level: float, names: Sequence[str]) -> dict[str, float]:
    """The mean and the ends of Student's interval by column; the ends are NaN for one value."""
    found = mean_of(values, "-", level)
    return dict(zip(names, (found.value, *found.ends("repeats")), strict=True))


MEAN_RUNS, FEWER = ("mean_runs", "lower", "upper"), ("fewer_than_search", "fewer_lower", "fewer_upper")


def summarise_search(
    tables: list[pd.DataFrame], reached: list[dict[str, list[np.ndarray]]], targets: list[str], level: float
) -> pd.DataFrame:
    """Runs to the best, start included, for every target, and over all of them.

    tables, reached: of each target, as search_table returns and takes them; targets: the case of each. Columns: target,
    strategy, mean_runs, lower, upper, median_runs, starts, and fewer_than_search: the mean of the runs that expected
    improvement takes less those of the strategy, from the same starts, with fewer_lower and fewer_upper, and
    conclusion. The intervals of one target are Student's over starts: they say what another start would change, not
    what another best run would. Those of the last rows, for the target `all`, are over targets, each a mean over its
    starts: they say whether the order of the strategies would hold for other best runs.
    """
    counts: list[dict[str, np.ndarray]] = []
    rows = []
    for table, paths, target in zip(tables, reached, targets, strict=True):
        first = int(table["runs"].iloc[0])
        own = {name: np.array([first + len(path) - 1 for path in each], dtype=float) for name, each in paths.items()}
        # E[N] = sum over n of P(N > n).
        exact = first + float((1 - table.loc[table["strategy"] == CHANCE, "found"]).sum())
        counts.append(own | {CHANCE: np.full(len(own[IMPROVEMENT]), exact)})
        for strategy, found in counts[-1].items():
            part = table[table["strategy"] == strategy]
            rows.append(
                {"target": target, "strategy": strategy}
                | _columns(found, level, MEAN_RUNS)
                | {"median_runs": part.loc[part["found"] >= 0.5, "runs"].iloc[0], "starts": len(found)}
                | _against_search(counts[-1][IMPROVEMENT] - found, level, "starts")
            )
    for strategy in counts[0]:
        means = np.array([own[strategy].mean() for own in counts])
        search = np.array([own[IMPROVEMENT].mean() for own in counts])
        rows.append(
            {"target": ALL_TARGETS, "strategy": strategy}
            | _columns(means, level, MEAN_RUNS)
            | {"starts": len(means) * len(counts[0][strategy])}
            | _against_search(search - means, level, "targets")
        )
    summary = pd.DataFrame(rows)
    summary.loc[summary["strategy"] == IMPROVEMENT, list(FEWER)] = np.nan
    summary.loc[summary["strategy"] == IMPROVEMENT, "conclusion"] = ""
    return summary


def _against_search(fewer: np.ndarray, level: float, over: str) -> dict[str, float | str]:
    """The paired differences, their mean and interval, and what follows in words."""
    found = _columns(fewer, level, FEWER)
    _, lower, upper = found.values()
    if lower > 0:
        words = f"needs fewer runs than the search over these {over}"
    elif upper < 0:
        words = f"needs more runs than the search over these {over}"
    else:
        words = f"cannot be told from the search by these {over}"
    return {**found, "conclusion": words}
