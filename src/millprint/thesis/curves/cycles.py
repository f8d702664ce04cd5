"""Dissipation of single revolutions (thesis Table 3.5, Fig. 3.5), and maps of where the balls are (Figs 3.9, 3.10)."""

import itertools
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from operator import itemgetter
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.config.errors import ConfigError
from millprint.fingerprint.descriptors import CHARGE, NOTHING, condition_of
from millprint.fingerprint.descriptors import CONDITION as WITH_CHARGE
from millprint.run.hdf5 import open_hdf5

# Only the chapters have these tables, and their balls are of one size.
CONDITION = [name for name in WITH_CHARGE if name != CHARGE]
CHANNELS = ("normal", "tangential")
CYCLE_PARTS = ("mean_J", "sd_J", "cv_percent")
# Of a density.
POINTS = 120


def _revolutions(summaries: list[dict]) -> Iterator[tuple[dict, dict[str, np.ndarray]]]:
    """Each condition, in order, with the energies of its revolutions [J] by channel, all seeds together."""
    groups: dict[tuple, list[dict]] = defaultdict(list)
    for run in summaries:
        condition = condition_of(run)
        groups[tuple(condition[name] for name in CONDITION)].append(run["per_revolution"])
    for key, runs in sorted(groups.items(), key=itemgetter(0)):
        energies = {name: np.concatenate([np.asarray(run[f"{name}_J"], float) for run in runs]) for name in CHANNELS}
        yield dict(zip(CONDITION, key, strict=True)), energies


def tabulate_cycles(summaries: list[dict]) -> pd.DataFrame:
    """Mean [J], standard deviation [J] and coefficient of variation [%] of the dissipation per revolution.

    A row for each condition with at least two revolutions; the columns of Table 3.5.
    """
    rows = []
    for row, cycles in _revolutions(summaries):
        row["revolutions"] = cycles["normal"].size
        if row["revolutions"] < 2:
            continue
        for channel, energies in cycles.items():
            mean, deviation = energies.mean(), energies.std(ddof=1)
            values = (mean, deviation, 100.0 * deviation / mean)
            row |= {f"{channel}_{part}": value for part, value in zip(CYCLE_PARTS, values, strict=True)}
        rows.append(row)
    columns = [*CONDITION, "revolutions", *(f"{c}_{s}" for c in CHANNELS for s in CYCLE_PARTS)]
    return pd.DataFrame(rows, columns=columns)


def tabulate_densities(summaries: list[dict], fill_ratio: float) -> pd.DataFrame:
    """Probability density [1/J] of the dissipation per revolution at one fill ratio, by a Gaussian kernel.

    For the mill as built; conditions with fewer than three revolutions have no density.
    """
    # Imported here: slow to import, and the check of the input imports this module.
    from scipy.stats import gaussian_kde

    frames = [pd.DataFrame(columns=[*CONDITION, "channel", "energy_J", "density_per_J"])]
    for condition, cycles in _revolutions(summaries):
        if not np.isclose(condition["fill_ratio"], fill_ratio) or condition["varied"] != NOTHING:
            continue
        for channel, energies in cycles.items():
            if energies.size < 3 or np.ptp(energies) == 0:
                continue
            margin = 3.0 * energies.std(ddof=1)
            grid = np.linspace(max(energies.min() - margin, 0.0), energies.max() + margin, POINTS)
            density = {"channel": channel, "energy_J": grid, "density_per_J": gaussian_kde(energies)(grid)}
            frames.append(pd.DataFrame(condition | density))
    return pd.concat(frames[1:] or frames, ignore_index=True)


def tabulate_published(cycles: pd.DataFrame, published: pd.DataFrame, mill: str, fill_ratio: float) -> pd.DataFrame:
    """Table 3.5 side by side: ours, the published value, and our deviation from the published one [%].

    cycles: as from `tabulate_cycles`; published: as from `published_cycles`. A row for each condition of `mill` at
    the fill ratio; conditions that the thesis does not print have empty published columns.
    """
    ours = cycles[(cycles["mill"] == mill) & np.isclose(cycles["fill_ratio"], fill_ratio)]
    ours = ours[ours["varied"] == NOTHING].drop(columns=["mill", "varied", "density_kg_m3", "amplitude_m"])
    key = ["contact", "fill_ratio", "ball_diameter_mm", "speed_rpm"]
    table = ours.merge(published, how="left", on=key, suffixes=("", "_published"))
    for channel, part in itertools.product(CHANNELS, CYCLE_PARTS):
        name = f"{channel}_{part}"
        if f"{name}_published" in table:
            table[f"{name}_deviation_percent"] = 100.0 * (table[name] / table[f"{name}_published"] - 1.0)
    return table


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
