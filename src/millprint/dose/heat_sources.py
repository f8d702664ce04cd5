"""Where the energy of a run becomes heat: dissipation of its ledger by place and channel, and the size of the jar."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import pandas as pd

from millprint.config.errors import ConfigError
from millprint.config.sweep import as_tabulated
from millprint.run.files import read_json
from millprint.run.hdf5 import open_hdf5

PLACES = ("ball_ball", "ball_wall")
CHANNELS = ("normal", "tangential", "rolling")
# What identifies a condition in the tables.
CONDITION = ("contact", "ball_diameter_mm", "fill_ratio", "speed_rpm")


@dataclass(frozen=True)
class HeatSource:
    """The heat sources of one condition of a mill, the mean over its seeds."""

    condition: str
    """name of the case without its seed"""
    about: dict[str, object]
    """the columns of CONDITION, and the number of seeds"""
    power_W: np.ndarray
    """dissipation by PLACES and CHANNELS (2, 3)"""
    balls_kg: float
    """mass of all balls"""
    balls_m2: float
    """surface of all balls"""
    inside_m2: float
    """inner surface of the jar, without inserts"""
    inside_m3: float
    """volume of the jar for the balls"""


def split_of_contacts(group: h5py.Group) -> np.ndarray | None:
    """Shares of PLACES in each of CHANNELS (2, 3) from the table of collisions; None if the run has none."""
    if "second" not in group:
        return None
    between = group["second"][:] >= 0
    energies = (group["normal_J"][:], group["damping_J"][:] + group["sliding_J"][:], group["rolling_J"][:])
    return _shares(
        np.array([[energy[between].sum(dtype=float), energy[~between].sum(dtype=float)] for energy in energies]).T
    )


def _shares(energy: np.ndarray) -> np.ndarray:
    """Columns of (2, 3) over their sums; halves for a channel without energy."""
    # Single values of a ledger may be a little below zero by rounding.
    energy = np.maximum(energy, 0.0)
    total = energy.sum(axis=0)
    return np.where(total > 0, energy / np.where(total > 0, total, 1.0), 0.5)


def split_of_summary(summary: dict) -> np.ndarray:
    """As `split_of_contacts`, from the summary's counting rule without thresholds; rolling is divided like sliding."""
    for rule in summary["collisions"]:
        if not any(rule["dropped"].values()):
            split = [
                [rule["shares"][place][channel] for channel in ("normal", "tangential", "tangential")]
                for place in PLACES
            ]
            return _shares(np.array(split))
    raise ConfigError(
        f"{summary['mill']}: the run kept no table of its collisions, and no rule of dem.counting_rules is without "
        "a threshold: heat cannot be divided between balls and wall"
    )


def read_source(summary_path: str | Path, run_path: str | Path) -> HeatSource:
    """The source of one run: powers of the ledger over its window, divided by the places where contacts dissipate.

    Raises ConfigError, in one line, for a file that cannot be read or a run that dissipates nothing.
    """
    # Imported here: slow to import, and the check of the input imports this module.
    import trimesh

    summary = read_json(summary_path)
    with open_hdf5(run_path) as file:
        split = split_of_contacts(file["collisions"])
        vertices, triangles = file["geometry/vertices_m"][:], file["geometry/triangles"][:]
    split = split_of_summary(summary) if split is None else split
    power = np.array([max(summary["power_W"][channel], 0.0) for channel in CHANNELS])
    if not power.sum() > 0:
        raise ConfigError(f"{summary_path}: the run dissipates nothing; a mill at rest has no heat balance")
    case = summary["case"]
    sizes = np.repeat(summary["ball_sizes_m"], summary["ball_counts"])
    return HeatSource(
        condition=Path(summary_path).parent.name.removesuffix(f"_s{case['seed']}"),
        about={"contact": case["contact"], **as_tabulated(case), "seeds": 1},
        power_W=split * power,
        balls_kg=summary["ball_mass_kg"] * summary["balls"],
        balls_m2=float(np.pi * (sizes**2).sum()),
        inside_m2=float(trimesh.Trimesh(vertices, triangles, process=False).area),
        inside_m3=summary["jar_volume_m3"],
    )


def read_sources(paths: Iterable[tuple[str, str]]) -> list[HeatSource]:
    """The conditions in pairs of summary and run.h5, each a mean over its seeds, in the order of the files."""
    grouped: dict[str, list[HeatSource]] = {}
    for summary_path, run_path in paths:
        source = read_source(summary_path, run_path)
        grouped.setdefault(source.condition, []).append(source)
    return [mean_of(group) for group in grouped.values()]


def mean_of(group: list[HeatSource]) -> HeatSource:
    """One condition from its seeds."""
    first = group[0]
    return HeatSource(
        condition=first.condition,
        about={**first.about, "seeds": len(group)},
        power_W=np.mean([each.power_W for each in group], axis=0),
        **{
            name: float(np.mean([getattr(each, name) for each in group]))
            for name in ("balls_kg", "balls_m2", "inside_m2", "inside_m3")
        },
    )


def source_table(sources: Iterable[HeatSource]) -> pd.DataFrame:
    """A row for each condition: dissipation by place and channel [W], mass of the balls, inner surface of the jar."""
    rows = []
    for source in sources:
        powers = {
            f"{place}_{channel}_W": source.power_W[i, k]
            for i, place in enumerate(PLACES)
            for k, channel in enumerate(CHANNELS)
        }
        sizes = {
            "balls_g": 1e3 * source.balls_kg,
            "balls_cm2": 1e4 * source.balls_m2,
            "inside_cm2": 1e4 * source.inside_m2,
        }
        rows.append({"condition": source.condition, **source.about, **powers, "total_W": source.power_W.sum(), **sizes})
    return pd.DataFrame(rows)
