"""A test of the proposals on the runs that were done: what the chosen runs teach of runs held out.

The best run is one draw, and a rule may find it by luck (millprint.thesis.yields.retrospective). The error of other
runs is what a search for information is for. So some runs are held out and never offered; each strategy chooses from
the rest, and the same averaged process, fitted on what is known, predicts the runs held out.
"""

from collections.abc import Callable

import numpy as np
import pandas as pd

from millprint.config.averaged_process import AveragingConfig
from millprint.config.next_experiments import RetrospectiveConfig
from millprint.thesis.doe.runs import YIELD
from millprint.thesis.yields.acquisition import choose_for_learning, expected_improvement
from millprint.thesis.yields.averaging import AveragedModel, fit_averaged
from millprint.thesis.yields.retrospective import CHANCE, IMPROVEMENT, RULE, mean_interval, rule_merit

LEARNING = "learning"
# Model of the known runs, positions of known and offered runs, all runs, random numbers: the position chosen.
Choice = Callable[[AveragedModel, np.ndarray, np.ndarray, pd.DataFrame, np.random.Generator], int]


def _for_learning(
    model: AveragedModel, _: np.ndarray, offered: np.ndarray, rows: pd.DataFrame, __: np.random.Generator
) -> int:
    """The run that lowers the variance of the yield most, summed over the settings of all runs."""
    return choose_for_learning(model, rows, np.arange(len(rows)), 1, candidates=offered)[0][0]


def _for_yield(
    model: AveragedModel, known: np.ndarray, offered: np.ndarray, rows: pd.DataFrame, _: np.random.Generator
) -> int:
    """The run of the largest expected improvement."""
    best = float(rows[YIELD].to_numpy(float)[known].max())
    return int(offered[expected_improvement(model, rows.iloc[offered], best).argmax()])


def _by_rule(
    _: AveragedModel, __: np.ndarray, offered: np.ndarray, rows: pd.DataFrame, generator: np.random.Generator
) -> int:
    """Most balls, then the longest time."""
    return int(offered[rule_merit(rows.iloc[offered], generator).argmax()])


def _by_chance(
    _: AveragedModel, __: np.ndarray, offered: np.ndarray, ___: pd.DataFrame, generator: np.random.Generator
) -> int:
    return int(generator.choice(offered))


CHOICES: dict[str, Choice] = {LEARNING: _for_learning, IMPROVEMENT: _for_yield, RULE: _by_rule, CHANCE: _by_chance}


def draw_held_out(count: int, settings: RetrospectiveConfig) -> list[tuple[np.ndarray, np.ndarray]]:
    """Positions of the runs known at first, (start_runs,), and of those held out, (held_out_runs,), for each start."""
    generator = np.random.default_rng(settings.seed)
    orders = [generator.permutation(count) for _ in range(settings.starts)]
    first, held = settings.start_runs, settings.held_out_runs
    return [(order[:first], order[first : first + held]) for order in orders]


def learn(
    rows: pd.DataFrame, start: np.ndarray, held: np.ndarray, choice: Choice, averaging: AveragingConfig, runs: int,
    seed: int,
) -> np.ndarray:  # fmt: skip
    """Mean absolute error of the runs held out [pp], (runs + 1,): at the start, and after each run that is chosen.

    rows: the six conditions and yield_percent; start, held: positions; runs: how many to choose; seed: of ties and of
    random choice. A strategy sees the settings of all runs, and the yields of the known ones.
    """
    yields, generator = rows[YIELD].to_numpy(float), np.random.default_rng(seed)
    known, errors = start, []
    while True:
        model = fit_averaged(rows.iloc[known], yields[known], averaging)
        errors.append(float(np.abs(model.predict(rows.iloc[held]) - yields[held]).mean()))
        if len(errors) > runs:
            return np.array(errors)
        offered = np.setdiff1d(np.arange(len(rows)), np.concatenate([known, held]))
        known = np.append(known, choice(model, known, offered, rows, generator))


def learning_table(errors: dict[str, np.ndarray], start_runs: int, level: float) -> pd.DataFrame:
    """What the chosen runs teach: strategy, runs, error_pp, less_than_chance_pp, their intervals, and conclusion.

    errors: of each strategy, (starts, runs + 1) as `learn` returns them. error_pp is the mean over starts, with lower
    and upper; less_than_chance_pp, with less_lower and less_upper, is that of random choice less it, from the same
    starts. Student's intervals are over starts: since all starts
    share the same runs, they say what another start would change, not what other runs would.
    """
    table = []
    for strategy, found in errors.items():
        for step in range(found.shape[1]):
            less = errors[CHANCE][:, step] - found[:, step]
            row = {"strategy": strategy, "runs": start_runs + step}
            row |= dict(zip(("error_pp", "lower", "upper"), mean_interval(found[:, step], level), strict=True))
            # Before the first choice, all are the same.
            if strategy != CHANCE and step:
                mean, lower, upper = mean_interval(less, level)
                row |= {"less_than_chance_pp": mean, "less_lower": lower, "less_upper": upper}
                row["conclusion"] = conclude(lower, upper)
            table.append(row)
    return pd.DataFrame(table)


def conclude(lower: float, upper: float) -> str:
    """What the interval of the difference to random choice says, in words."""
    if lower > 0:
        return "teaches more than random choice over these starts"
    if upper < 0:
        return "teaches less than random choice over these starts"
    return "cannot be told from random choice by these starts"
