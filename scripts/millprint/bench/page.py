"""The page docs/reference/comparison.md: features and speed of other tools beside ours."""

import re
from pathlib import Path

import pandas as pd

from millprint.bench.features import TOOLS, feature_rows, read_tools
from millprint.bench.history import STORED, faster_than_lammps, read_history

TOOLS_TABLE = "config/data/tools.tsv"

HEAD = """# Beside other tools

Made by `make reference` from [`config/data/tools.tsv`](../../config/data/tools.tsv) and
[`config/data/bench_history.tsv`](../../config/data/bench_history.tsv); do not edit. The others are general codes for
particles of all kinds; millprint is for balls in mills alone. So the first table also says what it does not have.

## Features

Our own column holds what the library's registries list, and `yes` where a test shows it: `make reference` fails if the
test is gone. What the others have is from their documentation or from trying; the sources are below. *Not documented*
means that we did not find it in the pages that are named there; *not known to us* means that we could not look.
"""

SPEED = """
## Speed

`make bench` times millprint and LAMMPS in turns on one core: the same cylinder, the same motion and the same settled
start, with nothing written. Time of a step of one ball [ns], the median of the repetitions; *ratio* is LAMMPS over
millprint. The walls differ: flat facets in millprint, a smooth cylinder in LAMMPS. `make bench STORE=1` adds a run.
"""

NO_RUN = "No run is kept yet."
ADDRESS = re.compile(r"https?://[^\s;]+")


def _row(cells: list[str]) -> str:
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def _table(head: list[str], rows: list[list[str]]) -> str:
    return "\n".join([_row(head), _row(["---"] * len(head)), *map(_row, rows)])


def speed_rows(history: pd.DataFrame) -> list[list[str]]:
    """A row for each case of the latest run of every processor."""
    table = faster_than_lammps(history)
    latest = table.groupby("processor")["date"].transform("max") == table["date"]
    return [
        [row.processor, row.instructions, f"{row.date}, {row.commit[:7]}", row.lammps, f"{row.balls:.0f}",
         f"{row.ours_ns:.1f}", f"{row.lammps_ns:.0f}", f"{row.ratio:.1f} ± {row.ratio * row.spread:.1f}"]
        for row in table[latest].itertuples()
    ]  # fmt: skip


def comparison_text(root: Path) -> str:
    """The page as Markdown. Raises ConfigError for a table with a fault, and for a feature whose test is not there."""
    tools, history = read_tools(root / TOOLS_TABLE), read_history(root / STORED)
    parts = [HEAD, _table(["", "millprint", *TOOLS], feature_rows(tools, root)), SPEED]
    if len(history):
        head = ["processor", "instructions", "date, commit", "LAMMPS of", "balls", "millprint", "LAMMPS", "ratio"]
        parts.append(_table(head, speed_rows(history)))
    else:
        parts.append(NO_RUN)
    parts.append("\n## Sources\n")
    addresses = tools["source"].str.replace(ADDRESS, r"<\g<0>>", regex=True)
    named = zip(tools["tool"], tools["feature"].str.replace("_", " "), addresses, strict=True)
    sources = [f"- {tool}, {feature}: {address}" for tool, feature, address in named]
    return "\n".join([*parts, *sources]) + "\n"
