"""Power in the charge from a wattmeter: with loose balls, less that with the same balls fixed.

Fixed balls have the same mass, so that motor, bearings and air take the same power; only loose balls dissipate. Of
the additional electric power, the share `efficiency` reaches the balls.
"""

import numpy as np

from millprint.own_machine.estimates import Estimate, difference_of
from millprint.own_machine.settings import WattSettings


def power_of_charge(loose: np.ndarray, fixed: np.ndarray, settings: WattSettings) -> tuple[Estimate, Estimate]:
    """Difference of the electric power, and power in the balls of one jar [W]; its interval holds both ranges.

    loose, fixed: means of blocks of the electric power [W] (n,).
    """
    electric = difference_of(loose, fixed)
    low, high = settings.efficiency_low, settings.efficiency_high
    ends = [end * share for end in electric[1:] for share in (low, high)]
    charge = Estimate(electric.value * (low + high) / 2, min(ends), max(ends))
    return electric, charge.times(1 / settings.jars)
