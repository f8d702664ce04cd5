"""The timings of `make bench` that are kept: when, which commit, on which machine, how much faster than LAMMPS.

Times of different machines cannot be compared; ratios of two codes on one machine can, with care: instruction sets and
caches favour one or the other.
"""

import os
import platform
from datetime import date
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from millprint.bench.table import LAMMPS
from millprint.errors import ConfigError
from millprint.files import read_table
from millprint.machine import commit

STORED = "config/data/bench_history.tsv"
# Vector instructions, the widest first: the name that readers know, and that of LLVM.
INSTRUCTIONS = {"AVX-512": "avx512f", "AVX2": "avx2", "AVX": "avx", "SSE4.2": "sse4.2", "NEON": "neon"}


class Machine(NamedTuple):
    """What a run of the bench ran with."""

    date: str
    commit: str
    processor: str
    instructions: str
    cores: int
    lammps: str


TIMED = ("case", "balls", "code", "wall")
NUMBERS = ("ns_per_ball_step", "least_ns", "largest_ns", "ratio_to_us")
HISTORY_COLUMNS = (*Machine._fields, *TIMED, *NUMBERS)


def widest_instructions(features: dict[str, bool]) -> str:
    """The widest vector instructions among the features of a processor, as LLVM names them."""
    return next((name for name, own in INSTRUCTIONS.items() if features.get(own)), "none")


def bench_machine(lammps: str) -> Machine:
    """This machine, today, and the commit of this library; lammps: the version of LAMMPS."""
    # Slow to import, and readers of the table need none of it.
    from llvmlite import binding

    features = dict(binding.get_host_cpu_features())
    return Machine(
        date=date.today().isoformat(),
        commit=commit(),
        processor=f"{binding.get_host_cpu_name()}, {platform.machine()}",
        instructions=widest_instructions(features),
        cores=os.cpu_count() or 1,
        lammps=lammps,
    )


def read_history(path: str | Path) -> pd.DataFrame:
    """The kept timings, HISTORY_COLUMNS. Raises ConfigError, in one line, for a table that is not one of them."""
    numeric = ["cores", "balls", *NUMBERS]
    table = read_table(path, numeric=numeric, text=[name for name in HISTORY_COLUMNS if name not in numeric])
    keys = ["date", "commit", "processor", "case", "code"]
    if table.duplicated(keys).any():
        row = table[table.duplicated(keys)].iloc[0]
        raise ConfigError(f"{path}: {row['date']}, {row['commit']}, {row['case']}, {row['code']}: stands there twice")
    return table[list(HISTORY_COLUMNS)]


def with_run(history: pd.DataFrame, timings: pd.DataFrame, ends: pd.DataFrame, machine: Machine) -> pd.DataFrame:
    """The history with the timings of a run at its end; a run of the same day, commit and processor is replaced.

    timings, ends: as of `summarise` and `spread`.
    """
    rows = timings.merge(ends, on=["case", "code"], validate="one_to_one").assign(**machine._asdict())
    keys = ["date", "commit", "processor"]
    same = (history[keys] == [machine.date, machine.commit, machine.processor]).all(axis=1)
    parts = [part for part in (history[~same], rows[list(HISTORY_COLUMNS)]) if len(part)]
    return pd.concat(parts, ignore_index=True)


def faster_than_lammps(history: pd.DataFrame) -> pd.DataFrame:
    """For each run and case that LAMMPS can express: what it ran with, ours and LAMMPS's ns a ball-step, and the ratio.

    In the order of the table. `ours_ns`, `lammps_ns`, `ratio` (LAMMPS over ours), and `spread`, the largest relative
    half range of the repetitions of the two codes.
    """
    theirs = history[history["code"] == LAMMPS]
    keys = ["date", "commit", "processor", "case"]
    ours = history[history["code"] != LAMMPS]
    both = theirs.merge(ours, on=keys, suffixes=("_theirs", "_ours"), validate="one_to_one")
    half = [
        (both[f"largest_ns_{code}"] - both[f"least_ns_{code}"]) / 2 / both[f"ns_per_ball_step_{code}"]
        for code in ("ours", "theirs")
    ]
    return pd.DataFrame(
        {
            **{name: both[name] for name in keys},
            **{name: both[f"{name}_theirs"] for name in ("instructions", "lammps", "balls", "wall")},
            "ours_ns": both["ns_per_ball_step_ours"],
            "lammps_ns": both["ns_per_ball_step_theirs"],
            "ratio": both["ns_per_ball_step_theirs"] / both["ns_per_ball_step_ours"],
            "spread": pd.concat(half, axis=1).max(axis=1),
        }
    )
