"""What the energies of single turns of a mill tell: their mean, its error, and whether they are steady or repeat.

Neighbouring turns are alike. They are averaged in pairs again and again, and the largest of the errors of the mean at
the sizes of block that leave at least FEWEST_BLOCKS is taken (Flyvbjerg and Petersen, J. Chem. Phys. 91 (1989) 461). So
a correlation over more than an eighth of a window is not seen, and of fewer than sixteen turns none is; and a motion
that has settled into one of several lasting ones does not show the others, however long it is recorded. Only other
seeds do (`millprint.fingerprint.descriptors`).
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from millprint.observables.condition import Condition, energy_scale

FEWEST_BLOCKS = 8
# The power of a channel under this share of the whole is known well enough, however it varies [-].
NEGLIGIBLE = 0.01
# Probability of taking a steady power for one that rises or falls [-].
UNSTEADY = 0.05
# A motion repeats if turns a period apart differ by less than ALIKE of the spread of independent collisions, in seven
# pairs at least, which eight turns have.
LONGEST_PERIOD, FEWEST_PAIRS, ALIKE = 4, 7, 1 / 3
# Normal dissipation of a ball in a turn over rho omega^2 A^2 d^3 of one hit by 1 % of the wall's speed.
LEAST_HIT = 1e-3


class MeanOfTurns(NamedTuple):
    """The standard error of a mean, its degrees of freedom, and the equivalent number of independent turns."""

    error: float
    freedom: int
    independent: float


def mean_of_turns(values: Sequence[float]) -> MeanOfTurns | None:
    """What the values of single turns tell about their mean; None for fewer than two."""
    blocks = np.asarray(values, dtype=float)
    if len(blocks) < 2:
        return None
    found = [(_plain_error(blocks), len(blocks) - 1)]
    while len(blocks) // 2 >= FEWEST_BLOCKS:
        blocks = blocks[: len(blocks) // 2 * 2].reshape(-1, 2).mean(axis=1)
        found.append((_plain_error(blocks), len(blocks) - 1))
    error, freedom = max(found, key=lambda own: own[0])
    plain, number = found[0][0], len(values)
    return MeanOfTurns(error, freedom, number * (plain / error) ** 2 if error else float(number))


def _plain_error(values: np.ndarray) -> float:
    return float(values.std(ddof=1) / math.sqrt(len(values)))


def relative_error(energies: Sequence[float]) -> float:
    """Standard error of a mean of turns over its size [-]; inf for fewer than FEWEST_BLOCKS turns."""
    mean = abs(float(np.mean(energies))) if len(energies) else 0.0
    known = mean_of_turns(energies) if len(energies) >= FEWEST_BLOCKS and mean else None
    return known.error / mean if known else math.inf


def half_width(energies: Sequence[float]) -> float:
    """Half of the 95 % interval of a mean of turns over its size [-]; inf for fewer than FEWEST_BLOCKS independent."""
    # Imported here: scipy is slow to import, and a job that only reads turns does not need it.
    from millprint.estimate.quantiles import student_exceeded

    known, mean = mean_of_turns(energies), abs(float(np.mean(energies))) if len(energies) else 0.0
    if not known or not mean or known.independent < FEWEST_BLOCKS:
        return math.inf
    return float(student_exceeded(0.025, known.freedom)) * known.error / mean


class Drift(NamedTuple):
    """How far a power rises or falls through a window over its mean [-], the standard error, its degrees of freedom."""

    change: float
    error: float
    freedom: int


def drift_of_turns(energies: Sequence[float]) -> Drift | None:
    """The drift of the energies of turns by the line of least squares; None for fewer than three turns.

    The slope of n turns has the variance n s^2 / sum (i - mean i)^2, with s the error of a mean of what the line
    leaves, by `mean_of_turns`, which takes neighbours that are alike into account.
    """
    values = np.asarray(energies, dtype=float)
    if len(values) < 3 or not values.mean():
        return None
    places = np.arange(len(values)) - (len(values) - 1) / 2
    squares = float(places @ places)
    slope = float(places @ values) / squares
    left = mean_of_turns((values - values.mean() - slope * places).tolist())
    assert left is not None
    # The line takes one degree of freedom more than the mean.
    error = left.error * math.sqrt(left.freedom / (left.freedom - 1) * len(values) / squares)
    scale = len(values) / abs(float(values.mean()))
    return Drift(scale * slope, scale * error, left.freedom - 1)


def is_steady(energies: Sequence[float], largest: float) -> bool:
    """Whether the mean of a window's turns is that of a long run, as far as they can tell.

    It is where a drift (`drift_of_turns`) moves the mean by at most `largest` [-], half its change, or where it is one
    by chance, P > UNSTEADY of Student's t.
    """
    # Imported here, as in `half_width`.
    from millprint.estimate.quantiles import student_exceeded

    drift = drift_of_turns(energies)
    if not drift or abs(drift.change) / 2 <= largest:
        return True
    return abs(drift.change) <= float(student_exceeded(UNSTEADY / 2, drift.freedom)) * drift.error


def motion_repeats(energies: Sequence[float], collisions: float) -> bool:
    """Whether the energies of turns [J] repeat, one after another or after up to LONGEST_PERIOD turns.

    collisions: of a turn. Energies of N independent collisions would vary from turn to turn by 1/sqrt(N) at least, more
    if collisions differ. A motion that is locked to the drive varies by less than ALIKE of that:
    rms(e_(i+p) - e_i) / sqrt(2) < ALIKE mean(e) / sqrt(N) for a period p.
    """
    values = np.asarray(energies, dtype=float)
    if len(values) <= FEWEST_PAIRS or collisions <= 0 or not values.mean() > 0:
        return False
    periods = range(1, min(LONGEST_PERIOD, len(values) - FEWEST_PAIRS) + 1)
    apart = min(float(np.sqrt(np.mean((values[period:] - values[:-period]) ** 2) / 2)) for period in periods)
    return apart < ALIKE * values.mean() / math.sqrt(collisions)


def scale_of_hits(run: Mapping[str, Any]) -> float:
    """rho omega^2 A^2 d^3 of all balls [J]; run: a summary, or what `dem.run.described` has of it."""
    own = {name: run[name] for name in ("ball_diameter_m", "density_kg_m3", "amplitude_m")}
    condition = Condition(fill_ratio=run["case"]["fill_ratio"], speed_hz=run["frequency_hz"], **own)
    return run["balls"] * energy_scale(condition)


def has_impacts(energies: Sequence[float], scale: float) -> bool:
    """Whether balls hit anything, by the normal dissipation of all balls in each turn [J].

    scale: `scale_of_hits` [J]. Where all balls go round with the wall as one layer, or lie on it, a
    turn dissipates less than LEAST_HIT of that: a hit by 1 % of the wall's speed v = 2 pi omega A has m v^2 / 2 times
    1e-4, which is 1e-3 of the scale for balls of mass m = pi / 6 rho d^3. The last quarter of the turns decides, by its
    median, since such a layer may form within the window, and then lasts.
    """
    last = energies[-max(1, len(energies) // 4) :]
    return float(np.median(last)) >= LEAST_HIT * scale
