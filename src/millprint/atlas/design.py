"""The conditions of the atlas: spread over the groups of a kind, and the held-out mills that no model sees.

Both are Sobol sequences over the ranges of the groups (scipy.stats.qmc), each with its own seed. The held-out ones are
drawn first and kept in a file, so that a later change of the design cannot choose them.
"""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from scipy.stats import qmc

from millprint.atlas.kind_groups import FEWEST_BALLS, MOST_BALLS, Kind
from millprint.atlas.kinds import KINDS, kind_named
from millprint.config.atlas import HELD_OUT_MILLS
from millprint.run.files import read_table, write_table

HELD_OUT, TRAINING = "held_out", "training"
# What the motion of a row without numbers begins with: its simulation failed, or it would teach little.
FAILED, SKIPPED = "failed", "not simulated"
# Seeds of the two sequences.
SEEDS = {HELD_OUT: 20_281, TRAINING: 7}


def conditions(kind: Kind, part: str) -> Iterator[dict[str, float]]:
    """The conditions of a part of the design of a kind, without end: all of `Kind.condition_of`.

    A point with more than MOST_BALLS balls, or whose whole number of balls has a fill ratio out of the range, is left
    out.
    """
    sequence = qmc.Sobol(len(kind.groups), scramble=True, seed=SEEDS[part])
    fill = kind.groups[kind.names.index("fill")]
    while True:
        for shares in sequence.random(64):
            groups = {group.name: group.at(share) for group, share in zip(kind.groups, shares, strict=True)}
            condition = kind.condition_of(groups)
            own = kind.groups_of(condition)["fill"]
            if FEWEST_BALLS <= condition["number"] <= MOST_BALLS and fill.low <= own <= fill.high:
                yield condition


def design(kind: Kind, part: str, count: int) -> pd.DataFrame:
    """The first `count` conditions of a part, a row each, and the groups that they have; index: their number."""
    rows = [condition for _, condition in zip(range(count), conditions(kind, part), strict=False)]
    groups = [kind.groups_of(row) for row in rows]
    table = pd.DataFrame({"kind": kind.name, "part": part, "row": np.arange(count)})
    return pd.concat(
        [table, pd.DataFrame(groups), pd.DataFrame({"number": [int(row["number"]) for row in rows]})], axis=1
    )


def rows_of(kind: str, part: str, first: int, count: int, held_out: str) -> pd.DataFrame:
    """Rows `first` to `first + count - 1` of a part of the design of a kind.

    held_out: the file of the held-out mills, which were drawn before any model was fitted. Raises ConfigError for an
    unknown kind.
    """
    own = kind_named(kind)
    if part == HELD_OUT:
        table = read_table(held_out)
        return table.loc[table["kind"] == kind, ["kind", "part", "row", *own.names, "number"]].iloc[
            first : first + count
        ]
    return design(own, part, first + count).iloc[first:]


def write_held_out(path: str) -> None:
    """Draw the held-out mills of every kind and write their table. It is done once."""
    write_table(pd.concat([design(kind, HELD_OUT, HELD_OUT_MILLS) for kind in KINDS.values()]), path, digits=17)
