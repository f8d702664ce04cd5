"""Several seeds of one condition: how far a run is from the mean of many, and when this estimate cannot be trusted.

The scatter of a run is seen twice: within its window, between turns, and between seeds. Both estimate the variance of
one run, so they are pooled by their degrees of freedom; where seeds vary by more than their windows explain, the
variance between seeds counts. Where they do so beyond chance, as where balls lock onto one of several lasting motions,
windows are ignored and only seeds count: k - 1 degrees of freedom.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

# Probability of taking seeds of the same motion for several motions; independent turns that suffice.
CHANCE, FEWEST_TURNS = 0.01, 8


class Run(NamedTuple):
    """Variance of one run about the mean of many, its degrees of freedom, and whether seeds differ beyond chance."""

    variance: float
    freedom: int
    differ: bool


def block_length(revolutions: int) -> int:
    """Length of a bootstrap block [revolutions]; at most half of `revolutions`, so that draws differ."""
    return max(1, min(int(np.ceil(revolutions ** (1 / 3) - 1e-9)), revolutions // 2))


def variance_of_run(values: Sequence[float], within: Sequence[tuple[float, int]]) -> Run | None:
    """The variance of one run, estimated from k seeds; None for a single run without an estimate.

    values: of the runs (k,). within: variance and degrees of freedom of each run whose window gives them. w is the mean
    of these variances weighted by their degrees of freedom, v in all, and b the variance of the values. The result is b
    with k - 1 degrees where b / w is beyond the F distribution's quantile 1 - CHANCE, else max(b, pooled),
    pooled = (v w + (k - 1) b) / (v + k - 1). The mean of the runs has 1/k of the variance of one run.
    """
    seeds = len(values)
    between = float(np.var(values, ddof=1)) if seeds > 1 else 0.0
    inside = sum(freedom for _, freedom in within)
    squares = sum(variance * freedom for variance, freedom in within)
    freedom = inside + seeds - 1
    if freedom == 0:
        return None
    # Seeds that agree to the last digits of a number do not differ.
    if seeds > 1 and inside and np.ptp(values) > 1e-9 * np.max(np.abs(values)):
        # Imported here: slow to import, and most conditions have one seed.
        from millprint.statistics.quantiles import f_exceeded

        limit = float(f_exceeded(CHANCE, seeds - 1, inside))
        if between > limit * squares / inside:
            return Run(between, seeds - 1, True)
    return Run(max(between, (squares + (seeds - 1) * between) / freedom), freedom, False)


class Motion(NamedTuple):
    """A reason why a standard error may be wrong: a word, and what it means with what to do."""

    word: str
    meaning: str


MOTIONS: Mapping[str, Motion] = {
    "no_impacts": Motion(
        "no impacts",
        "all balls move with the wall, as one layer that goes round or at rest on it, and nothing hits; curves "
        "leave it out: take a higher fill ratio or another speed",
    ),
    "few_turns": Motion(
        "few turns",
        f"fewer than {FEWEST_TURNS} independent turns were recorded, so that the scatter of a run is hardly known: "
        "record a longer window",
    ),
    "repeats": Motion(
        "repeats",
        "the motion is locked to the drive and repeats itself, so that turns do not show other lasting motions: "
        "simulate more seeds",
    ),
    "seeds_differ": Motion(
        "seeds differ",
        "seeds differ by more than their turns explain, as where several motions last: simulate more seeds, and take "
        "the mean as one over these motions",
    ),
}


def motion_of(impacts: int, independent: float, repeating: int, differ: bool) -> list[Motion]:
    """Why the standard errors of a condition may be wrong, from its turns and seeds: some of MOTIONS.

    impacts: seeds whose balls hit anything; independent: turns of all seeds; repeating: seeds whose motion repeats;
    differ: whether seeds differ beyond chance.
    """
    said = {
        "no_impacts": impacts == 0,
        "few_turns": independent < FEWEST_TURNS,
        "repeats": repeating > 0,
        "seeds_differ": differ,
    }
    return [MOTIONS[name] for name, holds in said.items() if holds]
