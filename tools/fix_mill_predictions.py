"""Fixes predictions for the included mills before anybody measures: python tools/fix_mill_predictions.py RELEASE.

Adds those of each included fingerprint that is not in config/data/waiting_predictions.tsv, with date and digest, as the
generation of a release, such as 0.4.0; with `--swing results/validation/leaf_spring/predictions.tsv` also those of the
box on a leaf spring. Rows that this release had before are replaced, those of earlier releases stay. Writes the table
of docs/why/predictions.md: of the newest rows of each mill, the largest balls, the lowest speed and the middle fill
ratio.
"""

import argparse
import datetime
import re
from pathlib import Path

import pandas as pd

from millprint.config.checks import stop_on_bad_input
from millprint.config.setup_models import SETTINGS, LeafSpringConfig
from millprint.run.files import read_table
from millprint.validation.waiting import (
    LEAF_SPRING,
    TABLE,
    digest_of_file,
    fix_rows,
    fix_waiting,
    read_waiting,
    swing_rows,
)

PAGE = Path("docs/why/predictions.md")
BLOCK = re.compile(r"(<!-- table: python tools/fix_mill_predictions.py -->\n).*?(<!-- end -->)", re.S)
CONDITION = ["mill", "ball_diameter_mm", "fill_ratio", "speed_rpm"]
QUANTITIES = {"power of the walls": "Power [W]", "impacts a second": "Impacts [1/s]",
              "warming of the jar in two minutes": "Warming in 2 min [K]"}  # fmt: skip


def digits(value: float) -> str:
    """A number with three digits, never with an exponent."""
    return f"{float(f'{value:.3g}'):g}"


def table_of(waiting: pd.DataFrame) -> str:
    """A line for each mill: value and intervals of each of QUANTITIES, at one condition of the newest release."""
    head = ["Mill", "Balls [mm]", "Fill ratio [-]", "Speed [rpm]", *QUANTITIES.values()]
    lines = [head, ["---"] * len(head)]
    for _, rows in waiting[waiting["mill"] != LEAF_SPRING].groupby("mill", sort=False):
        own = rows[rows["date"] == rows["date"].max()]
        own = own[own["ball_diameter_mm"] == own["ball_diameter_mm"].max()]
        own = own[own["speed_rpm"] == own["speed_rpm"].min()]
        fills = sorted(own["fill_ratio"].unique())
        own = own[own["fill_ratio"] == fills[len(fills) // 2]]
        cells = []
        for quantity in QUANTITIES:
            found = own[own["quantity"] == quantity]
            ends = "; ".join(f"{digits(row.lower)} to {digits(row.upper)}" for row in found.itertuples())
            cells.append(f"{digits(found['value'].iloc[0])} ({ends})")
        lines.append(
            [*(f"{own[name].iloc[0]:g}" if name != "mill" else own[name].iloc[0] for name in CONDITION), *cells]
        )
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("release", help="version that is to be released")
    parser.add_argument("--swing", type=Path, help="predictions.tsv of the set-up leaf_spring")
    given = parser.parse_args()
    with stop_on_bad_input():
        now = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M")
        fixed = fix_waiting(TABLE, given.release, now)
        if given.swing:
            settings = SETTINGS[LEAF_SPRING]
            assert isinstance(settings, LeafSpringConfig)
            rows = swing_rows(read_table(given.swing, may_be_blank=["x", "lower", "upper", "id"]), settings)
            if fix_rows(TABLE, given.release, now, lambda: rows, LEAF_SPRING, digest_of_file(given.swing)):
                fixed.append(LEAF_SPRING)
        table = table_of(read_waiting())
        PAGE.write_text(BLOCK.sub(lambda found: f"{found[1]}{table}\n{found[2]}", PAGE.read_text()))
        print(f"fixed now: {', '.join(fixed) or 'nothing'}")
