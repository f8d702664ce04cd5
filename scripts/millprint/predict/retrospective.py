"""A test of the proposals on the runs that were done: how many it takes to find the best one, against chance."""

from collections.abc import Callable

import numpy as np
import pandas as pd
from scipy.stats import t
from statsmodels.stats.proportion import proportion_confint

from millprint.config.averaging import AveragingConfig
from millprint.config.proposals import RetrospectiveConfig
from millprint.doe.runs import YIELD
from millprint.predict.acquisition import expected_improvement
from millprint.predict.averaging import AveragedModel, fit_averaged

IMPROVEMENT, GREEDY, CHANCE = "expected_improvement", "highest_mean", "random"
Merit = Callable[[AveragedModel, pd.DataFrame, float], np.ndarray]
MERITS: dict[str, Merit] = {
    IMPROVEMENT: expected_improvement,
    GREEDY: lambda model, rows, best: model.predict(rows),
}


def smaller_library(averaging: AveragingConfig, settings: RetrospectiveConfig) -> AveragingConfig:
    """The library with only the links and structures of the test, to save time: every step fits the library again."""
    return averaging.model_copy(update={"links": settings.links, "structures": settings.structures})


def draw_starts(yields: np.ndarray, settings: RetrospectiveConfig) -> list[np.ndarray]:
    """Positions (start_runs,) of the runs known at each start, never with a run of the highest yield.

    yields: (n,) [%]. Raises ValueError if there are too few other runs.
    """
    generator, others = np.random.default_rng(settings.seed), np.flatnonzero(yields < yields.max())
    return [generator.choice(others, settings.start_runs, replace=False) for _ in range(settings.starts)]


def search_best(rows: pd.DataFrame, start: np.ndarray, merit: Merit, averaging: AveragingConfig) -> np.ndarray:
    """Best yield known after each run, (runs,) [%], from the start until the best run of all is found.

    rows: the six conditions and yield_percent. At each step a model is fitted to the known runs, and the run with the
    largest merit among the others becomes known. start: positions of the runs known at first.
    """
    yields = rows[YIELD].to_numpy(float)
    known, reached = list(start), [float(yields[start].max())]
    while reached[-1] < yields.max():
        left = np.setdiff1d(np.arange(len(rows)), known)
        model = fit_averaged(rows.iloc[known], yields[known], averaging)
        known.append(int(left[merit(model, rows.iloc[left], reached[-1]).argmax()]))
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


def summarise_search(table: pd.DataFrame, reached: dict[str, list[np.ndarray]], level: float) -> pd.DataFrame:
    """Runs to the best, start included: strategy, mean_runs with a t interval over starts, median_runs, starts."""
    found = []
    for strategy, rows in table.groupby("strategy", sort=False):
        first = int(rows["runs"].iloc[0])
        if strategy == CHANCE:
            # E[N] = sum over n of P(N > n).
            mean, half, starts = first + float((1 - rows["found"]).sum()), 0.0, np.nan
        else:
            counts = np.array([first + len(path) - 1 for path in reached[strategy]], dtype=float)
            mean, starts = float(counts.mean()), len(counts)
            spread = float(counts.std(ddof=1)) if starts > 1 else np.nan
            half = float(t.ppf(0.5 + level / 2, max(starts - 1, 1)) * spread / np.sqrt(starts))
        median = int(rows.loc[rows["found"] >= 0.5, "runs"].iloc[0])
        about = {"strategy": strategy, "mean_runs": mean, "lower": mean - half, "upper": mean + half}
        found.append(about | {"median_runs": median, "starts": starts})
    return pd.DataFrame(found)
