"""The observables: numbers that are read off runs, one record each, and the scaled quantities that curves are of.

A record has name, symbol, unit and definition, how it is read or computed, and, where a fingerprint predicts it, how it
scales (`SCALES`), whether it adds up over the balls, its curve and where it is shown. Tables, pages, cards, `match`,
the explorer and workflow/descriptors.md ask these records. A statistic of collisions is a `Measured` with
`of_collisions`: it is read from run.h5, and nothing is simulated again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import reduce
from operator import getitem
from typing import TYPE_CHECKING, Any

from millprint.observables.condition import (
    SCALES,
    Condition,
    effective_restitution,
    energy_scale,
    specific_frequency,
    specific_power,
)

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd

    from millprint.observables.counted_collisions import Collisions

Column = Callable[["pd.DataFrame"], "pd.Series"]


@dataclass(frozen=True)
class Observable:
    """A number that is read off runs: a column of descriptors.tsv, but for SHARE.

    name: ends with its unit; title: in sheets; axis: label in figures, if it differs from the title; optional: whether
    it may be empty; symbol: for a narrow column of the explorer.

    Of one that is predicted, curve: the scaled quantity that it is predicted from, itself over its `scale` of SCALES;
    adds_up: whether it is of all balls, and its curve of one; matched: the set of descriptors that compares mills by
    it, or BY_NAME for one that only a target by its name asks for; panel, line: chart of the explorer, and its line.
    counted: whether it depends on the counting rule; on_card: whether a card has it without a curve.
    """

    name: str
    unit: str
    title: str
    meaning: str
    axis: str = ""
    optional: bool = False
    symbol: str = ""
    curve: str = ""
    scale: str = "none"
    adds_up: bool = False
    matched: str = ""
    panel: str = ""
    line: str = ""
    counted: bool = False
    on_card: bool = False

    def __post_init__(self) -> None:
        """Check the scale. Raises ValueError."""
        if self.scale not in SCALES:
            raise ValueError(f"{self.name}: scale = {self.scale}: must be one of {', '.join(SCALES)}")

    @property
    def label(self) -> str:
        """The label of an axis, with the unit."""
        return f"{self.axis or self.title} [{self.unit}]"

    def scale_of(self, condition: Condition, balls: Any = 1) -> Any:
        """What its scaled quantity is multiplied by at a condition."""
        scale = SCALES[self.scale].of(condition)
        return balls * scale if self.adds_up else scale


@dataclass(frozen=True, kw_only=True)
class Measured(Observable):
    """A number that is measured in each run; a table has the mean over the seeds.

    key: its place in the run's summary, GROUP.KEY. The group `rule` has the collisions found by the counting rule.
    of_collisions: in place of a key, its value from the collisions of run.h5 by the counting rule; NaN for a run
        without that table, so that it is `optional`. Its error is from blocks of turns left out, and from seeds.
    """

    key: str = ""
    of_collisions: Callable[[Collisions], float] | None = None

    def __post_init__(self) -> None:
        """Check that it has one origin. Raises ValueError."""
        super().__post_init__()
        if bool(self.key) == bool(self.of_collisions) or (self.of_collisions and not self.optional):
            raise ValueError(f"{self.name}: give a key, or of_collisions and optional=True")

    def of_run(self, summary: dict, rule: dict, collisions: Collisions | None) -> Any:
        """The value of one run."""
        if self.of_collisions:
            return self.of_collisions(collisions) if collisions else math.nan
        return reduce(getitem, self.key.split("."), summary | {"rule": rule})


@dataclass(frozen=True, kw_only=True)
class Computed(Observable):
    """A number computed from the columns before it.

    values: of the conditions (n,), from their table; standard_error: likewise, for the column NAME_se.
    """

    values: Column
    standard_error: Column | None = None


# The sets of descriptors that mills are compared by; BY_NAME: in none, asked for by its name.
WEIGHTED_SET, COLLISION_SET, SHARE_SET, BY_NAME = "weighted", "per_collision", "shear_share", "by_name"
# fmt: off
MEASURED = (
    Measured("balls", "-", "balls", "number n of balls", key="balls"),
    Measured("ball_diameter_m", "m", "ball diameter", "diameter d of the balls; of several sizes, that of mean volume",
             key="ball_diameter_m"),
    Measured("restitution", "-", "restitution", "coefficient e of ball on ball; empty for a law without it",
             key="restitution", optional=True),
    Measured("static_friction", "-", "static friction", "coefficient mu of ball on ball", key="static_friction"),
    Measured("wall_restitution", "-", "restitution at the wall", "coefficient e of a ball at a wall",
             key="wall_restitution", optional=True),
    Measured("wall_static_friction", "-", "static friction at the wall", "coefficient mu of a ball at a wall",
             key="wall_static_friction"),
    Measured("speed_hz", "1/s", "speed", "omega, what the mill is set to", key="frequency_hz"),
    Measured("window_s", "s", "window", "recorded time of a run", key="window_s"),
    Measured("collision_gap_turns", "-", "gap", "gap of the counting rule, in turns of the mill", key="rule.gap_turns"),
    Measured("collision_frequency_hz", "1/s", "collision frequency", "collisions of all balls a second",
             key="rule.frequency_hz"),
    Measured("collisions_of_a_ball_hz", "1/s", "collisions of a ball",
             "those that a ball takes part in: one between two balls counts for both",
             key="rule.collisions_of_a_ball_hz", on_card=True),
    Measured("collisions", "-", "collisions", "counted collisions, the sum over the seeds", key="rule.count"),
    Measured("normal_power_W", "W", "normal power", "normal dissipation of all balls", key="power_W.normal",
             curve="Pn", scale="power", adds_up=True, panel="Power", line="normal"),
    Measured("tangential_power_W", "W", "tangential power", "tangential dissipation of all balls",
             key="power_W.tangential", curve="Pt", scale="power", adds_up=True, panel="Power", line="tangential"),
    Measured("rolling_power_W", "W", "rolling power", "rolling dissipation of all balls", key="power_W.rolling",
             curve="Pr", scale="power", adds_up=True, panel="Power", line="rolling"),
    Measured("wall_power_W", "W", "power",
             "power of the walls on all balls, which drive and thermometer see: work of walls and gravity over the "
             "window, less what the balls stored of it; normal, tangential and rolling power are its parts, and add up "
             "to it within `closure`",
             key="power_W.wall", curve="Pw", scale="power", adds_up=True, panel="Power", line="all"),
    Measured("weighted_normal_energy_J", "J", "weighted normal energy E*n",
             "sum e^2 / sum e of the normal energies e of all contacts; a longer one counts once for each turn",
             axis="weighted\nnormal energy", key="weighted.normal.energy_J",
             symbol="E*n", curve="En_star", scale="energy", matched=WEIGHTED_SET, panel="Weighted energy E*",
             line="normal"),
    Measured("weighted_tangential_energy_J", "J", "weighted tangential energy E*t",
             "sum e^2 / sum e of the tangential energies e of all contacts, likewise",
             axis="weighted\ntangential energy", key="weighted.tangential.energy_J",
             symbol="E*t", curve="Et_star", scale="energy", matched=WEIGHTED_SET, panel="Weighted energy E*",
             line="tangential"),
    Measured("strong_frequency_hz", "1/s", "strong collisions f90",
             "the strongest contacts that hold 90 % of the normal energy, over the balls",
             key="weighted.strong_frequency_hz", symbol="f90", curve="f90", scale="frequency"),
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


def _counting_error(table: pd.DataFrame, name: str = "collision") -> pd.Series:
    """Relative standard error of a number of collisions: as of independent ones, or from the seeds if that is larger.

    name: of the frequency, of all or of the strong ones. With one seed it is a lower bound.
    """
    import numpy as np

    if name == "strong":
        number = table["strong_frequency_hz"] * table["balls"] * table["window_s"] * table["seeds"]
    else:
        number = table["collisions"]
    seeds = table[f"{name}_frequency_seed_sd_hz"] / table[f"{name}_frequency_hz"] / np.sqrt(table["seeds"])
    return np.fmax(1.0 / np.sqrt(number), seeds)


def _together(first: pd.Series, second: pd.Series) -> pd.Series:
    """The error of a product or a ratio of two independent numbers, from their relative errors."""
    import numpy as np

    return np.hypot(first, second)


def _rate(table: pd.DataFrame, channel: str) -> pd.Series:
    """Power of a ball over the weighted energy [1/s]; 0 where nothing is dissipated."""
    energy = table[f"weighted_{channel}_energy_J"]
    return (table[f"{channel}_power_W"] / table["balls"] / energy).where(energy > 0, 0.0)


def _of_a_collision(table: pd.DataFrame, channel: str) -> pd.Series:
    """Power over the collision frequency [J]; 0 where nothing collides."""
    frequency = table["collision_frequency_hz"]
    return (table[f"{channel}_power_W"] / frequency).where(frequency > 0, 0.0)


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
_COMPUTED = (
    Computed("normal_energy_J", "J", "normal energy of a collision", "normal power over collision frequency (Eq. 3.20)",
             axis="normal energy\nper collision", symbol="En", curve="En", scale="energy", matched=COLLISION_SET,
             panel="Energy of a collision", line="normal", counted=True,
             values=lambda table: _of_a_collision(table, "normal")),
    Computed("tangential_energy_J", "J", "tangential energy of a collision",
             "tangential power over collision frequency (Eq. 3.21)", axis="tangential energy\nper collision",
             symbol="Et", curve="Et", scale="energy", matched=COLLISION_SET, panel="Energy of a collision",
             line="tangential", counted=True,
             values=lambda table: _of_a_collision(table, "tangential")),
    Computed("weighted_normal_frequency_hz", "1/s", "weighted normal frequency f*n",
             "normal power of a ball over E*n: rate of collisions of E*n that dissipates it",
             symbol="f*n", curve="fn_star", scale="frequency", matched=WEIGHTED_SET, panel="Weighted frequency f*",
             line="normal", values=lambda table: _rate(table, "normal")),
    Computed("weighted_tangential_frequency_hz", "1/s", "weighted tangential frequency f*t",
             "tangential power of a ball over E*t: rate of collisions of E*t that dissipates it",
             symbol="f*t", curve="ft_star", scale="frequency", matched=WEIGHTED_SET, panel="Weighted frequency f*",
             line="tangential", values=lambda table: _rate(table, "tangential")),
    Computed("specific_frequency_hz", "1/s", "specific collision frequency",
             "all collisions over the number of balls, one between two balls counted once",
             symbol="f", curve="f", scale="frequency", matched=COLLISION_SET, panel="Specific collision frequency",
             line="collisions", counted=True,
             values=lambda table: table["collision_frequency_hz"] / table["balls"]),
    Computed("effective_restitution", "-", "effective restitution",
             "eps = e - 3/2 mu exp(-3 mu) of ball on ball (Eq. 3.30)", optional=True,
             values=lambda table: effective_restitution(table["restitution"], table["static_friction"])),
    Computed("drive_torque_Nm", "N m", "torque of the drive",
             "mean torque of the balls on the mill about the axis of its drive, power of the walls over 2 pi omega "
             "(Eqs 3.24 and 3.25); empty for a mill at rest", optional=True,
             values=lambda table: table["wall_power_W"] / (2 * math.pi * table["speed_hz"].replace(0, math.nan))),
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
    Computed("P", "-", "specific power of the thesis", "Pn + Pt, without rolling",
             values=lambda table: table["Pn"] + table["Pt"],
             standard_error=lambda table: table["P"] * table["power_relative_se"]),
    Computed("Pr", "-", "specific rolling power", "rolling power over n rho omega^3 A^2 d^3",
             values=lambda table: _specific(table, "rolling"),
             standard_error=lambda table: table["Pr"] * table["rolling_power_relative_se"]),
    Computed("Pw", "-", "specific power of the walls", "power of the walls over n rho omega^3 A^2 d^3",
             values=lambda table: _specific(table, "wall"),
             standard_error=lambda table: table["Pw"] * table["wall_power_relative_se"]),
    Computed("rolling_ratio", "-", "rolling over normal and tangential", "Pr / P",
             values=lambda table: table["Pr"] / table["P"],
             standard_error=lambda table: table["rolling_ratio"] * table["rolling_ratio_relative_se"]),
    Computed("En", "-", "specific normal energy", "normal energy of a collision over rho omega^2 A^2 d^3, Pn / f",
             values=lambda table: table["normal_energy_J"] / energy_scale(Condition.of_table(table)),
             standard_error=lambda table: table["En"] * _together(_normal_error(table), _counting_error(table))),
    Computed("Et", "-", "specific tangential energy",
             "tangential energy of a collision over rho omega^2 A^2 d^3, Pt / f",
             values=lambda table: table["tangential_energy_J"] / energy_scale(Condition.of_table(table)),
             standard_error=lambda table: table["Et"] * _together(_tangential_error(table), _counting_error(table))),
    _scaled("En_star", "weighted_normal_energy_J", "scaled E*n", "E*n over rho omega^2 A^2 d^3"),
    _scaled("Et_star", "weighted_tangential_energy_J", "scaled E*t", "E*t over rho omega^2 A^2 d^3"),
    _scaled("fn_star", "weighted_normal_frequency_hz", "scaled f*n", "f*n over omega, Pn / En_star"),
    _scaled("ft_star", "weighted_tangential_frequency_hz", "scaled f*t", "f*t over omega, Pt / Et_star"),
    Computed("f90", "-", "scaled f90", "strong collisions over omega",
             values=lambda table: table["strong_frequency_hz"] / table["speed_hz"],
             standard_error=lambda table: table["f90"] * _counting_error(table, "strong")),
)
# fmt: on


def _scaled_of(own: Measured) -> Computed:
    """The scaled quantity of a statistic of collisions, with its error from turns and seeds."""
    return Computed(
        own.curve,
        "-",
        f"scaled {own.title}",
        f"{own.title} over its scale, as a {own.scale}",
        optional=own.optional,
        values=lambda table: table[own.name] / own.scale_of(Condition.of_table(table), table["balls"]),
        standard_error=lambda table: table[own.curve] * table[f"{own.name}_relative_se"],
    )


STATISTICS = tuple(own for own in MEASURED if own.of_collisions)
COMPUTED = (*_COMPUTED, *map(_scaled_of, (own for own in STATISTICS if own.curve)))
DESCRIPTORS: dict[str, Observable] = {own.name: own for own in (*MEASURED, *COMPUTED)}
SHARE = Observable(
    "tangential_share", "-", "tangential share", "tangential over normal and tangential dissipation, without rolling",
    symbol="share", curve="share", panel="Tangential share", line="share", on_card=True,
)  # fmt: skip


def _place(own: Observable) -> int:
    """Where a predicted observable is shown: by energies and frequencies, then powers."""
    return 4 if own.adds_up else (WEIGHTED_SET, "", COLLISION_SET, BY_NAME).index(own.matched)


# What fingerprints predict, in the order of pages and cards.
PREDICTED: dict[str, Observable] = {
    own.name: own for own in [*sorted((own for own in DESCRIPTORS.values() if own.curve), key=_place), SHARE]
}
# Of one ball or one collision -> the scaled quantity.
SCALED_BY = {name: own.curve for name, own in PREDICTED.items() if own is not SHARE and not own.adds_up}
# The sets of descriptors for comparing conditions, and all that a target may name.
DESCRIPTOR_SETS = {
    chosen: tuple(name for name, own in PREDICTED.items() if own.matched == chosen)
    for chosen in (WEIGHTED_SET, COLLISION_SET)
}
TARGET_DESCRIPTORS = tuple(name for name, own in PREDICTED.items() if own.matched)
# What a match can ask for: a set, or how hard the hits are and which share of the power is shear.
ASKED_SETS = {**DESCRIPTOR_SETS, SHARE_SET: ("weighted_normal_energy_J", SHARE.name)}
ASKED_DESCRIPTORS = (*TARGET_DESCRIPTORS, SHARE.name)
# The power and its parts.
POWER, POWER_PARTS = "wall_power_W", ("normal_power_W", "tangential_power_W", "rolling_power_W")


def with_power(parts: Mapping[str, Any]) -> dict[str, Any]:
    """Values by name with the power that closes the energy balance, the sum of its parts, and SHARE."""
    normal, tangential, rolling = (parts[name] for name in POWER_PARTS)
    return {**parts, POWER: normal + tangential + rolling, SHARE.name: tangential / (normal + tangential)}


# What a card has: what is predicted, and what has no curve.
ON_CARD = {**PREDICTED, **{name: own for name, own in DESCRIPTORS.items() if own.on_card}}

# The scaled quantities from which the others of the thesis are calculated (Eqs 3.28 and 3.29).
BASIC = ("Pn", "Pt", "f")
# Quantities that need no counting rule, over the same scales: weighted energies, and the rate of strong collisions.
WEIGHTED_BASIC = ("En_star", "Et_star", "f90")
# Curves of statistics of collisions, each of its own.
OWN_CURVES = tuple(own.curve for own in STATISTICS if own.curve)
# Scaled quantities with a master curve: the four panels of thesis Fig. 3.12, then those for predictions.
PANELS = ("Pn", "Pt", "f", "ratio")
# The panels of a mill's sheet.
SHEET_PANELS = ("Pn", "Pt", "En_star", "Et_star")
# The quantities that depend on the counting rule; those of the energy-weighted descriptors.
COUNTED = ("f", "En", "Et", *OWN_CURVES)
WEIGHTED = ("En_star", "Et_star", "fn_star", "ft_star", "f90")
THESIS_CURVES = (*PANELS, "P", "En", "Et")
# Curves that may be missing: where nothing rolls, of runs without contacts, and in files made before an observable.
LATER_CURVES = ("Pr", "Pw", "rolling_ratio", *OWN_CURVES)
CURVES = (*THESIS_CURVES, *WEIGHTED, *LATER_CURVES)
CURVE_COLUMNS = [
    "fill_ratio",
    *(f"{name}{end}" for name in dict.fromkeys((*PANELS, *SHEET_PANELS)) for end in ("", "_lower", "_upper")),
]


def scaled_quantities(basic: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Every scaled quantity [-] from the quantities of BASIC: ratio = Pt / Pn, P = Pn + Pt, En = Pn / f, Et = Pt / f.

    With the quantities of WEIGHTED_BASIC also fn_star = Pn / En_star and ft_star = Pt / Et_star.
    """
    import numpy as np

    normal, tangential, frequency = (np.asarray(basic[name]) for name in BASIC)
    weighted = {name: np.asarray(basic[name]) for name in WEIGHTED_BASIC if name in basic}
    if weighted:
        weighted |= {"fn_star": normal / weighted["En_star"], "ft_star": tangential / weighted["Et_star"]}
    return weighted | {
        "Pn": normal,
        "Pt": tangential,
        "f": frequency,
        "ratio": tangential / normal,
        "P": normal + tangential,
        "En": normal / frequency,
        "Et": tangential / frequency,
    }


def descriptors_of(condition: Condition, scaled: Mapping[str, Any]) -> dict[str, Any]:
    """Energies [J] and frequencies per ball [1/s] of a condition, by Eqs 3.22, 3.28 and 3.29: each descriptor of
    SCALED_BY whose scaled quantity is known.

    scaled: quantities of the condition [-]: numbers, arrays or `Estimate`s.
    """
    return {
        name: scaled[quantity] * PREDICTED[name].scale_of(condition)
        for name, quantity in SCALED_BY.items()
        if quantity in scaled
    }


def explain_columns() -> str:
    """The page workflow/descriptors.md: every column with its unit and meaning, as Markdown."""
    columns = DESCRIPTORS.values()
    rows = "".join(f"| `{column.name}` | {column.unit} | {column.title}: {column.meaning} |\n" for column in columns)
    return f"# Columns of `descriptors.tsv`\n\n| column | unit | meaning |\n|---|---|---|\n{rows}"
