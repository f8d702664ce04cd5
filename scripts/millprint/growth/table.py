"""The table of growth that is kept: what was measured, when, with which commit, on which machine."""

from pathlib import Path

import pandas as pd

from millprint.bench.history import bench_machine
from millprint.files import read_table

STORED, PICTURE = "config/data/growth.tsv", "docs/pictures/growth.png"
# part: planning, fingerprint, pages or simulation; size: cases, conditions, MB or balls; value: what it is for one.
MEASURED_COLUMNS = ("part", "what", "size", "processor_s", "memory_MB", "file_MB", "value", "unit", "note")
MACHINE_COLUMNS = ("date", "commit", "processor", "instructions", "cores")
GROWTH_COLUMNS = (*MEASURED_COLUMNS, *MACHINE_COLUMNS)


def this_machine() -> dict[str, str | int]:
    """MACHINE_COLUMNS of this machine, today."""
    values = bench_machine("")._asdict()
    return {name: values[name] for name in MACHINE_COLUMNS}


def read_growth(path: str | Path) -> pd.DataFrame:
    """The table, GROWTH_COLUMNS. Raises ConfigError, in one line, for a table that is not one of them."""
    text = ["part", "what", "unit", "note", "date", "commit", "processor", "instructions"]
    return read_table(path, numeric=["size", "cores"], text=text)[list(GROWTH_COLUMNS)]


def kept_rows(rows: pd.DataFrame, measured: list[dict]) -> pd.DataFrame:
    """The rows with those that were measured; one that measures the same on such a processor takes its place.

    A page has a new size whenever it changes, so that its name alone says which it is.
    """
    both = pd.concat([rows, pd.DataFrame(measured)]) if len(rows) else pd.DataFrame(measured)
    same = both["size"].astype(float).where(both["part"] != "pages", 0.0)
    last = ~both.assign(size=same).duplicated(["processor", "part", "what", "size"], keep="last")
    order = ["processor", "part", "what", "size"]
    return both[last].sort_values(order, kind="stable")[list(GROWTH_COLUMNS)].reset_index(drop=True)
