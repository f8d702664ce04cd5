"""Intervals of power, toe and shoulder of a tumbling mill: by scatter of seeds and by contact parameters."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from millprint.config.setups.tumbling_setups import TumblingConfig
from millprint.statistics.quantiles import student_quantile
from millprint.validation.predictions import CONTACT, SCATTER
from millprint.validation.tumbling_runs import FURTHER, PREDICTS, SAMPLE

PROBABILITY = 0.95
BOTH = f"{SCATTER} and {CONTACT}"


def mean_interval(
    values: np.ndarray, least: float = -math.inf, probability: float = PROBABILITY
) -> tuple[float, float, float]:
    """Mean of values over the seeds, and its interval by Student's t; without an interval (nan) for a single value.

    least: the smallest possible value of the quantity, where the interval is cut off. This does not change its
    probability.
    """
    values = np.asarray(values, dtype=float)
    mean = float(values.mean())
    if len(values) < 2:
        return mean, math.nan, math.nan
    half = float(student_quantile(0.5 + probability / 2, len(values) - 1) * values.std(ddof=1) / math.sqrt(len(values)))
    return mean, _not_below(mean - half, mean, least), mean + half


def _not_below(lower: float, value: float, least: float) -> float:
    """The lower end of an interval about a value, or `least` if that is higher; the value itself stays inside."""
    return max(lower, min(value, least))


def without_jump(angles_deg: np.ndarray) -> np.ndarray:
    """The same angles [deg] within half a turn of their circular mean, so that 359 and 1 are two degrees apart."""
    angles = np.asarray(angles_deg, dtype=float)
    if not angles.size:
        return angles
    # Slow to import, and every set-up imports this module.
    from scipy.stats import circmean

    return nearest_turn(angles, circmean(angles, high=360))


def nearest_turn(angles_deg: Any, reference_deg: Any) -> Any:
    """Angles [deg] plus or minus whole turns, so that each is within half a turn of a reference [deg]."""
    return reference_deg + (angles_deg - reference_deg + 180) % 360 - 180


@dataclass(frozen=True)
class Quantity:
    """A quantity with a known interval by contact parameters: a column of the runs, and how it changes.

    least: its smallest possible value; relative: whether contact parameters multiply it, or add to it, as to an angle
    [deg].
    """

    column: str
    unit: str
    least: float
    relative: bool

    @property
    def unchanged(self) -> float:
        """The change of a quantity that stays the same."""
        return 1.0 if self.relative else 0.0

    def change(self, value: pd.Series, base: pd.Series) -> pd.Series:
        """The change from the base to the value."""
        return value / base if self.relative else nearest_turn(value, base) - base

    def changed(self, base: float, change: float) -> float:
        """The base after a change."""
        return base * change if self.relative else base + change

    def mean_interval(self, values: pd.Series) -> tuple[float, float, float]:
        """`mean_interval` of the known values; nan if there are none."""
        known = values.dropna().to_numpy()
        if not known.size:
            return math.nan, math.nan, math.nan
        return mean_interval(known if self.relative else without_jump(known), self.least)

    def name(self, what: str) -> str:
        """The column of a table for one end of an interval, such as power_scatter_lower_W."""
        return f"{self.column.removesuffix(self.unit)}{what}_{self.unit}"


POWER_W = Quantity("power_W", "W", least=0.0, relative=True)
ANGLES = {name: Quantity(name, "deg", least=-math.inf, relative=False) for name in ("toe_deg", "shoulder_deg")}
QUANTITIES = (POWER_W, *ANGLES.values())
ENDS = ("lower", "upper")


def contact_changes(runs: pd.DataFrame, quantity: Quantity, probability: float = PROBABILITY) -> pd.DataFrame:
    """How contact parameters change a quantity: index speed, columns lower and upper, factors or differences.

    Each run of the sample and of the further contact sets is compared with the prediction of the same seed and speed.
    The ends are quantiles over the sample, widened to include the further sets and the prediction itself. A charge that
    covers the whole shell has no toe and no shoulder, and is left out; so is a speed without any angle.
    """
    first = runs[runs["role"] != PREDICTS]
    own = runs[(runs["role"] == PREDICTS) & (runs["number"] == runs["number"].iloc[0])]
    base = own[own["seed"] == own["seed"].iloc[0]].set_index("speed")[quantity.column]
    change = quantity.change(first[quantity.column], first["speed"].map(base))
    tail = (1 - probability) / 2
    rows = {}
    for speed, group in first.assign(change=change).dropna(subset="change").groupby("speed"):
        sampled = group.loc[group["role"] == SAMPLE, "change"]
        named = [quantity.unchanged, *group.loc[group["role"] == FURTHER, "change"]]
        ends = sampled.quantile([tail, 1 - tail]) if len(sampled) else pd.Series([quantity.unchanged] * 2)
        rows[speed] = {"lower": min(ends.iloc[0], *named), "upper": max(ends.iloc[1], *named)}
    return pd.DataFrame.from_dict(rows, orient="index", columns=list(ENDS)).sort_index()


def combined(
    value: float, scatter: tuple[float, float], contact: tuple[float, float], least: float = -math.inf
) -> tuple[float, float]:
    """Ends of two independent intervals about a value together: their distances from it, added in squares.

    least: as for `mean_interval`.
    """
    low = math.hypot(value - scatter[0], value - contact[0])
    high = math.hypot(scatter[1] - value, contact[1] - value)
    return _not_below(value - low, value, least), value + high


def _interval_columns(group: pd.DataFrame, speed: float, quantity: Quantity, changes: pd.DataFrame) -> dict[str, float]:
    """The mean over the seeds, and the ends of both of its intervals; nan where they are not known."""
    mean, *scatter = quantity.mean_interval(group[quantity.column])
    change = [float(np.interp(speed, changes.index, changes[end])) if len(changes) else math.nan for end in ENDS]
    contact = [quantity.changed(mean, each) for each in change]
    return {
        quantity.column: mean,
        **{quantity.name(f"scatter_{end}"): value for end, value in zip(ENDS, scatter, strict=True)},
        **{quantity.name(f"contact_{end}"): value for end, value in zip(ENDS, contact, strict=True)},
    }


def intervals(runs: pd.DataFrame, settings: TumblingConfig) -> pd.DataFrame:
    """Power, toe and shoulder with both of their intervals; a row for each number of balls and speed.

    Columns: number, speed, speed_rpm, seeds; for power_W, toe_deg and shoulder_deg the mean over the seeds and the ends
    of the intervals, such as power_scatter_lower_W and toe_contact_upper_deg; rings; carried_share: of the balls. The
    effect of contact parameters is taken from the first number of balls, interpolated over the speed and constant
    beyond the sampled speeds.
    """
    changes = {quantity: contact_changes(runs, quantity) for quantity in QUANTITIES}
    own = runs[runs["role"] == PREDICTS]
    rows = []
    for (number, speed), group in own.groupby(["number", "speed"]):
        row = {"number": number, "speed": speed, "speed_rpm": group["speed_rpm"].iloc[0], "seeds": len(group)}
        for quantity, effect in changes.items():
            row |= _interval_columns(group, speed, quantity, effect)
        rows.append(row | {"rings": group["rings"].mean(), "carried_share": group["carried"].mean() / number})
    rank = {number: place for place, number in enumerate(settings.numbers)}
    return pd.DataFrame(sorted(rows, key=lambda row: (rank[row["number"]], row["speed"])))


def whole_interval(row: dict[str, Any], quantity: Quantity) -> tuple[float, float, str]:
    """Ends of the interval of a row of `intervals` by scatter and by contact parameters, and its origin."""
    value, scatter, contact = (
        row[quantity.column],
        *((row[quantity.name(f"{by}_lower")], row[quantity.name(f"{by}_upper")]) for by in ("scatter", "contact")),
    )
    if math.isnan(contact[0]):
        return *scatter, SCATTER
    return *combined(value, scatter, contact, quantity.least), BOTH
