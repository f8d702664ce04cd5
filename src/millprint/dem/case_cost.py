"""The cost of a case before it is run, to detect typing errors of some powers of ten."""

import math

import numpy as np

from millprint.config.sweep import Case, DemConfig, ball_count
from millprint.dem.resources import BALL_STEP_S, SNAPSHOT_COLUMNS
from millprint.dem.timestep import aligned_step
from millprint.mill.vessel import Vessel

MOST_DAYS = 60
# Bytes of energies, snapshots and the grid of occupancy, which stay in memory until the end.
MOST_BYTES = 32e9
# Numbers in a row of the energy ledger, and in a cell of the grid of occupancy.
LEDGER_COLUMNS, OCCUPANCY_COLUMNS = 16, 5
# Side of the square cells of that grid [m], and the time between its samples [s].
OCCUPANCY_CELL_M, OCCUPANCY_INTERVAL_S = 0.002, 5e-4
# Largest number of sites for the balls at the start.
MOST_SITES = 5e6


def sites_of(vessel: Vessel, diameter_m: float) -> float:
    """About how many balls a hexagonal close packing over the vessel's bounding box has: sqrt(2) V / d^3."""
    low, high = vessel.bounds
    return math.sqrt(2) * float(np.prod((high - low) / diameter_m))


def cost(
    case: Case, dem: DemConfig, vessel: Vessel, volume_m3: float, step_s: float, frequency_hz: float
) -> tuple[float, float]:
    """Days on one core and bytes in memory that a case takes, to an order of magnitude.

    step_s: the requested step [s]; frequency_hz: turns of the mill in a second.
    """
    balls = ball_count(case.fill_ratio, volume_m3, case.ball_diameter_m)
    window = max(case.window_s, case.window_max_s or 0.0)
    sample = (1 / frequency_hz if frequency_hz else case.window_s) / dem.ledger_samples_per_revolution
    # A window holds at least one sample, even in a slow mill.
    window = max(window, sample)
    interval = case.snapshot_interval_s or sample
    # A step so small that their ratio is not finite stays as it is.
    step = aligned_step(step_s, interval)[0] if interval < 1e15 * step_s else step_s
    days = (case.settle_s + case.discard_s + window) / step * balls * BALL_STEP_S / 86_400
    low, high = vessel.bounds
    values = window / sample * LEDGER_COLUMNS
    values += float(np.prod((high - low)[:2] / OCCUPANCY_CELL_M + 1)) * OCCUPANCY_COLUMNS
    if case.snapshot_interval_s:
        values += window / max(case.snapshot_interval_s, step) * balls * SNAPSHOT_COLUMNS
    return days, 8 * values
