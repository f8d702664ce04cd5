"""Maps of the balls in the jar and of their granular temperature, from the grid of a run (thesis Figs 3.9, 3.10)."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from millprint.config.errors import ConfigError
from millprint.run.hdf5 import open_hdf5

DATASETS = ("edges_x_m", "edges_y_m", "count", "granular_temperature")


@dataclass(frozen=True)
class OccupancyMap:
    """Maps on a grid in the frame of the jar, seen from above.

    edges_x_m (nx + 1), edges_y_m (ny + 1): edges of the cells [m]; share (nx, ny): balls in a cell over balls in the
    fullest cell [-]; temperature_m2_s2 (nx, ny): granular temperature of Eq. 3.26 [m2/s2]. Both maps are masked where
    no ball came.
    """

    title: str
    edges_x_m: np.ndarray
    edges_y_m: np.ndarray
    share: np.ma.MaskedArray
    temperature_m2_s2: np.ma.MaskedArray


def read_occupancy(path: str | Path, title: str) -> OccupancyMap:
    """The maps of a run.h5; raises ConfigError for a file without its grid, and if no ball was seen in any cell."""
    with open_hdf5(path) as run:
        group = run.get("occupancy")
        missing = [name for name in DATASETS if group is None or name not in group]
        if missing:
            raise ConfigError(f"{path}: occupancy/{missing[0]} is missing; rerun the simulation that wrote the file")
        edges_x, edges_y, count, temperature = (group[name][()] for name in DATASETS)
    if count.sum() <= 0:
        raise ConfigError(f"{title}: no ball was seen on the grid; the run recorded no window")
    empty = count == 0
    share = np.ma.masked_array(count / count.max(), mask=empty)
    temperature = np.ma.masked_array(np.where(empty, 0.0, temperature.astype(float)), mask=empty)
    return OccupancyMap(title, edges_x, edges_y, share, temperature)
