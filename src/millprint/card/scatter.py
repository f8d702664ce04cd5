"""Intervals of one condition from the scatter of its simulations: seeds, and blocks of revolutions within each window.

A simulation scatters because its window is short. This scatter is seen twice: between seeds, and between blocks of
neighbouring revolutions in one window (delete-a-group jackknife, Kott, J. Official Stat. 17 (2001) 521). Both estimate
the variance v of the logarithm of a descriptor of one simulation (`variance_of_run`). With k seeds, mean m and
Student's t for the degrees of freedom of v, a new simulation of the condition falls into
exp(ln m +- t sqrt(v (1 + 1/k))), and the mean of very many into exp(ln m +- t sqrt(v / k)).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd

from millprint.config.counting import CountingRule, recorded_count
from millprint.dem.collisions import kept_by, strongest, turns_of
from millprint.dose.spectra import read_contacts
from millprint.estimate.quantiles import student_quantile
from millprint.fingerprint.descriptors import block_length, variance_of_run
from millprint.observables.definitions import with_power

# Columns for each revolution: energies [J] and sums of squared contact energies [J2] by channel, and the numbers of
# collisions, of collisions summed over the balls in them, and of strong contacts.
TOTALS = ("normal", "tangential", "rolling", "normal_square", "tangential_square", "count", "taken_part", "strong")
NORMAL, TANGENTIAL, ROLLING, NORMAL_SQUARE, TANGENTIAL_SQUARE, COUNT, TAKEN_PART, STRONG = range(len(TOTALS))
# Descriptors that depend on a number of collisions, and that number.
COUNTED = {
    "normal_energy_J": COUNT,
    "tangential_energy_J": COUNT,
    "specific_frequency_hz": COUNT,
    "collisions_of_a_ball_hz": TAKEN_PART,
    "strong_frequency_hz": STRONG,
}


@dataclass(frozen=True)
class Window:
    """What one simulation recorded in each whole revolution.

    totals: TOTALS of each (n, 8); revolution_s: time of one [s]; counted: whether the numbers were counted in each
    revolution, and are not equal shares of the whole.
    """

    totals: np.ndarray
    revolution_s: float
    balls: int
    counted: bool


def read_window(summary: dict, run_path: str, rule_name: str) -> Window:
    """The revolutions of a run. Without single contacts in the run, each has an equal share of the collisions."""
    revolutions = summary["per_revolution"]
    keys = ("normal_J", "tangential_J", "rolling_J", "normal_square_J2", "tangential_square_J2")
    energies = [np.asarray(revolutions.get(key, []), dtype=float) for key in keys]
    number, turn_s = len(energies[0]), 1 / summary["frequency_hz"]
    rule = recorded_count(summary, rule_name)
    contacts = read_contacts(run_path)
    if contacts is None:
        of_balls = [rule["collisions_of_a_ball_hz"], summary["weighted"]["strong_frequency_hz"]]
        rates = [rule["frequency_hz"], *(summary["balls"] * rate for rate in of_balls)]
        counts = [np.full(number, rate * turn_s) for rate in rates]
    else:
        own = CountingRule.of_count(rule)
        merged = contacts.merged(own, summary["frequency_hz"])
        kept = merged[kept_by(own, merged)]
        ordered = contacts.ordered("surface")
        lasting = turns_of(ordered, contacts.begin_s, summary["frequency_hz"])
        hard = ordered.iloc[strongest(ordered["normal_J"].to_numpy(), lasting)]
        chosen = [kept, kept[kept["second"] >= 0], hard]
        alone, both, strong = (_per_turn(each, contacts.begin_s, turn_s, number) for each in chosen)
        counts = [alone, alone + both, strong]
    return Window(np.column_stack([*energies, *counts]), turn_s, summary["balls"], contacts is not None)


def _per_turn(collisions: pd.DataFrame, begin_s: float, turn_s: float, number: int) -> np.ndarray:
    """Collisions that begin in each of `number` revolutions."""
    place = np.floor((collisions["start_s"].to_numpy() - begin_s) / turn_s).astype(int)
    return np.bincount(place[(place >= 0) & (place < number)], minlength=number).astype(float)


def descriptors_of_totals(totals: np.ndarray, time_s: np.ndarray | float, balls: int) -> dict[str, np.ndarray]:
    """Observables from sums of TOTALS (..., 8) over a time [s]."""
    normal, tangential, count = (totals[..., place] for place in (NORMAL, TANGENTIAL, COUNT))
    normal_mean, tangential_mean = totals[..., NORMAL_SQUARE] / normal, totals[..., TANGENTIAL_SQUARE] / tangential
    return with_power(
        {
            "weighted_normal_energy_J": normal_mean,
            "weighted_tangential_energy_J": tangential_mean,
            "weighted_normal_frequency_hz": normal / normal_mean / time_s / balls,
            "weighted_tangential_frequency_hz": tangential / tangential_mean / time_s / balls,
            "strong_frequency_hz": totals[..., STRONG] / time_s / balls,
            "collisions_of_a_ball_hz": totals[..., TAKEN_PART] / time_s / balls,
            "normal_energy_J": normal / count,
            "tangential_energy_J": tangential / count,
            "specific_frequency_hz": count / time_s / balls,
            "normal_power_W": normal / time_s,
            "tangential_power_W": tangential / time_s,
            "rolling_power_W": totals[..., ROLLING] / time_s,
        }
    )


def jackknife(window: Window) -> tuple[dict[str, float], int]:
    """Variance of the logarithm of each descriptor of a window, and its degrees of freedom; empty for one block.

    Each of g blocks of equal length is left out in turn: v = (g - 1) / g sum (ln x_(j) - mean)^2. Without counts for
    each revolution, collisions vary as if they were independent.
    """
    number = len(window.totals)
    length = block_length(number) if number >= 2 else 1
    groups = number // length
    if groups < 2:
        return {}, 0
    blocks = window.totals[: groups * length].reshape(groups, length, len(TOTALS)).sum(axis=1)
    left = blocks.sum(axis=0) - blocks
    found = descriptors_of_totals(left, (groups - 1) * length * window.revolution_s, window.balls)
    # A block without collisions, or without dissipation of a kind, has no logarithm.
    variances = {
        name: float((groups - 1) * np.log(values).var()) for name, values in found.items() if (values > 0).all()
    }
    if not window.counted:
        for name, place in COUNTED.items():
            variances[name] = variances.get(name, 0.0) + 1 / window.totals[:, place].sum()
    return variances, groups - 1


class Halves(NamedTuple):
    """Half the widths of the bands of a descriptor's logarithm, for a new simulation and for the mean."""

    new: float
    mean: float


def spread(
    windows: list[Window], values: list[dict[str, float]], variances: list[dict[str, float]], probability: float
) -> dict[str, Halves]:
    """Half the widths of both bands of each descriptor; empty where there is no estimate.

    windows, values: revolutions and descriptors of each seed; variances: of the logarithms of statistics of collisions,
    from the same blocks.
    """
    seeds = len(windows)
    within = [(found | own, freedom) for (found, freedom), own in zip(map(jackknife, windows), variances, strict=True)]
    found = {}
    for name in values[0]:
        if min(own[name] for own in values) <= 0:
            continue
        inside = [(known[name], freedom) for known, freedom in within if name in known]
        run = variance_of_run([float(np.log(own[name])) for own in values], inside)
        if run is not None:
            quantile = float(student_quantile(0.5 + probability / 2, run.freedom))
            found[name] = Halves(
                *(quantile * float(np.sqrt(run.variance * share)) for share in (1 + 1 / seeds, 1 / seeds))
            )
    return found
