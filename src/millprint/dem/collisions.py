"""The table of collisions, counts under each counting rule, and energy-weighted descriptors.

A row of the table is a contact of a ball with another ball or with a surface of the wall or, where a rule counts by
facet, the part of such a contact on one facet.

Counting rule: contacts of one pair (two balls, or a ball and one surface or facet of the wall) that follow each other
within a gap are one collision; a collision below a peak force or a time in contact is then dropped. A gap of 0 counts
lifetimes. The rule is stated with every number.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from millprint.config.counting import CountingRule
from millprint.dem.layout import COLLISION, ENDED
from millprint.mill.kernel_columns import names_of
from millprint.observables.counted_collisions import CHANNELS

if TYPE_CHECKING:
    import h5py

    # Its module holds kernels, which a reader of finished runs does not need.
    from millprint.dem.recording import Table

# The dissipation of a channel under this share of the whole is rounding, as the shear of balls that bounce straight up.
ROUNDING = 1e-9
# Share by which times may be rounded, in the single precision of a file too: of a gap or a duration, far below a step.
ROUNDED = 1e-4
# Name of a collision's value in the column of all tangential work: the work less the damping share.
SLIDING = "sliding_J"
# Values of a collision, with their units in the name.
VALUE_NAMES = [SLIDING if name == "tangential_J" else name for name in names_of(COLLISION)]
# Columns of the rows as recorded, and of contacts.
ROW_NAMES = ["first", "second", "facet", "contact", *VALUE_NAMES, "ended"]
COLLISION_NAMES = ["first", "second", *VALUE_NAMES, "complete"]
# How the values of rows combine to the value of their contact; all others add up.
JOINED = {
    **dict.fromkeys(("start_s", "approach_speed_m_s", "slip_speed_m_s"), "first"),
    **dict.fromkeys(("peak_force_N", "peak_overlap_m"), "max"),
}

# The two parts of the tangential work.
WORKS = ("damping_J", SLIDING)

# The share of the normal energy that the strongest collisions hold, which are counted as f90.
STRONG_SHARE = 0.9


def collision_table(contacts: Table) -> pd.DataFrame:
    """The rows that were open in the window, in ROW_NAMES.

    first: ball; second: ball, or -1 - patch of the wall; facet: feature of the wall on which the row ended, -1 for two
    balls and where a contact has one row; contact: its number in the run; ended: of layout.RowEnds. start_s counts from
    the start of the mill and may lie before the window; energies are those within the window. sliding_J is the
    tangential work less the damping share.
    """
    values = dict(zip(names_of(COLLISION), contacts.value.T, strict=True))
    values[SLIDING] = values.pop("tangential_J") - values["damping_J"]
    columns = {name: getattr(contacts, name) for name in ("first", "second", "facet", "contact", "ended")}
    if len(contacts.facet) < len(contacts.first):
        columns["facet"] = np.full(len(contacts.first), -1)
    return pd.DataFrame(columns | values)[ROW_NAMES].astype({"ended": np.uint8})


def by_surface(rows: pd.DataFrame) -> pd.DataFrame:
    """The contacts of rows as `collision_table` gives them, one row each; columns that are not there stay out.

    Works and times in contact add up over the rows of a contact; the start and the speed of approach are those of the
    first, peaks the largest. complete is 0 where the window ended before the contact.
    """
    if (rows["ended"] == ENDED.passed).any():
        groups = rows.sort_values(["contact", "start_s"], kind="stable").groupby("contact", sort=True)
        ways = {name: JOINED.get(name, "sum") for name in VALUE_NAMES if name in rows}
        rows = groups.agg({"first": "first", "second": "first", **ways, "ended": "last"})
    return _contacts(rows)


def by_facet(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows themselves as contacts, with -1 - facet as the partner of a ball at a wall."""
    facet = rows["facet"].to_numpy()
    return _contacts(rows.assign(second=np.where(facet >= 0, -1 - facet, rows["second"])))


def _contacts(rows: pd.DataFrame) -> pd.DataFrame:
    kept = rows[[name for name in COLLISION_NAMES if name in rows]]
    return kept.assign(complete=(rows["ended"] == ENDED.parted).astype(np.uint8)).reset_index(drop=True)


CONTACTS_BY = {"surface": by_surface, "facet": by_facet}


# The values that counting and energies need.
COUNTING = ("start_s", "duration_s", "peak_force_N", "normal_J", *WORKS)


def read_rows(group: h5py.Group, names: Iterable[str] = COUNTING) -> pd.DataFrame | None:
    """Rows of the group `collisions` of a run.h5, with some of VALUE_NAMES; None where there were too many to keep.

    In double precision: sums of millions of numbers in single precision would lose digits.
    """
    if "second" not in group:
        return None
    whole = {name: group[name][:].astype(np.int64) for name in ROW_NAMES if name not in VALUE_NAMES}
    return pd.DataFrame(whole | {name: group[name][:].astype(float) for name in names})


def sort_by_pair(table: pd.DataFrame) -> pd.DataFrame:
    """The columns for counting, ordered by pair and then by start; tangential_J is the whole tangential work.

    Of the values of a contact, all that the table has stay.
    """
    order = np.lexsort([table[name].to_numpy() for name in ("start_s", "second", "first")])
    tangential = table["damping_J"].to_numpy() + table["sliding_J"].to_numpy()
    names = ("first", "second", *(name for name in VALUE_NAMES if name in table and name not in WORKS))
    columns = {name: table[name].to_numpy()[order] for name in names}
    return pd.DataFrame({**columns, "tangential_J": tangential[order]})


def merge_contacts(ordered: pd.DataFrame, gap_s: float) -> pd.DataFrame:
    """One row for each collision, of contacts as `sort_by_pair` gives them: re-contacts within gap_s [s] are one.

    Start and speeds are those of the first contact, peaks the largest; times in contact and energies add up. A gap that
    is a whole number of steps is as often met exactly, so that rounding must not decide.
    """
    if ordered.empty or gap_s == 0:
        return ordered
    column = {name: ordered[name].to_numpy() for name in ordered.columns}
    same_pair = (np.diff(column["first"]) == 0) & (np.diff(column["second"]) == 0)
    free_s = column["start_s"][1:] - (column["start_s"] + column["duration_s"])[:-1]
    begins = np.flatnonzero(np.concatenate([[True], ~(same_pair & (free_s <= gap_s * (1 + ROUNDED)))]))
    ways = {"first": "first", "second": "first", **JOINED}
    joined = {
        "first": lambda values: values[begins],
        "max": lambda values: np.maximum.reduceat(values, begins),
        "sum": lambda values: np.add.reduceat(values, begins),
    }
    return pd.DataFrame({name: joined[ways.get(name, "sum")](values) for name, values in column.items()})


def _shares(chosen: np.ndarray, weights: dict[str, np.ndarray]) -> dict[str, float]:
    """Sum of each weight over the chosen collisions, as a fraction of its sum over all; 0 where there is none."""
    totals = {name: float(weight.sum()) for name, weight in weights.items()}
    return {
        name: float(weight[chosen].sum()) / totals[name] if totals[name] else 0.0 for name, weight in weights.items()
    }


def kept_by(rule: CountingRule, merged: pd.DataFrame) -> np.ndarray:
    """Which of the merged collisions are over the thresholds of a rule."""
    hard = merged["peak_force_N"].to_numpy() >= rule.peak_force_min_N
    return hard & (merged["duration_s"].to_numpy() >= rule.duration_min_s * (1 - ROUNDED))


def count_collisions(merged: pd.DataFrame, rule: CountingRule, begin_s: float, window_s: float, balls: int) -> dict:
    """The statistics of one rule, from collisions merged by its gap, as in `collision_statistics`."""
    begins_within = merged["start_s"].to_numpy() >= begin_s
    kept = kept_by(rule, merged)
    weights = {
        "count": begins_within.astype(float),
        "normal": merged["normal_J"].to_numpy(),
        "tangential": merged["tangential_J"].to_numpy(),
    }
    among_kept = {name: weight[kept] for name, weight in weights.items()}
    count = int(among_kept["count"].sum())
    of_balls = merged["second"].to_numpy()[kept] >= 0
    # Each of two balls takes part in their collision.
    taken_part = count + int(among_kept["count"][of_balls].sum())
    return {
        **rule.model_dump(),
        "count": count,
        "frequency_hz": count / window_s,
        "specific_frequency_hz": count / window_s / balls,
        "collisions_of_a_ball_hz": taken_part / window_s / balls,
        "mean_normal_J": float(among_kept["normal"].sum()) / count if count else 0.0,
        "mean_tangential_J": float(among_kept["tangential"].sum()) / count if count else 0.0,
        "shares": {"ball_ball": _shares(of_balls, among_kept), "ball_wall": _shares(~of_balls, among_kept)},
        "dropped": _shares(~kept, weights),
    }


def collision_statistics(
    rows: pd.DataFrame, rules: list[CountingRule], begin_s: float, window_s: float, balls: int, frequency_hz: float
) -> list[dict]:
    """Collisions under each counting rule: count, frequency and mean energies, thesis Eqs 3.20 and 3.21.

    A collision counts if it begins within the window, which starts at begin_s and lasts window_s [s]. Its energies are
    those within the window, and those of collisions from before it are in the mean too, so that frequency times mean
    energy is the power dissipated in collisions that the rule keeps (Eqs 3.22, 3.23). Tangential energy is damping and
    sliding together. specific_frequency_hz: all collisions over the balls; collisions_of_a_ball_hz: those that a ball
    takes part in, so that one between two balls counts for both. shares: fractions of the kept collisions and their
    energies that are between balls, and with the wall. dropped: fractions of all collisions and energies that fell
    below a threshold of the rule. frequency_hz: turns of the mill, in which gaps are.
    """
    counted = {}
    # Rules with the same pairs and gap share the merged table; only one is held in memory at a time.
    for by, contacts_by in CONTACTS_BY.items():
        of_pairs = [rule for rule in rules if rule.by == by]
        ordered = sort_by_pair(contacts_by(rows)) if of_pairs else None
        for gap in {rule.gap_turns for rule in of_pairs}:
            same = [rule for rule in of_pairs if rule.gap_turns == gap]
            merged = merge_contacts(ordered, same[0].gap_s(frequency_hz))
            for rule in same:
                counted[rule.name] = count_collisions(merged, rule, begin_s, window_s, balls)
    return [counted[rule.name] for rule in rules]


def energies_of(contacts: pd.DataFrame) -> dict[str, np.ndarray]:
    """The energy of each contact in each of CHANNELS [J]."""
    tangential = contacts["damping_J"].to_numpy() + contacts["sliding_J"].to_numpy()
    return dict(zip(CHANNELS, (contacts["normal_J"].to_numpy(), tangential), strict=True))


def turns_of(contacts: pd.DataFrame, begin_s: float, frequency_hz: float) -> np.ndarray:
    """How many contacts each counts as in `weighted_energy`: 1, or its turns in the window if it lasts longer than one.

    Otherwise a ball that always rests or rolls would make E* grow with the recorded time.
    """
    start = contacts["start_s"].to_numpy()
    within_s = start + contacts["duration_s"].to_numpy() - np.maximum(start, begin_s)
    return np.maximum(within_s * frequency_hz, 1.0)


def squares_of(energy: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """The part of each contact in the sum of squares [J2]; a negative work, which a spring gave back, has none."""
    return np.maximum(energy, 0.0) ** 2 / turns


def weighted_energy(energy: np.ndarray, turns: np.ndarray) -> float:
    """Energy-weighted mean energy E* = sum e^2 / sum e [J] of contacts (n,), as a Sauter diameter; 0 without energy.

    A contact weighs as much as it dissipates, so that weak contacts, and how they are counted, do not matter. One with
    a negative work weighs nothing. turns: as of `turns_of`; one of k > 1 counts as k of e / k.
    """
    total = np.maximum(energy, 0.0).sum()
    return float(squares_of(energy, turns).sum() / total) if total > 0 else 0.0


def strongest(energy: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Places of the strongest contacts that hold STRONG_SHARE of all energy, strongest first; none without energy."""
    order = np.argsort(-energy / turns, kind="stable")
    held = np.cumsum(np.maximum(energy[order], 0.0))
    if not held.size or held[-1] <= 0:
        return order[:0]
    # Rounding must not take one more than the share asks for.
    return order[: int(np.searchsorted(held, STRONG_SHARE * held[-1] * (1 - 1e-12))) + 1]


def weighted_statistics(
    contacts: pd.DataFrame, power_W: dict[str, float], begin_s: float, window_s: float, balls: int, frequency_hz: float
) -> dict:
    """Descriptors without a counting rule, from contacts by surface.

    For each of CHANNELS, energy_J: E* (see `weighted_energy`); specific_frequency_hz: f* = P / E* over the balls, the
    rate of collisions of E* that dissipate the power P; negative: the contacts of a negative work, and their share of
    the energy of all. strong_frequency_hz: f90, the strongest contacts that hold STRONG_SHARE of the normal energy, a
    second and over the balls. power_W: of the ledger, by channel; frequency_hz: turns of the mill.
    """
    energies, turns, found = energies_of(contacts), turns_of(contacts, begin_s, frequency_hz), {}
    for channel, energy in energies.items():
        mean, lost = weighted_energy(energy, turns), energy[energy < 0]
        total = energy.sum()
        found[channel] = {
            "energy_J": mean,
            "specific_frequency_hz": power_W[channel] / mean / balls if mean else 0.0,
            "negative": {"count": len(lost), "share": float(lost.sum() / total) if total > 0 else 0.0},
        }
    strong = float(turns[strongest(energies["normal"], turns)].sum())
    return found | {"strong_frequency_hz": strong / window_s / balls}


def squares_per_turn(contacts: pd.DataFrame, begin_s: float, frequency_hz: float, turns: int) -> dict[str, np.ndarray]:
    """Sums of squares [J2] in each of CHANNELS of the contacts that begin in each turn (turns,); those from before the
    window are in the first, those after the last whole turn in the last.
    """
    place = np.floor((contacts["start_s"].to_numpy() - begin_s) * frequency_hz).astype(int).clip(0, turns - 1)
    lasting = turns_of(contacts, begin_s, frequency_hz)
    return {
        channel: np.bincount(place, weights=squares_of(energy, lasting), minlength=turns)
        for channel, energy in energies_of(contacts).items()
    }
