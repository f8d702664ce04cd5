"""Verdicts of other machines: a small table of the project, and how the verdicts of a run differ from it.

The processor decides how sums are rounded, and chaotic simulations and trainings magnify that. So a claim whose
interval decides nothing may have another verdict elsewhere; a claim that its interval decides should have the same
verdict everywhere.
"""

import platform
from pathlib import Path

import pandas as pd

from millprint.run.files import write_table
from millprint.run.tables import Text, read_measured, refuse_rows
from millprint.thesis.claims.claim_verdicts import INTERVAL_VERDICTS, NOT_RUN, OPEN_VERDICTS, VERDICTS
from millprint.thesis.claims.natures import CERTAIN, TIMED

MACHINE = ["processor", "instructions", "date"]
STORED = ["run", "id", "verdict", "interval_verdict", "reproduced", "lower", "upper"]
WORDS = {"verdict": VERDICTS, "interval_verdict": INTERVAL_VERDICTS}
COLUMNS = [*STORED, *MACHINE]
# The widest vector instructions of a processor, which decide in which order sums are taken; widest first.
INSTRUCTIONS = {"avx512f": "AVX-512", "avx2": "AVX2", "avx": "AVX", "sve": "SVE", "neon": "NEON"}
EXPECTED, UNEXPECTED, OF_MACHINE = "an interval decides nothing", "not expected", "a run time is of its machine"
DIFFERENCES = ["id", "verdict", "verdict_elsewhere", "reason", *MACHINE]


def this_machine(date: str) -> dict[str, str]:
    """The processor of this machine, its vector instructions, and a date, by MACHINE."""
    # Slow to import.
    from llvmlite import binding

    features = binding.get_host_cpu_features()
    widest = next((title for name, title in INSTRUCTIONS.items() if features.get(name)), platform.machine())
    return dict(zip(MACHINE, (binding.get_host_cpu_name(), widest, date), strict=True))


def read_stored(path: str | Path) -> pd.DataFrame:
    """The stored verdicts, with COLUMNS.

    Raises ConfigError, in one line, for a table that lacks a column, has another verdict, or has two verdicts of one
    processor on a claim of a run.
    """
    # A claim without an interval has no verdict by interval.
    columns = [Text(name, WORDS.get(name, ()), may_be_blank=name == "interval_verdict") for name in COLUMNS]
    table = read_measured(path, columns, fewest_rows=0)[COLUMNS].fillna("")
    twice = table.duplicated(["run", "id", "processor"])
    refuse_rows(table, path, "id", twice, "this run has a verdict of this processor on it in a row above")
    return table


def with_run(stored: pd.DataFrame, claims: pd.DataFrame, run: str, machine: dict[str, str]) -> pd.DataFrame:
    """The stored verdicts with those of a run in place of any that the same machine gave to the same run before.

    claims: as `millprint.thesis.claims.tabulate.tabulate_claims`; only what is simulated, trained or timed is stored,
    since the rest is the same everywhere.
    """
    own = claims[~claims["nature"].isin(CERTAIN) & (claims["verdict"] != NOT_RUN)]
    rows = own.assign(run=run, **machine)[COLUMNS]
    same = (stored["run"] == run) & (stored["processor"] == machine["processor"]) & stored["id"].isin(rows["id"])
    return pd.concat([stored[~same], rows], ignore_index=True).fillna("")


def store(path: str | Path, claims: pd.DataFrame, run: str, date: str) -> int:
    """Write the verdicts of a run on this machine into the table of stored ones; returns how many."""
    machine = this_machine(date)
    table = with_run(read_stored(path), claims, run, machine)
    write_table(table, path)
    return int(((table["run"] == run) & (table["processor"] == machine["processor"])).sum())


def compare_verdicts(claims: pd.DataFrame, stored: pd.DataFrame, run: str) -> pd.DataFrame:
    """A row, with DIFFERENCES, for each stored verdict of a run of this name that differs here."""
    own = claims.set_index("id")
    rows = []
    for row in stored[(stored["run"] == run) & stored["id"].isin(own.index)].to_dict("records"):
        here = own.loc[row["id"]]
        if here["verdict"] in (row["verdict"], NOT_RUN):
            continue
        is_open = here["interval_verdict"] in OPEN_VERDICTS or row["interval_verdict"] in OPEN_VERDICTS
        reason = OF_MACHINE if here["nature"] == TIMED else EXPECTED if is_open else UNEXPECTED
        rows.append(row | {"verdict": here["verdict"], "verdict_elsewhere": row["verdict"], "reason": reason})
    return pd.DataFrame(rows, columns=DIFFERENCES)


def in_a_line(differences: pd.DataFrame, stored: pd.DataFrame, run: str) -> str:
    """What differs from the stored verdicts, as one line for people."""
    known = stored[stored["run"] == run]
    if known.empty:
        return f"verdicts of other machines: none is stored of the run {run}"
    machines = known.groupby(MACHINE, sort=False).size()
    told = "; ".join(f"{number} of {', '.join(machine)}" for machine, number in machines.items())
    beginning = f"verdicts of other machines ({told})"
    if differences.empty:
        return f"{beginning}: none differs here"
    each = ", ".join(
        f"{row.id} ({row.verdict} here, {row.verdict_elsewhere} there: {row.reason})"
        for row in differences.itertuples()
    )
    odd = int((differences["reason"] == UNEXPECTED).sum())
    end = f"{odd} of them not expected" if odd else "all of them expected"
    return f"{beginning}: {len(differences)} differ here, {end}: {each}"
