"""Several seeds of one condition: how far a run lies from the mean of many, and what the runs say against that.

The scatter of a run is seen twice: within its window, between turns, and between seeds. Both estimate the variance of
one run, so they are pooled by their degrees of freedom; where seeds vary by more than their windows say, their variance
counts. Where they do so beyond chance, as where balls lock onto one of several lasting motions, windows tell nothing
and only seeds have a say: k - 1 degrees of freedom.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

# Probability at which seeds of one and the same motion are taken for several; independent turns that suffice.
CHANCE, FEWEST_TURNS = 0.01, 8


class Run(NamedTuple):
    """Variance of one run about the mean of many, its degrees of freedom, and whether seeds differ beyond chance."""

    variance: float
    freedom: int
    differ: bool


def variance_of_run(values: Sequence[float], within: Sequence[tuple[float, int]]) -> Run | None:
    """What k seeds say of the variance of one of them; None for a single one of which nothing is known.

    values: of the runs (k,). within: of each run whose window tells it, variance and degrees of freedom. With w the
    mean of these by their degrees of freedom v, and b the variance of the values: b with k - 1 where b / w is beyond
    the F distribution's quantile 1 - CHANCE, else max(b, pooled), pooled = (v w + (k - 1) b) / (v + k - 1). The mean of
    the runs has the variance of one over k.
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
        # Takes long to import, and most conditions have one seed.
        from millprint.quantiles import f_exceeded

        limit = float(f_exceeded(CHANCE, seeds - 1, inside))
        if between > limit * squares / inside:
            return Run(between, seeds - 1, True)
    return Run(max(between, (squares + (seeds - 1) * between) / freedom), freedom, False)


class Motion(NamedTuple):
    """A word for what turns and seeds say against an error, and what it means with what to do."""

    word: str
    meaning: str


MOTIONS: Mapping[str, Motion] = {
    "no_impacts": Motion(
        "no impacts",
        "all balls move with the wall, as one layer that goes round or at rest on it, and nothing hits; no curve is "
        "made of that: take a higher fill ratio or another speed",
    ),
    "few_turns": Motion(
        "few turns",
        f"fewer than {FEWEST_TURNS} independent turns were recorded, so that the scatter of a run is hardly known: "
        "record a longer window",
    ),
    "repeats": Motion(
        "repeats",
        "the motion is locked to the drive and repeats itself, so that turns tell nothing of other lasting motions: "
        "simulate more seeds",
    ),
    "seeds_differ": Motion(
        "seeds differ",
        "seeds differ by more than their turns explain, as where several motions last: simulate more seeds, and take "
        "the mean as one over these motions",
    ),
}


def motion_of(impacts: int, independent: float, repeating: int, differ: bool) -> list[Motion]:
    """What turns and seeds of a condition say against its errors, of MOTIONS.

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
