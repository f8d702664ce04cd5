"""Power in the charge from a wattmeter: with loose balls, less that with the same balls fixed.

Fixed balls have the same mass, so that motor, bearings and air take the same power; only loose balls dissipate. Of
the additional electric power, the share `efficiency` reaches the balls.
"""

import numpy as np

from millprint.estimate.estimates import Estimate, Interval, difference_of
from millprint.own_machine.settings import WattSettings

# Blocks of a series, each long against the time in which its values forget each other; 10 to 30 are usual (Schmeiser,
# Operations Research 30 (1982) 556).
BLOCKS = 10


def block_means(time_s: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Means (BLOCKS,) of a series over parts of equal time; a part without a reading raises ValueError."""
    edges = np.linspace(time_s[0], time_s[-1], BLOCKS + 1)
    place = np.searchsorted(edges[1:-1], time_s, side="right")
    counts = np.bincount(place, minlength=BLOCKS)
    if not counts.all():
        raise ValueError(f"a tenth of the time without a reading, from {edges[counts.argmin()]:g} s on")
    return np.bincount(place, weights=values, minlength=BLOCKS) / counts


def power_of_charge(loose: np.ndarray, fixed: np.ndarray, settings: WattSettings) -> tuple[Estimate, Estimate]:
    """Difference of the electric power, and power in the balls of one jar [W]; its interval holds both ranges.

    loose, fixed: means of blocks of the electric power [W] (n,).
    """
    electric = difference_of(loose, fixed, "W")
    low, high = settings.efficiency_low, settings.efficiency_high
    ends = [end * share for end in electric.ends("repeats") for share in (low, high)]
    charge = Estimate(electric.value * (low + high) / 2, "W", repeats=Interval(min(ends), max(ends)), how="measured")
    return electric, charge * (1 / settings.jars)
