"""Measures of a bed of balls that flows in a turning drum: angle of its surface, speed over depth, depth of zero speed.

Functions of positions and velocities, without files. A place is (x, z) [m] from the axis of the drum, z up. All
measures are in the frame of the surface: down its slope, and along its normal, both through the axis. So a place along
the normal is negative below the axis.
"""

import math
from dataclasses import dataclass

import numpy as np

from millprint.statistics.quantiles import student_quantile

# At the surface, the number density falls to this share of its value in the bed.
SURFACE_SHARE = 0.5
# Rows of the histogram of a column per width of the column.
ROWS_PER_CELL = 2
TURNS_MAX, TURN_END = 20, 1e-4
# A mean needs at least this number of balls.
FEWEST = 20


@dataclass(frozen=True)
class Surface:
    """A plane free surface, by its slope.

    slope_rad: angle to the horizontal, positive where the surface rises with x; height_m: its place along the normal.
    """

    slope_rad: float
    height_m: float

    @property
    def angle_deg(self) -> float:
        """Angle to the horizontal [deg], without its sign."""
        return math.degrees(abs(self.slope_rad))

    @property
    def down(self) -> np.ndarray:
        """Unit vector (2,) down the slope."""
        along = np.array([math.cos(self.slope_rad), math.sin(self.slope_rad)])
        return -along if self.slope_rad > 0 else along

    @property
    def normal(self) -> np.ndarray:
        """Unit vector (2,) out of the bed."""
        return np.array([-math.sin(self.slope_rad), math.cos(self.slope_rad)])


def _column_tops(along: np.ndarray, up: np.ndarray, half_width: float, cell: float) -> tuple[np.ndarray, np.ndarray]:
    """Middles (c,) of columns, and heights (c,) at which the density falls to SURFACE_SHARE of that below [m]."""
    columns = max(4, round(2 * half_width / cell))
    step = cell / ROWS_PER_CELL
    low, high = up.min() - step, up.max() + 2 * step
    rows = math.ceil((high - low) / step)
    edges = np.linspace(-half_width, half_width, columns + 1)
    counts, _, heights = np.histogram2d(along, up, [edges, np.linspace(low, low + rows * step, rows + 1)])
    middles, centres = (edges[1:] + edges[:-1]) / 2, (heights[1:] + heights[:-1]) / 2
    tops = np.full(columns, math.nan)
    for column, count in enumerate(counts):
        if not count.any():
            continue
        half = SURFACE_SHARE * np.median(count[count > 0])
        last = np.flatnonzero(count >= half)[-1]
        # The highest row is always empty.
        tops[column] = centres[last] + step * (count[last] - half) / (count[last] - count[last + 1])
    return middles, tops


def fit_surface(places: np.ndarray, half_width: float, cell: float) -> Surface:
    """The free surface by least squares, in the middle part of the drum.

    places: (n, 2) of the balls at all times [m]; half_width: of the part that is fitted, along the surface on both
    sides of the axis [m]; cell: width of a column [m], about a ball. The fit is repeated until the columns are
    perpendicular to the surface. Raises ValueError if fewer than three columns contain balls.
    """
    slope, height = 0.0, math.nan
    for _ in range(TURNS_MAX):
        along = np.array([math.cos(slope), math.sin(slope)])
        normal = np.array([-along[1], along[0]])
        middles, tops = _column_tops(places @ along, places @ normal, half_width, cell)
        known = np.isfinite(tops)
        if known.sum() < 3:
            raise ValueError("fewer than three columns of the middle part hold balls")
        gradient, height = np.polyfit(middles[known], tops[known], 1)
        turn = math.atan(gradient)
        slope += turn
        if abs(turn) < TURN_END:
            break
    return Surface(slope, float(height))


def speed_profile(
    places: np.ndarray, velocities: np.ndarray, surface: Surface, depths: np.ndarray, half_width: float,
    half_height: float,
) -> np.ndarray:  # fmt: skip
    """Mean speed down the slope (k,) [m/s] at places (k,) along the normal [m].

    places, velocities: (n, 2) of the balls at all times [m], [m/s]. The mean is over the balls in a box around the
    place with half the height half_height and half the width half_width [m]; NaN for fewer than FEWEST balls.
    """
    near = np.abs(places @ surface.down) < half_width
    height, speed = places[near] @ surface.normal, velocities[near] @ surface.down
    order = np.argsort(height)
    height, total = height[order], np.concatenate([[0.0], np.cumsum(speed[order])])
    first = np.searchsorted(height, np.asarray(depths) - half_height)
    last = np.searchsorted(height, np.asarray(depths) + half_height)
    count = last - first
    return np.where(count >= FEWEST, (total[last] - total[first]) / np.maximum(count, 1), math.nan)


def zero_place(depths: np.ndarray, speeds: np.ndarray) -> float:
    """The place [m] of the first change of sign of the speed on the way up from the wall, interpolated; nan for none.

    depths: (k,) ascending [m]; speeds: (k,) [m/s], negative where the bed turns with the drum.
    """
    known = np.isfinite(speeds)
    depth, speed = np.asarray(depths)[known], np.asarray(speeds)[known]
    changes = np.flatnonzero((speed[:-1] <= 0) & (speed[1:] > 0))
    if not len(changes):
        return math.nan
    at = changes[0]
    return float(depth[at] - speed[at] * (depth[at + 1] - depth[at]) / (speed[at + 1] - speed[at]))


def block_uncertainty(values: np.ndarray, probability: float = 0.95) -> np.ndarray:
    """Half the interval of the means of blocks, from Student's t and the scatter of the blocks.

    values: (b, ...) of b blocks of one run, or of b runs; NaN where a block has no value, or for one block.
    """
    blocks = len(values)
    if blocks < 2:
        return np.full(np.shape(values)[1:], math.nan)
    factor = student_quantile((1 + probability) / 2, blocks - 1)
    return factor * np.std(values, axis=0, ddof=1) / math.sqrt(blocks)
