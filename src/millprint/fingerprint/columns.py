"""The columns of a table of descriptors: name, unit, title, meaning, and how each is measured or computed.

To add a descriptor, add a record here: tables, figures, sheets and workflow/descriptors.md read these records. A
statistic of collisions is a `Measured` with `of_collisions`: it is read from run.h5, and nothing is simulated again.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import reduce
from operator import getitem
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from millprint.fingerprint.condition import (
    Condition,
    effective_restitution,
    energy_scale,
    specific_frequency,
    specific_power,
)

if TYPE_CHECKING:
    from millprint.fingerprint.readers import Collisions

Column = Callable[[pd.DataFrame], pd.Series]


@dataclass(frozen=True)
class Descriptor:
    """A column of descriptors.tsv.

    title: in sheets; axis: label in figures, if it differs from the title; optional: whether it may be empty.
    """

    name: str
    unit: str
    title: str
    meaning: str
    axis: str = ""
    optional: bool = False

    @property
    def label(self) -> str:
        """The label of an axis, with the unit."""
        return f"{self.axis or self.title} [{self.unit}]"


@dataclass(frozen=True, kw_only=True)
class Measured(Descriptor):
    """A column measured in each run; the table has the mean over the seeds.

    key: its place in the run's summary, GROUP.KEY. The group `rule` has the collisions found by the counting rule.
    of_collisions: in place of a key, its value from the collisions of run.h5 by the counting rule; NaN for a run
        without that table, so that the column is `optional`.
    """

    key: str = ""
    of_collisions: "Callable[[Collisions], float] | None" = None

    def __post_init__(self) -> None:
        """Check that it has one origin. Raises ValueError."""
        if bool(self.key) == bool(self.of_collisions) or (self.of_collisions and not self.optional):
            raise ValueError(f"{self.name}: give a key, or of_collisions and optional=True")

    def of_run(self, summary: dict, rule: dict, collisions: "Collisions | None") -> Any:
        """The value of one run."""
        if self.of_collisions:
            return self.of_collisions(collisions) if collisions else np.nan
        return reduce(getitem, self.key.split("."), summary | {"rule": rule})


@dataclass(frozen=True, kw_only=True)
class Computed(Descriptor):
    """A column computed from the columns before it.

    values: of the conditions (n,), from their table; standard_error: likewise, for the column NAME_se.
    """

    values: Column
    standard_error: Column | None = None


# fmt: off
MEASURED = (
    Measured("balls", "-", "balls", "number n of balls", key="balls"),
    Measured("ball_diameter_m", "m", "ball diameter", "diameter d of the balls; of several sizes, that of mean volume",
             key="ball_diameter_m"),
    Measured("restitution", "-", "restitution", "coefficient e of ball on ball", key="restitution"),
    Measured("static_friction", "-", "static friction", "coefficient mu of ball on ball", key="static_friction"),
    Measured("wall_restitution", "-", "restitution at the wall", "coefficient e of a ball at a wall",
             key="wall_restitution"),
    Measured("wall_static_friction", "-", "static friction at the wall", "coefficient mu of a ball at a wall",
             key="wall_static_friction"),
    Measured("speed_hz", "1/s", "speed", "omega, what the mill is set to", key="frequency_hz"),
    Measured("window_s", "s", "window", "recorded time of a run", key="window_s"),
    Measured("collision_gap_turns", "-", "gap", "gap of the counting rule, in turns of the mill", key="rule.gap_turns"),
    Measured("collision_frequency_hz", "1/s", "collision frequency", "collisions of all balls a second",
             key="rule.frequency_hz"),
    Measured("collisions_of_a_ball_hz", "1/s", "collisions of a ball",
             "those that a ball takes part in: one between two balls counts for both",
             key="rule.collisions_of_a_ball_hz"),
    Measured("collisions", "-", "collisions", "counted collisions, the sum over the seeds", key="rule.count"),
    Measured("normal_power_W", "W", "normal power", "normal dissipation of all balls", key="power_W.normal"),
    Measured("tangential_power_W", "W", "tangential power", "tangential dissipation of all balls",
             key="power_W.tangential"),
    Measured("rolling_power_W", "W", "rolling power", "rolling dissipation of all balls", key="power_W.rolling"),
    Measured("wall_power_W", "W", "power of the walls", "work of the walls over the window", key="power_W.wall"),
    Measured("weighted_normal_energy_J", "J", "weighted normal energy E*n",
             "sum e^2 / sum e of the normal energies e of all contacts; a longer one counts once for each turn",
             axis="weighted\nnormal energy", key="weighted.normal.energy_J"),
    Measured("weighted_tangential_energy_J", "J", "weighted tangential energy E*t",
             "sum e^2 / sum e of the tangential energies e of all contacts, likewise",
             axis="weighted\ntangential energy", key="weighted.tangential.energy_J"),
    Measured("strong_frequency_hz", "1/s", "strong collisions f90",
             "the strongest contacts that hold 90 % of the normal energy, over the balls",
             key="weighted.strong_frequency_hz"),
    Measured("mean_ball_height_m", "m", "mean height of the balls", "height of their centres over the body's origin",
             key="mean_ball_height_m"),
    Measured("median_contact_duration_s", "s", "median duration of a contact",
             "of single contacts; empty where none ended", key="median_contact_duration_s", optional=True),
    Measured("closure", "-", "error of the energy balance", "over the wall work; the largest of the seeds",
             key="closure"),
)
# fmt: on


def relative_error_of(column: str) -> str:
    """The column of the relative standard error of a weighted energy or frequency, from the spread between turns."""
    return f"{column.rpartition('_')[0]}_relative_se"


def _specific(table: pd.DataFrame, channel: str) -> pd.Series:
    return specific_power(table[f"{channel}_power_W"], table["balls"], Condition.of_table(table))


def _normal_error(table: pd.DataFrame) -> pd.Series:
    """Relative standard error of the normal power, from the spread between turns and between seeds."""
    return table["normal_power_se_W"] / table["normal_power_W"]


def _tangential_error(table: pd.DataFrame) -> pd.Series:
    """Relative standard error of the tangential power, from the spread between turns and between seeds."""
    return table["tangential_power_se_W"] / table["tangential_power_W"]


def _counting_error(table: pd.DataFrame) -> pd.Series:
    """Relative standard error of a number of collisions: as of independent ones, or from the seeds if that is larger.

    With one seed it is a lower bound.
    """
    seeds = table["collision_frequency_seed_sd_hz"] / table["collision_frequency_hz"] / np.sqrt(table["seeds"])
    return np.fmax(1.0 / np.sqrt(table["collisions"]), seeds)


def _rate(table: pd.DataFrame, channel: str) -> pd.Series:
    """Power of a ball over the weighted energy [1/s]; 0 where nothing is dissipated."""
    energy = table[f"weighted_{channel}_energy_J"]
    return (table[f"{channel}_power_W"] / table["balls"] / energy).where(energy > 0, 0.0)


def _scaled(name: str, column: str, title: str, meaning: str) -> Computed:
    """A weighted energy or frequency over its scale, with the relative error of its column."""
    energy = column.endswith("_J")

    def values(table: pd.DataFrame) -> pd.Series:
        return table[column] / (energy_scale(Condition.of_table(table)) if energy else table["speed_hz"])

    return Computed(
        name,
        "-",
        title,
        meaning,
        values=values,
        standard_error=lambda table: table[name] * table[relative_error_of(column)],
    )


# fmt: off
COMPUTED = (
    Computed("normal_energy_J", "J", "normal energy of a collision", "normal power over collision frequency (Eq. 3.20)",
             axis="normal energy\nper collision",
             values=lambda table: table["normal_power_W"] / table["collision_frequency_hz"]),
    Computed("tangential_energy_J", "J", "tangential energy of a collision",
             "tangential power over collision frequency (Eq. 3.21)", axis="tangential energy\nper collision",
             values=lambda table: table["tangential_power_W"] / table["collision_frequency_hz"]),
    Computed("weighted_normal_frequency_hz", "1/s", "weighted normal frequency f*n",
             "normal power of a ball over E*n: rate of collisions of E*n that dissipates it",
             values=lambda table: _rate(table, "normal")),
    Computed("weighted_tangential_frequency_hz", "1/s", "weighted tangential frequency f*t",
             "tangential power of a ball over E*t: rate of collisions of E*t that dissipates it",
             values=lambda table: _rate(table, "tangential")),
    Computed("specific_frequency_hz", "1/s", "specific collision frequency",
             "all collisions over the number of balls, one between two balls counted once",
             values=lambda table: table["collision_frequency_hz"] / table["balls"]),
    Computed("effective_restitution", "-", "effective restitution",
             "eps = e - 3/2 mu exp(-3 mu) of ball on ball (Eq. 3.30)",
             values=lambda table: effective_restitution(table["restitution"], table["static_friction"])),
    Computed("drive_torque_Nm", "N m", "torque of the drive",
             "mean torque of the balls on the mill about the axis of its drive, power of the walls over 2 pi omega "
             "(Eqs 3.24 and 3.25); empty for a mill at rest", optional=True,
             values=lambda table: table["wall_power_W"] / (2 * np.pi * table["speed_hz"].replace(0, np.nan))),
    Computed("efficiency", "-", "share of the drive's power",
             "normal and tangential power over the power of the walls (Sec. 3.2.2); empty for a mill at rest",
             axis="share of power", optional=True,
             values=lambda table: (table["normal_power_W"] + table["tangential_power_W"])
             / table["wall_power_W"].where(table["speed_hz"] != 0)),
    Computed("Pn", "-", "specific normal power", "normal power over n rho omega^3 A^2 d^3 (Eq. 3.28)",
             values=lambda table: _specific(table, "normal"),
             standard_error=lambda table: table["Pn"] * _normal_error(table)),
    Computed("Pt", "-", "specific tangential power", "tangential power over n rho omega^3 A^2 d^3 (Eq. 3.28)",
             values=lambda table: _specific(table, "tangential"),
             standard_error=lambda table: table["Pt"] * _tangential_error(table)),
    Computed("f", "-", "specific collision frequency per turn", "collision frequency over n omega (Eq. 3.29)",
             values=lambda table: specific_frequency(
                 table["collision_frequency_hz"], table["balls"], table["speed_hz"]),
             standard_error=lambda table: table["f"] * _counting_error(table)),
    Computed("ratio", "-", "tangential over normal", "Pt / Pn, tangential over normal dissipation",
             values=lambda table: table["Pt"] / table["Pn"],
             standard_error=lambda table: table["ratio"] * table["power_ratio_relative_se"]),
    Computed("P", "-", "specific power", "Pn + Pt",
             values=lambda table: table["Pn"] + table["Pt"],
             standard_error=lambda table: table["P"] * table["power_relative_se"]),
    Computed("En", "-", "specific normal energy", "normal energy of a collision over rho omega^2 A^2 d^3, Pn / f",
             values=lambda table: table["normal_energy_J"] / energy_scale(Condition.of_table(table)),
             standard_error=lambda table: table["En"] * np.hypot(_normal_error(table), _counting_error(table))),
    Computed("Et", "-", "specific tangential energy",
             "tangential energy of a collision over rho omega^2 A^2 d^3, Pt / f",
             values=lambda table: table["tangential_energy_J"] / energy_scale(Condition.of_table(table)),
             standard_error=lambda table: table["Et"] * np.hypot(_tangential_error(table), _counting_error(table))),
    _scaled("En_star", "weighted_normal_energy_J", "scaled E*n", "E*n over rho omega^2 A^2 d^3"),
    _scaled("Et_star", "weighted_tangential_energy_J", "scaled E*t", "E*t over rho omega^2 A^2 d^3"),
    _scaled("fn_star", "weighted_normal_frequency_hz", "scaled f*n", "f*n over omega, Pn / En_star"),
    _scaled("ft_star", "weighted_tangential_frequency_hz", "scaled f*t", "f*t over omega, Pt / Et_star"),
    Computed("f90", "-", "scaled f90", "strong collisions over omega",
             values=lambda table: table["strong_frequency_hz"] / table["speed_hz"],
             standard_error=lambda table: table["f90"] / np.sqrt(
                 table["strong_frequency_hz"] * table["balls"] * table["window_s"] * table["seeds"])),
)
# fmt: on

DESCRIPTORS: dict[str, Descriptor] = {column.name: column for column in (*MEASURED, *COMPUTED)}


def explain_columns() -> str:
    """The page workflow/descriptors.md: every column with its unit and meaning, as Markdown."""
    columns = DESCRIPTORS.values()
    rows = "".join(f"| `{column.name}` | {column.unit} | {column.title}: {column.meaning} |\n" for column in columns)
    return f"# Columns of `descriptors.tsv`\n\n| column | unit | meaning |\n|---|---|---|\n{rows}"
