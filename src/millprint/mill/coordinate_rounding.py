"""By how much the coordinates of a file are rounded, from the coordinates themselves.

Programs write a fixed number of decimals, a fixed number of digits, or 32-bit numbers, and may have rounded before, in
another unit or format. So the digits in the file do not say it. But rounded coordinates all lie on a grid.
"""

from collections.abc import Iterator

import numpy as np

# A coarser grid is how the body was drawn, not rounding; on a finer one nobody draws [shares of its size].
COARSEST, FINEST = 1e-3, 1e-5
# Between them a grid is believed if this many coordinates, and this share of them, are on none that is five times as
# coarse: those of a round wall need their last digit, while the sizes of a drawing end in 0 or 5.
FEWEST, SHARE = 3, 0.25
INCH_MM = 25.4


def _off(values: np.ndarray, step: np.ndarray | float) -> np.ndarray:
    """Distances of values from the multiples of a step."""
    return np.abs(values - np.rint(values / step) * step)


def _grids(values: np.ndarray) -> Iterator[np.ndarray]:
    """Steps of each value (n,): of one number of decimals, then of one number of digits, from the coarsest on."""
    decade = np.floor(np.log10(values))
    for exponent in range(int(decade.max()), -16, -1):
        yield np.full(len(values), 10.0**exponent)
    for digits in range(1, 17):
        yield 10.0 ** (decade - digits + 1)


def _step(values: np.ndarray, noise: np.ndarray, size: float) -> float:
    """The largest step of a grid that all values (n,) lie on, to within a noise (n,); 0 where there is none."""
    largest, some = 0.0, slice(None, None, max(1, len(values) // 100))
    for step in _grids(values):
        is_sure, error = 16 * noise <= step, noise + 1e-9 * step
        if not is_sure.any() or step.max() > COARSEST * size:
            continue
        if any((_off(values[rows], step[rows]) > error[rows]).any() for rows in (some, slice(None))):
            continue
        needs_it = is_sure & (_off(values, 5 * step) > error)
        # In the decade of the largest step that enough values need.
        for top in np.unique(step[is_sure])[::-1]:
            here = step == top
            enough = max(FEWEST, SHARE * here.sum()) if top > FINEST * size else 1
            if top > largest and needs_it[here].sum() >= enough:
                largest = float(top)
    return largest


def coordinate_rounding(points: np.ndarray) -> float:
    """The largest error that rounding gives a coordinate of points (v, 3), in their unit.

    Half a step of the grid of decimals or digits, in the points' unit or 25.4 times as large, on which all coordinates
    are; half the spacing of 32-bit or 64-bit numbers where there is none that is certain.
    """
    values = np.unique(np.abs(points))
    values = values[values > 0]
    single = values.astype(np.float32)
    # A 32-bit number that is written with nine digits.
    is_single = bool((np.abs(single - values) <= 5e-9 * values).all())
    spacing = np.spacing(single).astype(float) if is_single else np.spacing(values)
    size = float(np.ptp(points, axis=0).max())
    step = _step(values, spacing, size)
    in_inches = _step(values / INCH_MM, np.maximum(spacing, step / 2) / INCH_MM, size / INCH_MM) * INCH_MM
    return max(float(spacing.max()), step, in_inches) / 2
