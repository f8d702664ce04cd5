"""The page docs/reference/growth.md: how cost grows with the size of a run, from the table that is kept."""

from pathlib import Path

import pandas as pd

from millprint.growth.table import STORED, read_growth

HEAD = """# How cost grows

Made by `make reference` from [`config/data/growth.tsv`](../../config/data/growth.tsv); do not edit.
`python scripts/measure_growth.py --store` measures again. Times are processor times [s], with those of all children and
all threads; memory is the largest of one process [MB].

:::{figure} ../pictures/growth.png
:alt: Five panels: time over simulations, conditions, size of a page and balls; memory over balls, with the cost model

What was measured, and the cost model of `make plan`, dashed, up to a million balls.
:::
"""
# By part: its title, what it says, and the columns that it shows with their heads.
SHOWN = {
    "planning": (
        "Planning",
        "A mill with so many simulations: up to 100 seeds of each of 300 conditions. *Snakemake alone* are as many "
        "jobs with nothing behind them.",
        {"size": "simulations", "processor_s": "time (s)", "memory_MB": "memory (MB)"},
    ),
    "fingerprint": (
        "Fingerprint",
        "Conditions near those of a measured sweep, with scatter. The file is the fingerprint.",
        {"size": "conditions", "processor_s": "time (s)", "memory_MB": "memory (MB)", "file_MB": "file (MB)"},
    ),
    "pages": (
        "Pages",
        "A browser without a window opens the page, runs its scripts, and ends; most of the time is its start.",
        {"size": "size (MB)", "processor_s": "time (s)", "memory_MB": "memory (MB)"},
    ),
    "simulation": (
        "Simulations",
        "A short stretch of the driven Emax at one fill ratio, scaled up or down.",
        {"size": "balls", "value": "a ball and a step (ns)", "memory_MB": "memory (MB)"},
    ),
}


def _cell(value: object) -> str:
    number = pd.to_numeric(value, errors="coerce")
    return "" if pd.isna(number) else f"{number:,.0f}" if number >= 1000 else f"{number:.3g}"


def _rows(table: pd.DataFrame, columns: dict[str, str]) -> list[str]:
    head = ["", *columns.values(), "measured"]
    lines = [f"| {' | '.join(head)} |", f"| {' | '.join(['---'] * len(head))} |"]
    for row in table.to_dict("records"):
        when = f"{row['date']}, {row['commit'][:7]}"
        note = f", {row['note']}" if isinstance(row["note"], str) and row["note"] else ""
        cells = [f"{row['what']}{note}", *(_cell(row[name]) for name in columns), when]
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def growth_text(root: Path) -> str:
    """The page as Markdown, with a section for each processor. Raises ConfigError for a table with a fault."""
    lines = [HEAD]
    for (processor, instructions, cores), own in read_growth(root / STORED).groupby(
        ["processor", "instructions", "cores"]
    ):
        lines += [f"## {processor}, {instructions}, {cores:.0f} cores", ""]
        for part, (title, words, columns) in SHOWN.items():
            measured = own[own["part"] == part]
            if len(measured):
                lines += [f"### {title}", "", words, "", *_rows(measured, columns), ""]
    return "\n".join(lines).rstrip() + "\n"
