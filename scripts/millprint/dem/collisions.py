"""The table of collisions by contact lifetime, and descriptors for each counting rule.

Counting rule: contacts of one pair (two balls, or a ball and one feature of the wall) that follow each other within a
gap are one collision; a collision below a peak force or a time in contact is then dropped. A gap of 0 counts
lifetimes. The rule is stated with every number.
"""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from millprint.columns import names_of
from millprint.config.counting import CountingRule
from millprint.dem.layout import COLLISION

if TYPE_CHECKING:
    # Its module holds kernels, which a reader of finished runs does not need.
    from millprint.dem.recording import Table

# What a collision has in the column of all its tangential work: the work less the damping share.
SLIDING = "sliding_J"
# Values of a collision, with their units in the name, and all columns of the table.
VALUE_NAMES = [SLIDING if name == "tangential_J" else name for name in names_of(COLLISION)]
COLLISION_NAMES = ["first", "second", "facet", "contact", *VALUE_NAMES, "complete"]


def collision_table(contacts: "Table") -> pd.DataFrame:
    """The contacts that were open in the window, a row each, in COLLISION_NAMES.

    first: ball; second: ball, or -1 - patch of the wall; facet: feature of the wall, or -1 for two balls and where it
    was not recorded; contact: number of the contact. start_s counts from the start of the mill and may lie
    before the window; energies are those within the window. sliding_J is the tangential work less the damping share.
    complete is 0 where the window ended before the contact.
    """
    values = dict(zip(names_of(COLLISION), contacts.value.T, strict=True))
    values[SLIDING] = values.pop("tangential_J") - values["damping_J"]
    facet = contacts.facet if len(contacts.facet) else np.full(len(contacts.first), -1)
    whole = {"first": contacts.first, "second": contacts.second, "facet": facet, "contact": contacts.contact}
    columns = {**whole, **values, "complete": contacts.ended}
    return pd.DataFrame(columns)[COLLISION_NAMES].astype({"complete": np.uint8})


def sort_by_pair(table: pd.DataFrame) -> pd.DataFrame:
    """The columns for counting, ordered by pair and then by start; tangential_J is the whole tangential work."""
    order = np.lexsort([table[name].to_numpy() for name in ("start_s", "second", "first")])
    tangential = table["damping_J"].to_numpy() + table["sliding_J"].to_numpy()
    names = ("first", "second", "start_s", "duration_s", "peak_force_N", "normal_J")
    columns = {name: table[name].to_numpy()[order] for name in names}
    return pd.DataFrame({**columns, "tangential_J": tangential[order]})


def merge_contacts(ordered: pd.DataFrame, gap_s: float) -> pd.DataFrame:
    """One row for each collision, of contacts as `sort_by_pair` gives them: re-contacts within gap_s [s] are one.

    start_s is that of the first contact, duration_s the time in contact, peak_force_N the largest; energies add up.
    """
    if ordered.empty or gap_s == 0:
        return ordered
    column = {name: ordered[name].to_numpy() for name in ordered.columns}
    same_pair = (np.diff(column["first"]) == 0) & (np.diff(column["second"]) == 0)
    free_s = column["start_s"][1:] - (column["start_s"] + column["duration_s"])[:-1]
    begins = np.flatnonzero(np.concatenate([[True], ~(same_pair & (free_s <= gap_s))]))
    merged = {name: column[name][begins] for name in ("first", "second", "start_s")}
    merged["peak_force_N"] = np.maximum.reduceat(column["peak_force_N"], begins)
    for name in ("duration_s", "normal_J", "tangential_J"):
        merged[name] = np.add.reduceat(column[name], begins)
    return pd.DataFrame(merged)


def _shares(chosen: np.ndarray, weights: dict[str, np.ndarray]) -> dict[str, float]:
    """Sum of each weight over the chosen collisions, as a fraction of its sum over all; 0 where there is none."""
    totals = {name: float(weight.sum()) for name, weight in weights.items()}
    return {
        name: float(weight[chosen].sum()) / totals[name] if totals[name] else 0.0 for name, weight in weights.items()
    }


def count_collisions(merged: pd.DataFrame, rule: CountingRule, begin_s: float, window_s: float, balls: int) -> dict:
    """The statistics of one rule, from collisions merged by its gap, as in `collision_statistics`."""
    begins_within = merged["start_s"].to_numpy() >= begin_s
    hard = merged["peak_force_N"].to_numpy() >= rule.peak_force_min_N
    kept = hard & (merged["duration_s"].to_numpy() >= rule.duration_min_s)
    weights = {
        "count": begins_within.astype(float),
        "normal": merged["normal_J"].to_numpy(),
        "tangential": merged["tangential_J"].to_numpy(),
    }
    among_kept = {name: weight[kept] for name, weight in weights.items()}
    count = int(among_kept["count"].sum())
    of_balls = merged["second"].to_numpy()[kept] >= 0
    return {
        **rule.model_dump(),
        "count": count,
        "frequency_hz": count / window_s,
        "frequency_per_ball_hz": count / window_s / balls,
        "mean_normal_J": float(among_kept["normal"].sum()) / count if count else 0.0,
        "mean_tangential_J": float(among_kept["tangential"].sum()) / count if count else 0.0,
        "shares": {"ball_ball": _shares(of_balls, among_kept), "ball_wall": _shares(~of_balls, among_kept)},
        "dropped": _shares(~kept, weights),
    }


def collision_statistics(
    table: pd.DataFrame, rules: list[CountingRule], begin_s: float, window_s: float, balls: int
) -> list[dict]:
    """Collisions under each counting rule: count, frequency and mean energies, thesis Eqs 3.20 and 3.21.

    A collision counts if it begins within the window, which starts at begin_s and lasts window_s [s]. Its energies are
    those within the window, and those of collisions from before it are in the mean too, so that frequency times mean
    energy is the power dissipated in collisions that the rule keeps (Eqs 3.22, 3.23). Tangential energy is damping and
    sliding together. shares: fractions of the kept collisions and their energies that are between balls, and with the
    wall. dropped: fractions of all collisions and energies that fell below a threshold of the rule.
    """
    ordered = sort_by_pair(table)
    counted = {}
    # Rules with the same gap share the merged table; only one is held in memory at a time.
    for gap in {rule.gap_s for rule in rules}:
        merged = merge_contacts(ordered, gap)
        for rule in rules:
            if rule.gap_s == gap:
                counted[rule.name] = count_collisions(merged, rule, begin_s, window_s, balls)
    return [counted[rule.name] for rule in rules]


# The lower end of a histogram, over the largest value.
RANGE = 1e-12
# A start has no distribution.
HISTOGRAM_NAMES = [name for name in VALUE_NAMES if name != "start_s"]


def histograms(table: pd.DataFrame, bins: int = 120) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Counts of the columns HISTOGRAM_NAMES of the table over logarithmic bins: (edges (bins + 1,), counts (bins,)).

    Values below RANGE of the largest, such as the damping of a contact that hardly slips, are in the first bin.
    """
    made = {}
    for name in HISTOGRAM_NAMES:
        value = table[name].to_numpy()
        value = value[value > 0]
        if value.size:
            low = max(value.min(), RANGE * value.max())
            edges = np.geomspace(low, value.max() * (1 + 1e-12), bins + 1)
            made[name] = (edges, np.histogram(np.maximum(value, low), edges)[0])
    return made
