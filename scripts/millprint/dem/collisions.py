"""The table of collisions by contact lifetime, and the descriptors that a counting rule makes of it.

Counting rule: contacts of one pair (two balls, or a ball and one feature of the wall) that follow each other within a
gap are one collision. A gap of 0 counts lifetimes. The gap is stated with every number.
"""

import numpy as np
import pandas as pd

# Columns of a collision, with their units in the name.
COLUMNS = (
    "first",
    "second",
    "start_s",
    "duration_s",
    "approach_speed_m_s",
    "peak_force_N",
    "peak_overlap_m",
    "normal_J",
    "damping_J",
    "sliding_J",
    "rolling_J",
    "complete",
)


def collision_table(first: np.ndarray, second: np.ndarray, ended: np.ndarray, value: np.ndarray) -> pd.DataFrame:
    """One row for each contact that was open in the window.

    first: ball; second: ball, or -1 - feature of the wall. start_s counts from the start of the mill and may lie
    before the window; energies are those within the window. sliding_J is the tangential work less the damping share.
    complete is 0 where the window ended before the contact.
    """
    start, duration, approach, force, overlap, normal, damping, tangential, rolling = value.T
    columns = (first, second, start, duration, approach, force, overlap, normal, damping, tangential - damping, rolling)
    table = pd.DataFrame(dict(zip(COLUMNS, columns, strict=False)))
    table["complete"] = ended.astype(np.uint8)
    return table


def group_collisions(table: pd.DataFrame, gap_s: float) -> np.ndarray:
    """Number of the collision (n,) that each contact belongs to under the counting rule with this gap [s]."""
    if table.empty:
        return np.zeros(0, dtype=np.int64)
    first, second = table["first"].to_numpy(), table["second"].to_numpy()
    start = table["start_s"].to_numpy()
    order = np.lexsort((start, second, first))
    end = (start + table["duration_s"].to_numpy())[order]
    same_pair = (np.diff(first[order]) == 0) & (np.diff(second[order]) == 0)
    joined = same_pair & (start[order][1:] - end[:-1] <= gap_s) & (gap_s > 0)
    groups = np.empty(len(table), dtype=np.int64)
    groups[order] = np.concatenate([[0], np.cumsum(~joined)])
    return groups


def collision_statistics(table: pd.DataFrame, gaps_s: list[float], begin_s: float, window_s: float) -> list[dict]:
    """Count, frequency and mean energies of a collision for each gap, thesis Eqs 3.20 and 3.21.

    A collision counts if it begins within the window, which starts at begin_s and lasts window_s [s]; the energies
    are those of all contacts in the window, so that frequency times mean energy is the dissipated power (Eqs 3.22,
    3.23). Tangential energy is damping and sliding together.
    """
    normal = float(table["normal_J"].sum())
    tangential = float(table["damping_J"].sum() + table["sliding_J"].sum())
    rows = []
    for gap in gaps_s:
        starts = table["start_s"].groupby(group_collisions(table, gap)).min()
        count = int((starts >= begin_s).sum())
        rows.append(
            {
                "gap_s": float(gap),
                "count": count,
                "frequency_hz": count / window_s,
                "mean_normal_J": normal / count if count else 0.0,
                "mean_tangential_J": tangential / count if count else 0.0,
            }
        )
    return rows


def histograms(table: pd.DataFrame, bins: int = 120) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Counts of every column of the table over logarithmic bins, as (edges, counts)."""
    made = {}
    for name in COLUMNS[3:11]:
        value = table[name].to_numpy()
        value = value[value > 0]
        if value.size:
            edges = np.geomspace(value.min(), value.max() * (1 + 1e-12), bins + 1)
            made[name] = (edges, np.histogram(value, edges)[0])
    return made
